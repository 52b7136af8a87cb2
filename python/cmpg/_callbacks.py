"""Functions of a program's own that the library calls."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any


def weakly(owner: Any, name: str) -> Callable[..., None]:
    """Calls the function that an object has under this name. The library keeps it, and the garbage collector does not look there: it keeps nothing alive."""
    found = weakref.ref(owner)

    def call(*arguments: Any) -> None:
        held = found()
        if held is not None:
            getattr(held, name)(*arguments)

    return call
