"""Cuts as arrays, and their figures, against the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import gemtrace
import numpy as np
import pytest
from conftest import ROOT, Program

CUTS = ["spectral-core/data/cuts/srb_diamond_57.asc", "scenes/cuts/step.gem", "scenes/cuts/portuguese.gcs", "scenes/meshes/rhomb.obj"]


@pytest.mark.parametrize("name", CUTS)
def test_arrays_describe_the_solid(name: str, program: Program) -> None:
    cut = gemtrace.cut(ROOT / name)
    facets, vertices = len(cut.normals), len(cut.vertices)
    assert cut.normals.shape == (facets, 3) and cut.offsets.shape == (facets,) and len(cut.names) == facets
    assert cut.triangles.shape == (len(cut.facet_of), 3) and cut.triangles.max() == vertices - 1
    np.testing.assert_allclose(np.linalg.norm(cut.normals, axis=1), 1.0, rtol=1e-12)
    # Each triangle lies in the plane of its facet, and all together enclose the volume.
    corners = cut.vertices[cut.triangles]
    planes = np.einsum("tcx,tx->tc", corners, cut.normals[cut.facet_of]) - cut.offsets[cut.facet_of, None]
    assert np.abs(planes).max() < 2e-6
    volume = np.einsum("tx,tx->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert abs(volume / cut.proportions["volume"] - 1.0) < 1e-9
    said = json.loads(program("cut", ROOT / name, "--json"))
    assert said["solid"] == cut.proportions and repr(cut) == f"<gemtrace.Cut of {facets} facets>"
    if "tiers" in said:
        assert len(cut.tiers) == len(said["tiers"]) and list(cut.title) == said["title"]
        assert cut.gear == said["gear"] and cut.index_of_refraction == said["index_of_refraction"]
        assert isinstance(cut.footnotes, tuple)


def test_shapes() -> None:
    brilliant = gemtrace.Cut.shape("round-brilliant", table=0.55, crown=np.float32(34.5))
    assert abs(brilliant.proportions["table_percent"] - 55.0) < 1e-9
    assert abs(brilliant.proportions["crown_angle"] - 34.5) < 1e-9
    assert gemtrace.Cut.shape("step", crown=[45.0, 35.0, 25.0]).proportions["convex"]
    bad: list[tuple[str, dict[str, Any], type[Exception], str]] = [
        ("round-briliant", {}, gemtrace.UnknownNameError, "did you mean 'round-brilliant'"),
        ("round-brilliant", {"table": 1.5}, gemtrace.InputError, "table: 1.5"),
        ("round-brilliant", {"tabel": 0.5}, gemtrace.InputError, "tabel"),
        ("round-brilliant", {"table": float("nan")}, gemtrace.InputError, "table: nan"),
        ("round-brilliant", {"table": "wide"}, gemtrace.InputError, "shape 'round-brilliant'"),
        ("round-brilliant", {"table": 1j}, TypeError, "complex"),
    ]
    for name, parameters, error, words in bad:
        with pytest.raises(error, match=words):
            gemtrace.Cut.shape(name, **parameters)


def test_planes_give_back_what_they_were() -> None:
    cut = gemtrace.cut(ROOT / CUTS[0])
    again = gemtrace.Cut.from_planes(3.0 * cut.normals, 3.0 * cut.offsets, cut.names)
    np.testing.assert_allclose(again.normals, cut.normals, atol=1e-15)
    np.testing.assert_allclose(again.offsets, cut.offsets, rtol=1e-15)
    assert again.names == cut.names
    for convert in (np.asfortranarray, lambda a: a.astype(">f8"), lambda a: np.repeat(a, 2, axis=0)[::2], np.ndarray.tolist):
        np.testing.assert_array_equal(gemtrace.Cut.from_planes(convert(cut.normals), cut.offsets).vertices, gemtrace.Cut.from_planes(cut.normals, cut.offsets).vertices)


@pytest.mark.parametrize(
    ("normals", "offsets", "error", "words"),
    [
        (np.eye(3), np.ones(3), gemtrace.InputError, "towards"),
        (np.eye(3), np.ones(2), gemtrace.InputError, r"\(3, 3\) and offsets \(2,\)"),
        (np.eye(3)[:, :2], np.ones(3), gemtrace.InputError, "length 3"),
        (np.zeros((0, 3)), np.zeros(0), gemtrace.InputError, "."),
        (np.zeros((6, 3)), np.ones(6), gemtrace.InputError, "not zero"),
        (np.full((6, 3), np.nan), np.ones(6), gemtrace.InputError, r"normals\[0, 0\]: nan"),
        (np.concatenate([np.eye(3), -np.eye(3)]), -np.ones(6), gemtrace.InputError, "."),
        (np.concatenate([np.eye(3), -np.eye(3)]), [1, 1, 1, 1, 1, np.inf], gemtrace.InputError, r"offsets\[5\]"),
        ("abc", np.ones(1), TypeError, "normals"),
        (np.eye(3) * 1j, np.ones(3), TypeError, "normals: complex128"),
        (np.eye(3), None, TypeError, "offsets: object"),
    ],
)
def test_planes_that_are_none(normals: Any, offsets: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        gemtrace.Cut.from_planes(normals, offsets)


@pytest.mark.parametrize(
    ("vertices", "triangles", "error", "words"),
    [
        (np.eye(3), [[0, 1, 2]], gemtrace.InputError, "open|boundary|closed"),
        (np.eye(3), [[0, 1, 3]], gemtrace.InputError, "3"),
        (np.eye(3), [[0, 1, -1]], gemtrace.InputError, "-1"),
        (np.eye(3), [[0.0, 1.0, 2.0]], TypeError, "whole numbers"),
        (np.eye(3), [0, 1, 2], gemtrace.InputError, r"\(3,\)"),
        (np.eye(3), np.zeros((0, 3), int), gemtrace.InputError, "."),
        (np.eye(2), [[0, 1, 1]], gemtrace.InputError, "length 3"),
        (np.full((3, 3), np.nan), [[0, 1, 2]], gemtrace.InputError, "nan"),
        (None, [[0, 1, 2]], TypeError, "object"),
    ],
)
def test_meshes_that_are_none(vertices: Any, triangles: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        gemtrace.Cut.from_mesh(vertices, triangles)


def test_files_that_are_none(tmp_path: Path) -> None:
    broken = tmp_path / "x.asc"
    broken.write_text("GemCad 5.0\ng 96 0.0\ny 8 y\na 45.0 1.0 12 n 1\n")
    unknown = tmp_path / "x.step"
    unknown.write_text("x")
    for path, words in [(tmp_path / "none.asc", "no such file"), (unknown, "not a cut format"), (tmp_path, "folder"), (broken, "x.asc")]:
        with pytest.raises(gemtrace.FileError, match=words):
            gemtrace.cut(path)
    with pytest.raises(TypeError):
        gemtrace.cut(3)  # type: ignore[arg-type]
    with pytest.raises(gemtrace.InputError, match="names: 1"):
        gemtrace.Cut.from_planes(np.eye(3), np.ones(3), ["C1"])
