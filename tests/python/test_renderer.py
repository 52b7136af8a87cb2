"""Images and derivatives."""

import threading
import time

import numpy as np
import pytest
from conftest import LIGHT, PAINTING, ROOT

import cmpg
from cmpg._arrays import key_of


def test_renders(scene):
    renderer = cmpg.Renderer(scene, max_depth=4)
    image = renderer.render(width=24, height=16, spp=4, seed=3)
    assert image.shape == (16, 24, 3) and image.dtype == np.float32 and isinstance(image, cmpg.Image)
    np.testing.assert_array_equal(image, renderer.render(width=24, height=16, spp=4, seed=3))
    assert (image != renderer.render(width=24, height=16, spp=4, seed=4)).any()
    assert (image != renderer.render(width=24, height=16, spp=4, seed=3, camera="corner")).any()


def test_follows_the_scene(scene):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=3)
    before = renderer.render(width=16, spp=4)
    for name in (PAINTING, "white.baseColor"):  # one that the renderer differentiates, and another
        kept = scene[name].values
        scene[name] = 0.0
        assert renderer.render(width=16, spp=4).mean() < before.mean()
        scene[name] = kept
        np.testing.assert_array_equal(renderer.render(width=16, spp=4), before)


def test_forward_is_the_derivative(scene):
    renderer = cmpg.Renderer(scene, LIGHT, max_depth=3)
    light = scene[LIGHT].values
    derivative = renderer.forward({LIGHT: light}, width=16, spp=4, frozen=True)
    image = renderer.render(width=16, spp=4, frozen=True)
    scene[LIGHT] = 2 * light
    difference = renderer.render(width=16, spp=4, frozen=True) - image
    assert difference.max() > 0.1
    np.testing.assert_allclose(derivative, difference, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("name, step", [(LIGHT, 0.5), ("white.baseColor", 0.01)])
def test_backward_agrees_with_finite_differences(scene, name, step):
    """With the same random numbers in all passes. Base colours are no factor of what is drawn in a scene without gloss."""
    for other in scene.select("*.specular"):
        scene[other] = 0
    renderer = cmpg.Renderer(scene, name, max_depth=4)
    adjoint = np.random.default_rng(2).random((16, 16, 3), dtype=np.float32)
    gradient = renderer.backward(adjoint, spp=4, seed=5, frozen=True)[name]
    values = scene[name].values
    for channel in range(3):
        loss = []
        for sign in (1, -1):
            moved = values.copy()
            moved[..., channel] += sign * step
            scene[name] = moved
            image = renderer.render(width=16, height=16, spp=4, seed=5, frozen=True)
            loss.append(np.sum(np.asarray(adjoint, dtype=np.float64) * image))
        expected = (loss[0] - loss[1]) / (2 * step)
        scene[name] = values
        assert expected > 1
        assert gradient[..., channel].sum() == pytest.approx(expected, rel=2e-3)


def test_backward_is_the_transpose_of_forward(scene):
    renderer = cmpg.Renderer(scene, [PAINTING, LIGHT], max_depth=3)
    adjoint = np.random.default_rng(2).random((16, 16, 3), dtype=np.float32)
    gradients = renderer.backward(adjoint, spp=4, frozen=True)
    assert list(gradients) == renderer.parameters == [PAINTING, LIGHT]
    for name, gradient in gradients.items():
        assert gradient.shape == scene[name].shape and gradient.dtype == np.float32
        image = renderer.forward({name: 1}, width=16, height=16, spp=4, frozen=True)
        assert gradient.sum() == pytest.approx((adjoint * image).sum(), rel=1e-3)


def test_images_and_derivatives_have_random_numbers_of_their_own(scene):
    renderer = cmpg.Renderer(scene, LIGHT, max_depth=3)
    frozen, free = (renderer.forward({LIGHT: scene[LIGHT].values}, width=16, spp=4, frozen=f) for f in (True, False))
    assert (frozen != free).any()


def test_learning_passes_guide(device):
    door = cmpg.Scene(ROOT / "scenes/door/scene.gltf")
    renderer = cmpg.Renderer(door, device=device, sampling="primal")
    plain = renderer.render(width=16, spp=4)
    guided = renderer.render(width=16, spp=4, train=2)
    assert (guided != plain).any()
    np.testing.assert_array_equal(renderer.render(width=16, spp=4), guided)  # draws from what was learned
    np.testing.assert_array_equal(renderer.render(width=16, spp=4, train=2), guided)  # anew


def test_refuses_wrong_shapes(scene):
    renderer = cmpg.Renderer(scene, LIGHT)
    with pytest.raises(cmpg.UsageError):
        renderer.backward(np.ones((16, 16)))
    with pytest.raises(cmpg.UsageError):
        renderer.forward({PAINTING: 1}, width=8)
    with pytest.raises(cmpg.UsageError):
        cmpg.Renderer(scene).backward(np.ones((8, 8, 3)))


def test_names_the_count_that_is_negative(scene):
    renderer = cmpg.Renderer(scene)
    for call in (lambda: renderer.render(width=8, spp=-1), lambda: cmpg.Renderer(scene, max_depth=-2), lambda: cmpg.Film(8, -8), lambda: renderer.train(passes=-3)):
        with pytest.raises(cmpg.UsageError, match="spp is -1|max_depth is -2|height must be from 1|passes is -3"):
            call()
    with pytest.raises(cmpg.UsageError, match="steps is -1"):
        cmpg.Recovery(scene, np.ones((8, 8, 3)), PAINTING, steps=-1)
    with pytest.raises(cmpg.UsageError, match="complex"):
        scene[PAINTING] = 0.5j


@pytest.mark.parametrize(
    "call, name",
    [
        (lambda scene: cmpg.Renderer(scene).render(width=2**40), "width"),
        (lambda scene: cmpg.Renderer(scene).render(width=8.0), "width"),
        (lambda scene: cmpg.Renderer(scene).render(width=8, spp=2**40), "spp"),
        (lambda scene: cmpg.Renderer(scene).render(width=8, spp=np.float32(2)), "spp"),
        (lambda scene: cmpg.Renderer(scene).render(width=8, seed=2**64), "seed"),
        (lambda scene: cmpg.Renderer(scene).render(width=8, seed=-1), "seed"),
        (lambda scene: cmpg.Renderer(scene, memory=1.5), "memory"),
        (lambda scene: cmpg.Renderer(scene, LIGHT).check(LIGHT, spp_gradient=-1), "spp_gradient"),
        (lambda scene: cmpg.Recovery(scene, np.ones((8, 8, 3)), LIGHT, steps=2**40), "steps"),
        (lambda scene: cmpg.Recovery(scene, np.ones((8, 8, 3)), LIGHT, width=4.0), "width"),
        (lambda scene: cmpg.Recovery(scene, np.ones((8, 8, 3)), LIGHT).set_samples(4, -1), "spp_gradient"),
        (lambda scene: cmpg.Recovery(scene, np.ones((8, 8, 3)), LIGHT).image(-1), "target"),
        (lambda scene: cmpg.Film(8, 2**40), "height"),
        (lambda scene: scene.resize(PAINTING, 8.0, 8), "width"),
        (lambda scene: scene.pick(1, 1, height=2**40), "height"),
    ],
)
def test_names_what_is_no_number_of_its_kind(scene, call, name):
    with pytest.raises(cmpg.UsageError, match=f"^{name} is ") as caught:
        call(scene)
    assert caught.value.options == [name] and "a whole number from 0 to" in caught.value.remedy


def test_takes_whole_numbers_of_numpy(scene):
    renderer = cmpg.Renderer(scene, max_depth=2)
    image = renderer.render(width=np.int64(8), spp=np.uint8(1), seed=np.uint64(2**64 - 1))
    np.testing.assert_array_equal(image, renderer.render(width=8, spp=1, seed=2**64 - 1))


def test_equal_options_have_one_key():
    """By which renderers of cmpg.torch are kept."""
    key = key_of({"max_depth": 4, "expert": {"guide_share": 0.3, "forgetting": 0.5}})
    assert {key: 1}[key_of({"expert": {"forgetting": 0.5, "guide_share": 0.3}, "max_depth": 4})] == 1
    assert key != key_of({"max_depth": 4, "expert": {"guide_share": 0.4, "forgetting": 0.5}}) != key_of({"max_depth": 4})


def test_two_scenes_at_once(scene):
    """Each on a device of its own, from threads of their own."""
    other = cmpg.Scene(ROOT / "scenes/furnace/scene.gltf")
    renderers = [cmpg.Renderer(scene, max_depth=4), cmpg.Renderer(other, max_depth=4)]
    assert scene.device is not other.device
    alone = [r.render(width=16, spp=2) for r in renderers]
    found = [[], []]

    def work(i):
        for _ in range(5):
            found[i].append(renderers[i].render(width=16, spp=2))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i in range(2):
        assert len(found[i]) == 5
        for image in found[i]:
            np.testing.assert_array_equal(image, alone[i])


def test_other_threads_run_meanwhile(scene):
    renderer = cmpg.Renderer(scene)
    renderer.render(width=8, spp=1)
    done = threading.Event()
    ticks = []

    def tick():
        while not done.wait(0.005):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    renderer.render(width=64, spp=64)
    end = time.perf_counter()
    done.set()
    thread.join()
    within = sum(begin < t < end for t in ticks)
    assert end - begin > 0.05, "the pass is too short to tell"
    assert within > 0.1 * (end - begin) / 0.005


def test_renderers_go_while_others_work(scene):
    """Dropping the last reference waits for the device without the interpreter's lock."""
    working = cmpg.Renderer(scene)
    thread = threading.Thread(target=lambda: working.render(width=64, spp=32))
    thread.start()
    for _ in range(5):
        cmpg.Renderer(scene).render(width=8, spp=1)
    thread.join()


def test_samples_until_the_error_is_small_enough(scene):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=3)
    assert renderer.report is None
    image = renderer.render(width=24, error_target=0.05)
    report = renderer.report
    assert report.end == "error" and report.error <= 0.05 and report.error_low < report.error_high
    assert report.paths == report.spp * image.shape[0] * image.shape[1]
    np.testing.assert_array_equal(renderer.render(width=24, spp=report.spp, batches=8), image)
    renderer.backward(np.ones((18, 24, 3)), spp=16, error_target=1e-6)
    assert renderer.report.end == "samples" and renderer.report.spp == 16
    with pytest.raises(cmpg.UsageError, match="error_target"):
        renderer.render(error_target=-1)


def test_guides_are_saved_and_loaded(scene, tmp_path):
    options = {"max_depth": 3, "sampling": "conditional"}
    renderer = cmpg.Renderer(scene, PAINTING, **options)
    with pytest.raises(cmpg.UsageError, match="train"):
        renderer.save_guide(tmp_path / "guide")
    image = renderer.render(width=16, spp=4, train=2)
    assert renderer.report.sampling == "conditional" and renderer.report.figures[0]["variance"] > 0
    renderer.save_guide(tmp_path / "guide")
    again = cmpg.Renderer(scene, PAINTING, load_guide=tmp_path / "guide", **options)
    np.testing.assert_array_equal(again.render(width=16, spp=4), image)
    other = cmpg.Renderer(scene, PAINTING, load_guide=tmp_path / "guide", expert={"guide_share": 0.2}, **options)
    assert (other.render(width=16, spp=4) != image).any()
    with pytest.raises(cmpg.UsageError, match="expert option"):
        cmpg.Renderer(scene, expert={"speed": 2})


def test_layers_and_samplers(scene):
    renderer = cmpg.Renderer(scene, max_depth=2)
    image = renderer.render(width=16, spp=2, layers=True)
    layers = renderer.report.layers()
    assert layers["normal"].shape == image.shape and layers["depth"].shape == (*image.shape[:2], 1)
    assert "guided" not in layers
    assert (cmpg.Renderer(scene, max_depth=2, sampler="independent").render(width=16, spp=2) != image).any()


def test_check_agrees(scene):
    found = cmpg.Renderer(scene, PAINTING, max_depth=2).check(PAINTING, width=24, spp=4)
    assert found["agrees"] and found["comparisons"][0]["what"] == "red mean"
    assert abs(found["comparisons"][0]["relative_error"]) < 0.1


def test_footprint_tells_what_passes_take(scene):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=3)
    before = scene.device.memory_in_use
    images, derivatives = renderer.footprint(), renderer.footprint(["render", "backward"])
    assert scene.device.memory_in_use == before
    assert {k["kind"] for k in images["kernels"]} == {"render"} and {k["kind"] for k in derivatives["kernels"]} == {"render", "backward"}
    assert all(0 < k["bytes"] <= k["module_bytes"] for k in derivatives["kernels"])
    assert sum(derivatives["buffers"].values()) > sum(images["buffers"].values()) > 0
    assert derivatives["features"]["differentiated"] == "baseColor" and derivatives["features"]["guided directions"] == "off"
    assert renderer.footprint(train=True)["features"]["guided directions"] == "on"
    renderer.render(width=8, spp=1)
    assert renderer.footprint() == images  # beside what the renderer has itself
    with pytest.raises(cmpg.UsageError, match="kinds"):
        renderer.footprint("image")


def test_says_which_argument_means_nothing(scene):
    renderer = cmpg.Renderer(scene, param=PAINTING, max_depth=2)
    for name, value in {"error_target": "2%", "time_budget": "1s", "spp": 1.5, "width": 16.0}.items():
        with pytest.raises(cmpg.UsageError, match=name):
            renderer.render(**{name: value})
    with pytest.raises(cmpg.UsageError, match="a direction is a mapping"):
        renderer.forward(PAINTING)
