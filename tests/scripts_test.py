#!/usr/bin/env python3
"""Scripts say how they are called, and refuse what they do not know, before they do anything; on a machine that lacks what they need, too."""
import os
import pathlib
import runpy
import shutil
import subprocess
import sys
import tempfile

root = pathlib.Path(__file__).resolve().parent.parent
wrong = []


def call(script, *arguments):
    """Without Python's other packages, and with no program to do any work by."""
    python = script.read_text().startswith("#!/usr/bin/env python3")
    command = [sys.executable, "-S"] if python else [shutil.which("bash")]
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")} | {"PATH": few}
    return subprocess.run([*command, script, *arguments], env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)


def expect(script, arguments, code, *parts):
    """The exit code, and parts of what is said: to standard output where all is well, else to standard error, without a traceback."""
    done = call(root / "scripts" / script, *arguments)
    said, other = (done.stderr, done.stdout) if code else (done.stdout, done.stderr)
    if done.returncode != code or other or "Traceback" in said or any(part not in said for part in parts):
        wrong.append(f"scripts/{script} {' '.join(arguments)}: exit code {done.returncode}, not {code} with {parts}\n{done.stdout}{done.stderr}")


with tempfile.TemporaryDirectory() as few:
    for tool in ("bash", "dirname", "sed"):
        os.symlink(shutil.which(tool), pathlib.Path(few) / tool)
    for script in sorted(f.name for f in (root / "scripts").iterdir() if not f.suffix and f.is_file()):
        expect(script, ["--help"], 0, script)
        expect(script, ["-h"], 0, script)
        expect(script, ["--nonsense"], 2, script)  # or what it cannot do without comes first

    for script in ("bench-differing", "bench-sampling", "bench-noise", "bench-peer", "bench-recovery", "paper-rooms"):
        own = {"bench-noise": [], "bench-peer": [], "bench-recovery": ["--only", "mitsuba"], "bench-sampling": [sys.executable],
               "paper-rooms": ["scenes", "--cmpg", sys.executable]}.get(script, ["--cmpg", sys.executable])
        expect(script, own, 1, "lacks", "numpy", "pip install")
    for script in ("bench-differing", "bench-sampling", "bench-ranks", "bench-recovery", "bench-scale", "paper-results", "paper-rooms", "tradeoffs"):
        own = ["scenes"] * (script == "paper-rooms") + ["--cmpg"] * (script not in ("bench-sampling", "bench-ranks", "bench-scale"))
        expect(script, [*own, "nowhere/cmpg-vk"], 2, "there is no program nowhere/cmpg-vk")


class Sphinx:
    """Knows an extension's events where the configuration names the extension."""

    def __init__(self, configuration):
        self.extensions, self.connected = configuration["extensions"], []

    def connect(self, event, _):
        if event.startswith("autodoc-") and "sphinx.ext.autodoc" not in self.extensions:
            wrong.append(f"docs/site/conf.py: without the module's reference there is no event {event}")
        self.connected.append(event)


for module in ("", "1"):
    os.environ["CMPG_SITE_MODULE"] = module
    configuration = runpy.run_path(str(root / "docs/site/conf.py"))
    sphinx = Sphinx(configuration)
    configuration["setup"](sphinx)
    if module and not sphinx.connected:
        wrong.append("docs/site/conf.py: docstrings of the module's reference are not made plain")

sys.exit("\n".join(wrong) or None)
