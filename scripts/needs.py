"""What scripts need before they begin, so that what is missing is said in a sentence, and not after minutes."""
import argparse
import importlib.util
import pathlib
import shutil
import sys

HOW = {"cmpg": "pip install . in the project's folder, see docs/python.md"}  # all others have their name where pip finds them


def packages(*names):
    """Ends this program where one of these Python packages is missing."""
    missing = [name for name in names if not installed(name)]
    if missing:
        pip = " ".join(name for name in missing if name not in HOW)
        how = [f"pip install {pip}"] * bool(pip) + [HOW[name] for name in missing if name in HOW]
        sys.exit(f"{sys.executable} lacks {', '.join(missing)}: {'; '.join(how)}")


def installed(name):
    found = importlib.util.find_spec(name)
    return found is not None and found.origin is not None  # a folder of that name has none: tests/reference/mitsuba


def program(text):
    """A path for argparse: of a file, or of a program on the PATH."""
    found = shutil.which(f"./{text}" if pathlib.Path(text).is_file() and "/" not in text else text)
    if found is None:
        raise argparse.ArgumentTypeError(f"there is no program {text}")
    return pathlib.Path(found).absolute()
