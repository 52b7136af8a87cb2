"""Examples run from top to bottom, as their own first lines say."""

import json
import os
import re
import subprocess
import sys

import pytest

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


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.full)], ids=["smaller", "whole"])
def test_notebook(tmp_path, whole):
    """Its cells in a fresh interpreter, one after the other; the values of last lines show themselves, as in a notebook."""
    pytest.importorskip("matplotlib")
    notebook = json.loads((ROOT / "python/examples/recover_painting.ipynb").read_text())
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in notebook["cells"] if cell["cell_type"] == "code")
    for long, short in [] if whole else [("width=160", "width=96"), ("steps=40", "steps=16")]:
        assert any(long in cell for cell in cells)
        cells = [cell.replace(long, short) for cell in cells]
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    runner = tmp_path / "run.py"
    runner.write_text(f"""
import ast
names = {{}}
for cell in {cells!r}:
    body = ast.parse(cell).body
    last = body.pop() if isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), "cell", "exec"), names)
    shown = eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last else None
    if hasattr(shown, "_repr_png_"):
        assert shown._repr_png_().startswith(b"\\x89PNG")
        print("picture", shown.shape)
""")
    result = subprocess.run([sys.executable, runner], cwd=tmp_path, env={**os.environ, "MPLBACKEND": "Agg"}, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("picture") == 3 and "agrees" in result.stdout
    first, last = re.search(r"error of a texel ([0-9.]+) to ([0-9.]+)", result.stdout).groups()
    assert float(last) < 0.5 * float(first)
    assert (tmp_path / "out/notebook/recovery.png").stat().st_size > 10000
