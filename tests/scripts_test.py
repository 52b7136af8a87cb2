#!/usr/bin/env python3
"""What scripts do on a machine that lacks what they need."""
import os
import pathlib
import runpy
import sys

root = pathlib.Path(__file__).resolve().parent.parent
wrong = []


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
