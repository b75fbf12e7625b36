"""Films against the files of the command line, and what is asked of them."""

from __future__ import annotations

import builtins
import pickle
from pathlib import Path

import gemtrace
import numpy as np
import OpenEXR
import pytest
from conftest import ROOT, Program

SPECTRAL = "scenes/cookbook/spectral.toml"
# One convex stone, areas; a crystal; metals and a ground; a transparent picture; spectra.
SCENES = ["scenes/brilliant.toml", "scenes/cookbook/zircon.toml", "scenes/ring.toml", "scenes/transparent.toml", SPECTRAL]


def channels(path: Path) -> dict[str, np.ndarray]:
    """An EXR as another library reads it."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for name, channel in file.channels().items()}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("space", ["srgb", "acescg", "xyz"])
def test_arrays_have_the_bits_of_the_command_lines_exr(name: str, space: str, tmp_path: Path, program: Program) -> None:
    exr = tmp_path / "x.exr"
    program("render", ROOT / name, "--size", "40x32", "--samples", "2", "--space", space, "--backend", "cpu", "-o", exr)
    film = gemtrace.load(ROOT / name).render(backend="cpu", resolution=(40, 32), samples=2)
    found = channels(exr)
    for index, channel in enumerate("RGB"):
        np.testing.assert_array_equal(film.rgb(space)[..., index].view(np.uint32), found[channel].view(np.uint32))
    np.testing.assert_array_equal(film.alpha, found["A"])
    spectra = sorted((float(key[3:-2].replace(",", ".")), key) for key in found if key.startswith("S0."))
    assert len(spectra) == len(film.wavelengths) and (name == SPECTRAL) == bool(spectra)
    for index, (nm, key) in enumerate(spectra):
        assert abs(nm - film.wavelengths[index]) < 1e-6
        np.testing.assert_array_equal(film.spectral[..., index].view(np.uint32), found[key].view(np.uint32))
    # And the file that the film writes is the same, byte for byte.
    film.save(tmp_path / "y.exr", space=space)
    assert (tmp_path / "y.exr").read_bytes() == exr.read_bytes()


def test_qualities_have_the_bits_of_the_command_line(tmp_path: Path, program: Program) -> None:
    """Adaptive sampling, areas and a backdrop, as scene and quality have them; PNGs, too."""
    path = ROOT / "scenes/sapphire.toml"
    for quality in ("draft", "normal"):
        program("render", path, "--size", "24x24", "--quality", quality, "--backend", "cpu", "-o", tmp_path / "x.exr", "-o", tmp_path / "x.png")
        film = gemtrace.load(path).render(backend="cpu", resolution=(24, 24), quality=quality)
        film.save(tmp_path / "y.exr")
        film.save(tmp_path / "y.png")
        program("render", path, "--size", "24x24", "--quality", quality, "--backend", "cpu", "--tone", "clip", "--exposure", "1", "-o", tmp_path / "x.p16.png", "--bits", "16")
        film.save(tmp_path / "y.p16.png", tone="clip", exposure=1.0, bits=16)
        for kind in ("exr", "png", "p16.png"):
            assert (tmp_path / f"y.{kind}").read_bytes() == (tmp_path / f"x.{kind}").read_bytes()


def test_shapes_types_and_figures(scene: gemtrace.Scene) -> None:
    film = scene.replace(render={"spectral": True, "wavelengths": [450.0, 550.0, 650.0], "jitter": None}).render(backend="cpu")
    assert film.shape == (24, 32) and film.finished
    arrays: list[tuple[np.ndarray, tuple[int, ...], type]] = [
        (film.rgb(), (24, 32, 3), np.float32),
        (film.xyz, (24, 32, 3), np.float32),
        (film.alpha, (24, 32), np.float32),
        (film.coverage, (24, 32), np.float32),
        (film.samples, (24, 32), np.uint32),
        (film.spectral, (24, 32, 3), np.float32),
        (film.wavelengths, (3,), np.float64),
    ]
    for array, shape, kind in arrays:
        assert array.shape == shape and array.dtype == kind and array.flags.c_contiguous
    assert film.spectral is film.spectral and not film.spectral.flags.writeable
    assert set(film.samples.ravel()) == {1} and film.coverage.max() == 1.0 and film.alpha.min() == 1.0
    assert list(film.energy) == ["dropped", "dropped_depth", "dropped_threshold", "left_at_limit", "lost"]
    assert film.provenance["backend"] == "cpu" and not film.provenance["partial"]
    assert film.reason.startswith("cpu") and film.seconds >= 0.0
    assert repr(film).startswith("<gemtrace.Film, 32 × 24 pixels, ")
    assert film._repr_png_().startswith(b"\x89PNG")
    assert np.shares_memory(film.spectral, film.to_xarray()["spectral"].values)
    # A caller's array is the caller's.
    film.rgb()[:] = 0.0
    assert film.rgb().max() > 0.0


def test_xarray(scene: gemtrace.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    film = scene.render(backend="cpu")
    data = film.to_xarray()
    assert dict(data.sizes) == {"y": 24, "x": 32, "channel": 3, "tristimulus": 3}
    assert data["x"].values[0] == 0.5 and "spectral" not in data and data.attrs["backend"] == "cpu"
    np.testing.assert_array_equal(data["rgb"].sel(channel="g").values, film.rgb()[..., 1])
    lit = scene.replace(render={"spectral": True}).render(backend="cpu").to_xarray()
    assert lit["spectral"].sel(wavelength=550.0, method="nearest").shape == (24, 32)
    assert lit["wavelength"].attrs["units"] == "nm"
    real = builtins.__import__

    def without(name: str, *rest: object) -> object:
        if name == "xarray":
            raise ImportError(name)
        return real(name, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ImportError):
        film.to_xarray()


def test_bad_requests_are_refused(scene: gemtrace.Scene, tmp_path: Path) -> None:
    film = scene.render(backend="cpu")
    with pytest.raises(gemtrace.InputError, match="keeps no spectra"):
        film.spectral
    with pytest.raises(gemtrace.UnknownNameError, match="unknown colour space 'rec202'; did you mean 'rec2020'"):
        film.rgb("rec202")
    with pytest.raises(gemtrace.UnknownNameError, match="colour space"):
        film.save(tmp_path / "x.exr", space="lab")
    with pytest.raises(gemtrace.InputError, match="'.png' or '.exr'"):
        film.save(tmp_path / "x.jpg")
    with pytest.raises(gemtrace.UnknownNameError, match="unknown tone 'hues'; did you mean 'hue'"):
        film.save(tmp_path / "x.png", tone="hues")
    with pytest.raises(gemtrace.InputError, match="bits: 12"):
        film.save(tmp_path / "x.png", bits=12)
    for stops in (np.nan, np.inf, 1e9):
        with pytest.raises(gemtrace.InputError, match="exposure"):
            film.save(tmp_path / "x.png", exposure=stops)
    with pytest.raises(gemtrace.OutputError, match="no such folder|does not exist|nowhere"):
        film.save(tmp_path / "nowhere" / "x.png")
    with pytest.raises(gemtrace.InputError, match="'.png' or '.exr'"):
        film.save(tmp_path)
    with pytest.raises(TypeError):
        film.rgb(3)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        film.save(tmp_path / "x.png", bits="8")  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        pickle.dumps(film)
    assert list(tmp_path.iterdir()) == []


def test_a_film_is_not_written_over_its_scene(tmp_path: Path) -> None:
    sky = tmp_path / "sky.png"
    gemtrace.load(ROOT / "scenes/brilliant.toml").render(backend="cpu", resolution=(8, 4), quality="draft").save(sky)
    scene = gemtrace.Scene(camera={"position": (0, -9, 9), "look_at": (0, 0, 0)}, environment={"image": sky}, film={"width": 4, "height": 4})
    before = sky.read_bytes()
    with pytest.raises(gemtrace.InputError, match="is an input"):
        scene.render(backend="cpu").save(sky)
    assert sky.read_bytes() == before
    assert scene.render(backend="cpu").save(str(tmp_path / "y.png"), bits=16, exposure=1.0) == tmp_path / "y.png"
