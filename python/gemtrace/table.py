"""What scenes in code are made of: tables with the keys of scene files.

Every key is described, with its unit and default, in ``docs/scene.md``. Lengths are in mm, angles in degrees, wavelengths
in nm; colours are linear sRGB; +z is the normal of a stone's table. In place of a path, ``image`` takes an array, ``cut`` a
:class:`gemtrace.Cut`, and ``mesh`` a cut or a pair of arrays. Where vectors are asked for, arrays will do. :class:`gemtrace.Scene` says what errors there are.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

import numpy.typing as npt

if TYPE_CHECKING:
    from ._cut import Cut

Path = str | os.PathLike[str]
Vector = Sequence[float] | npt.NDArray[Any]
Quality = Literal["draft", "normal", "final"]
Coverage = Literal["auto", "points", "area"]


class Camera(TypedDict, total=False):
    """The eye. ``position`` and ``look_at`` (mm) must be given; ``fov`` in degrees over the height of the picture, or in
    its place ``orthographic``, the height in mm. Values outside their range are an InputError."""

    position: Vector
    look_at: Vector
    up: Vector
    fov: float
    orthographic: float


class Film(TypedDict, total=False):
    """The picture: ``width`` and ``height`` in pixels, ``exposure`` of the PNG in stops. A size of 0, or one that no memory
    holds, is an InputError."""

    width: int
    height: int
    background: str | Vector
    exposure: float
    tone: Literal["hue", "clip", "neutral"]


class Environment(TypedDict, total=False):
    """The light, exactly one of ``image``, ``uniform``, ``preset`` and ``model``.

    ``image`` is a path or an array of shape (rows, columns, 3): linear sRGB as floating-point numbers, row 0 at +z,
    u = atan2(x, y)/2π along the columns. Values that are not finite become black, with a remark. ``uniform`` is one
    colour. ``rotation`` in degrees, ``scale`` a factor, ``head_shadow``, ``half_angle`` and ``radius`` in degrees. An
    array of another shape is an InputError."""

    image: Path | npt.NDArray[Any]
    uniform: Vector
    preset: Literal["studio"]
    model: str
    rotation: float
    scale: float
    illuminant: str
    head_shadow: float
    zenith: str | Vector
    below: Vector
    seed: int
    half_angle: float
    count: int
    radius: float


class Stone(TypedDict, total=False):
    """A stone: exactly one of ``cut``, ``mesh`` and ``shape``, and ``material``.

    ``cut`` is a path or a :class:`gemtrace.Cut`; ``mesh`` a path, a Cut, or a pair of arrays: vertices of shape (V, 3) and
    triangles of shape (T, 3), counter-clockwise seen from outside. ``width`` in mm, ``rotation`` in degrees about x, then
    y, then z, ``position`` in mm. A surface that is not closed is an InputError."""

    cut: Path | Cut
    mesh: Path | Cut | tuple[npt.ArrayLike, npt.ArrayLike]
    shape: str | Mapping[str, Any]
    material: str
    name: str
    up: Literal["x", "y", "z"]
    width: float
    rotation: Vector
    position: Vector
    at: Sequence[Mapping[str, Vector]]
    optic_axis: Vector
    crystal_axes: Sequence[Vector]
    crystal: bool
    priority: int


class Material(TypedDict, total=False):
    """A material: one of ``index``, ``cauchy``, ``measured``, ``sellmeier``, ``pole``, ``index_table``, ``conductor`` and
    ``like``. ``measured`` and ``index_table`` have rows [nm, n], shape (m, 2). λ is in µm in the formulas and in nm in tables; ``absorption`` is Napierian, in 1/mm; ``density`` in g/cm³. Two
    of the first, or none, are an InputError."""

    like: str
    index: float
    cauchy: Vector
    measured: Sequence[Vector] | npt.NDArray[Any]
    sellmeier: Mapping[str, Any]
    pole: Mapping[str, Any]
    index_table: Sequence[Vector] | npt.NDArray[Any]
    conductor: Mapping[str, Any]
    absorption: str | Sequence[Mapping[str, float]]
    extraordinary: Mapping[str, Any]
    principal: Sequence[Mapping[str, Any]]
    density: float


class Ground(TypedDict, total=False):
    """What the stones stand on: ``diffuse`` (reflectance 0 to 1, or a colour), ``material`` or ``mirror``; ``height`` and
    ``size`` in mm. Two of the first are an InputError."""

    diffuse: float | Vector
    material: str
    mirror: bool
    height: float
    size: float


class Pose(TypedDict, total=False):
    """How all stones are held: ``turn`` about +z and ``tilt`` towards the eye in degrees, ``rotation`` about x, then y,
    then z in degrees, ``size`` of the first stone in mm. A size of 0 or less is an InputError."""

    turn: float
    tilt: float
    rotation: Vector
    size: float


class Render(TypedDict, total=False):
    """How much work a picture takes. ``wavelengths`` is a list of nm or a table with ``count`` and ``range`` (nm);
    ``tolerance`` is a colour difference, ΔE00; ``threshold`` and ``split`` are shares from 0 to 1. Values outside their range
    are an InputError."""

    quality: Quality
    coverage: Coverage
    samples: int
    tolerance: float
    wavelengths: Vector | Mapping[str, Any]
    jitter: bool
    max_depth: int
    leftover: Literal["exit", "drop"]
    threshold: float
    split: float
    polarized: bool
    spectral: bool
