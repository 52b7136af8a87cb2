"""Images as functions of torch tensors, so that any loss, network or optimiser can stand around them.

    image = cmpg.torch.render(scene, {"painting.baseColor": texture}, width=128, seed=step)
    loss = ((image - target) ** 2).mean()
    loss.backward()  # texture.grad
"""

from __future__ import annotations

import atexit
import threading
import weakref
from collections.abc import Mapping
from typing import Any

import numpy as np

try:
    import torch
except ImportError as error:
    raise ImportError("cmpg.torch needs PyTorch: pip install torch") from error

from . import Camera, Device, Renderer, Scene, UsageError
from ._arrays import key_of

__all__ = ["render"]


class _Bridge:
    """A copy of a scene whose values are those of tensors, and a renderer that follows it."""

    def __init__(self, scene: Scene, names: tuple[str, ...], device: Device | None, options: dict[str, Any]) -> None:
        #: held from when the tensors' values are set until they are rendered
        self.lock = threading.Lock()
        self.revision = scene._revision
        self.scene = scene.copy()
        self.renderer = Renderer(self.scene, names, device=device or scene.device, **options)
        _bridges.add(self)

    def set(self, names: tuple[str, ...], tensors: tuple[torch.Tensor, ...]) -> None:
        for name, tensor in zip(names, tensors):
            self.scene[name] = _array(tensor)


_bridges: weakref.WeakSet[_Bridge] = weakref.WeakSet()


@atexit.register
def _let_go() -> None:
    """What the graph of an image holds is never freed where the image lives until the interpreter ends. Renderers, and with them the device, are let go before."""
    for bridge in _bridges:
        del bridge.renderer, bridge.scene


_looking = threading.Lock()  # for a bridge: two threads make one


def _array(tensor: torch.Tensor) -> np.ndarray:
    return tensor.detach().to("cpu", torch.float32).contiguous().numpy()


def _bridge(scene: Scene, names: tuple[str, ...], device: Device | None, options: dict[str, Any]) -> _Bridge:
    key = (names, device, key_of(options))
    with _looking:
        bridge = scene._renderers.get(key)
        if bridge is None or bridge.revision != scene._revision:  # other values of the scene have changed
            bridge = scene._renderers[key] = _Bridge(scene, names, device, options)
        return bridge


class _Render(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, bridge: _Bridge, names: tuple[str, ...], image: dict[str, Any], gradient: dict[str, Any],
                *tensors: torch.Tensor) -> torch.Tensor:
        with bridge.lock:
            bridge.set(names, tensors)
            pixels = bridge.renderer.render(**image)
        ctx.bridge, ctx.names, ctx.gradient = bridge, names, gradient
        ctx.save_for_backward(*tensors)
        return torch.from_numpy(np.asarray(pixels)).to(tensors[0].device, tensors[0].dtype)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, adjoint: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        tensors = ctx.saved_tensors
        with ctx.bridge.lock:
            ctx.bridge.set(ctx.names, tensors)  # another image may have been made since
            gradients = ctx.bridge.renderer.backward(_array(adjoint), **ctx.gradient)
        found = [
            torch.from_numpy(np.asarray(gradients[name])).to(tensor.device, tensor.dtype).reshape(tensor.shape) if needed else None
            for name, tensor, needed in zip(ctx.names, tensors, ctx.needs_input_grad[4:])
        ]
        return (None, None, None, None, *found)


def render(scene: Scene, parameters: Mapping[str, torch.Tensor], *, device: Device | None = None, camera: str | Camera = "", width: int = 0, height: int = 0,
           spp: int = 16, spp_gradient: int = 0, seed: int = 0, frozen: bool = False, **options: Any) -> torch.Tensor:
    """An image of the scene whose parameters have the values of tensors, differentiable by them.

    The scene keeps its own values. A renderer is kept with the scene for every set of names and options, so that a loop compiles and allocates once.

    Args:
        scene: what is rendered.
        parameters: tensors by the name of the parameter, of its shape (height, width, channels), with values in its range; on any torch device and of
            any floating type. The image has device and type of the first.
        device: the Vulkan device; None: the scene's.
        camera, width, height: as in Renderer.render().
        spp: samples per pixel of the image.
        spp_gradient: of the derivative pass; 0: as many.
        seed: another one for every step of a loop. The derivative pass has random numbers of its own: its noise is independent of the image's.
        frozen: the derivative pass has those of the image instead, for comparison with finite differences.
        options: as in Renderer: max_depth, sampling, memory ...

    Returns:
        (height, width, 3), linear.

    Raises:
        UsageError: unknown names, another shape, or values out of range: a loop that optimises values keeps them in it, by clamp_() or a sigmoid.
    """
    if not parameters:
        raise UsageError("an image that depends on no tensor has no derivative", "", "name a parameter, or use Renderer.render()", ["param"])
    names = tuple(parameters)
    for name, tensor in parameters.items():
        if not isinstance(tensor, torch.Tensor) or not tensor.is_floating_point():
            raise UsageError(f"the values of {name} are no tensor of a floating type", "", "give a tensor")
        if tuple(tensor.shape) != scene[name].shape:
            raise UsageError(f"{name} has the shape {scene[name].shape}, not {tuple(tensor.shape)}", "", "reshape or expand the tensor")
    bridge = _bridge(scene, names, device, options)
    image = {"camera": camera, "width": width, "height": height, "spp": spp, "seed": seed, "frozen": frozen}
    gradient = {"camera": camera, "spp": spp_gradient or spp, "seed": seed, "frozen": frozen}
    return _Render.apply(bridge, names, image, gradient, *parameters.values())
