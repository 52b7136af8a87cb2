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
        function = None if held is None else getattr(held, name)
        if function is not None:  # it may be taken away by another thread, which the library hears of when the pass is over
            function(*arguments)

    return call
