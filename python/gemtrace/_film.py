"""Films: what was rendered, as arrays, files and pictures in a notebook."""

from __future__ import annotations

import json
import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _gemtrace
from ._array import Floats
from ._errors import InputError

if TYPE_CHECKING:
    import xarray

Singles = npt.NDArray[np.float32]


class Film:
    """A rendered picture of H rows and W columns; row 0 is at the top.

    Arrays are means over the samples of each pixel, linear, and have the bits of the EXR that ``gemtrace render`` writes.
    Colours are relative: light of (1, 1, 1) under D65 has Y = 1. They are premultiplied by alpha; negative values are
    real colours outside the space. Each access makes a new array, but for :attr:`spectral`. A film raises errors only for what it does not have.
    """

    def __init__(self, film: _gemtrace.Film) -> None:
        """Not for callers: films come from ``render``. ``film`` is what was rendered; there are no errors."""
        self._film = film

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, (H, W), in pixels. No errors."""
        height, width = self._film.size
        return height, width

    @property
    def finished(self) -> bool:
        """Whether every sample that was asked for is there. No units, no errors."""
        return self._film.finished

    def rgb(self, space: str = "srgb") -> Singles:
        """Colours in a linear space: (H, W, 3), float32, relative.

        ``space``: ``"srgb"``, ``"p3"``, ``"rec2020"``, ``"acescg"`` or ``"xyz"``. Raises UnknownNameError for another.
        """
        return self._film.rgb(space)

    @property
    def xyz(self) -> Singles:
        """CIE 1931 XYZ, relative to D65 with Y = 1: (H, W, 3), float32. No errors."""
        return self._film.rgb("xyz")

    @property
    def alpha(self) -> Singles:
        """The EXR's alpha, 0 to 1: (H, W), float32, a share. The stones' coverage where the background is transparent, else 1, and 0
        where an interrupted render never came. No errors."""
        return self._film.alpha()

    @property
    def coverage(self) -> Singles:
        """The share of each pixel in which a stone is seen, 0 to 1, whatever the background: (H, W), float32. No errors."""
        return self._film.coverage()

    @cached_property
    def spectral(self) -> Singles:
        """Spectral radiance, relative, at :attr:`wavelengths`: (H, W, λ), float32. It is made once, without a copy between
        the library and NumPy, and is read-only. Raises InputError for a film that keeps no spectra."""
        spectra = self._film.spectral()
        if spectra.shape[2] == 0:
            raise InputError('this film keeps no spectra; render a scene with render={"spectral": True}')
        spectra.setflags(write=False)
        return spectra

    @property
    def wavelengths(self) -> Floats:
        """The wavelengths of :attr:`spectral` in nm: (λ,), float64; empty for a film without spectra. Where they move from
        sample to sample, the middles of their cells. No errors."""
        return self._film.wavelengths()

    @property
    def samples(self) -> npt.NDArray[np.uint32]:
        """The number of samples of each pixel: (H, W), uint32. No errors."""
        return self._film.samples()

    @property
    def energy(self) -> dict[str, float]:
        """Where the light went, as shares of all that started: ``dropped``, and its parts ``dropped_depth`` and
        ``dropped_threshold``; ``left_at_limit``, ``lost``. No errors."""
        energy: dict[str, float] = json.loads(self._film.energy())
        return energy

    @property
    def provenance(self) -> dict[str, Any]:
        """What goes into the headers of files: version, scene, hash, device, settings, rays, energy. Units as
        in ``docs/json.md``. No errors."""
        facts: dict[str, Any] = json.loads(self._film.facts())
        return facts

    @property
    def reason(self) -> str:
        """Why the last device was taken, in one line. No units, no errors."""
        return self._film.reason

    @property
    def warnings(self) -> tuple[str, ...]:
        """Remarks about the scene and its render; they are logged, too. No units, no errors."""
        return tuple(self._film.warnings)

    @property
    def seconds(self) -> float:
        """The time that tracing took, in seconds, without preparing the scene. No errors."""
        return self._film.seconds

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        space: str = "srgb",
        bits: int = 8,
        exposure: float = 0.0,
        tone: str | None = None,
    ) -> Path:
        """Writes a PNG or an EXR, as the extension says, and returns its path.

        ``space`` as for :meth:`rgb`; PNGs are at most in Rec. 2020. ``bits``: 8 or 16, of a PNG. ``exposure``: stops by
        which a PNG is brightened, beside the scene's own. ``tone``: how a PNG shows
        colours that a screen cannot, ``"hue"``, ``"clip"`` or ``"neutral"``, in place of the scene's. An EXR has 32-bit floats, the spectra if there are any, and where
        the picture comes from. The file appears when it is whole. Raises InputError for another extension or depth and for
        a file that the scene was read from, UnknownNameError for an unknown space or tone, OutputError for a file that cannot be
        written.
        """
        stops = float(exposure)
        if not abs(stops) <= 1000.0:
            raise InputError(f"exposure: {exposure} is not valid; expected stops from -1000 to 1000")
        self._film.save(os.fspath(path), space, bits, stops, tone)
        return Path(path)

    def to_xarray(self) -> xarray.Dataset:
        """An ``xarray.Dataset``: ``rgb`` (y, x, channel), ``xyz``, ``alpha``, ``samples`` and, if kept, ``spectral`` (y, x,
        wavelength). Coordinates: x and y in pixels from the top left corner to the pixels' middles, wavelength in nm.
        Attributes: the provenance. Raises ImportError without xarray.
        """
        import xarray

        height, width = self.shape
        coords: dict[str, Any] = {
            "y": ("y", np.arange(height) + 0.5, {"units": "pixel"}),
            "x": ("x", np.arange(width) + 0.5, {"units": "pixel"}),
            "channel": list("rgb"),
            "tristimulus": list("XYZ"),
        }
        data: dict[str, Any] = {
            "rgb": (("y", "x", "channel"), self.rgb(), {"space": "linear sRGB", "units": "relative"}),
            "xyz": (("y", "x", "tristimulus"), self.xyz, {"units": "relative"}),
            "alpha": (("y", "x"), self.alpha),
            "samples": (("y", "x"), self.samples),
        }
        if self.wavelengths.size:
            coords["wavelength"] = ("wavelength", self.wavelengths, {"units": "nm"})
            data["spectral"] = (("y", "x", "wavelength"), self.spectral, {"units": "relative spectral radiance"})
        attributes = {key: entry if isinstance(entry, str) else json.dumps(entry) for key, entry in self.provenance.items()}
        return xarray.Dataset(data, coords, attributes)

    def _repr_png_(self) -> bytes:
        """How a notebook shows it: the PNG that ``save`` writes."""
        return self._film.png()

    def __repr__(self) -> str:
        height, width = self.shape
        state = "" if self.finished else ", not finished"
        return f"<gemtrace.Film, {width} × {height} pixels, {self.provenance['device']}{state}>"
