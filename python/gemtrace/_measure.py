"""What a cut does with light, in numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _gemtrace, table
from ._array import Floats, real
from ._cut import Cut
from ._errors import InputError
from ._scene import Progress, Scene, opened

Curves = dict[str, Floats]


class Measurement(NamedTuple):
    """A stone measured at T angles; every array has the shape (T,), float64, and shares from 0 to 1. No errors."""

    tilt: Floats
    """The angles, degrees."""
    stone: Curves
    """By name: light return under each model, ``leakage``, ``extinction``, ``contrast``, ``aset_blue``, ``aset_red``,
    ``aset_green``, ``missing``; see ``docs/light-models.md``. Over all rays that meet the stone."""
    table: Curves | None
    """The same over those that meet its table first; NaN at angles where none does, None for a stone without one."""
    dropped: Floats
    """Of the light, what was dropped at the depth limit or the threshold."""


def measure(
    subject: Scene | Cut,
    tilt: npt.ArrayLike = 0.0,
    *,
    material: str | None = None,
    width: float | None = None,
    models: Sequence[str] = ("iso", "cos", "sc2"),
    head: float = 10.0,
    eye: float | Literal["camera"] | None = "camera",
    rays: int = 300,
    about: Literal["x", "y"] = "x",
    experimental: bool = False,
    backend: str = "cpu",
    progress: Progress | None = None,
) -> Measurement:
    """Light return, leakage, extinction and contrast of one stone, as ``gemtrace measure`` has them.

    ``subject``: a scene of one stone, or a cut with a ``material`` and perhaps a ``width`` in mm. ``tilt``: angles in
    degrees, of any shape; results have its numbers in one row. ``models``: names of light models. ``head``: half-angle of
    the viewer's head, 0 to 90 degrees. ``eye``: its distance in mm, None for parallel rays, ``"camera"`` for the scene's
    own. ``rays``: across the square raster. ``about``: the axis of the tilt. ``experimental``: fire and scintillation,
    too. ``progress`` as for :meth:`gemtrace.Scene.render`, for each of its renders. Raises InputError for values outside
    these ranges or a scene of more than one stone, UnknownNameError for an unknown name, DeviceError for a device that fails.
    """
    angles = real("tilt", tilt).reshape(-1)
    half = float(real("head", head, 0.0, 90.0, "a half-angle in degrees, from 0 (no head) to 90"))
    if not 1 <= rays <= 4096:
        raise InputError(f"rays: {rays} is not valid; expected a whole number from 1 to 4096")
    if isinstance(subject, Cut):
        subject = alone(subject, material, width)
    else:
        pose: table.Pose | None = None if width is None else {"size": width}
        subject = subject.replace(material=material, pose=pose) if (material or pose) else subject
    distance = seen_from(subject) if eye == "camera" else eye
    session = opened(backend, None, None, single=False)
    rows = session.measure(
        subject._scene, angles.tolist(), list(models), half, distance, rays, about, experimental, progress
    )
    names = [name for name, _ in rows[0][2]] if rows else []
    stone = {name: np.array([dict(row[2])[name] for row in rows]) for name in names}
    tables = [dict(row[3]) if row[3] is not None else {} for row in rows]
    table_ = {name: np.array([figures.get(name, np.nan) for figures in tables]) for name in names} if any(tables) else None
    return Measurement(angles, stone, table_, np.array([row[0] for row in rows]))


def alone(cut: Cut, material: str | None, width: float | None) -> Scene:
    """A scene of one stone, seen by parallel rays."""
    if material is None:
        raise InputError("material: None is not valid; a cut is measured with the name of a material")
    stone: table.Stone = {"cut": cut, "material": material}
    if width is not None:
        stone["width"] = width
    camera: table.Camera = {"position": (0.0, 0.0, 1e3), "look_at": (0.0, 0.0, 0.0), "up": (0.0, 1.0, 0.0), "orthographic": 10.0}
    render: table.Render = {"samples": 1, "wavelengths": {"count": 8, "range": (380.0, 740.0)}, "jitter": False}
    return Scene(camera=camera, stones=[stone], render=render)


def seen_from(scene: Scene) -> float | None:
    """The distance of a camera with perspective, mm."""
    camera = scene.document["camera"]
    if "orthographic" in camera:
        return None
    return float(np.linalg.norm(np.subtract(camera["position"], camera["look_at"])))
