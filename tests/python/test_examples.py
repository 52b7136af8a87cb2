"""Examples run from top to bottom, as their own first lines say."""

import re
import subprocess
import sys

from conftest import ROOT

import cmpg


def test_recover_painting(tmp_path):
    result = subprocess.run([sys.executable, ROOT / "python/examples/recover_painting.py", "4", tmp_path / "out"], check=True, capture_output=True,
                            text=True)
    errors = [float(e) for e in re.findall(r"error of a texel ([0-9.]+)", result.stdout)]
    assert len(errors) == 4 and errors[-1] < 0.9 * errors[0]
    for name in ("painting.png", "room.png", "scene.gltf", "parameters/painting.baseColor.exr"):
        assert (tmp_path / "out" / name).stat().st_size > 0
    assert cmpg.load_image(tmp_path / "out/gradient.exr").any()
