"""Arrays in and out, pictures and their files."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _cmpg
from ._errors import UsageError

Path = Union[str, "os.PathLike[str]"]
Names = Union[str, Sequence[str]]


def floats(values: Any) -> npt.NDArray[np.float32]:
    """Any array as contiguous float32: itself where it is that. Arrays of other libraries come by DLPack, without a copy where they lie on the host."""
    if not isinstance(values, np.ndarray) and hasattr(values, "__dlpack__"):
        if getattr(values, "requires_grad", False):  # a tensor's graph would be cut in silence
            raise UsageError("values that take part in a derivative would be cut off from it", "", "use cmpg.torch.render(), or give values.detach()")
        try:
            values = np.from_dlpack(values)
        except (BufferError, RuntimeError, TypeError) as error:
            raise UsageError("an array of another library cannot be read", str(error), "copy it to the host as float32") from error
    try:
        array = np.asarray(values)
    except ValueError as error:  # rows of different lengths
        raise UsageError("values are no array", str(error), "give an array of numbers, or a number") from error
    if array.dtype.kind in "OSUMm":  # None would be not a number, and text read as one
        raise UsageError(f"values are no numbers but {type(values).__name__}", f"the array of them has the type {array.dtype}", "give an array of numbers, or a number")
    if np.iscomplexobj(array):
        raise UsageError("complex numbers have no place here", "their imaginary parts would be dropped", "give real ones")
    return np.ascontiguousarray(array, dtype=np.float32)


#: the most that the library has room for, of arguments that are whole numbers
_MOST = (dict.fromkeys(["width", "height", "edge"], 2**31 - 1)
         | dict.fromkeys(["spp", "spp_gradient", "spp_difference", "train", "train_spp", "batches", "max_depth", "steps", "views_per_step", "warm_up", "freeze",
                          "cell"], 2**32 - 1)
         | dict.fromkeys(["seed", "memory", "guide_memory", "target"], 2**64 - 1))


#: arguments that are numbers
_NUMBERS = ["error_target", "time_budget", "prior", "total_variation", "final_rate", "guide_share", "direction_share", "forgetting", "roulette_effort"]


def made(kind: Callable[..., Any], **options: Any) -> Any:
    """What `kind` makes of options. What is no whole number, or too large a one, is refused by name where one is meant."""
    try:
        return kind(**options)
    except TypeError:
        for name, value in options.items():
            if name in _MOST and not (isinstance(value, (int, np.integer)) and 0 <= value <= _MOST[name]):
                raise UsageError(f"{name} is {value}", "", f"give a whole number from 0 to {_MOST[name]}", [name]) from None
            if name in _NUMBERS and not isinstance(value, (int, float, np.number)):
                raise UsageError(f"{name} is {value!r}", "", "give a number: 0.02 for 2 %" if name == "error_target" else "give a number", [name]) from None
        raise


def key_of(options: Any) -> Hashable:
    """What stands for options in a dictionary: equal ones, mappings among them, find each other."""
    return tuple(sorted((name, key_of(value)) for name, value in options.items())) if isinstance(options, Mapping) else options


def names_of(names: Names) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


class Image(np.ndarray):
    """An array of (height, width, channels), float32, linear, that shows itself as a picture in a notebook."""

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return array[()] if array.ndim == 0 else array.view(Image)  # a sum is a number, no picture

    def save(self, file: Path, exposure: float = 0) -> None:
        """Writes .exr (exact) or .png (8-bit sRGB of values times 2^exposure, clamped to [0, 1]).

        Raises:
            UsageError: another ending.
            OutputError: the file cannot be written.
        """
        _cmpg.save_image(file, floats(self), exposure)

    def png(self, exposure: float = 0) -> bytes:
        """The bytes of such a PNG file."""
        return _cmpg.encode_png(floats(self), exposure)

    def _repr_png_(self) -> bytes | None:
        return self.png() if self.ndim == 3 and self.shape[2] in (1, 3) else None


def as_image(array: npt.NDArray[np.float32]) -> Image:
    return array.view(Image)


def load_image(file: Path) -> Image:
    """Reads .exr, .hdr, .png or .jpg as (height, width, 3); .png and .jpg are decoded from sRGB.

    Raises:
        InputError: the file is missing or malformed.
    """
    return as_image(_cmpg.load_image(file))
