"""Materials, against closed forms and the command line."""

from __future__ import annotations

import json
import logging
from typing import Any

import gemtrace
import numpy as np
import pytest
from conftest import Program


def test_the_catalogue_is_a_mapping(program: Program) -> None:
    materials = gemtrace.materials
    listed = json.loads(program("materials", "--json"))["materials"]
    assert [entry["name"] for entry in listed] == list(materials) and len(materials) == len(listed)
    assert "ruby" in materials and "rubby" not in materials and materials.get("rubby") is None
    assert materials["Ruby"].name == "ruby" and "ruby" in repr(materials)
    with pytest.raises(KeyError) as found:
        materials["rubby"]
    assert str(found.value) == "unknown material 'rubby'; did you mean 'ruby'?"
    assert isinstance(found.value, gemtrace.UnknownNameError)
    with pytest.raises(TypeError):
        materials[3]  # type: ignore[index]


@pytest.mark.parametrize("name", list(gemtrace.materials))
def test_every_material_has_its_curves(name: str) -> None:
    material = gemtrace.materials[name]
    nm = np.linspace(380.0, 740.0, 37)
    for axis in (None, *material.axes):
        assert (material.n(nm, axis) > 0.0).all() and (material.absorption(nm, axis) >= 0.0).all()
    assert (material.k(nm) > 0.0).all() == material.is_metal
    assert material.axes in ((), ("o", "e"), ("x", "y", "z"))
    assert material.sources and all(source["source"] for source in material.sources)
    assert isinstance(material.aliases, tuple) and isinstance(material.notes, tuple)
    assert material.density is None or 1.0 < material.density < 25.0
    assert repr(material) == f"<gemtrace.Material {name}>"


def test_known_figures() -> None:
    diamond, calcite, gold = (gemtrace.materials[name] for name in ("diamond", "calcite", "gold"))
    assert abs(diamond.n(589.29) - 2.41726) < 1e-5 and isinstance(diamond.n(589.29), float)
    assert calcite.axes == ("o", "e")
    assert abs(calcite.n(589.3, "o") - 1.6584) < 5e-4 and abs(calcite.n(589.3, "e") - 1.4864) < 5e-4
    assert gemtrace.materials["tanzanite"].axes == ("x", "y", "z")
    nm = np.array([500.0, 600.0])
    np.testing.assert_allclose(gold.absorption(nm), 4.0 * np.pi * gold.k(nm) / (nm * 1e-6), rtol=1e-14)


@pytest.mark.parametrize("kind", ["<f8", ">f8", "<f4", "<i4", ">u2", "<f2"])
def test_curves_take_any_array_and_keep_its_shape(kind: str) -> None:
    ruby = gemtrace.materials["ruby"]
    nm = np.array([[400, 500, 600], [450, 550, 650]], kind)
    nm.flags.writeable = False
    expected = [[ruby.n(float(x)) for x in row] for row in nm]
    for given in (nm, np.asfortranarray(nm), np.repeat(nm, 2, axis=1)[:, ::2], nm.tolist()):
        np.testing.assert_array_equal(ruby.n(given), expected)
    assert ruby.n(np.zeros((0, 3))).shape == (0, 3) and ruby.absorption([]).shape == (0,)


@pytest.mark.parametrize(
    ("nm", "error", "words"),
    [
        (0.589, gemtrace.InputError, "micrometres"),
        ([500.0, np.nan], gemtrace.InputError, r"nm\[1\]: nan"),
        ([[500.0], [np.inf]], gemtrace.InputError, r"nm\[1, 0\]: inf"),
        (-500.0, gemtrace.InputError, "-500"),
        (5893, gemtrace.InputError, "5893"),
        ("red", TypeError, "<U3"),
        (500j, TypeError, "complex128"),
        (None, TypeError, "object"),
        ([True], TypeError, "bool"),
        ([[1.0], [1.0, 2.0]], gemtrace.InputError, "nm"),
    ],
)
def test_wavelengths_that_are_none(nm: Any, error: type[Exception], words: str) -> None:
    ruby = gemtrace.materials["ruby"]
    for curve in (ruby.n, ruby.k, ruby.absorption):
        with pytest.raises(error, match=words):
            curve(nm)


def test_axes_that_are_none() -> None:
    with pytest.raises(gemtrace.UnknownNameError, match="unknown axis 'x' of calcite; valid: o, e"):
        gemtrace.materials["calcite"].n(500.0, "x")
    with pytest.raises(gemtrace.UnknownNameError, match="isotropic"):
        gemtrace.materials["diamond"].absorption(500.0, axis="o")


def test_materials_of_ones_own(caplog: pytest.LogCaptureFixture) -> None:
    glass = gemtrace.Material("pink glass", {"cauchy": (1.5046, 0.0042), "absorption": [{"centre": 553.0, "sigma": 38.0, "peak": 0.9}]})
    nm = np.array([450.0, 553.0])
    np.testing.assert_allclose(glass.n(nm), 1.5046 + 0.0042 / (nm / 1e3) ** 2, rtol=1e-15)
    assert abs(glass.absorption(553.0) - 0.9) < 1e-15 and glass.axes == () and not glass.is_metal
    with caplog.at_level(logging.WARNING, "gemtrace"):
        gemtrace.Material("far", {"measured": np.array([[500.0, 1.52], [600.0, 1.51], [700.0, 1.505]])})
    assert "violet is extrapolated" in caplog.text
    bad: list[tuple[Any, type[Exception], str]] = [
        ({}, gemtrace.InputError, "give one of index"),
        ({"index": 1.5, "cauchy": [1.5]}, gemtrace.InputError, "give one of them only"),
        ({"index": -1.0}, gemtrace.InputError, "-1"),
        ({"index": np.nan}, gemtrace.InputError, "index: nan"),
        ({"indx": 1.5}, gemtrace.InputError, "indx"),
        ({"index": "1.5"}, gemtrace.InputError, "material 'x'"),
        ({"like": "rubby"}, gemtrace.UnknownNameError, "did you mean 'ruby'"),
        ({"index": 1.5, "absorption": "nowhere.csv"}, gemtrace.InputError, "no such file"),
        (1.5, TypeError, "float"),
    ]
    for spec, error, words in bad:
        with pytest.raises(error, match=words):
            gemtrace.Material("x", spec)
