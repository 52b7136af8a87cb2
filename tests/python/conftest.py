import pathlib

import numpy as np
import pytest

import cmpg

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOX = ROOT / "scenes/box/scene.gltf"
PAINTING = "painting.baseColor"  # (64, 64, 3)
LIGHT = "light.emission"  # (1, 1, 3), which images are linear in


@pytest.fixture(scope="session")
def device():
    return cmpg.Device()


@pytest.fixture
def scene(device):
    loaded = cmpg.Scene(BOX)
    loaded._device = device  # one for all tests, so that kernels are compiled once
    return loaded


@pytest.fixture
def target(scene):
    """A small picture of the true scene."""
    return cmpg.Renderer(scene, max_depth=4).render(width=32, spp=32, seed=1)


@pytest.fixture
def grey(scene):
    scene[PAINTING] = np.full((64, 64, 3), 0.5)
    return scene
