"""The vectorised functions, against closed forms."""

from __future__ import annotations

import logging
from typing import Any

import gemtrace
import numpy as np
import pytest
from gemtrace import Fresnel, cauchy_fit, crystal, fresnel, stokes, upsample

NOTHING: Any = None


def test_fresnel_at_normal_incidence_and_beyond_the_critical_angle() -> None:
    event = fresnel(1.0, 1.0, 1.5)
    assert isinstance(event, Fresnel) and event.reflectance.shape == ()
    assert abs(event.reflectance - 0.04) < 1e-15 and abs(event.transmittance - 0.96) < 1e-15
    inside = fresnel(0.5, 1.5, 1.0)
    assert inside.total and inside.reflectance_s == 1.0 and inside.transmittance == 0.0 and inside.cos_t == 0.0
    # |r_s r_p*| is 1, and its phase the retardation of Born & Wolf, §1.5.4.
    sin2 = 0.75
    delta = 2.0 * np.arctan(0.5 * np.sqrt(sin2 - 1.0 / 1.5**2) / sin2)
    assert abs(inside.reflected_cross - np.exp(1j * delta)) < 1e-12


def test_fresnel_broadcasts_and_agrees_with_the_equations() -> None:
    cos, n = np.linspace(0.01, 1.0, 50), np.array([[1.3], [1.77], [2.42]])
    event = fresnel(cos, 1.0, n)
    cos_t = np.sqrt(1.0 - (1.0 - cos**2) / n**2)
    r_s, r_p = (cos - n * cos_t) / (cos + n * cos_t), (n * cos - cos_t) / (n * cos + cos_t)
    for found, exact in [
        (event.reflectance_s, r_s**2),
        (event.reflectance_p, r_p**2),
        (event.transmittance_s, 1.0 - r_s**2),
        (event.transmittance_p, 1.0 - r_p**2),
        (event.reflected_cross, r_s * r_p),
        (event.refracted_cross, np.sqrt((1.0 - r_s**2) * (1.0 - r_p**2))),
        (event.cos_t, cos_t),
    ]:
        assert found.shape == (3, 50)
        np.testing.assert_allclose(found, exact, atol=1e-14)
    assert event.total.dtype == bool and not event.total.any()


def test_fresnel_of_a_metal() -> None:
    gold = fresnel(1.0, 1.0, 0.29 + 2.863j)
    assert abs(gold.reflectance - abs((1 - (0.29 + 2.863j)) / (1 + 0.29 + 2.863j)) ** 2) < 1e-14
    assert gold.transmittance == 0.0
    # A complex index without an imaginary part reflects as a dielectric does, but lets nothing through.
    assert abs(fresnel(0.7, 1.0, 1.5 + 0j).reflectance_s - fresnel(0.7, 1.0, 1.5).reflectance_s) < 1e-14


@pytest.mark.parametrize("kind", ["<f8", ">f8", "<f4", "<f2"])
def test_any_array_will_do(kind: str) -> None:
    cos = np.array([0.25, 0.5, 1.0], kind)
    cos.flags.writeable = False
    for given in (cos, np.repeat(cos, 3)[::3], cos[::-1][::-1], cos.tolist()):
        np.testing.assert_array_equal(fresnel(given, np.int8(1), 2).reflectance_s, fresnel([0.25, 0.5, 1.0], 1.0, 2.0).reflectance_s)
    assert fresnel([], 1.0, 1.5).reflectance.shape == (0,)
    assert stokes(fresnel([], 1.0, 1.5), "reflected").shape == (0, 4, 4)
    assert crystal(np.ones((0, 3)), (0, 0, 1)).ray.shape == (0, 2, 3)
    assert upsample(np.ones((0, 3)), np.linspace(390, 730, 8)).shape == (0, 8)
    assert cauchy_fit([450, 550, 650], np.ones((0, 3))).shape == (0, 3)


def test_stokes_matrices() -> None:
    event = fresnel(np.array([0.2, 0.9]), 1.0, 1.77)
    for kind, s, p, cross in [
        ("reflected", event.reflectance_s, event.reflectance_p, event.reflected_cross.real),
        ("refracted", event.transmittance_s, event.transmittance_p, event.refracted_cross),
    ]:
        matrix = stokes(event, kind)  # type: ignore[arg-type]
        assert matrix.shape == (2, 4, 4)
        np.testing.assert_allclose(matrix[:, 0, 0], (s + p) / 2)
        np.testing.assert_allclose(matrix[:, 0, 1], (s - p) / 2)
        np.testing.assert_allclose(matrix[:, 2, 2], cross)
    # A frame that is turned by a right angle exchanges s and p.
    turned = stokes(event, "reflected", np.pi / 2)
    np.testing.assert_allclose(turned[:, 0, 1], -stokes(event, "reflected")[:, 0, 1], atol=1e-15)
    assert stokes(event, "reflected", np.zeros((5, 1))).shape == (5, 2, 4, 4)
    with pytest.raises(gemtrace.InputError, match="kind: 'both'"):
        stokes(event, "both")  # type: ignore[arg-type]
    with pytest.raises(gemtrace.InputError, match="turn: nan"):
        stokes(event, "reflected", np.nan)
    with pytest.raises(gemtrace.InputError, match="go together"):
        stokes(event, "reflected", np.zeros(3))


def test_crystal_waves() -> None:
    # Calcite at 41.870° from the axis, where its rays part most (design figure of the library's own test).
    angle = np.radians(41.870)
    waves = crystal((1.65835, 1.48640), (np.sin(angle), 0.0, 3.0 * np.cos(angle) / 3.0))
    assert waves.n.shape == (2,) and waves.ray.shape == (2, 3)
    assert abs(waves.n[0] - 1.65835) < 1e-12
    np.testing.assert_allclose(np.degrees(waves.walk_off), [0.0, 6.259454], atol=1e-5)
    # Along every axis of a biaxial crystal the two waves have the other two indices.
    topaz = np.array([1.609, 1.611, 1.618])
    found = crystal(topaz, np.eye(3))
    np.testing.assert_allclose(found.n, [[1.611, 1.618], [1.609, 1.618], [1.609, 1.611]], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(found.electric, axis=-1), 1.0, rtol=1e-14)
    # An axis that is turned with the direction changes nothing.
    frame = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    direction = np.array([0.3, -0.5, 0.8])
    np.testing.assert_allclose(crystal(topaz, direction @ frame, frame).n, crystal(topaz, direction).n, atol=1e-14)
    assert crystal(np.tile(topaz, (4, 1, 1)), np.eye(3)).n.shape == (4, 3, 2)


def test_upsampled_colours_are_exact() -> None:
    nm = np.linspace(385.625, 734.375, 32)
    rgb = np.array([[1.0, 1.0, 1.0], [0.3, 0.5, 0.9], [0.0, 0.0, 0.0]])
    spectra = upsample(rgb, nm)
    assert spectra.shape == (3, 32) and (spectra >= 0.0).all() and not spectra[2].any()
    # Radiance adds up, and a white is the sum of its parts.
    np.testing.assert_allclose(upsample(2.0 * rgb, nm), 2.0 * spectra, rtol=1e-14)
    assert upsample((0.2, 0.3, 0.4), nm, space="acescg").shape == (32,)
    with pytest.raises(gemtrace.UnknownNameError, match="colour space"):
        upsample(rgb, nm, space="lab")


def test_colours_of_no_light_are_remarked(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "gemtrace"):
        upsample((1.0, -0.5, 0.0), np.linspace(390, 730, 16))
        upsample((1.0, 0.5, 0.0), [450.0, 600.0])
    assert "lie outside sRGB" in caplog.messages[0] and "no light of these 2 wavelengths" in caplog.messages[1]


def test_cauchy_fit() -> None:
    nm = np.array([430.79, 486.13, 589.29, 686.72])
    um2 = (nm / 1e3) ** 2
    exact = np.array([[1.5, 0.004, 0.0001], [2.4, 0.012, 0.0003]])
    n = exact[:, :1] + exact[:, 1:2] / um2 + exact[:, 2:] / um2**2
    np.testing.assert_allclose(cauchy_fit(nm, n), exact, rtol=1e-9)
    assert cauchy_fit(nm, n[0]).shape == (3,)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: fresnel(1.5, 1.0, 1.5), gemtrace.InputError, "cos_i: 1.5 is not valid; expected a cosine"),
        (lambda: fresnel([0.5, np.nan], 1.0, 1.5), gemtrace.InputError, r"cos_i\[1\]: nan"),
        (lambda: fresnel(0.5, 0.0, 1.5), gemtrace.InputError, "n1: 0.0"),
        (lambda: fresnel(0.5, 1.0, -1.5), gemtrace.InputError, "n2: -1.5"),
        (lambda: fresnel(0.5, 1.0, 1.5 - 1j), gemtrace.InputError, "imaginary part: -1.0"),
        (lambda: fresnel([0.1, 0.2], [1.0, 1.1, 1.2], 1.5), gemtrace.InputError, r"cos_i \(2,\), n1 \(3,\)"),
        (lambda: fresnel("a", 1.0, 1.5), TypeError, "cos_i"),
        (lambda: fresnel(0.5j, 1.0, 1.5), TypeError, "cos_i: complex128"),
        (lambda: fresnel(0.5, NOTHING, 1.5), TypeError, "n1: object"),
        (lambda: crystal((1.5, 1.6, 1.7, 1.8), (0, 0, 1)), gemtrace.InputError, "last axis has length 3"),
        (lambda: crystal(1.5, (0, 0, 1)), gemtrace.InputError, "last axis"),
        (lambda: crystal((1.5, 0.0, 1.6), (0, 0, 1)), gemtrace.InputError, r"n\[1\]: 0.0"),
        (lambda: crystal((1.5, 1.6), (0, 0, 0)), gemtrace.InputError, "length 0"),
        (lambda: crystal((1.5, 1.6), (0, 0, np.inf)), gemtrace.InputError, r"direction\[2\]: inf"),
        (lambda: crystal((1.5, 1.6), (0, 0, 1), np.ones((3, 3))), gemtrace.InputError, "unit and perpendicular"),
        (lambda: crystal((1.5, 1.6), (0, 0, 1), (1, 0, 0)), gemtrace.InputError, "axes"),
        (lambda: crystal(np.ones((2, 3)), np.ones((3, 3))), gemtrace.InputError, "go together"),
        (lambda: crystal("abc", (0, 0, 1)), TypeError, "n: <U3"),
        (lambda: upsample((1, 1), [400.0, 500.0]), gemtrace.InputError, "rgb"),
        (lambda: upsample((1, 1, np.nan), [400.0, 500.0]), gemtrace.InputError, r"rgb\[2\]: nan"),
        (lambda: upsample((1, 1, 1), [500.0, 400.0]), gemtrace.InputError, "ascend"),
        (lambda: upsample((1, 1, 1), [0.4, 0.5]), gemtrace.InputError, "micrometres"),
        (lambda: upsample((1, 1, 1), []), gemtrace.InputError, "wavelength"),
        (lambda: upsample((1, 1, 1), 500.0), gemtrace.InputError, r"\(λ,\)"),
        (lambda: upsample((1j, 1, 1), [400.0]), TypeError, "complex"),
        (lambda: cauchy_fit([450, 550], [1.5, 1.5]), gemtrace.InputError, "three or more"),
        (lambda: cauchy_fit([], []), gemtrace.InputError, "three or more"),
        (lambda: cauchy_fit([450, 550, 650], [1.5, 1.5]), gemtrace.InputError, "last axis has length 3"),
        (lambda: cauchy_fit([450, 550, 650], [1.5, 0.5, 1.4]), gemtrace.InputError, r"measured\[1\]"),
        (lambda: cauchy_fit([450, 450, 650], [1.5, 1.5, 1.4]), gemtrace.InputError, "same wavelength"),
        (lambda: cauchy_fit([[450, 550, 650]], [1.5, 1.5, 1.4]), gemtrace.InputError, r"\(m,\)"),
        (lambda: cauchy_fit([450, 550, 650], [1.5, np.nan, 1.4]), gemtrace.InputError, r"n\[1\]: nan"),
    ],
)
def test_arguments_that_are_none(call: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        call()
