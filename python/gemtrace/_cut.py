"""Cuts and meshes: facets as arrays, and proportions."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _gemtrace
from ._array import Floats, plain, real, remark, vectors
from ._errors import InputError

Indices = npt.NDArray[np.uint32]


def indices(what: str, given: object) -> Indices:
    """Rows of three whole numbers from 0, in one row."""
    array = plain(what, given, "iuf")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{what}: an array of shape {array.shape} is not valid; expected (T, 3)")
    if array.dtype.kind == "f" and array.size:
        raise TypeError(f"{what}: {array.dtype} is not valid; expected an array of whole numbers")
    if array.size and (array.min() < 0 or array.max() >= 2**32):
        raise InputError(f"{what}: {array.min()} to {array.max()} is not valid; expected indices of vertices, from 0")
    return np.ascontiguousarray(array, dtype=np.uint32).reshape(-1)


class Cut:
    """A closed solid as a faceter knows it: planes, corners, names and proportions.

    Made by :func:`gemtrace.cut`, :meth:`Cut.shape`, :meth:`Cut.from_planes` and :meth:`Cut.from_mesh`. +z is the normal of
    the table; lengths are in the design's own unit, usually such that the girdle's radius is near 1. A stone of a
    :class:`gemtrace.Scene` takes it as its ``cut``. It never changes. Everything that makes one raises InputError for
    planes or triangles that bound no solid, with the place of the fault.
    """

    def __init__(self, solid: _gemtrace.Solid) -> None:
        """Not for callers: use the functions above. ``solid`` is what they made; there are no errors."""
        self._solid = solid
        self._facts: dict[str, Any] = json.loads(solid.facts())
        remark(self._facts["warnings"])

    @classmethod
    def shape(cls, name: str, **parameters: Any) -> Cut:
        """A classical shape: ``"round-brilliant"``, ``"step"`` or ``"portuguese"``.

        ``parameters`` are those of ``docs/scene.md``: angles in degrees, sizes as shares of the width. The width is 1.
        Raises UnknownNameError for another name and InputError for a parameter outside its range.
        """
        from ._document import table, value

        return cls(_gemtrace.Solid.shape(name, json.dumps(value(name, table(name, parameters)))))

    @classmethod
    def from_planes(cls, normals: npt.ArrayLike, offsets: npt.ArrayLike, names: Sequence[str | None] = ()) -> Cut:
        """The convex solid behind planes ``normal · x = offset``.

        ``normals``: (F, 3), pointing outwards, of any length above 0. ``offsets``: (F,), for normals as they are given, in
        any unit of length. ``names``: one for each facet, or none. Raises InputError for other shapes, and for planes that
        leave the solid open (with the direction) or empty.
        """
        n, d = vectors("normals", normals, 3), real("offsets", offsets)
        if n.ndim != 2 or d.shape != n.shape[:1]:
            raise InputError(f"normals {n.shape} and offsets {d.shape} do not go together; expected (F, 3) and (F,)")
        if len(names) not in (0, len(d)):
            raise InputError(f"names: {len(names)} are not valid; expected one for each of {len(d)} facets, or none")
        return cls(_gemtrace.Solid.planes(n.reshape(-1), d.tolist(), list(names)))

    @classmethod
    def from_mesh(cls, vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> Cut:
        """A closed mesh. Triangles in one plane become one facet.

        ``vertices``: (V, 3), in any unit of length. ``triangles``: (T, 3), whole numbers from 0, counter-clockwise seen
        from outside. Raises InputError for a surface that is open, without volume, or names a vertex that is not there.
        """
        from ._document import triangles as solid

        return cls(solid("mesh", (vertices, triangles)))

    @property
    def normals(self) -> Floats:
        """Unit normals of the facets, outwards: (F, 3), float64, without unit. No errors."""
        return self._solid.normals()

    @property
    def offsets(self) -> Floats:
        """Distances of the facets' planes from the origin: (F,), float64, in the design's unit. No errors."""
        return self._solid.offsets()

    @property
    def names(self) -> tuple[str | None, ...]:
        """What the design calls each of the F facets; None where it has no name. No units, no errors."""
        return tuple(self._facts["names"])

    @property
    def vertices(self) -> Floats:
        """The corners: (V, 3), float64, in the design's unit. No errors."""
        return self._solid.vertices()

    @property
    def triangles(self) -> Indices:
        """Three corners a triangle, counter-clockwise seen from outside: (T, 3), uint32, without unit. No errors."""
        return self._solid.corners()

    @property
    def facet_of(self) -> Indices:
        """The facet that each triangle lies in: (T,), uint32, without unit. No errors."""
        return self._solid.facet_of()

    @property
    def proportions(self) -> dict[str, Any]:
        """The figures of ``gemtrace cut --json`` (``docs/json.md``): lengths in the design's unit, shares in percent of the
        width, angles in degrees from the girdle's plane, None where there is no such facet. No errors."""
        return dict(self._facts["proportions"])

    @property
    def tiers(self) -> list[dict[str, Any]]:
        """Facets at one angle and distance: ``name``, ``part``, ``facets``, ``angle`` in degrees, ``distance`` in the design's
        unit. No errors."""
        return [dict(tier) for tier in self._facts["tiers"]]

    @property
    def title(self) -> tuple[str, ...]:
        """The lines that head the design; none for a mesh. No units, no errors."""
        return tuple(self._facts["title"] or ())

    @property
    def footnotes(self) -> tuple[str, ...]:
        """The design's closing remarks; none for a mesh. No units, no errors."""
        return tuple(self._facts["footnotes"] or ())

    @property
    def gear(self) -> int | None:
        """Teeth of the index gear, negative if it counts clockwise; None where the design does not say. No units, no errors."""
        gear: int | None = self._facts["gear"]
        return gear

    @property
    def index_of_refraction(self) -> float | None:
        """The index that the design was made for, without unit; None where it does not say. No errors."""
        index: float | None = self._facts["index_of_refraction"]
        return index

    def __repr__(self) -> str:
        return f"<gemtrace.Cut of {len(self.names)} facets>"


def cut(path: str | os.PathLike[str]) -> Cut:
    """Reads a cut (``.asc``, ``.gem``, ``.gcs``) or a mesh (``.obj``, ``.stl``, ``.ply``).

    Its arrays are those of :class:`Cut`, in the file's own unit of length. Raises FileError for a file that is missing or not
    what its name says, and for planes or triangles that bound no solid.
    """
    return Cut(_gemtrace.Solid.read(os.fspath(path)))
