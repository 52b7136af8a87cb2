"""Threads that share a scene through the bridge to PyTorch, which is not needed: arrays stand in for its tensors."""

import concurrent.futures
import importlib
import sys
import types

import numpy as np
import pytest
from conftest import LIGHT

import cmpg


class Tensor:
    """As much of a tensor as the bridge touches."""

    device, dtype = "cpu", np.float32

    def __init__(self, values):
        self.values = np.asarray(values, np.float32)
        self.shape = self.values.shape

    def is_floating_point(self):
        return True

    def detach(self):
        return self

    contiguous = detach

    def to(self, *_):
        return self

    def reshape(self, shape):
        return Tensor(self.values.reshape(shape))

    def numpy(self):
        return self.values


class Function:
    """One whose context is returned with its result."""

    @classmethod
    def apply(cls, *arguments):
        context = types.SimpleNamespace(needs_input_grad=[True] * len(arguments))
        context.save_for_backward = lambda *tensors: setattr(context, "saved_tensors", tensors)
        return cls.forward(context, *arguments), lambda adjoint: cls.backward(context, adjoint)


@pytest.fixture
def bridge(monkeypatch):
    function = types.SimpleNamespace(once_differentiable=lambda call: call)
    torch = types.ModuleType("torch")
    torch.Tensor, torch.float32, torch.from_numpy = Tensor, np.float32, Tensor
    torch.autograd = types.SimpleNamespace(Function=Function, function=function)
    monkeypatch.setitem(sys.modules, "torch", torch)
    monkeypatch.delitem(sys.modules, "cmpg.torch", raising=False)
    before = getattr(cmpg, "torch", None)
    yield importlib.import_module("cmpg.torch")
    sys.modules.pop("cmpg.torch", None)
    if before is None:
        del cmpg.torch
    else:
        cmpg.torch, sys.modules["cmpg.torch"] = before, before


def test_each_gets_what_its_values_make(bridge, scene):
    values = [0.5 * (i + 1) for i in range(4)]

    def pictures(value):
        found = []
        for _ in range(10):
            image, backward = bridge.render(scene, {LIGHT: Tensor(np.full((1, 1, 3), value))}, width=8, spp=1, max_depth=3, pixel_sampling="uniform")
            found.append((image.numpy(), backward(Tensor(np.full((8, 8, 3), value)))[4].numpy()))
        return found

    expected = [pictures(value)[0] for value in values]
    scene._renderers.clear()
    with concurrent.futures.ThreadPoolExecutor(len(values)) as threads:
        for alone, many in zip(expected, threads.map(pictures, values)):
            for image, gradient in many:
                np.testing.assert_array_equal(image, alone[0])
                np.testing.assert_array_equal(gradient, alone[1])
    assert len(scene._renderers) == 1
