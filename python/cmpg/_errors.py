"""Errors: what went wrong, the likely cause and the remedy."""

from __future__ import annotations


class Error(Exception):
    """Base of all errors of the library.

    Attributes:
        what: one sentence that names the file, parameter or device.
        cause: the likely cause, or "".
        remedy: what to do about it, or "".
        options: the keyword arguments that the remedy is about.
    """

    def __init__(self, what: str, cause: str = "", remedy: str = "", options: list[str] | None = None) -> None:
        super().__init__(what, cause, remedy, options or [])
        self.what = what
        self.cause = cause
        self.remedy = remedy
        self.options = list(options or [])

    def __str__(self) -> str:
        lines = [self.what]
        if self.cause:
            lines.append("  cause:  " + self.cause)
        if self.remedy:
            lines.append("  remedy: " + self.remedy + (f" ({', '.join(self.options)})" if self.options else ""))
        return "\n".join(lines)


class UsageError(Error, ValueError):
    """An argument, a name or a value that makes no sense."""


class InputError(Error):
    """A scene, an image or another file that is missing or malformed."""


class DeviceError(Error):
    """No Vulkan device, or one that lacks a feature, is lost, has too little memory or computes wrong results."""


class NumericalError(Error):
    """Values so large or small that floats overflow."""


class OutputError(Error):
    """A result could not be written."""


for _class in (Error, UsageError, InputError, DeviceError, NumericalError, OutputError):
    _class.__module__ = "cmpg"  # where users find them
