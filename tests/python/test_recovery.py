"""Recoveries: iterators over steps."""

import os
import signal
import threading

import numpy as np
import pytest
from conftest import PAINTING, ROOT

import cmpg


def test_loss_falls(scene):
    target = cmpg.Renderer(scene, max_depth=4).render(width=32, spp=1024, seed=1)
    scene[PAINTING] = grey = np.full((64, 64, 3), 0.5)
    # The loss is one without the image's noise, and negative where that is larger than it.
    recovery = cmpg.Recovery(scene, target, PAINTING, steps=6, spp=512, spp_difference=0, max_depth=4)
    steps = list(recovery)
    assert [s.step for s in steps] == list(range(6)) and recovery.done and recovery.steps_done == 6
    assert steps[-1].loss < 0.65 * steps[0].loss  # 0.58 to 0.59 with seeds 0 to 2
    assert all(s.seconds > 0 and s.gradient_norm > 0 and s.dropped == 0 for s in steps)
    assert (scene[PAINTING].values == grey).all()
    assert recovery.gradient(PAINTING).shape == recovery[PAINTING].shape == (64, 64, 3)
    assert recovery.image(spp=8).shape == (32, 32, 3)
    recovery.apply(scene)
    np.testing.assert_array_equal(scene[PAINTING].values, recovery[PAINTING])
    assert list(recovery) == []  # done


def test_takes_files_cameras_and_masks(grey, target, tmp_path):
    corner = cmpg.Renderer(grey, max_depth=4).render(camera="corner", width=16, spp=8)
    target.save(tmp_path / "front.exr")
    recovery = cmpg.Recovery(grey, {"front": tmp_path / "front.exr", "corner": corner}, PAINTING, max_depth=4)
    recovery.step()
    assert recovery.image(1, spp=1).shape == (16, 16, 3)

    same = cmpg.Recovery(grey, target, PAINTING, max_depth=4)
    masked = cmpg.Recovery(grey, target, PAINTING, mask=np.eye(32), max_depth=4)
    assert same.step().loss != masked.step().loss
    exposed = cmpg.Recovery(grey, target / 4, PAINTING, target_exposure=2, max_depth=4)
    exposed.step()
    np.testing.assert_array_equal(exposed[PAINTING], same[PAINTING])


def test_averages_targets(grey, target, tmp_path):
    target.save(tmp_path / "target.exr")
    half = np.asarray(target).reshape(target.shape[0] // 2, 2, target.shape[1] // 2, 2, 3).mean(axis=(1, 3))
    for given in (target, tmp_path / "target.exr"):
        recovery = cmpg.Recovery(grey, given, PAINTING, steps=1, width=target.shape[1] // 2)
        np.testing.assert_allclose(recovery.target(), half, rtol=1e-5)
    with pytest.raises(cmpg.InputError, match="target"):
        cmpg.Recovery(grey, target, PAINTING, width=2 * target.shape[1])


def test_takes_a_mask_for_each_camera(grey, target):
    ones, some = np.ones((32, 32)), np.eye(32)

    def loss(mask):
        return cmpg.Recovery(grey, {"front": target, "corner": target}, PAINTING, mask=mask, max_depth=4).step().loss

    both = loss({"front": some, "corner": ones})
    assert loss({"front": some}) == both  # a camera without one has all its pixels
    assert loss({"corner": some}) != both
    assert loss(some) == loss({"front": some, "corner": some})
    with pytest.raises(cmpg.UsageError, match="a mask of side, but no target"):
        loss({"side": some})


def test_masks_have_the_shape_of_their_target(grey):
    image, weights = np.ones((8, 16, 3)), np.ones((8, 16))
    value, _ = cmpg.loss_of(image, image / 2, mask=weights)
    assert cmpg.loss_of(image, image / 2, mask=weights[:, :, None])[0] == value
    for wrong in (weights.T, weights.ravel(), np.ones((8, 16, 3)), weights[:4]):
        for refuse in (lambda: cmpg.loss_of(image, image, mask=wrong), lambda: cmpg.Recovery(grey, image, PAINTING, mask=wrong)):
            with pytest.raises(cmpg.UsageError, match=r"the mask has the shape .*, not \(8, 16\)") as caught:
                refuse()
            assert caught.value.options == ["mask"]


def test_reads_files_when_steps_see_them(grey, target, tmp_path, monkeypatch):
    target.save(tmp_path / "target.exr")
    held = cmpg.Recovery(grey, tmp_path / "target.exr", PAINTING, max_depth=4)
    monkeypatch.setattr("cmpg._recovery.MOST_TARGET_BYTES", 0)
    streamed = cmpg.Recovery(grey, tmp_path / "target.exr", PAINTING, max_depth=4)
    assert held.step().loss == streamed.step().loss
    (target * 2).save(tmp_path / "target.exr")
    with pytest.raises(cmpg.InputError, match="another one than at the start"):
        streamed.step()


def test_goes_on_from_a_checkpoint(grey, target, tmp_path):
    options = dict(max_depth=4, rate={"baseColor": 0.05})
    whole, half, resumed = (cmpg.Recovery(grey, target, PAINTING, **options) for _ in range(3))
    for _ in range(4):
        whole.step()
    half.step()
    half.step()
    half.save(tmp_path / "kept", note="two steps")
    assert cmpg.Recovery.note(tmp_path / "kept") == "two steps" and cmpg.Recovery.note(tmp_path / "none") is None
    assert not resumed.resume(tmp_path / "none")
    assert resumed.resume(tmp_path / "kept") and resumed.steps_done == 2
    resumed.step()
    resumed.step()
    np.testing.assert_array_equal(resumed[PAINTING], whole[PAINTING])
    assert [s.loss for s in resumed.history] == [s.loss for s in whole.history] and len(whole.history) == 4
    with pytest.raises(cmpg.UsageError, match="rate of baseColor") as refused:
        cmpg.Recovery(grey, target, PAINTING, max_depth=4).resume(tmp_path / "kept")
    assert refused.value.options == ["rate", "resume"]


def test_tells_what_it_did(grey, target):
    recovery = cmpg.Recovery(grey, target, PAINTING, max_depth=4)
    start = recovery.image(spp=4)
    step = recovery.step()
    assert 0 < step.image_seconds + step.gradient_seconds <= step.seconds and step.warnings == []
    np.testing.assert_array_equal(recovery.image(spp=4, initial=True), start)
    assert (recovery.image(spp=4) != start).any()
    assert recovery.report.paths > 0 and recovery.report.sampling in ("bsdf", "primal", "conditional") and recovery.report.guided


def test_interrupt_ends_a_recovery(grey):
    """Within a step, which can then be done again."""
    target = np.ones((64, 64, 3))
    recovery = cmpg.Recovery(grey, target, PAINTING, spp=64, spp_gradient=64, spp_difference=0)
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in recovery:
            pass
    timer.join()
    assert recovery.steps_done < 200
    done = recovery.steps_done
    assert recovery.step().step == done


def test_refuses_what_makes_no_sense(scene, target):
    with pytest.raises(cmpg.UsageError, match="loss cannot be 'huber'"):
        cmpg.Recovery(scene, target, PAINTING, loss="huber")
    with pytest.raises(cmpg.UsageError) as caught:
        cmpg.Recovery(scene, target, [])
    assert caught.value.options == ["param"]
    with pytest.raises(cmpg.InputError):
        cmpg.Recovery(scene, ROOT / "nowhere.exr", PAINTING)
    with pytest.raises(cmpg.UsageError, match="codes of a picture"):
        cmpg.Recovery(scene, (255 * target).astype("uint8"), PAINTING)
    with pytest.raises(cmpg.UsageError):
        cmpg.Recovery(scene, target, PAINTING)["white.baseColor"]


def test_defaults_are_those_of_the_command_line(grey, target, tmp_path):
    import subprocess

    program = os.environ.get("CMPG_BINARY")
    if not program:
        pytest.skip("CMPG_BINARY does not say where the program is")
    target.save(tmp_path / "target.exr")
    subprocess.run([program, "--headless", "--quiet", "optimize", ROOT / "scenes/box/scene.gltf", "--param", PAINTING, "--set", PAINTING + "=0.5",
                    "--target", tmp_path / "target.exr", "--steps", "3", "-o", tmp_path / "run"], check=True, capture_output=True)
    recovery = cmpg.Recovery(grey, target, PAINTING, steps=3)
    for _ in recovery:
        pass
    np.testing.assert_array_equal(recovery[PAINTING], cmpg.load_image(tmp_path / "run/parameters/painting.baseColor.exr"))
    continued = cmpg.Recovery(grey, target, PAINTING, steps=3)  # from the program's checkpoint
    assert continued.resume(tmp_path / "run") and continued.steps_done == 3
    np.testing.assert_array_equal(continued[PAINTING], recovery[PAINTING])


def test_refuses_what_is_not_finite_and_rates_that_are_none(grey, target):
    broken = np.array(target)
    broken[3, 4] = np.nan
    with pytest.raises(cmpg.UsageError, match="not finite"):
        cmpg.loss_of(broken, target)
    with pytest.raises(cmpg.UsageError, match="not finite"):
        cmpg.Renderer(grey, PAINTING).forward({PAINTING: np.nan}, width=8, spp=1)
    with pytest.raises(cmpg.UsageError, match="has the shape"):
        cmpg.Renderer(grey, PAINTING).forward({PAINTING: np.ones((3, 5))}, width=8, spp=1)
    with pytest.raises(cmpg.UsageError, match="above 0 with an exponential schedule"):
        cmpg.Recovery(grey, target, PAINTING, schedule="exponential", final_rate=0)


def test_losses_of_images_have_their_derivative(target):
    rng = np.random.default_rng(5)
    image = target + rng.normal(0, 0.1, target.shape).astype(np.float32)
    value, adjoint = cmpg.loss_of(image, target)
    assert value == pytest.approx(np.mean((image - target) ** 2), rel=1e-5)
    np.testing.assert_allclose(adjoint, 2 * (image - target) / target.size, rtol=1e-4, atol=1e-9)
    mask = np.zeros(target.shape[:2])
    mask[3:9, 2:20] = 1
    value, adjoint = cmpg.loss_of(image, target, "l1", mask=mask)
    assert value == pytest.approx(np.abs(image - target)[mask > 0].mean(), rel=1e-5)
    assert (np.asarray(adjoint)[mask == 0] == 0).all()
    with pytest.raises(cmpg.InputError):
        cmpg.loss_of(image[1:], target)
    with pytest.raises(cmpg.UsageError, match="loss cannot be"):
        cmpg.loss_of(image, target, "none")
