#!/usr/bin/env python3
"""No two folders of src/ build on each other, directly or around a corner, and what uses the library does so by include/cmpg. Prints which folder includes which."""
import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parent.parent
source = root / "src"

# The folders behind include/cmpg, and who may include what of them. A rule is for all files of a folder; the most specific rule of a file applies.
behind = ("scene", "guiding", "render", "optimize", "library", "vk")
allowed = {
    **{f"src/{folder}": behind for folder in behind},
    "src/base": (),
    "src/imaging": ("scene/",),  # images and their files
    # A scene and a device as the options want them, and the scene itself for what other programs have no use for.
    "src/session": ("scene/", "library/states.h", "library/ranks.h", "vk/device.h"),
    # Files and their names. All else goes by include/cmpg.
    "src/app": ("scene/export_folder.h", "scene/file_io.h", "scene/image.h"),
    "src/lab": ("scene/export_folder.h", "scene/image.h"),
    "src/live": (),
    "src/viewer": (),
    "src/viewer/present": ("vk/instance.h",),  # it presents with Vulkan on a device of its own
    "src/manual": (),
    "src/mpi": (),
    "bench": (),
    "bench/traversal.cpp": ("support/", "base/stopwatch.h"),  # single rays, which include/cmpg does not show
    "python/src": (),
    "python/src/lab.cpp": ("lab/",),  # the laboratory is a program's, not the library's
}
# Where even the folders of the program are out of reach.
apart = {"bench": ("bench.h", "median.h"), "python/src": ("errors.h", "handles.h", "ranks.h")}


def included(file):
    return re.findall(r'#include "([^"]+)"', file.read_text())


def place(name):
    """The longest place of `allowed` that a file lies in."""
    fitting = [p for p in allowed if name == p or name.startswith(p + "/")]
    return max(fitting, key=len, default=None)


def fits(header, names):
    return any(header == n or header.startswith(n if n.endswith("/") else n + "/") for n in names)


wrong = []
includes = {}
for file in sorted(f for folder in ("src", "bench", "python/src") for f in (root / folder).rglob("*")):
    if file.suffix not in (".h", ".cpp"):
        continue
    name = file.relative_to(root).as_posix()
    own = place(name)
    if own is None:
        sys.exit(f"{name}: nothing says what it may include")
    if name.startswith("src/"):
        folder = file.relative_to(source).parts[0]
        targets = includes.setdefault(folder, set())
        targets.update(header.split("/")[0] for header in included(file) if "/" in header and (source / header.split("/")[0]).is_dir())
        targets.discard(folder)
    outside = next((names for p, names in apart.items() if name.startswith(p + "/")), None)
    for header in included(file):
        hidden = header.split("/")[0] in behind if outside is None else header not in outside
        if hidden and not fits(header, allowed[own]):
            wrong.append(f"{name} includes {header}, which stands behind include/cmpg")

for folder, targets in sorted(includes.items()):
    print(f"{folder}: {' '.join(sorted(targets)) or '-'}")
for file in sorted((root / "include").rglob("*.h")):
    wrong += [f"{file.relative_to(root)} includes {header}, which is not part of the surface" for header in included(file)]
    wrong += [f"{file.relative_to(root)} includes <{header}>" for header in re.findall(r"#include <((?:glm|vulkan|nlohmann)[^>]*)>", file.read_text())]

# What includes nothing that is left can be taken away; a circle stays.
left = {folder: set(targets) for folder, targets in includes.items()}
while True:
    free = [folder for folder, targets in left.items() if not targets & left.keys()]
    if not free:
        break
    for folder in free:
        del left[folder]
if left:
    wrong.append("folders in a circle: " + ", ".join(sorted(left)))
sys.exit("\n".join(wrong) or None)
