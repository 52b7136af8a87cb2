"""Code of the documentation runs as it stands, but for sizes and numbers of steps."""

import re

import numpy as np
import pytest
from conftest import BOX, ROOT

import cmpg


def blocks(file):
    return re.findall(r"```python\n(.*?)```", (ROOT / file).read_text(), flags=re.DOTALL)


def under(file, heading):
    """The blocks of a section, as one."""
    section = re.search(rf"^## {heading}$(.*?)(?=^## |\Z)", (ROOT / file).read_text(), flags=re.DOTALL | re.MULTILINE)[1]
    return "\n".join(re.findall(r"```python\n(.*?)```", section, flags=re.DOTALL))


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
    names = run(under("docs/python.md", "Recover a texture"), monkeypatch, tmp_path, {})
    assert names["recovery"].done and (tmp_path / "out/recovered/scene.gltf").exists()


def test_derivatives(monkeypatch, tmp_path, scene):
    names = run(under("docs/python.md", "Images and derivatives"), monkeypatch, tmp_path, {"cmpg": cmpg, "scene": scene, "target": np.full((16, 16, 3), 0.5)})
    assert names["image"].shape == names["change"].shape == names["guided"].shape == (16, 16, 3)
    assert names["gradient"].shape == (64, 64, 3)
    assert set(names["gradients"]) == {"painting.baseColor", "light.emission"}


def test_budgets(monkeypatch, tmp_path, scene):
    code = under("docs/python.md", "Errors and time in place of samples").replace("time_budget=2", "time_budget=0.5").replace("0.01", "0.2")
    names = {"cmpg": cmpg, "scene": scene, "renderer": cmpg.Renderer(scene, ["painting.baseColor", "light.emission"], max_depth=2)}
    run(code, monkeypatch, tmp_path, names)
    assert names["renderer"].report.end == "time" and names["image"].shape == (16, 16, 3)


def test_looking_on(monkeypatch, tmp_path, scene):
    names = {"cmpg": cmpg, "scene": scene, "renderer": cmpg.Renderer(scene, "painting.baseColor", sampling="conditional", max_depth=3)}
    run(under("docs/python.md", "Look on"), monkeypatch, tmp_path, names)
    assert names["film"].samples == 4 and names["image"].shape[1] == 16 and (tmp_path / "out/directions.png").exists()
    assert names["recovery"].steps_done == 2 and not names["recovery"].ended


def test_measurements(monkeypatch, tmp_path, scene):
    names = run(under("docs/python.md", "Measurements").replace("seeds=4", "seeds=4, max_depth=2"), monkeypatch, tmp_path, {"cmpg": cmpg, "scene": scene})
    assert names["curve"]["mse"].shape == names["curve"]["seconds"].shape


def test_torch(monkeypatch, tmp_path):
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: scripts/python-env --torch")
    names = run(under("docs/python.md", "With torch"), monkeypatch, tmp_path, {"torch": torch, "scene": cmpg.Scene(BOX), "target": torch.full((16, 16, 3), 0.5)})
    assert names["texture"].grad.abs().sum() > 0


def test_ranks(monkeypatch, tmp_path):
    try:
        from mpi4py import MPI  # noqa: F401
    except ImportError as error:
        pytest.skip(f"mpi4py or its MPI is not installed: {error}")
    names = run(blocks("docs/mpi.md")[0], monkeypatch, tmp_path, {})
    assert names["recovery"].done and list((tmp_path / "out/run").iterdir())
