"""What programs use that look on: films, moved cameras, picks, what the guide knows, recoveries of a renderer."""

import dataclasses
import gc
import os
import signal
import threading
import time
import weakref

import numpy as np
import pytest
from conftest import LIGHT, PAINTING, ROOT

import cmpg


def test_films_have_the_bits_of_one_pass(scene):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=4)
    film, derivative = cmpg.Film(24, 16, layers=True), cmpg.Film(24, 16)
    assert film.shape == (16, 24, 3) and film.samples == 0
    for spp in (1, 7, 5):
        renderer.render_into(film, spp=spp, seed=5)
        assert renderer.report.spp == spp and renderer.report.paths == spp * 24 * 16
        renderer.forward_into(derivative, {PAINTING: 1}, spp=spp, seed=5)
    assert film.samples == 13 and "13 samples" in repr(film)
    image = renderer.render(width=24, height=16, spp=13, seed=5, layers=True)
    np.testing.assert_array_equal(film.image(), image)
    assert isinstance(film.image(), cmpg.Image) and film.image().dtype == np.float32
    for name in ("normal", "depth", "albedo"):
        np.testing.assert_array_equal(film.layers()[name], renderer.report.layers()[name])
    np.testing.assert_array_equal(derivative.image(), renderer.forward({PAINTING: 1}, width=24, height=16, spp=13, seed=5))


def test_images_of_a_film_are_copies(scene):
    renderer = cmpg.Renderer(scene, max_depth=2)
    film = cmpg.Film(8, 8)
    renderer.render_into(film, spp=1)
    image = film.image()
    kept = image.copy()
    renderer.render_into(film, spp=4)
    np.testing.assert_array_equal(image, kept)
    del film
    image += 1  # owns its memory
    np.testing.assert_array_equal(image, kept + 1)


def test_films_refuse_what_makes_no_sense(scene):
    renderer = cmpg.Renderer(scene, PAINTING)
    film = cmpg.Film(8, 8)
    for wrong in (lambda: cmpg.Film(0, 8), film.image, film.layers, lambda: renderer.render_into(film, camera="nobody"),
                  lambda: renderer.render_into(film, spp=1 << 25), lambda: renderer.forward_into(film, {}), lambda: renderer.forward_into(film, {LIGHT: 1})):
        with pytest.raises(cmpg.UsageError):
            wrong()
    assert film.samples == 0


def test_interrupt_leaves_a_film_as_it_was(scene):
    renderer = cmpg.Renderer(scene)
    film = cmpg.Film(64, 64)
    renderer.render_into(film, spp=2)
    before = film.image()
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        renderer.render_into(film, spp=1 << 16)
    timer.join()
    assert film.samples == 2
    np.testing.assert_array_equal(film.image(), before)
    renderer.render_into(film, spp=3)
    np.testing.assert_array_equal(film.image(), renderer.render(width=64, height=64, spp=5))


def test_reading_a_film_waits_for_the_pass_and_not_for_the_interpreter(scene):
    renderer = cmpg.Renderer(scene)
    film = cmpg.Film(64, 64)
    renderer.render_into(film, spp=1)
    adding = threading.Thread(target=lambda: [renderer.render_into(film, spp=16) for _ in range(4)])
    reading = threading.Thread(target=lambda: [film.image() for _ in range(50)])
    adding.start()
    reading.start()
    begin, ticks = time.perf_counter(), 0
    while adding.is_alive() and time.perf_counter() - begin < 60:
        time.sleep(0.002)
        ticks += 1
    adding.join()
    reading.join()
    assert film.samples == 65 and ticks > 5


def test_cameras_are_moved(scene):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=3)
    front = scene.camera("front")
    assert front.name == scene.camera().name == "front" and front.to_world.shape == (4, 4) and not front.orthographic and 0 < front.yfov < np.pi
    np.testing.assert_allclose(front.to_world[:3, :3] @ front.to_world[:3, :3].T, np.eye(3), atol=1e-5)
    options = dict(width=24, height=16, spp=2)
    image = renderer.render(camera="front", **options)
    np.testing.assert_array_equal(renderer.render(camera=front, **options), image)
    np.testing.assert_array_equal(renderer.render(camera=scene.camera("corner"), **options), renderer.render(camera="corner", **options))

    place = front.to_world[:3, 3]
    ahead = front.look_at(place, place - front.to_world[:3, 2], up=front.to_world[:3, 1])
    np.testing.assert_allclose(ahead.to_world, front.to_world, atol=1e-5)
    aside = front.look_at(place + [0.3, 0, 0], place - front.to_world[:3, 2])
    assert (renderer.render(camera=aside, **options) != image).any()
    assert (renderer.render(camera=dataclasses.replace(front, yfov=0.4), **options) != image).any()
    assert renderer.forward({PAINTING: 1}, camera=aside, **options).shape == image.shape
    assert (renderer.backward(np.ones_like(image), camera=aside, spp=2)[PAINTING] != renderer.backward(np.ones_like(image), spp=2)[PAINTING]).any()
    for wrong in (dataclasses.replace(front, to_world=front.to_world * np.nan), dataclasses.replace(front, yfov=4), dataclasses.replace(front, to_world=np.eye(3))):
        with pytest.raises(cmpg.UsageError, match="camera"):
            renderer.render(camera=wrong, **options)
    for up in ((0, 0, 0), place):
        with pytest.raises(cmpg.UsageError):
            front.look_at(place, (0, 0, 0), up=up)


def test_cameras_of_another_shape(scene):
    """Where only one edge is asked for, the other follows from it: of passes and of picks."""
    renderer = cmpg.Renderer(scene, max_depth=2)
    front = scene.camera("front")
    wide = dataclasses.replace(front, aspect=2.0)
    assert renderer.render(camera=front, width=32, spp=1).shape == (32, 32, 3)
    assert renderer.render(camera=dataclasses.replace(front, aspect=None), width=32, spp=1).shape == (32, 32, 3)
    assert renderer.render(camera=wide.look_at((0.4, 0.6, 2.5), (0, 0.5, 0)), width=32, spp=1).shape == (16, 32, 3)
    assert renderer.render(camera=wide, height=8, spp=1).shape == (8, 16, 3)
    np.testing.assert_array_equal(renderer.render(camera=wide, width=32, spp=1), renderer.render(camera=front, width=32, height=16, spp=1))
    assert scene.pick(16, 8, camera=wide, width=32) == scene.pick(16, 8, camera="front", width=32, height=16)
    for wrong in (0, -1, float("nan"), float("inf")):
        for refuse in (lambda camera: renderer.render(camera=camera, width=32), lambda camera: scene.pick(1, 1, camera=camera)):
            with pytest.raises(cmpg.UsageError, match="aspect ratio above 0"):
                refuse(dataclasses.replace(front, aspect=wrong))


def test_cameras_of_a_film_take_another_shape(tmp_path):
    """What a file says in pixels holds as long as the shape is its own."""
    file = tmp_path / "scene.xml"
    file.write_text('<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm"><integer name="width" value="30"/><integer name="height" value="20"/>'
                    '</film></sensor><shape type="sphere"/><emitter type="constant"/></scene>')
    scene = cmpg.Scene(file)
    renderer = cmpg.Renderer(scene)
    assert renderer.render(camera=scene.camera(), spp=1).shape == (20, 30, 3)
    assert renderer.render(camera=dataclasses.replace(scene.camera(), aspect=2), width=30, spp=1).shape == (15, 30, 3)


def test_moved_cameras_see_their_middle(scene):
    """Where a camera looks, it picks."""
    seen = scene.pick(12, 12, camera="front", width=24, height=24)
    moved = scene.camera("front").look_at(np.add(seen.position, seen.normal) + [0.02, 0.03, 0], seen.position)
    again = scene.pick(8, 8, camera=moved, width=16, height=16)
    np.testing.assert_allclose(again.position, seen.position, atol=1e-4)
    assert again.material == seen.material
    assert scene.pick(8, 8, camera=scene.camera("front").look_at((0, 0, 1e3), (0, 0, 2e3)), width=16, height=16) is None


@pytest.fixture
def door(device):
    loaded = cmpg.Scene(ROOT / "scenes/door/scene.gltf")
    loaded._device = device
    return loaded


def test_guides_tell_what_they_know(door):
    renderer = cmpg.Renderer(door, "wall.baseColor", sampling="conditional", max_depth=4, recoveries=True)
    point = door.pick(12, 12, width=24, height=24)
    assert renderer.guide_at(point.position) is None
    renderer.train(passes=2, spp=8, width=24, height=24)
    film = cmpg.Film(24, 24, layers=True)
    renderer.render_into(film, spp=2)
    cells = renderer.guide_cells(film.layers()["depth"])
    found = renderer.guide_at(point.position)
    assert found.cells > 0 and found.cell < found.cells and found.records > 0 and len(found.means) == len(found.weights) == 3
    assert cells.shape == (24, 24, 1) and cells.min() >= -1 and cells.max() < found.cells and cells[12, 12, 0] >= 0
    density = found.density([1, 0, 0], edge=32)
    assert density.shape == (32, 32, 1) and density.mean() == pytest.approx(1, abs=1e-3)
    np.testing.assert_array_equal(found.density(edge=32), found.density(found.weights, edge=32))
    for wrong in (lambda: found.density([1, 0]), lambda: found.density(edge=33), lambda: renderer.guide_at((0, 0)), lambda: renderer.guide_at(point.position, "image"),
                  lambda: renderer.guide_cells(np.ones((4, 4, 3)))):
        with pytest.raises(cmpg.UsageError):
            wrong()

    renderer.set_sampling("bsdf")  # by the guide as it is
    assert renderer.guide_at(point.position).records == found.records
    renderer.forget()
    assert renderer.guide_at(point.position) is None and renderer.guide_cells(film.layers()["depth"]) is None
    with pytest.raises(cmpg.UsageError, match="sampling cannot be"):
        renderer.set_sampling("magic")
    with pytest.raises(cmpg.UsageError, match="recoveries"):
        cmpg.Renderer(door).set_sampling("bsdf")


def test_guide_files_say_what_they_hold(door, tmp_path):
    renderer = cmpg.Renderer(door, "wall.baseColor", max_depth=4)
    renderer.backward(np.ones((24, 24, 3)), spp=4, train=2)
    file = tmp_path / "door.guide"
    renderer.save_guide(file)
    guide = cmpg.Guide(file)
    figures, cells = guide.figures, guide.cells
    assert figures["updates"] == 2 and figures["parameters"] == ["wall.baseColor"] and f"of {figures['cells']} cells" in repr(guide)
    methods = [(m["roulette"], m["sampling"]) for m in figures["methods"]]
    assert methods and len(set(methods)) == len(methods) and all(m["variance"] > 0 and m["passes"] > 0 for m in figures["methods"])
    assert cells["lower"].shape == cells["means"].shape == (figures["cells"], 3) and cells["records"].shape == (figures["cells"], 1)
    assert cells["records"].sum() == pytest.approx(figures["records"]) and cells["nodes"].sum() == figures["nodes"]
    assert cells["records"].argmax() == figures["most_records"]
    assert np.prod(cells["upper"] - cells["lower"], axis=1).sum() == pytest.approx(np.prod(np.subtract(figures["upper"], figures["lower"])))
    density = guide.density(figures["most_records"], edge=32)
    assert density.shape == (32, 32, 1) and density.mean() == pytest.approx(1, abs=1e-3) and guide.fault == ""
    for wrong in (lambda: guide.density(figures["cells"]), lambda: guide.density(0, (1, 0)), lambda: guide.density(0, edge=3)):
        with pytest.raises(cmpg.UsageError):
            wrong()
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(cmpg.InputError):
        cmpg.Guide(file)


def test_images_are_shown_as_they_grow(scene):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=2)
    shown = []
    image = renderer.render(width=16, spp=64, seed=1, on_image=shown.append)
    assert isinstance(shown[-1], cmpg.Image)
    np.testing.assert_array_equal(shown[-1], image)
    np.testing.assert_array_equal(renderer.render(width=16, spp=64, seed=1), image)
    derivative = renderer.forward({PAINTING: 1}, width=16, spp=16, on_image=shown.append)
    np.testing.assert_array_equal(shown[-1], derivative)

    def refuse(image):
        raise LookupError("seen enough")

    with pytest.raises(LookupError, match="seen enough"):
        renderer.render(width=16, spp=64, on_image=refuse)
    np.testing.assert_array_equal(renderer.render(width=16, spp=64, seed=1), image)


def test_submissions_are_told_and_may_end_a_pass(scene, target):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=4)
    calls = []
    renderer.on_submission(lambda: calls.append(1), seconds=0.02)
    image = renderer.render(width=32, spp=16, seed=3)
    assert calls

    def stop():
        raise TimeoutError("no longer wanted")

    film = cmpg.Film(32, 24)
    renderer.on_submission(stop)
    with pytest.raises(TimeoutError, match="no longer wanted"):
        renderer.render_into(film, spp=4)
    assert film.samples == 0
    renderer.on_submission(None)
    np.testing.assert_array_equal(renderer.render(width=32, spp=16, seed=3), image)

    recovery = cmpg.Recovery(scene, target, PAINTING, steps=2, spp=2, spp_gradient=1, max_depth=4)
    recovery.on_submission(stop)
    with pytest.raises(TimeoutError):
        recovery.step()
    assert recovery.steps_done == 0
    recovery.on_submission(None)
    assert recovery.step().step == 0


def test_recoveries_show_the_images_they_compare(grey, target):
    recovery = cmpg.Recovery(grey, {"": target}, PAINTING, steps=3, spp=4, spp_gradient=1, max_depth=4)
    seen = []
    recovery.on_image(lambda number, image: seen.append((number, image)))
    for _ in recovery:
        pass
    assert len(seen) >= 3 and all(number == 0 and image.shape == target.shape for number, image in seen)


def test_callbacks_keep_nothing_alive(scene):
    renderer = cmpg.Renderer(scene, max_depth=2)
    found = weakref.ref(renderer)
    renderer.on_submission(lambda kept=renderer: None)  # a cycle, which the collector sees
    renderer.render(width=8, spp=1)
    del renderer
    gc.collect()
    assert found() is None


def test_callbacks_may_be_taken_away_amidst_a_pass(grey, target):
    renderer = cmpg.Renderer(grey, PAINTING, max_depth=4, recoveries=True)
    recovery = cmpg.Recovery.of(renderer, target)
    threads = []

    def takes(away, *arguments):
        def call(*_):
            if not threads:
                threads.append(threading.Thread(target=away, args=arguments))
                threads[0].start()
            time.sleep(0.02)

        return call

    renderer.on_submission(takes(renderer.on_submission, None), seconds=0.001)
    renderer.render(width=64, spp=64)
    threads.pop().join(20)
    recovery.on_image(lambda *_: None)
    renderer.on_submission(takes(recovery.on_image, None), seconds=0.001)
    recovery.step()
    threads.pop().join(20)


def test_learning_goes_on(door):
    whole, parts = (cmpg.Renderer(door, "wall.baseColor", sampling="primal", max_depth=4, recoveries=r) for r in (False, True))
    image = whole.render(width=16, height=16, spp=4, train=3, seed=7)
    for _ in range(3):
        parts.train(spp=4, width=16, height=16, seed=7)
    film = cmpg.Film(16, 16)
    parts.render_into(film, spp=4, seed=7)
    np.testing.assert_array_equal(film.image(), image)


@pytest.mark.parametrize("passes", [-3, 1.5, 2**40, 100001])
def test_learning_passes_are_named_as_they_are_given(scene, passes):
    with pytest.raises(cmpg.UsageError, match="^passes ") as caught:
        cmpg.Renderer(scene).train(passes=passes, width=8, spp=1)
    assert caught.value.options == ["passes"]


def test_a_recovery_of_a_renderer_is_that_of_a_device(grey, target):
    own = grey.copy()
    alone = cmpg.Recovery(own, target, PAINTING, steps=3, max_depth=4)
    renderer = cmpg.Renderer(grey, PAINTING, max_depth=4, recoveries=True)
    recovery = cmpg.Recovery.of(renderer, target, steps=3)
    assert recovery.parameters == [PAINTING] and not recovery.ended
    for step in recovery:
        assert step.loss == alone.step().loss
        np.testing.assert_array_equal(grey[PAINTING].values, alone[PAINTING])  # the scene's own
        np.testing.assert_array_equal(recovery.gradient(PAINTING), alone.gradient(PAINTING))
        renderer.render_into(cmpg.Film(16, 16), spp=2)  # leaves no trace
    assert recovery.done and grey._changed == {PAINTING}
    film = cmpg.Film(32, 32)
    assert recovery.image_into(film, spp=3).spp == 3
    recovery.image_into(film, spp=6)
    np.testing.assert_array_equal(film.image(), recovery.image(spp=9))
    np.testing.assert_array_equal(recovery.target(), target)
    with pytest.raises(cmpg.UsageError, match="makes no recoveries"):
        cmpg.Recovery.of(cmpg.Renderer(grey, PAINTING), target)
    with pytest.raises(cmpg.UsageError, match="no target 1"):
        recovery.target(1)


def test_goes_on_where_a_recovery_ended(grey, target, tmp_path):
    renderer = cmpg.Renderer(grey, PAINTING, max_depth=4, recoveries=True)
    recovery = cmpg.Recovery.of(renderer, {grey.camera("front"): target})
    recovery.set_samples(8, 2)
    recovery.step()
    recovery.save(tmp_path)
    kept = grey[PAINTING].values
    recovery.set_rate_factor(0)
    recovery.step()
    np.testing.assert_array_equal(grey[PAINTING].values, kept)
    grey[PAINTING] = 0.25  # taken over
    recovery.step()
    assert (recovery[PAINTING] == 0.25).all()
    assert recovery.resume(tmp_path) and recovery.steps_done == 1
    np.testing.assert_array_equal(grey[PAINTING].values, kept)

    renderer.set_sampling("conditional")
    assert recovery.ended and recovery.steps_done == 1
    with pytest.raises(cmpg.UsageError, match="ended") as refused:
        recovery.step()
    assert refused.value.cause and refused.value.remedy
    more = cmpg.Renderer(grey, [PAINTING, "white.baseColor"], max_depth=4, recoveries=True)
    following = cmpg.Recovery.of(more, target, progress=recovery.progress())
    assert following.steps_done == 1 and following.step().step == 1
    assert (grey[PAINTING].values != kept).any()


def test_another_size_ends_a_recovery(grey, target):
    """What it still tells has the shape of its values."""
    renderer = cmpg.Renderer(grey, PAINTING, max_depth=4, recoveries=True)
    recovery = cmpg.Recovery.of(renderer, target, steps=3, spp=2, spp_gradient=1)
    recovery.step()
    gradient = recovery.gradient(PAINTING)
    assert gradient.shape == (64, 64, 3) and gradient.any()
    grey.resize(PAINTING, 4, 2)
    with pytest.raises(cmpg.UsageError, match="has ended"):
        recovery.step()
    assert recovery[PAINTING].shape == (2, 4, 3)
    np.testing.assert_array_equal(recovery[PAINTING], grey[PAINTING].values)
    np.testing.assert_array_equal(recovery.gradient(PAINTING), gradient)
    recovery = cmpg.Recovery.of(renderer, target, steps=3, spp=2, spp_gradient=1)
    grey.resize(PAINTING, 8, 8)
    with pytest.raises(cmpg.UsageError, match="has ended"):
        recovery.step()
    assert recovery.gradient(PAINTING).shape == (2, 4, 3) and not recovery.gradient(PAINTING).any()


def test_targets_of_moved_cameras(grey, target):
    """The target decides where the camera stands."""
    aside = grey.camera("front").look_at((0.2, 0.5, 2), (0, 0, 0))
    seen = cmpg.Renderer(grey, max_depth=4).render(camera=aside, width=16, height=16, spp=64)
    recovery = cmpg.Recovery(grey, {"front": target, aside: seen}, PAINTING, max_depth=4)
    recovery.step()
    np.testing.assert_allclose(recovery.image(1, spp=64, initial=True).mean(), seen.mean(), rtol=0.05)


def test_interrupt_ends_a_step_of_a_renderer(grey):
    renderer = cmpg.Renderer(grey, PAINTING, recoveries=True)
    recovery = cmpg.Recovery.of(renderer, np.ones((64, 64, 3)), spp=64, spp_gradient=64, spp_difference=0)
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in recovery:
            pass
    timer.join()
    done, values = recovery.steps_done, grey[PAINTING].values
    np.testing.assert_array_equal(recovery[PAINTING], values)
    assert renderer.render(width=16, spp=2).shape[1] == 16  # goes on being usable
    assert recovery.step().step == done


def test_handles_go_in_any_order(grey, target):
    renderer = cmpg.Renderer(grey, PAINTING, max_depth=3, recoveries=True)
    recovery = cmpg.Recovery.of(renderer, target)
    del renderer
    recovery.step()
    progress = recovery.progress()
    del recovery
    assert cmpg.Recovery.of(cmpg.Renderer(grey, PAINTING, max_depth=3, recoveries=True), target, progress=progress).steps_done == 1
