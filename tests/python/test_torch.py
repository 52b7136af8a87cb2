"""The bridge to PyTorch."""

import gc
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import BOX, LIGHT, PAINTING, ROOT

torch = pytest.importorskip("torch", reason="PyTorch is not installed: scripts/python-env --torch")

import cmpg  # noqa: E402
import cmpg.torch  # noqa: E402


def tensor(scene, name, dtype=torch.float32):
    return torch.tensor(np.asarray(scene[name].values), dtype=dtype, requires_grad=True)


def test_gradcheck(scene):
    """Of all entries of a light's emission, which the image is linear in, with the same random numbers in all passes."""
    light = tensor(scene, LIGHT, torch.float64)
    assert torch.autograd.gradcheck(lambda e: cmpg.torch.render(scene, {LIGHT: e}, width=4, height=4, spp=4, max_depth=3, frozen=True), (light,),
                                    eps=0.5, atol=1e-4, rtol=1e-3)


def test_agrees_with_the_renderer(scene):
    painting = tensor(scene, PAINTING)
    image = cmpg.torch.render(scene, {PAINTING: painting}, width=16, spp=4, seed=3, max_depth=4)
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=4)
    np.testing.assert_array_equal(image.detach().numpy(), renderer.render(width=16, spp=4, seed=3))
    image.square().sum().backward()
    expected = renderer.backward(2 * image.detach().numpy(), spp=4, seed=3)[PAINTING]
    aside = scene.camera("front").look_at((0.2, 0.5, 2), (0, 0, 0))
    moved = cmpg.torch.render(scene, {PAINTING: painting}, camera=aside, width=16, spp=4, seed=3, max_depth=4)
    np.testing.assert_array_equal(moved.detach().numpy(), renderer.render(camera=aside, width=16, spp=4, seed=3))
    np.testing.assert_array_equal(painting.grad.numpy(), expected)


def test_no_part_of_the_graph_is_cut(scene):
    """All tensors get a gradient, through functions before and after the image; those that need none get none."""
    painting, light = tensor(scene, PAINTING), tensor(scene, LIGHT)
    other = torch.full((1, 1, 1), 0.4)
    logits = torch.logit(painting.detach(), eps=1e-3).requires_grad_()
    image = cmpg.torch.render(scene, {PAINTING: torch.sigmoid(logits), LIGHT: light, "painting.roughness": other}, width=16, spp=4, max_depth=4)
    assert image.requires_grad
    (image * image).mean().backward()
    assert logits.grad.abs().sum() > 0 and light.grad.abs().sum() > 0 and painting.grad is None and other.grad is None


def test_images_of_other_values_do_not_disturb(scene):
    """Two images of one graph, made before the derivatives of either."""
    a, b = torch.full((64, 64, 3), 0.2, requires_grad=True), torch.full((64, 64, 3), 0.8, requires_grad=True)
    options = dict(width=16, spp=4, max_depth=4)
    alone = cmpg.torch.render(scene, {PAINTING: a}, **options)
    alone.square().sum().backward()
    expected, a.grad = a.grad.clone(), None
    first, second = (cmpg.torch.render(scene, {PAINTING: t}, **options) for t in (a, b))
    (first.square().sum() + second.square().sum()).backward()
    torch.testing.assert_close(a.grad, expected, rtol=0, atol=0)
    assert (b.grad != a.grad).any()


def test_scene_keeps_its_values_and_others_are_followed(scene):
    kept = scene[PAINTING].values
    white = torch.full((64, 64, 3), 1.0)
    before = cmpg.torch.render(scene, {PAINTING: white}, width=16, spp=2, max_depth=4)
    np.testing.assert_array_equal(scene[PAINTING].values, kept)
    scene[LIGHT] = 0
    assert cmpg.torch.render(scene, {PAINTING: white}, width=16, spp=2, max_depth=4).sum() < before.sum()


def test_options_for_experts_are_options(scene):
    white = torch.full((64, 64, 3), 1.0)
    options = dict(width=16, spp=2, max_depth=4)
    plain = cmpg.torch.render(scene, {PAINTING: white}, **options)
    for _ in range(2):
        torch.testing.assert_close(cmpg.torch.render(scene, {PAINTING: white}, expert={"all_features": 1}, **options), plain, rtol=0, atol=0)
    assert len(scene._renderers) == 2


def test_types_and_devices_are_those_of_the_tensors(scene):
    painting = tensor(scene, PAINTING, torch.float64)
    image = cmpg.torch.render(scene, {PAINTING: painting}, width=8, spp=1, max_depth=3)
    assert image.dtype == torch.float64 and image.device == painting.device
    image.sum().backward()
    assert painting.grad.dtype == torch.float64 and painting.grad.device == painting.device
    if torch.cuda.is_available():
        on_gpu = painting.detach().cuda().requires_grad_()
        image = cmpg.torch.render(scene, {PAINTING: on_gpu}, width=8, spp=1, max_depth=3)
        image.sum().backward()
        assert image.is_cuda and on_gpu.grad.is_cuda


def test_memory_does_not_grow_with_steps(scene):
    painting = tensor(scene, PAINTING)

    def step(seed):
        image = cmpg.torch.render(scene, {PAINTING: painting}, width=16, spp=1, seed=seed, max_depth=3)
        image.sum().backward()
        painting.grad = None

    for seed in range(3):
        step(seed)
    gc.collect()
    tensors, memory = sum(type(o) is torch.Tensor for o in gc.get_objects()), scene.device.memory_in_use
    for seed in range(20):
        step(seed)
    gc.collect()
    assert sum(type(o) is torch.Tensor for o in gc.get_objects()) == tensors
    assert scene.device.memory_in_use == memory


def test_wrong_tensors_are_refused(scene):
    with pytest.raises(cmpg.UsageError, match="shape"):
        cmpg.torch.render(scene, {PAINTING: torch.zeros(3, 64, 64)})
    with pytest.raises(cmpg.UsageError, match="floating"):
        cmpg.torch.render(scene, {PAINTING: torch.zeros(64, 64, 3, dtype=torch.int32)})
    with pytest.raises(cmpg.UsageError, match="range"):
        cmpg.torch.render(scene, {PAINTING: torch.full((64, 64, 3), 2.0)})
    with pytest.raises(cmpg.UsageError):
        cmpg.torch.render(scene, {})


def test_second_derivatives_are_refused_and_not_wrong(scene):
    light = tensor(scene, LIGHT)
    loss = cmpg.torch.render(scene, {LIGHT: light}, width=8, spp=1, max_depth=3).square().sum()
    (gradient,) = torch.autograd.grad(loss, light, create_graph=True)
    with pytest.raises(RuntimeError):
        gradient.sum().backward()


def test_a_network_learns_a_texture(scene):
    """A small network from texture coordinates to colours, by Adam and a loss of torch."""
    torch.manual_seed(0)
    target = torch.from_numpy(np.asarray(cmpg.Renderer(scene, max_depth=3).render(width=24, spp=32, seed=99)))
    y, x = torch.meshgrid(torch.linspace(-1, 1, 64), torch.linspace(-1, 1, 64), indexing="ij")
    waves = torch.stack([f(k * 3.14 * c) for k in (1, 2) for c in (x, y) for f in (torch.sin, torch.cos)], dim=-1)
    network = torch.nn.Sequential(torch.nn.Linear(8, 32), torch.nn.ReLU(), torch.nn.Linear(32, 3), torch.nn.Sigmoid())
    optimizer = torch.optim.Adam(network.parameters(), lr=0.02)

    def error():
        return np.square(network(waves).detach().numpy() - scene[PAINTING].values).mean()

    before = error()
    for step in range(40):
        image = cmpg.torch.render(scene, {PAINTING: network(waves)}, width=24, spp=8, seed=step, max_depth=3)
        loss = torch.nn.functional.mse_loss(image, target)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    assert error() < 0.5 * before


def test_two_processes_average_their_gradients(tmp_path):
    """The example with torch.distributed: both hold the same texture, whose error falls."""
    result = subprocess.run([sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2",
                             ROOT / "python/examples/recover_distributed.py", "25", tmp_path / "out"], capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr
    errors = {rank: re.findall(rf"process {rank}, .* error of a texel ([0-9.]+)", result.stdout) for rank in "01"}
    losses = {rank: re.findall(rf"process {rank}, .* image ([0-9.]+)", result.stdout) for rank in "01"}
    assert len(errors["0"]) == 25 and errors["0"] == errors["1"] and losses["0"] != losses["1"]
    assert float(errors["0"][-1]) < 0.8 * float(errors["0"][0])
    assert (tmp_path / "out/painting.png").stat().st_size > 0


def test_ends_quietly_with_an_image_that_lives():
    """Torch frees no graph once the interpreter ends; what was in one may be reported as leaked then."""
    code = f"""
import torch, cmpg, cmpg.torch
scene = cmpg.Scene({str(BOX)!r})
painting = torch.full((64, 64, 3), 0.5, requires_grad=True)
image = cmpg.torch.render(scene, {{{PAINTING!r}: painting}}, width=8, spp=1, max_depth=2)
image.mean().backward()
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")
