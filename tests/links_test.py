#!/usr/bin/env python3
"""Links of README.md, docs/ and its folders lead somewhere: to a file of the project, a heading of a page, or another site, which is not asked."""
import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parent.parent
pages = [root / "README.md", *sorted((root / "docs").glob("**/*.md"))]


def without_code(text):
    return re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)


def anchors(page):
    """Of a page's headings: lower case, spaces to hyphens, no other signs; a number behind what was there before."""
    found = {}
    for heading in re.findall(r"^#{1,6} (.*)$", without_code(page.read_text()), re.M):
        name = re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.lower())).strip().replace(" ", "-")
        found[name] = found.get(name, -1) + 1
        if found[name]:
            found[f"{name}-{found[name]}"] = 0
    return found


wrong, seen = [], 0
for page in pages:
    text = re.sub(r"`[^`\n]*`", "", without_code(page.read_text()))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        seen += 1
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists():
            wrong.append(f"{page.relative_to(root)}: there is no {target}")
        elif anchor and (file not in pages or anchor not in anchors(file)):
            wrong.append(f"{page.relative_to(root)}: there is no heading for {target}")
if seen < 20:
    sys.exit(f"only {seen} links were found")
print("\n".join([*wrong, f"{seen} links, {len(wrong)} lead nowhere"]))
sys.exit(bool(wrong))
