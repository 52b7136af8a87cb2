"""Memory stays as it is, however often scenes are loaded and rendered."""

import ctypes
import gc

import numpy as np
import pytest
from conftest import BOX, PAINTING

import cmpg


class MallocInfo(ctypes.Structure):
    """struct mallinfo2 of glibc: bytes, over all arenas."""

    _fields_ = [(name, ctypes.c_size_t) for name in
                ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost")]


def allocated() -> int:
    """Bytes that malloc has given out. Resident memory says less: arenas that threads share come and go by 8 MiB, and hide a leak."""
    mallinfo2 = ctypes.CDLL(None).mallinfo2
    mallinfo2.restype = MallocInfo
    info = mallinfo2()
    return info.uordblks + info.hblkhd


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
    before, on_device = allocated(), device.memory_in_use
    for _ in range(times):
        load_and_render(device)
    gc.collect()
    assert device.memory_in_use == on_device
    return (allocated() - before) / times


# Seen: below 200 bytes each time.
def test_memory_is_flat(device):
    assert grows(device, 40) < 4 << 10


@pytest.mark.full
def test_memory_is_flat_over_500(device):
    assert grows(device, 500) < 1 << 10
