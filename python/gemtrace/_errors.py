"""The exceptions of the package. Their messages are those of the library and of the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._film import Film


class Error(Exception):
    """What every error of gemtrace is. Programming errors (a text where a number is expected) are ``TypeError``."""

    film: Film | None = None
    """What was finished of a picture when its device failed; None for other errors."""


class InputError(Error, ValueError):
    """A value that is not valid. The message names it, its value, and what would be valid."""


class UnknownNameError(InputError, KeyError):
    """A name that nothing has: of a material, a colour space, a quality. The message has the nearest name."""

    def __str__(self) -> str:
        # A KeyError would show its message in quotes.
        return str(self.args[0]) if self.args else ""


class FileError(InputError, OSError):
    """A file that is missing, cannot be read, or is not what its name says."""


class OutputError(Error, OSError):
    """A file that cannot be written. Nothing is left of it."""


class DeviceError(Error, RuntimeError):
    """A device that is not there or that failed. ``film`` has what was finished, if anything was."""


class OutOfMemoryError(Error, MemoryError):
    """More memory than there is; the message says for what, and how much, in GiB."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a render. ``film`` has what was finished: a whole picture of fewer samples, or a part of one."""

    film: Film | None = None
    """What was finished, or None while something else than a picture was under way."""
