"""Gemstones, rendered spectrally: every wavelength traced on its own, without noise, into NumPy arrays.

    >>> import gemtrace
    >>> scene = gemtrace.Scene(
    ...     camera={"position": (0, -11, 30), "look_at": (0, 0, 0)},
    ...     stones=[{"shape": "round-brilliant", "width": 6.5, "material": "ruby"}],
    ... )
    >>> film = scene.render(quality="draft", resolution=(32, 32))
    >>> film.rgb().shape
    (32, 32, 3)

Lengths are in mm, angles in degrees unless a name or a text says radians, wavelengths in nm, colours linear. Errors are
:class:`gemtrace.Error`; remarks go to the logger ``gemtrace``. ``docs/python.md`` has the whole.
"""

from __future__ import annotations

import json
from typing import Any

from . import _gemtrace, table
from ._cut import Cut, cut
from ._errors import (
    DeviceError,
    Error,
    FileError,
    InputError,
    Interrupted,
    OutOfMemoryError,
    OutputError,
    UnknownNameError,
)
from ._film import Film
from ._material import Material, Materials, materials
from ._measure import Measurement, measure
from ._notebook import LiveView, view
from ._optics import Fresnel, Waves, cauchy_fit, crystal, fresnel, stokes, upsample
from ._scene import Scene, View, load

__version__ = _gemtrace.version()

__all__ = [
    "Cut",
    "DeviceError",
    "Error",
    "FileError",
    "Film",
    "Fresnel",
    "InputError",
    "Interrupted",
    "LiveView",
    "Material",
    "Materials",
    "Measurement",
    "OutOfMemoryError",
    "OutputError",
    "Scene",
    "UnknownNameError",
    "View",
    "Waves",
    "cauchy_fit",
    "crystal",
    "cut",
    "devices",
    "fresnel",
    "load",
    "materials",
    "measure",
    "stokes",
    "table",
    "upsample",
    "view",
]


def devices() -> list[dict[str, Any]]:
    """What this machine can render on: ``backend``, ``index``, ``name``, ``driver``, ``api``, ``memory`` in bytes or None,
    ``intersection``, ``hardware``, ``kind``, as in ``docs/json.md``. No errors: a backend without devices adds nothing."""
    found: list[dict[str, Any]] = json.loads(_gemtrace.devices())
    return found
