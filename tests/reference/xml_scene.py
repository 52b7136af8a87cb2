"""Scenes in Mitsuba's own format, which both programs read from the same file."""
import pathlib
import re

import mitsuba as mi


class XmlScene:
    """What make_references.py needs of a scene, as mitsuba_scene.Translation has it."""

    def __init__(self, file):
        self.scene = mi.load_file(str(file))
        text = pathlib.Path(file).read_text() + (pathlib.Path(file).parent / "common.xml").read_text()
        depth = re.search(r'name="(max_depth|maxDepth)" value="(\d+)"', text) or re.search(r'(name="depth") value="(\d+)"', text)
        self.max_depth = int(depth.group(2))
        self.extras = {}

    def integrator(self, max_depth=None):
        return mi.load_dict({"type": "prb", "max_depth": max_depth or self.max_depth, "rr_depth": 1 << 20})

    def parameter(self, name):
        owner, _, slot = name.rpartition(".")
        parameters = mi.traverse(self.scene)
        for key in (name, *(f"{owner}.{within}.{slot}" for within in ("brdf_0", "nested_bsdf", "nested_bsdf.brdf_0"))):
            for ending in ("", ".data", ".value"):
                if key + ending in parameters:
                    return parameters, key + ending
        raise KeyError(f"{name}: not in\n{parameters}")
