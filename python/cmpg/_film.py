"""Images that grow sample by sample."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _cmpg
from ._arrays import Image, as_image, made


class Film:
    """An image, or a derivative, that grows with the passes that add to it: Renderer.render_into(), Renderer.forward_into(), Recovery.image_into().

    Samples may come in any number of passes: they leave the bits that one pass would have left. What reads a film while another thread adds to it waits
    until that pass has ended.

    Args:
        width, height: in pixels, from 1 to 32768.
        layers: passes of images keep what the camera sees first as well.

    Raises:
        UsageError: a size out of range.
    """

    def __init__(self, width: int, height: int, *, layers: bool = False) -> None:
        self._handle = made(_cmpg.Film, width=width, height=height, layers=layers)

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, 3)."""
        return (self._handle.height(), self._handle.width(), 3)

    @property
    def samples(self) -> int:
        """Samples per pixel so far."""
        return self._handle.samples()

    def image(self) -> Image:
        """The mean of the samples, (height, width, 3), linear: a copy.

        Raises:
            UsageError: there are no samples yet.
        """
        return as_image(self._handle.image())

    def layers(self) -> dict[str, npt.NDArray[np.float32]]:
        """What the camera sees first, and what the guide does there, each (height, width, channels): as `report.layers()` of a pass.

        Raises:
            UsageError: the film was made without layers, or there are no samples yet.
        """
        return self._handle.layers()

    def __repr__(self) -> str:
        height, width, _ = self.shape
        return f"<cmpg.Film {width}x{height}, {self.samples} samples per pixel>"
