"""Optics over arrays, by the library's own formulas."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _gemtrace
from ._array import Floats, flat, plain, real, remark, together, vectors, wavelengths
from ._errors import InputError


class Fresnel(NamedTuple):
    """What an interface does to light; every array has the shape of :func:`fresnel`'s arguments together.

    s is perpendicular to the plane of incidence; in the frame (e_s, e_p, k) with e_p = k × e_s, r_p = −r_s at normal
    incidence. Transmittances are shares of power: T = 1 − R for a dielectric, 0 for a metal. No units; making one raises no
    errors.
    """

    reflectance_s: Floats
    """R_s, 0 to 1."""
    reflectance_p: Floats
    """R_p, 0 to 1."""
    transmittance_s: Floats
    """T_s, 0 to 1."""
    transmittance_p: Floats
    """T_p, 0 to 1."""
    reflected_cross: npt.NDArray[np.complex128]
    """r_s · conj(r_p); its phase is the retardation of reflected light."""
    refracted_cross: Floats
    """√(T_s T_p)."""
    cos_t: Floats
    """Cosine of the angle of refraction; 0 under total reflection and for a metal."""
    total: npt.NDArray[np.bool_]
    """Whether reflection is total."""

    @property
    def reflectance(self) -> Floats:
        """Of unpolarised light, a share from 0 to 1, in the shape of the others. No errors."""
        return (self.reflectance_s + self.reflectance_p) / 2.0

    @property
    def transmittance(self) -> Floats:
        """Of unpolarised light, a share from 0 to 1, in the shape of the others. No errors."""
        return (self.transmittance_s + self.transmittance_p) / 2.0


def fresnel(cos_i: npt.ArrayLike, n1: npt.ArrayLike, n2: npt.ArrayLike) -> Fresnel:
    """Reflection and refraction at interfaces, by Fresnel's equations.

    ``cos_i``: cosines of the angle of incidence, 0 to 1. ``n1``: index on the incident side, above 0. ``n2``: index beyond,
    above 0, or complex, n + ik with k at least 0, for a metal. Shapes are broadcast; there are no units. Raises InputError
    for values outside these ranges or shapes that do not go together, and TypeError for what is no number.
    """
    index = plain("n2", n2, "iufc")
    metal = index.dtype.kind == "c"
    positive = "an index of refraction, above 0"
    least = np.nextafter(0.0, 1.0)
    cos, incident, n, k = together(
        cos_i=real("cos_i", cos_i, 0.0, 1.0, "a cosine from 0 to 1"),
        n1=real("n1", n1, least, expected=positive),
        n2=real("n2", index.real, least, expected=positive),
        k2=real("n2: imaginary part", index.imag, 0.0, expected="k of n + ik, from 0") if metal else np.zeros(()),
    )
    rows = np.stack([cos, incident, n, k], axis=-1)
    out = _gemtrace.fresnel(flat(rows), metal).reshape(*cos.shape, 9)
    r_s, r_p, t_s, t_p, re, im, refracted, cos_t, total = (out[..., i] for i in range(9))
    return Fresnel(r_s, r_p, t_s, t_p, re + 1j * im, refracted, cos_t, total > 0.5)


def stokes(event: Fresnel, kind: Literal["reflected", "refracted"], turn: npt.ArrayLike = 0.0) -> Floats:
    """Mueller matrices of an event: shape (…, 4, 4), without units. They act on Stokes columns (I, Q, U, V) from the left.

    Q = |E_s|² − |E_p|², U = 2 Re(E_s E_p*), V = 2 Im(E_s E_p*), fields as exp(i(k·r − ωt)). ``event`` from :func:`fresnel`,
    ``turn`` in radians: how far the frame is turned into the plane of incidence before, from e_s towards e_p. Shapes are
    broadcast. Raises InputError for another ``kind``, or angles that are not finite.
    """
    if kind == "reflected":
        s, p, cross = event.reflectance_s, event.reflectance_p, event.reflected_cross
    elif kind == "refracted":
        s, p, cross = event.transmittance_s, event.transmittance_p, event.refracted_cross.astype(np.complex128)
    else:
        raise InputError(f"kind: {kind!r} is not valid; expected 'reflected' or 'refracted'")
    angle = real("turn", turn)
    s, p, re, im, angle = together(s=s, p=p, re=np.asarray(cross.real), im=np.asarray(cross.imag), turn=angle)
    rows = np.stack([s, p, re, im, np.cos(2.0 * angle), np.sin(2.0 * angle)], axis=-1)
    return _gemtrace.mueller(flat(rows)).reshape(*s.shape, 4, 4)


class Waves(NamedTuple):
    """The two waves in a crystal along each direction: the ordinary and the extraordinary one of a uniaxial crystal, else
    those of the smaller and the larger index. The last but one axis of each array is (…, 2), or (…, 2, 3) for vectors; angles
    are in radians. No errors."""

    n: Floats
    """Index that the wave sees: (…, 2), without unit."""
    walk_off: Floats
    """Angle between wave vector and ray: (…, 2), radians."""
    ray: Floats
    """Unit vector along which the power goes: (…, 2, 3)."""
    electric: Floats
    """Unit vector of the electric field: (…, 2, 3)."""


def crystal(n: npt.ArrayLike, direction: npt.ArrayLike, axes: npt.ArrayLike | None = None) -> Waves:
    """The two waves of a crystal whose wave vectors have these directions.

    ``n``: (…, 3), indices along its axes, above 0; (…, 2) are those of the ordinary and extraordinary ray, with the optic
    axis third. ``direction``: (…, 3), of any length above 0. ``axes``: (…, 3, 3), its three axes as rows, unit and
    perpendicular; the coordinate axes if left out. Leading shapes are broadcast; there are no units but radians. Raises
    InputError for other shapes, indices, directions or axes.
    """
    index = real("n", n, np.nextafter(0.0, 1.0), expected="an index of refraction, above 0")
    if index.ndim and index.shape[-1] == 2:
        index = index[..., [0, 0, 1]]
    index, along = vectors("n", index, 3), vectors("direction", direction, 3)
    frame = vectors("axes", np.eye(3) if axes is None else axes, 3)
    if frame.ndim < 2 or frame.shape[-2] != 3:
        raise InputError(f"axes: an array of shape {frame.shape} is not valid; expected (…, 3, 3)")
    if not np.allclose(frame @ np.swapaxes(frame, -1, -2), np.eye(3), atol=1e-9):
        raise InputError("axes: they are not unit and perpendicular; give three rows that are, to 1e-9")
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    if not (length > 0.0).all():
        raise InputError("direction: a vector of length 0 is not valid; expected a direction")
    try:
        shape = np.broadcast_shapes(index.shape[:-1], along.shape[:-1], frame.shape[:-2])
    except ValueError:
        shapes = f"n {index.shape}, direction {along.shape}, axes {frame.shape}"
        raise InputError(f"shapes that do not go together: {shapes}") from None
    rows = np.concatenate(
        [
            np.broadcast_to(index, (*shape, 3)),
            np.broadcast_to(frame.reshape(*frame.shape[:-2], 9), (*shape, 9)),
            np.broadcast_to(along / length, (*shape, 3)),
        ],
        axis=-1,
    )
    out = _gemtrace.crystal(flat(rows)).reshape(*shape, 2, 8)
    return Waves(out[..., 0], out[..., 1], out[..., 2:5], out[..., 5:8])


def upsample(rgb: npt.ArrayLike, nm: npt.ArrayLike, space: str = "srgb") -> Floats:
    """Spectra of light of given colours: relative radiance, shape (…, λ).

    ``rgb``: (…, 3), linear. ``nm``: (λ,), ascending wavelengths in nm, on which the colour is exact: from 380 to 740 nm
    seven or more are enough. ``space`` as for :meth:`gemtrace.Film.rgb`. Colours that no light in sRGB has lose their
    negative components, with a remark in the log. (1, 1, 1) is D65. Raises InputError for other shapes or wavelengths, and
    UnknownNameError for an unknown space.
    """
    colours, grid = vectors("rgb", rgb, 3), wavelengths(nm)
    if grid.ndim != 1:
        raise InputError(f"nm: an array of shape {grid.shape} is not valid; expected (λ,)")
    spectra, warning, residual = _gemtrace.upsample(flat(colours), grid.tolist(), space)
    remark([warning] if warning else [])
    if residual > 1e-6:
        remark([f"no light of these {grid.size} wavelengths has every colour; the largest error is {residual:.1e}"])
    return spectra.reshape(*colours.shape[:-1], grid.size)


def cauchy_fit(nm: npt.ArrayLike, n: npt.ArrayLike) -> Floats:
    """Cauchy's n = A + B/λ² + C/λ⁴ with λ in µm, fitted to measured indices: (…, 3), the coefficients A, B and C.

    ``nm``: (m,), three or more wavelengths in nm, three of them 20 nm apart. ``n``: (…, m), the indices measured there,
    above 1. Three are met exactly, more in the least squares. Remarks about doubtful figures are logged. Raises InputError
    naming the measurement that is not valid.
    """
    at = wavelengths(nm)
    if at.ndim != 1:
        raise InputError(f"nm: an array of shape {at.shape} is not valid; expected (m,)")
    measured = vectors("n", n, at.size)
    if not at.size:
        raise InputError("nm: no wavelengths are not valid; expected three or more")
    fitted, remarks = _gemtrace.cauchy_fit(at.tolist(), flat(measured))
    remark(remarks)
    return fitted.reshape(*measured.shape[:-1], 3)
