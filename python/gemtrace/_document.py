"""Scenes as documents: from what callers give, with arrays taken out and named."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, SupportsIndex

import numpy as np

from . import _gemtrace
from ._array import plain, vectors
from ._cut import Cut, indices
from ._errors import InputError

Document = dict[str, Any]

# Of these keys a section has one; another one takes its place.
EITHER = {
    "camera": ("fov", "orthographic"),
    "environment": ("image", "uniform", "preset", "model"),
    "ground": ("diffuse", "material", "mirror"),
}
NESTED = 16


def value(what: str, given: object, depth: int = 0) -> Any:
    """What a document can hold: texts, truth values, numbers, lists and tables. TypeError for anything else, InputError for
    numbers that are not finite or too large."""
    if depth > NESTED:
        raise InputError(f"{what}: tables within more than {NESTED} others are not valid")
    if isinstance(given, (np.ndarray, np.generic)):
        plain(what, given, "biufU")
        given = given.tolist()
    if given is None or isinstance(given, (str, bool)):
        return given
    if isinstance(given, os.PathLike):
        return os.path.abspath(os.fspath(given))
    if isinstance(given, float):
        if math.isfinite(given):
            return given
        raise InputError(f"{what}: {given} is not valid; expected a finite number")
    if isinstance(given, SupportsIndex):
        whole = given.__index__()
        if abs(whole) < 2**63:
            return whole
        raise InputError(f"{what}: {whole} is not valid; expected a number below 2⁶³")
    if isinstance(given, Mapping):
        return {text(what, key): value(f"{what}.{key}", entry, depth + 1) for key, entry in given.items() if entry is not None}
    if isinstance(given, Iterable) and not isinstance(given, (bytes, bytearray)):
        return [value(f"{what}[{i}]", entry, depth + 1) for i, entry in enumerate(given)]
    raise TypeError(f"{what}: {type(given).__name__} is not valid; expected a number, a text, a list or a table")


def text(what: str, key: object) -> str:
    """A key of a table."""
    if isinstance(key, str):
        return key
    raise TypeError(f"{what}: the key {key!r} is not valid; keys are texts")


def table(what: str, given: object) -> Document:
    """A table, whose values are not looked at."""
    if isinstance(given, Mapping):
        return {text(what, key): entry for key, entry in given.items()}
    raise TypeError(f"{what}: {type(given).__name__} is not valid; expected a table, such as a dict")


class Maker:
    """Takes arrays and solids out of sections, and keeps them for the scene that will name them."""

    def __init__(self) -> None:
        self.made: list[_gemtrace.Made] = []

    def name(self, made: _gemtrace.Made) -> str:
        self.made.append(made)
        return made.name

    def section(self, what: str, given: object) -> Document:
        """A section; keys with None are kept, since they remove what was there."""
        section = table(what, given)
        if what == "environment" and section.get("image") is not None:
            section["image"] = self.image(section["image"])
        for key, entry in section.items():
            section[key] = value(f"{what}.{key}", entry)
        return section

    def image(self, image: object) -> str:
        """A path, or the name of a light from texels."""
        if isinstance(image, (str, os.PathLike)):
            return os.path.abspath(os.fspath(image))
        array = plain("environment.image", image, "iuf")
        if array.dtype == np.uint8:
            raise TypeError("environment.image: uint8 is not valid; decode pictures to linear sRGB in floating point")
        if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
            raise InputError(
                f"environment.image: an array of shape {array.shape} is not valid; expected (rows, columns, 3), linear sRGB"
            )
        with np.errstate(over="ignore"):
            texels = np.ascontiguousarray(array, dtype=np.float32).reshape(-1)
        return self.name(_gemtrace.Made.light(array.shape[0], array.shape[1], texels))

    def stones(self, given: object) -> list[Document]:
        """All stones."""
        if isinstance(given, (str, Mapping)) or not isinstance(given, Sequence):
            raise TypeError(f"stones: {type(given).__name__} is not valid; expected a list of tables")
        return [self.stone(f"stones[{i}]", stone) for i, stone in enumerate(given)]

    def stone(self, what: str, given: object) -> Document:
        """One stone; its shape may be a solid or arrays."""
        stone = table(what, given)
        for key in ("cut", "mesh"):
            shape = stone.get(key)
            if isinstance(shape, Cut):
                stone[key] = self.name(_gemtrace.Made.solid(shape._solid))
            elif isinstance(shape, (str, os.PathLike)):
                stone[key] = os.path.abspath(os.fspath(shape))
            elif shape is not None and key == "mesh":
                stone[key] = self.name(_gemtrace.Made.solid(triangles(f"{what}.mesh", shape)))
        return {key: value(f"{what}.{key}", entry) for key, entry in stone.items() if entry is not None}


def triangles(what: str, given: object) -> _gemtrace.Solid:
    """A closed mesh from a pair of arrays."""
    if not isinstance(given, (tuple, list)) or len(given) != 2:
        raise TypeError(f"{what}: expected a path, a Cut, or a pair (vertices, triangles)")
    vertices = vectors(f"{what}: vertices", given[0], 3).reshape(-1)
    return _gemtrace.Solid.triangles(vertices, indices(f"{what}: triangles", given[1]))


def merged(before: Document, name: str, change: Document) -> Document:
    """A section with another's keys; None removes one."""
    rivals = [key for key in EITHER.get(name, ()) if any(change.get(k) is not None for k in EITHER[name])]
    kept = {key: entry for key, entry in before.items() if key not in rivals}
    return {key: entry for key, entry in {**kept, **change}.items() if entry is not None}


def relocate(document: Document, files: Mapping[str, str], folder: Path) -> None:
    """Names every file of a document by its full path, and what was in no file by the file that it was written to."""

    def named(name: str) -> str:
        return files.get(name) or os.fspath(folder / name)

    for stone in document.get("stone", []):
        # What was made is written as a mesh.
        for key in ("mesh", "cut"):
            name = stone.pop(key, None)
            if name is not None:
                stone["mesh" if name in files else key] = named(name)
    environment = document.get("environment", {})
    if "image" in environment:
        environment["image"] = named(environment["image"])
    if "." in environment.get("illuminant", ""):
        environment["illuminant"] = named(environment["illuminant"])
    for material in document.get("material", {}).values():
        for part in (material, material.get("extraordinary", {}), *material.get("principal", [])):
            if isinstance(part.get("absorption"), str):
                part["absorption"] = named(part["absorption"])
