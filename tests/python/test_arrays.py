"""Arrays of other libraries come in and go out by DLPack."""

import numpy as np
import pytest

import cmpg
from conftest import LIGHT, PAINTING


class Foreign:
    """An array of another library: nothing but DLPack."""

    def __init__(self, array, device=(1, 0)):
        self.array, self.device = array, device

    def __dlpack__(self, **options):
        if self.device != (1, 0):
            raise BufferError("it lies on a GPU")
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.device


def test_values_images_and_adjoints_come_in(scene):
    values = np.random.default_rng(1).random((64, 64, 3), np.float32)
    scene[PAINTING] = Foreign(values)
    np.testing.assert_array_equal(scene[PAINTING].values, values)
    scene[LIGHT] = Foreign(np.array([1.0, 2.0, 3.0]))  # of another type
    np.testing.assert_array_equal(scene[LIGHT].values.ravel(), [1, 2, 3])
    renderer = cmpg.Renderer(scene, [PAINTING, LIGHT], max_depth=2)
    adjoint = np.ones((12, 16, 3), np.float32)
    np.testing.assert_array_equal(renderer.backward(Foreign(adjoint), spp=2)[LIGHT], renderer.backward(adjoint, spp=2)[LIGHT])
    np.testing.assert_array_equal(renderer.forward({PAINTING: Foreign(values)}, width=16, spp=2), renderer.forward({PAINTING: values}, width=16, spp=2))
    target = renderer.render(width=16, spp=4)
    assert cmpg.Recovery(scene, Foreign(np.asarray(target)), PAINTING, max_depth=2).step().loss == cmpg.Recovery(
        scene, target, PAINTING, max_depth=2).step().loss


def test_images_parameters_and_gradients_go_out(scene):
    renderer = cmpg.Renderer(scene, PAINTING, max_depth=2)
    image = renderer.render(width=16, spp=2)
    gradient = renderer.backward(np.ones(image.shape), spp=2)[PAINTING]
    for array in (image, gradient):
        out = np.from_dlpack(array)
        assert out.dtype == np.float32 and out.ctypes.data == array.ctypes.data  # no copy
        np.testing.assert_array_equal(out, array)
    np.testing.assert_array_equal(np.from_dlpack(scene[PAINTING]), scene[PAINTING].values)
    np.testing.assert_array_equal(np.asarray(scene[PAINTING]), scene[PAINTING].values)


def test_what_would_be_wrong_in_silence_is_refused(scene):
    with pytest.raises(cmpg.UsageError, match="on a GPU"):
        scene[PAINTING] = Foreign(np.zeros((64, 64, 3), np.float32), device=(2, 0))
    tracked = Foreign(np.zeros((64, 64, 3), np.float32))
    tracked.requires_grad = True
    with pytest.raises(cmpg.UsageError, match="detach"):
        scene[PAINTING] = tracked
    assert scene[PAINTING].values.any()
