"""Scenes, their parameters, images and errors."""

import gc
import itertools
import math
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import BOX, LIGHT, PAINTING

import cmpg


def test_values_go_in_and_come_out(scene):
    values = np.random.default_rng(1).random((64, 64, 3), dtype=np.float32)
    scene[PAINTING] = values
    assert scene[PAINTING].values.dtype == np.float32
    np.testing.assert_array_equal(scene[PAINTING].values, values)
    scene[PAINTING] = values[::-1]  # not contiguous
    np.testing.assert_array_equal(scene[PAINTING].values, values[::-1])
    scene[PAINTING] = [0.25, 0.5, 0.75]
    assert (scene[PAINTING].values == np.float32([0.25, 0.5, 0.75])).all()
    scene[PAINTING] = 0.5
    assert (scene[PAINTING].values == 0.5).all()


def test_values_are_copies(scene):
    values = scene[PAINTING].values
    values[:] = 0
    assert scene[PAINTING].values.max() > 0


def test_textures_take_other_sizes(scene):
    parameter = scene[PAINTING]
    renderer = cmpg.Renderer(scene, PAINTING)
    sharp = renderer.render(width=16, spp=2)
    scene.resize(PAINTING, width=4, height=2)
    assert parameter.shape == scene.parameters[PAINTING].shape == (2, 4, 3)
    assert not np.array_equal(renderer.render(width=16, spp=2), sharp)
    scene[PAINTING] = np.full((2, 4, 3), 0.25, np.float32)
    with pytest.raises(cmpg.UsageError, match="resize"):
        scene[PAINTING] = np.zeros((64, 64, 3), np.float32)
    with pytest.raises(cmpg.UsageError, match="normal map"):
        scene.resize("painting.normal", 4, 4)


def test_the_size_that_a_texture_has_changes_nothing(scene):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=2)
    before = renderer.render(width=16, spp=2)
    scene.resize(PAINTING, 64, 64)
    np.testing.assert_array_equal(renderer.render(width=16, spp=2), before)


def test_values_and_their_shape_are_of_one_moment(scene):
    """While another thread gives them other sizes: each time all of one value, which others around them in memory do not have."""
    end = time.monotonic() + 1
    mixed = []

    def read():
        while time.monotonic() < end:
            values = scene[PAINTING].values
            if abs(values[0, 0, 0] - values[-1, -1, -1]) > 1e-4:
                mixed.append(values.shape)

    def compute():  # so that the interpreter changes threads between any two calls
        while time.monotonic() < end:
            pass

    scene[PAINTING] = 0
    threads = [threading.Thread(target=work) for work in (read, read, read, read, compute)]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        for thread in threads:
            thread.start()
        values = itertools.cycle(np.linspace(0, 1, 1000))
        while time.monotonic() < end:
            for edge in (4, 64):
                scene.resize(PAINTING, edge, edge)
                scene[PAINTING] = next(values)
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(interval)
    assert not mixed


def test_describes_its_parameters(scene):
    parameter = scene.parameters[PAINTING]
    assert (parameter.slot, parameter.shape, parameter.lowest, parameter.highest) == ("baseColor", (64, 64, 3), 0, 1)
    assert scene[LIGHT].shape == (1, 1, 3) and math.isinf(scene[LIGHT].highest)
    assert scene.select("painting.base*") == [PAINTING]
    assert scene.select([PAINTING, LIGHT, "painting.base*"]) == [PAINTING, LIGHT]
    assert scene.cameras == {"front": 1.0, "corner": 1.0}


def test_picks_what_a_camera_sees(scene):
    point = scene.pick(32, 32, camera="front", width=64, height=64)
    assert f"{point.material}.baseColor" in scene.parameters
    assert point.distance > 0 and abs(sum(n * n for n in point.normal) - 1) < 1e-5
    with pytest.raises(cmpg.UsageError):
        scene.pick(0, 0, camera="nobody")


def test_copies_have_values_of_their_own(scene):
    other = scene.copy()
    other[PAINTING] = 0
    assert scene[PAINTING].values.max() > 0


def test_exports(scene, tmp_path):
    scene[PAINTING] = 0.5
    scene.export(tmp_path / "out")
    assert (cmpg.load_image(tmp_path / "out/parameters/painting.baseColor.exr") == 0.5).all()
    np.testing.assert_allclose(cmpg.Scene(tmp_path / "out/scene.gltf")[PAINTING].values, 0.5, atol=0.003)


def test_environment_and_variables_beside_the_file(tmp_path):
    sky = BOX.parent.parent / "environment" / "sky.exr"
    lit = cmpg.Scene(BOX, environment=sky, environment_rotation=90)
    assert "environment.radiance" in lit.parameters
    assert "environment.radiance" not in cmpg.Scene(BOX).parameters
    file = tmp_path / "scene.xml"
    file.write_text('<scene version="3.0.0"><default name="grey" value="0.5"/><shape type="sphere"><bsdf type="diffuse" id="ball">'
                    '<float name="reflectance" value="$grey"/></bsdf></shape></scene>')
    assert cmpg.Scene(file)["ball.reflectance"].values.ravel()[0] == 0.5
    assert cmpg.Scene(file, define={"grey": 0.25})["ball.reflectance"].values.ravel()[0] == 0.25


def test_filters_are_those_of_the_program(tmp_path):
    wide = cmpg.Renderer(cmpg.Scene(BOX, filter="gaussian:0.7")).render(width=16, spp=4)
    program = os.environ.get("CMPG_BINARY")
    if not program:
        pytest.skip("CMPG_BINARY does not say where the program is")
    subprocess.run([program, "--headless", "render", BOX, "--filter", "gaussian:0.7", "--width", "16", "--spp", "4", "-o", tmp_path / "a.exr"], check=True)
    np.testing.assert_array_equal(wide, cmpg.load_image(tmp_path / "a.exr"))
    assert (wide != cmpg.Renderer(cmpg.Scene(BOX)).render(width=16, spp=4)).any()
    with pytest.raises(cmpg.UsageError, match="no filter"):
        cmpg.Scene(BOX, filter="mitchell")


def test_images_show_and_save_themselves(scene, tmp_path):
    picture = scene[PAINTING]._repr_png_()
    assert picture.startswith(b"\x89PNG")
    scene[PAINTING].values.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == picture
    scene[PAINTING].values.save(tmp_path / "a.exr")
    np.testing.assert_array_equal(cmpg.load_image(tmp_path / "a.exr"), scene[PAINTING].values)
    assert isinstance(scene[PAINTING].values.mean(), np.float32)


@pytest.mark.parametrize(
    "wrong, kind, options",
    [
        (lambda s: s["paintin.baseColor"], cmpg.UsageError, ["Scene.parameters, Scene.cameras"]),
        (lambda s: s.__setitem__(PAINTING, 1.5), cmpg.UsageError, ["Scene.parameters, Scene.cameras"]),
        (lambda s: s.__setitem__(PAINTING, np.zeros((3, 64, 64))), cmpg.UsageError, []),
        (lambda s: s.__setitem__(PAINTING, None), cmpg.UsageError, []),
        (lambda s: s.__setitem__(PAINTING, "0.5"), cmpg.UsageError, []),
        (lambda s: s.__setitem__(PAINTING, [[1, 2], [3]]), cmpg.UsageError, []),
        (lambda s: cmpg.Scene("/nowhere.gltf"), cmpg.InputError, []),
        (lambda s: cmpg.Device("no such device"), cmpg.DeviceError, ["device"]),
        (lambda s: cmpg.Renderer(s, sampling="magic"), cmpg.UsageError, ["sampling"]),
        (lambda s: cmpg.Renderer(s, memory=1), cmpg.UsageError, ["memory"]),
        (lambda s: cmpg.Renderer(s).render(spp=1 << 25), cmpg.UsageError, ["spp"]),
        (lambda s: cmpg.Recovery(s, np.ones((8, 8, 3)), PAINTING, spp_difference=1), cmpg.UsageError, ["spp_difference"]),
    ],
)
def test_errors_have_a_remedy(scene, wrong, kind, options):
    with pytest.raises(kind) as caught:
        wrong(scene)
    error = caught.value
    assert isinstance(error, cmpg.Error) and error.remedy and error.options == options
    assert error.what in str(error) and error.remedy in str(error)
    assert "--" not in str(error)  # which is the command line's


def test_errors_have_a_cause(scene):
    with pytest.raises(cmpg.UsageError) as caught:
        scene["paintin.baseColor"]
    assert PAINTING in caught.value.cause and PAINTING in str(caught.value)
    assert isinstance(caught.value, ValueError)


def test_without_a_driver_the_error_says_what_to_do():
    missing = {"VK_ICD_FILENAMES": "/nonexistent/driver.json", "VK_DRIVER_FILES": "/nonexistent/driver.json"}
    result = subprocess.run([sys.executable, "-c", "import cmpg; cmpg.Device()"], env=os.environ | missing, capture_output=True, text=True)
    assert result.returncode == 1
    assert "cmpg.DeviceError" in result.stderr and "unset VK_ICD_FILENAMES and VK_DRIVER_FILES" in result.stderr


def test_loads_pathlib_and_text(device):
    assert cmpg.Scene(str(BOX)).source == cmpg.Scene(BOX).source


def test_is_a_collection_of_names(scene):
    assert PAINTING in scene
    assert "painting.colour" not in scene
    assert 3 not in scene
    assert list(scene) == list(scene.parameters)
    with pytest.raises(cmpg.UsageError, match="asked for by 0"):
        scene[0]


def test_names_of_files_need_not_be_utf8(tmp_path):
    name = os.fsdecode(b"n\xffthing.gltf")
    with pytest.raises(cmpg.InputError) as caught:
        cmpg.Scene(tmp_path / name)
    assert name in caught.value.what
    (tmp_path / name).touch()  # where a folder is wanted
    with pytest.raises(cmpg.OutputError) as caught:
        cmpg.Scene(BOX).export(tmp_path / name)
    assert name in caught.value.what


def test_has_a_version():
    assert cmpg.__version__.count(".") == 2


def test_a_forked_process_is_told():
    import multiprocessing
    renderer = cmpg.Renderer(cmpg.Scene(BOX))
    renderer.render(width=8, spp=1)

    def child(pipe):
        try:
            renderer.render(width=8, spp=1)
            pipe.send("rendered")
        except cmpg.DeviceError as error:
            pipe.send(str(error))

    context = multiprocessing.get_context("fork")
    here, there = context.Pipe()
    process = context.Process(target=child, args=(there,))
    process.start()
    try:
        assert here.poll(20), "the child hangs"
        assert "another process" in here.recv()
        process.join(20)
        assert process.exitcode == 0
    finally:
        process.kill()


def test_a_forked_process_drops_what_it_inherits():
    """Its driver has no threads, for which the end of a device waits."""
    import multiprocessing
    scene = cmpg.Scene(BOX)
    scene._device = cmpg.Device()
    renderer = cmpg.Renderer(scene, PAINTING)
    image = renderer.render(width=8, spp=1)
    kept = [scene, renderer, cmpg.Recovery(scene, image, PAINTING), cmpg.Recovery.of(cmpg.Renderer(scene, PAINTING, recoveries=True), image)]
    del scene, renderer

    def child(pipe):
        kept.clear()
        gc.collect()
        pipe.send("dropped")

    context = multiprocessing.get_context("fork")
    here, there = context.Pipe()
    process = context.Process(target=child, args=(there,))
    process.start()
    try:
        assert here.poll(20), "the child hangs"
        process.join(20)
        assert process.exitcode == 0
    finally:
        process.kill()
    kept[1].render(width=8, spp=1)  # the device is as it was
