"""What guides have learned: at a point of a scene, and in a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _cmpg
from ._arrays import Image, Path, as_image, made


class GuidePoint:
    """What the guide knows at a point of a scene. It has three parts: light, and the positive and the negative terms of its derivatives."""

    def __init__(self, handle: Any) -> None:
        self._handle = handle
        #: the number of the point's cell
        self.cell: int = handle.cell
        #: how many cells there are
        self.cells: int = handle.cells
        #: that the cell has learned from; those of old passes count less
        self.records: float = handle.records
        #: the same, faded since the cell learned last
        self.weight: float = handle.weight
        #: of the parts, per record
        self.means: tuple[float, float, float] = handle.means
        #: of the parts, in the mixture for a path that arrives straight from the camera
        self.weights: tuple[float, float, float] = handle.weights
        #: of light in that mixture, from 0 to 1; the derivatives have the rest
        self.light_share: float = handle.light_share
        #: of directions that are drawn from the mixture, from 0 to 1, where the material is rough enough; 0 where it is empty
        self.guide_share: float = handle.guide_share

    def density(self, mixture: Sequence[float] | None = None, *, edge: int = 128) -> Image:
        """The density of a mixture of the parts over that of uniform directions, (edge, edge, 1), the mean over each pixel.

        The picture is the equal-area square of all directions: azimuth across, z up, row 0 is z = 1. It is 0 where the mixture is empty.

        Args:
            mixture: weights of the three parts; None: `weights`.
            edge: a power of two, from 2 to 4096.

        Raises:
            UsageError: another number of weights, or another edge.
        """
        return as_image(made(self._handle.density, mixture=list(self.weights if mixture is None else mixture), edge=edge))

    def __repr__(self) -> str:
        return f"<cmpg.GuidePoint cell {self.cell} of {self.cells}, {self.guide_share:.0%} of directions>"


class Guide:
    """What a guide file holds, as Renderer.save_guide() and Recovery.save_guide() write it.

    A guide has three parts: P, light, and D+ and D-, the positive and the negative terms of its derivatives.

    Args:
        file: its name.

    Raises:
        InputError: it is no guide, of another version, truncated, or its contents contradict each other.
    """

    def __init__(self, file: Path) -> None:
        self._handle = _cmpg.Guide.load(file)

    @property
    def figures(self) -> dict[str, Any]:
        """In numbers: "lower" and "upper", the box of all cells; "cells"; "nodes" of their quadtrees, and "most_nodes", the bound; greatest "spatial_depth" and
        "quad_depth", "mean_spatial_depth" over cells and "mean_quad_depth" over leaves; "records", their statistical weight, and "mass" of the three parts, sums
        over cells; "without_records" and "without_derivative", shares of the cells; "most_records", the number of the cell that has them; "updates" that it has
        learned from; "forgetting", what old records are multiplied by when parameters change; "parameters" that derivatives were asked for; "methods", as
        PassReport.figures; "reference", what roulette compares with.
        """
        return self._handle.figures()

    @property
    def cells(self) -> dict[str, npt.NDArray[np.float64]]:
        """By cell, in the order of their numbers: "lower", "upper", the box, and "means" of the three parts per record, (cells, 3); "depth" and "quad_depth" in
        the two trees, "nodes", "records", and means of "reflected" radiance and of its "derivative", (cells, 1)."""
        return self._handle.cells()

    def density(self, cell: int, mixture: Sequence[float] = (1, 1, 1), *, edge: int = 128) -> Image:
        """What a cell would draw from, as GuidePoint.density().

        Raises:
            UsageError: there is no such cell, another number of weights, or another edge.
        """
        return as_image(made(self._handle.density, cell=cell, mixture=list(mixture), edge=edge))

    @property
    def fault(self) -> str:
        """What does not hold together although it could be read; "" where all is well."""
        return self._handle.fault()

    def __repr__(self) -> str:
        figures = self.figures
        return f"<cmpg.Guide of {figures['cells']} cells, {figures['updates']} updates>"
