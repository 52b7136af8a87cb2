#!/usr/bin/env python3
"""No two folders of src/ build on each other, directly or around a corner. Prints which folder includes which."""
import pathlib
import re
import sys

source = pathlib.Path(__file__).resolve().parent.parent / "src"
includes = {}
for file in sorted(source.rglob("*")):
    if file.suffix not in (".h", ".cpp"):
        continue
    folder = file.relative_to(source).parts[0]
    targets = includes.setdefault(folder, set())
    for name in re.findall(r'#include "([a-z_]+)/', file.read_text()):
        if (source / name).is_dir() and name != folder:
            targets.add(name)

for folder, targets in sorted(includes.items()):
    print(f"{folder}: {' '.join(sorted(targets)) or '-'}")

# What includes nothing that is left can be taken away; a circle stays.
left = {folder: set(targets) for folder, targets in includes.items()}
while True:
    free = [folder for folder, targets in left.items() if not targets & left.keys()]
    if not free:
        break
    for folder in free:
        del left[folder]
if left:
    sys.exit("folders in a circle: " + ", ".join(sorted(left)))
