"""Code of the documentation runs as it stands, but for sizes and numbers of steps."""

import re

import numpy as np
import pytest
from conftest import BOX, ROOT

import cmpg


def blocks(file):
    return re.findall(r"```python\n(.*?)```", (ROOT / file).read_text(), flags=re.DOTALL)


def smaller(code):
    for pattern, value in [(r"steps=\d+", "steps=2"), (r"width=\d+", "width=16"), (r"spp=\d+", "spp=2"), (r"range\(\d+\)", "range(2)")]:
        code = re.sub(pattern, value, code)
    return code


def run(code, monkeypatch, folder, names):
    monkeypatch.chdir(folder)
    (folder / "scenes").symlink_to(ROOT / "scenes")
    (folder / "out").mkdir()
    exec(compile(smaller(code), "documentation", "exec"), names)
    return names


def test_readme(monkeypatch, tmp_path):
    (code,) = blocks("README.md")
    names = run(code, monkeypatch, tmp_path, {})
    assert names["recovery"].done and (tmp_path / "painting.png").exists()


def test_recovery(monkeypatch, tmp_path):
    names = run(blocks("docs/python.md")[0], monkeypatch, tmp_path, {})
    assert names["recovery"].done and (tmp_path / "out/recovered/scene.gltf").exists()


def test_derivatives(monkeypatch, tmp_path, scene):
    names = run(blocks("docs/python.md")[1], monkeypatch, tmp_path, {"cmpg": cmpg, "scene": scene, "target": np.float32(0.5)})
    assert names["image"].shape == names["change"].shape == names["guided"].shape == (16, 16, 3)
    assert set(names["gradients"]) == {"painting.baseColor", "light.emission"}


def test_budgets(monkeypatch, tmp_path, scene):
    code = blocks("docs/python.md")[2].replace("time_budget=2", "time_budget=0.5").replace("0.01", "0.2")
    names = {"cmpg": cmpg, "scene": scene, "renderer": cmpg.Renderer(scene, ["painting.baseColor", "light.emission"], max_depth=2)}
    run(code, monkeypatch, tmp_path, names)
    assert names["renderer"].report.end == "time" and names["image"].shape == (16, 16, 3)


def test_measurements(monkeypatch, tmp_path, scene):
    names = run(blocks("docs/python.md")[3].replace("seeds=4", "seeds=4, max_depth=2"), monkeypatch, tmp_path, {"cmpg": cmpg, "scene": scene})
    assert names["curve"]["mse"].shape == names["curve"]["seconds"].shape


def test_torch(monkeypatch, tmp_path):
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: scripts/python-env --torch")
    names = run(blocks("docs/python.md")[4], monkeypatch, tmp_path, {"torch": torch, "scene": cmpg.Scene(BOX), "target": torch.full((16, 16, 3), 0.5)})
    assert names["texture"].grad.abs().sum() > 0


def test_ranks(monkeypatch, tmp_path):
    try:
        from mpi4py import MPI  # noqa: F401
    except ImportError as error:
        pytest.skip(f"mpi4py or its MPI is not installed: {error}")
    names = run(blocks("docs/mpi.md")[0], monkeypatch, tmp_path, {})
    assert names["recovery"].done and list((tmp_path / "out/run").iterdir())
