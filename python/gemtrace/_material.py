"""Materials: indices and absorptions over wavelengths."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, overload

import numpy.typing as npt

from . import _gemtrace, table
from ._array import Floats, flat, remark, wavelengths
from ._errors import UnknownNameError


class Material:
    """A substance: one of :data:`gemtrace.materials`, or from a table with the keys of a scene file.

    ``name`` is for messages; ``spec`` as in :class:`gemtrace.table.Material`: λ in µm in formulas and in nm in tables,
    absorption in 1/mm. A scene takes the table itself, in ``materials``. Curves keep the shape of the wavelengths. Raises
    InputError for impossible figures, and for an index that makes no sense between 380 and 740 nm.
    """

    def __init__(self, name: str, spec: table.Material) -> None:
        from ._document import table as section
        from ._document import value

        self._set(_gemtrace.Material.build(name, json.dumps(value(name, section(name, spec)))))

    def _set(self, material: _gemtrace.Material) -> None:
        self._material = material
        self._facts: dict[str, Any] = json.loads(material.facts())
        self._axes: dict[str, int] = {axis: place for axis, place in self._facts["axes"]}
        remark(self._facts["warnings"])

    def _place(self, axis: str | None) -> int:
        """The place of an axis among three."""
        if axis is None:
            return 0
        if axis in self._axes:
            return self._axes[axis]
        valid = ", ".join(self._axes) or "none, since it is isotropic"
        raise UnknownNameError(f"unknown axis {axis!r} of {self.name}; valid: {valid}")

    @overload
    def n(self, nm: float, axis: str | None = None) -> float: ...
    @overload
    def n(self, nm: npt.ArrayLike, axis: str | None = None) -> Floats: ...
    def n(self, nm: npt.ArrayLike, axis: str | None = None) -> Any:
        """The refractive index, without unit, at wavelengths in nm (vacuum); of a metal the real part.

        ``nm``: any shape, which the result has, too, as float64. ``axis``: one of :attr:`axes`; without it the index of an
        isotropic material, of the ordinary ray, or along x. Raises InputError for wavelengths outside 200 to 2000 nm and
        UnknownNameError for an axis that there is not.
        """
        array = wavelengths(nm)
        return self._material.index(flat(array), self._place(axis)).reshape(array.shape)[()]

    @overload
    def k(self, nm: float) -> float: ...
    @overload
    def k(self, nm: npt.ArrayLike) -> Floats: ...
    def k(self, nm: npt.ArrayLike) -> Any:
        """The imaginary part of a metal's index n + ik, without unit, at wavelengths in nm; 0 for what is transparent.

        ``nm``: any shape, which the result has, too. Raises InputError for wavelengths outside 200 to 2000 nm.
        """
        array = wavelengths(nm)
        return self._material.extinction(flat(array)).reshape(array.shape)[()]

    @overload
    def absorption(self, nm: float, axis: str | None = None) -> float: ...
    @overload
    def absorption(self, nm: npt.ArrayLike, axis: str | None = None) -> Floats: ...
    def absorption(self, nm: npt.ArrayLike, axis: str | None = None) -> Any:
        """The Napierian absorption coefficient α in 1/mm at wavelengths in nm: light fades by exp(−α·mm).

        ``nm``: any shape, which the result has, too. ``axis`` and errors as for :meth:`n`. Of a metal 4πk/λ.
        """
        array = wavelengths(nm)
        return self._material.absorption(flat(array), self._place(axis)).reshape(array.shape)[()]

    @property
    def name(self) -> str:
        """What it is called. No units, no errors."""
        return str(self._facts["name"])

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes of a crystal: ("o", "e") if it is uniaxial, ("x", "y", "z") if it is biaxial; () for what is isotropic.
        No units, no errors."""
        return tuple(self._axes)

    @property
    def is_metal(self) -> bool:
        """Whether it is opaque, with a complex index. No units, no errors."""
        return bool(self._facts["metal"])

    @property
    def aliases(self) -> tuple[str, ...]:
        """Other names that it is known by. No units, no errors."""
        return tuple(self._facts["aliases"])

    @property
    def density(self) -> float | None:
        """In g/cm³; None where it is not known. No errors."""
        density: float | None = self._facts["density"]
        return density

    @property
    def notes(self) -> tuple[str, ...]:
        """What one should know before relying on it. No units, no errors."""
        return tuple(self._facts["notes"])

    @property
    def sources(self) -> tuple[dict[str, Any], ...]:
        """Where each figure comes from: ``figure``, ``source``, ``licence``, ``range`` in nm or None, ``approximate``.
        No errors."""
        return tuple(self._facts["sources"])

    def __repr__(self) -> str:
        return f"<gemtrace.Material {self.name}>"


class Materials(Mapping[str, Material]):
    """The catalogue: a mapping of names to :class:`Material`, whose units hold.

    Other names are found, too, in any case: ``materials["Citrine"]``. An unknown one raises UnknownNameError, a KeyError,
    with the nearest name.
    """

    def __getitem__(self, name: str) -> Material:
        material = Material.__new__(Material)
        material._set(_gemtrace.Material.get(name))
        return material

    def __iter__(self) -> Iterator[str]:
        return iter(_gemtrace.material_names())

    def __len__(self) -> int:
        return len(_gemtrace.material_names())

    def __repr__(self) -> str:
        return f"<gemtrace.materials: {', '.join(self)}>"


materials = Materials()
