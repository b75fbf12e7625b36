"""Arrays from callers: checked, and in the form that the library takes."""

from __future__ import annotations

import logging
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from ._errors import InputError

Floats = npt.NDArray[np.float64]

log = logging.getLogger("gemtrace")


def remark(messages: Iterable[str]) -> None:
    """Logs remarks of the library as warnings."""
    for message in messages:
        log.warning("%s", message)


def plain(what: str, values: object, kinds: str) -> npt.NDArray[np.generic]:
    """An array whose dtype is of these kinds; TypeError for any other, InputError for rows of unequal length."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{what}: {error}") from None
    if array.dtype.kind not in kinds:
        expected = "real numbers" if "c" not in kinds else "numbers"
        raise TypeError(f"{what}: {array.dtype} is not valid; expected an array of {expected}")
    return array


def real(what: str, values: object, low: float = -np.inf, high: float = np.inf, expected: str = "a finite number") -> Floats:
    """Real numbers as contiguous float64, in any shape; InputError naming the first that is not finite or not within
    the bounds."""
    array = np.asarray(plain(what, values, "iuf"), dtype=np.float64, order="C")
    with np.errstate(invalid="ignore"):
        wrong = ~(np.isfinite(array) & (array >= low) & (array <= high))
    if wrong.any():
        place = tuple(int(i) for i in np.argwhere(wrong)[0])
        index = f"[{', '.join(map(str, place))}]" if place else ""
        raise InputError(f"{what}{index}: {array[place]} is not valid; expected {expected}")
    return array


def vectors(what: str, values: object, length: int, **bounds: float | str) -> Floats:
    """Real numbers whose last axis has a length."""
    array = real(what, values, **bounds)  # type: ignore[arg-type]
    if array.ndim == 0 or array.shape[-1] != length:
        raise InputError(f"{what}: an array of shape {array.shape} is not valid; its last axis has length {length}")
    return array


def wavelengths(values: object, what: str = "nm") -> Floats:
    """Wavelengths in nm."""
    array = real(what, values, 0.0, expected="wavelengths in nm, from 200 to 2000")
    outside = array[(array < 200.0) | (array > 2000.0)]
    if outside.size:
        small = bool((outside > 0.2).all() and (outside <= 2.0).all())
        hint = f"; {outside.flat[0]} looks like micrometres" if small else ""
        raise InputError(f"{what}: {outside.flat[0]} is not valid; expected wavelengths in nm, from 200 to 2000{hint}")
    return array


def together(**arrays: Floats) -> list[Floats]:
    """Arrays in one shape, by NumPy's rules of broadcasting; InputError with their shapes where there is none."""
    try:
        return list(np.broadcast_arrays(*arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise InputError(f"shapes that do not go together: {shapes}") from None


def flat(array: npt.NDArray[np.generic]) -> Floats:
    """All numbers in one row."""
    return np.ascontiguousarray(array, dtype=np.float64).reshape(-1)
