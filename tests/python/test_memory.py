"""Memory stays as it is, however often scenes are loaded and rendered."""

import gc
import pathlib

import numpy as np
import pytest
from conftest import BOX, PAINTING

import cmpg


def resident() -> int:
    """Bytes of host memory of this process."""
    for line in pathlib.Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return 1024 * int(line.split()[1])
    raise RuntimeError("/proc/self/status has no VmRSS")


def load_and_render(device):
    scene = cmpg.Scene(BOX)
    renderer = cmpg.Renderer(scene, PAINTING, device=device, max_depth=2)
    image = renderer.render(width=8, spp=1)
    renderer.backward(np.ones_like(image), spp=1)
    return image


def grows(device, times: int) -> float:
    """Bytes each time."""
    for _ in range(10):  # what drivers, allocators and caches take once
        load_and_render(device)
    gc.collect()
    before, on_device = resident(), device.memory_in_use
    for _ in range(times):
        load_and_render(device)
    gc.collect()
    assert device.memory_in_use == on_device
    return (resident() - before) / times


# A leak of what one load takes (a megabyte, textures and hierarchy) shows at once; allocators keep a few pages.
def test_memory_is_flat(device):
    assert grows(device, 40) < 64 << 10


@pytest.mark.full
def test_memory_is_flat_over_500(device):
    assert grows(device, 500) < 8 << 10
