"""cmpg.lab: the commands' numbers as dictionaries and arrays."""

import json
import os
import signal
import subprocess
import threading

import numpy as np
import pytest

import cmpg
import cmpg.lab
from conftest import BOX, PAINTING

SMALL = {"width": 24, "max_depth": 3, "seeds": 4, "train": 1, "spp_gradient": 2}
TIMED = {"seconds", "train_seconds", "efficiency", "efficiency_error", "ratio", "ratio_error"}  # hold seconds


def command(*arguments):
    run = subprocess.run([os.environ["CMPG_BINARY"], "--headless", "--json", *arguments], capture_output=True, text=True, check=True)
    return json.loads(run.stdout)


@pytest.mark.skipif("CMPG_BINARY" not in os.environ, reason="the command line is not there")
def test_numbers_are_those_of_the_command(tmp_path):
    # The reference is made by the method that was fastest, so a given one keeps clocks out.
    adjoint = tmp_path / "adjoint.exr"
    np.ones((18, 24, 3), np.float32).view(cmpg.Image).save(adjoint)
    scene = cmpg.Scene(BOX)
    truth = cmpg.Renderer(scene, PAINTING, max_depth=3).backward(np.ones((18, 24, 3)), spp=32)[PAINTING]
    truth.save(tmp_path / "truth.exr")
    found = cmpg.lab.compare(BOX, PAINTING, methods=["plain", "conditional"], adjoint=np.ones((18, 24, 3)), reference=tmp_path / "truth.exr", **SMALL)
    written = command("compare", str(BOX), "--param", PAINTING, "--methods", "plain,conditional", "--adjoint", str(adjoint), "--reference",
                      str(tmp_path / "truth.exr"), "--max-depth", "3", "--seeds", "4", "--train", "1", "--spp-gradient", "2", "-o", str(tmp_path / "out"))
    rows = [row for row in found["table"] if row["method"] != "reference"]
    assert [row["method"] for row in rows] == ["plain", "conditional"]
    for row, other in zip(rows, written["table"]):
        assert {key: value for key, value in row.items() if key not in TIMED} == {key: value for key, value in other.items() if key not in TIMED}
        assert row["relative_variance"] > 0
    np.testing.assert_array_equal(found["columns"]["relative_variance"][:2], [row["relative_variance"] for row in rows])
    images = found["images"]["reverse"]
    assert set(images) == {"reference", "plain", "conditional"}
    np.testing.assert_array_equal(images["plain"], cmpg.load_image(tmp_path / "out/plain.exr"))
    np.testing.assert_allclose(images["reference"], truth, rtol=1e-6)
    curve = found["curves"]["reverse"]["plain"]
    assert curve["passes"][-1] == 4 and curve["mse"].shape == curve["seconds"].shape == curve["passes"].shape
    assert curve["mse"][-1] == pytest.approx(rows[0]["mse"], rel=1e-4)
    assert found["files"] == {}


def test_values_that_were_set_are_compared(tmp_path):
    scene = cmpg.Scene(BOX)
    options = {**SMALL, "methods": "plain", "mode": "forward"}
    dark = scene.copy()
    dark["light.emission"] = scene["light.emission"].values * 0.25
    whole = cmpg.lab.compare(scene, PAINTING, output=tmp_path / "report", **options)
    quarter = cmpg.lab.compare(dark, PAINTING, **options)
    np.testing.assert_allclose(quarter["images"]["forward"]["plain"], whole["images"]["forward"]["plain"] * 0.25, rtol=1e-4, atol=1e-6)
    assert (tmp_path / "report/report.html").exists() and whole["files"]["report"].endswith("report.html")


def test_scenes_are_compared_as_they_were_made(tmp_path):
    """A copy as well: with surroundings, filter and the sizes of its textures."""
    given = cmpg.Scene(BOX, environment=BOX.parent.parent / "environment/sky.exr", environment_rotation=90, filter="gaussian:0.7")
    given.resize(PAINTING, 8, 4)
    given[PAINTING] = [0.2, 0.4, 0.6]
    scene = given.copy()
    options = {**SMALL, "methods": "plain", "mode": "forward", "reference_time": 0.1}
    found = cmpg.lab.compare(scene, PAINTING, output=tmp_path / "report", **options)
    told = json.loads((tmp_path / "report/run.json").read_text())
    assert told["environment"].endswith("environment/sky.exr") and told["environment-rotation"] == 90 and told["filter"] == "gaussian:0.7"
    assert told["texture"] == [f"{PAINTING}=8x4"]
    mean = cmpg.Renderer(scene, PAINTING, max_depth=3).forward({PAINTING: 1}, width=24, spp=64).mean()
    assert found["images"]["forward"]["plain"].mean() == pytest.approx(mean, rel=0.1)
    dark = cmpg.lab.compare(scene, PAINTING, output=tmp_path / "dark", environment=BOX.parent.parent / "environment/sky.exr", filter="box", **options)
    told = json.loads((tmp_path / "dark/run.json").read_text())
    assert told["filter"] == "box" and told.get("environment-rotation", 0) == 0  # options come before what the scene has
    assert dark["table"][0]["passes"] == 4


def test_variables_of_a_scene_are_compared(tmp_path):
    file = tmp_path / "scene.xml"
    file.write_text('<scene version="3.0.0"><default name="grey" value="0.5"/><default name="light" value="1"/><shape type="sphere"><bsdf type="diffuse" id="ball">'
                    '<float name="reflectance" value="$grey"/></bsdf><transform name="to_world"><translate z="3"/></transform></shape>'
                    '<emitter type="constant"><float name="radiance" value="$light"/></emitter><sensor type="perspective"/></scene>')
    scene = cmpg.Scene(file, define={"light": 2, "grey": 0.25})
    options = {**SMALL, "methods": "plain", "mode": "forward", "reference_time": 0.1}
    image = cmpg.lab.compare(scene, "ball.reflectance", **options)["images"]["forward"]["plain"]
    twice = cmpg.lab.compare(scene, "ball.reflectance", define=["light=4"], **options)["images"]["forward"]["plain"]
    once = cmpg.lab.compare(file, "ball.reflectance", **options)["images"]["forward"]["plain"]
    assert image.any()
    np.testing.assert_allclose(image, 2 * once, rtol=1e-4)
    np.testing.assert_allclose(twice, 2 * image, rtol=1e-4)


def test_directions_may_be_arrays():
    options = {**SMALL, "methods": "plain", "mode": "forward", "reference_time": 0.1}
    left, right = np.zeros((64, 64, 3), np.float32), np.zeros((64, 64, 3), np.float32)
    left[:, :32], right[:, 32:] = 1, 1
    images = [cmpg.lab.compare(BOX, PAINTING, direction=along, **options)["images"]["forward"]["plain"] for along in (left, right, "one")]
    assert images[0].any() and images[1].any()
    np.testing.assert_allclose(images[0] + images[1], images[2], rtol=1e-4, atol=1e-6)


def test_recoveries_are_compared(tmp_path):
    scene = cmpg.Scene(BOX)
    target = cmpg.Renderer(scene, max_depth=3).render(width=24, spp=16)
    scene[PAINTING] = 0.5
    found = cmpg.lab.compare(scene, PAINTING, mode="optimize", methods="plain", target=target, steps=3, max_depth=3, spp=4)
    assert found["table"][0]["steps"] == 3
    assert found["curves"]["optimize"]["plain"]["mse"][-1] < found["curves"]["optimize"]["plain"]["mse"][0]


def test_tradeoff():
    told = []
    found = cmpg.lab.tradeoff(BOX, PAINTING, time=2, seeds=1, width=16, max_depth=2, spp=2, progress=told.append)
    first = found["table"][0]
    assert first["part"] == "single" and first["gain"] == 1
    assert found["columns"]["seconds_per_pass"].min() > 0
    assert any(row["frontier"] for row in found["table"])
    assert found["images"]["reference"].shape[1:] == (16, 3)
    assert "training the defaults" in told


def test_what_makes_no_sense_is_refused(tmp_path):
    with pytest.raises(cmpg.UsageError, match="unknown key 'colour'"):
        cmpg.lab.compare(BOX, PAINTING, colour=1)
    with pytest.raises(cmpg.UsageError):
        cmpg.lab.compare(BOX, PAINTING, methods="fastest", output=tmp_path / "out")
    with pytest.raises(cmpg.UsageError, match="no parameter"):
        cmpg.lab.compare(BOX, "nothing.baseColor", mode="forward", output=tmp_path / "out")
    with pytest.raises(cmpg.InputError):
        cmpg.lab.compare("nowhere.gltf", PAINTING, mode="forward")
    with pytest.raises(cmpg.UsageError, match="mask is a ndarray"):
        cmpg.lab.compare(BOX, PAINTING, mask=np.ones((4, 4)))


@pytest.mark.parametrize(
    "options, named",
    [
        ({"seeds": 2}, "seeds must be at least 4"),
        ({"spp_gradient": 0}, "spp_gradient must be from 1"),
        ({"methods": "fastest"}, "methods: there is no method"),
        ({"mode": "reverse"}, "mode reverse needs target or adjoint"),
        ({"direction": np.ones((4, 4, 3), np.float32)}, "give the parameter that size \\(texture\\)"),
    ],
)
def test_messages_name_arguments(options, named):
    with pytest.raises(cmpg.Error, match=named) as caught:
        cmpg.lab.compare(BOX, PAINTING, **{"mode": "forward", "width": 16, **options})
    assert "--" not in str(caught.value)


def test_interrupt_ends_a_measurement():
    timer = threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        cmpg.lab.compare(BOX, PAINTING, methods="plain", mode="forward", time=60, width=24, max_depth=3)
    timer.join()
