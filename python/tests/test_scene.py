"""Scenes: what they take, what they refuse, and what is rendered of them."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import Any

import gemtrace
import numpy as np
import pytest
from conftest import ROOT, Program

CAMERA: gemtrace.table.Camera = {"position": (0.0, -10.0, 10.0), "look_at": (0.0, 0.0, 0.0)}
STONE: gemtrace.table.Stone = {"shape": "round-brilliant", "width": 6.5, "material": "diamond"}


def picture(scene: gemtrace.Scene) -> np.ndarray:
    return scene.render(backend="cpu", quality="draft", resolution=(16, 12)).rgb()


def test_a_scene_in_code_is_the_scene_of_its_file(tmp_path: Path) -> None:
    text = f"""format = 1
camera = {{ position = [0.0, -11.12, 30.05], look_at = [0.0, 0.0, -0.49], fov = 14.0 }}
film = {{ width = 16, height = 12, background = "transparent" }}
environment = {{ image = '{ROOT}/scenes/environments/hall.exr', rotation = 30.0, scale = 1.5 }}
ground = {{ diffuse = 0.5 }}
pose = {{ turn = 10, tilt = 5.0 }}
render = {{ quality = "draft" }}
[[stone]]
cut = '{ROOT}/scenes/cuts/brilliant.asc'
width = 6.5
material = "pink"
[material.pink]
like = "corundum"
absorption = [{{ centre = 553.0, sigma = 38.0, peak = 0.9 }}]
"""
    code = gemtrace.Scene(
        camera={"position": np.array([0.0, -11.12, 30.05]), "look_at": (0, 0.0, -0.49), "fov": float(np.float32(14))},
        film={"width": int(np.int64(16)), "height": 12, "background": "transparent"},
        environment={"image": ROOT / "scenes/environments/hall.exr", "rotation": 30, "scale": 1.5},
        ground={"diffuse": 0.5},
        pose={"turn": 10, "tilt": 5.0},
        render={"quality": "draft"},
        stones=[{"cut": os.fspath(ROOT / "scenes/cuts/brilliant.asc"), "width": 6.5, "material": "pink"}],
        materials={"pink": {"like": "corundum", "absorption": [{"centre": 553.0, "sigma": 38.0, "peak": 0.9}]}},
    )
    path = tmp_path / "same.toml"
    path.write_text(text)
    file = gemtrace.load(path)
    np.testing.assert_array_equal(picture(code), picture(file))
    assert (code.shape, code.path, file.path) == ((12, 16), None, path)
    assert code.document["stone"][0]["width"] == 6.5 and len(code.hash) == 64 and code.hash != file.hash


@pytest.mark.parametrize("kind", ["<f4", ">f4", "<f8", ">f8", "<f2", "<i4", ">i8", "<u2"])
def test_a_light_from_any_array(kind: str) -> None:
    light = np.zeros((4, 8, 3), kind)
    light[:2] = [1, 2, 3]
    other = np.asfortranarray(light)
    other.flags.writeable = False
    strided = np.repeat(light, 2, axis=0)[::2]
    pictures = [
        picture(gemtrace.Scene(camera=CAMERA, stones=[STONE], environment={"image": array, "rotation": 20.0}))
        for array in (light, other, strided, light.astype(np.float32))
    ]
    for other_picture in pictures[1:]:
        np.testing.assert_array_equal(pictures[0], other_picture)
    assert pictures[0].max() > 0.5


def test_a_light_from_an_array_is_that_of_a_uniform_one(caplog: pytest.LogCaptureFixture) -> None:
    ones = gemtrace.Scene(camera=CAMERA, stones=[STONE], environment={"image": np.ones((1, 1, 3), np.float32)})
    even = ones.replace(environment={"uniform": (1.0, 1.0, 1.0)})
    np.testing.assert_allclose(picture(ones), picture(even), atol=2e-6)
    broken = np.ones((2, 4, 3))
    broken[0, 1], broken[1, 2, 0] = np.nan, -5.0
    with caplog.at_level(logging.WARNING, "gemtrace"):
        scene = ones.replace(environment={"image": broken})
    assert len(scene.warnings) == 2 and "1 of the environment's 8 texels are not finite" in caplog.text
    assert np.isfinite(picture(scene)).all()


@pytest.mark.parametrize(
    ("image", "error", "words"),
    [
        (np.ones((4, 8)), gemtrace.InputError, r"shape \(4, 8\)"),
        (np.ones((4, 8, 4)), gemtrace.InputError, r"shape \(4, 8, 4\)"),
        (np.ones((0, 8, 3)), gemtrace.InputError, r"shape \(0, 8, 3\)"),
        (np.ones(3), gemtrace.InputError, "shape"),
        (np.ones((4, 8, 3), np.uint8), TypeError, "uint8"),
        (np.ones((4, 8, 3), complex), TypeError, "complex"),
        (np.ones((4, 8, 3), bool), TypeError, "bool"),
        (np.full((1, 1, 3), "a"), TypeError, "<U1"),
        ([[[1.0, 2.0, 3.0], [1.0]]], gemtrace.InputError, "environment.image"),
        (object(), TypeError, "object"),
        (b"hall.exr", TypeError, "environment.image"),
        ("nowhere.exr", gemtrace.InputError, "no such file"),
    ],
)
def test_lights_that_are_none(image: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        gemtrace.Scene(camera=CAMERA, environment={"image": image})


@pytest.mark.parametrize(
    ("sections", "error", "words"),
    [
        ({"camera": {"position": (0, 0, 9)}}, gemtrace.InputError, "look_at"),
        ({"camera": {**CAMERA, "fov": -1.0}}, gemtrace.InputError, "fov: -1 is not valid"),
        ({"camera": {**CAMERA, "fov": float("nan")}}, gemtrace.InputError, "camera.fov: nan is not valid"),
        ({"camera": {**CAMERA, "position": (0.0, np.inf, 1.0)}}, gemtrace.InputError, r"camera.position\[1\]: inf"),
        ({"camera": {**CAMERA, "position": (0.0, 1.0)}}, gemtrace.InputError, "position"),
        ({"camera": {**CAMERA, "position": np.zeros((0,))}}, gemtrace.InputError, "position"),
        ({"camera": {**CAMERA, "position": 1j}}, TypeError, "camera.position: complex"),
        ({"camera": {**CAMERA, "position": np.array([1j, 0, 0])}}, TypeError, "complex128"),
        ({"camera": {**CAMERA, "zoom": 2}}, gemtrace.InputError, r"unknown key 'zoom' in \[camera\]"),
        ({"camera": [1, 2]}, TypeError, "camera: list"),
        ({"camera": {1: 2}}, TypeError, "keys are texts"),
        ({"film": {"width": 0}}, gemtrace.InputError, "0"),
        ({"film": {"width": -4}}, gemtrace.InputError, "-4"),
        ({"film": {"width": 2.5}}, gemtrace.InputError, "2.5"),
        ({"film": {"width": 10**30}}, gemtrace.InputError, "film.width"),
        ({"film": {"width": 60000, "height": 60000}, "render": {"spectral": True}}, gemtrace.InputError, "GiB"),
        ({"stones": [{**STONE, "widht": 1}]}, gemtrace.InputError, "did you mean 'width'"),
        ({"stones": [STONE, {**STONE, "width": -1}, STONE]}, gemtrace.InputError, r"-1.*\(stone 2\)"),
        ({"stones": [{**STONE, "material": "dimond"}]}, gemtrace.InputError, "did you mean 'diamond'"),
        ({"stones": [{"width": 1.0, "material": "ruby"}]}, gemtrace.InputError, "exactly one of 'cut', 'mesh' and 'shape'"),
        ({"stones": STONE}, TypeError, "stones: dict"),
        ({"stones": "ruby"}, TypeError, "stones: str"),
        ({"stones": ["ruby"]}, TypeError, r"stones\[0\]: str"),
        ({"stones": [{**STONE, "position": {1, 2, 3}, "name": b"x"}]}, TypeError, "bytes"),
        ({"stones": [{"mesh": np.zeros((4, 3)), "material": "ruby"}]}, TypeError, "a pair"),
        ({"environment": {"uniform": (1, 1, 1), "preset": "studio"}}, gemtrace.InputError, "exactly one of"),
        ({"environment": {"uniform": (-1, 1, 1)}}, gemtrace.InputError, "from 0 to"),
        ({"environment": {"preset": "Studio"}}, gemtrace.InputError, "did you mean 'studio'"),
        ({"materials": {"own": {"index": 1.5, "cauchy": [1.5]}}}, gemtrace.InputError, "one of them only"),
        ({"materials": {"own": {"index": 0.2}}}, gemtrace.InputError, "own"),
        ({"pose": {"size": 0.0}}, gemtrace.InputError, "size"),
        ({"render": {"samples": 0}}, gemtrace.InputError, "samples: 0"),
        ({"render": {"quality": "best"}}, gemtrace.InputError, "quality"),
        ({"ground": {"mirror": 1}}, gemtrace.InputError, "true or false"),
    ],
)
def test_scenes_that_are_none(sections: dict[str, Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        gemtrace.Scene(**{"camera": CAMERA, **sections})


def test_tables_within_themselves_are_refused() -> None:
    endless: dict[str, Any] = {}
    endless["more"] = endless
    with pytest.raises(gemtrace.InputError, match="tables within more than"):
        gemtrace.Scene(camera=CAMERA, render=endless)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        gemtrace.Scene()  # type: ignore[call-arg]
    with pytest.raises(TypeError):
        gemtrace.Scene(camera=CAMERA, stone=[STONE])  # type: ignore[call-arg]


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(gemtrace.FileError, match="no such file; did you mean 'brilliant.toml'") as found:
        gemtrace.load(ROOT / "scenes/briliant.toml")
    assert isinstance(found.value, OSError) and isinstance(found.value, ValueError)
    bad = tmp_path / "bad.toml"
    bad.write_text("format = 1\ncamera = { position = [0, 0, 9], look_at = [0, 0, 0] }\nfilm = { widht = 3 }\n")
    with pytest.raises(gemtrace.InputError, match="bad.toml, line 3: unknown key 'widht' in .film.; did you mean 'width'"):
        gemtrace.load(str(bad))
    for given in (tmp_path, tmp_path / "a\0b"):
        with pytest.raises((gemtrace.FileError, ValueError)):
            gemtrace.load(given)
    with pytest.raises(TypeError):
        gemtrace.load(3)  # type: ignore[arg-type]


def test_replacing_merges_tables_and_forgets_nothing() -> None:
    scene = gemtrace.load(ROOT / "scenes/brilliant.toml")
    ruby = scene.replace(material="ruby", film={"width": 16, "height": 12}, environment={"rotation": 90.0})
    assert scene.document["stone"][0]["material"] == "diamond" and ruby.document["stone"][0]["material"] == "ruby"
    assert ruby.document["environment"]["rotation"] == 90.0 and "image" in ruby.document["environment"]
    assert ruby.shape == (12, 16) and scene.shape != ruby.shape
    plain = ruby.replace(environment={"uniform": (1, 1, 1), "rotation": None, "scale": None})
    assert plain.document["environment"] == {"uniform": [1, 1, 1], "illuminant": "D65"}
    camera = plain.replace(camera={"orthographic": 8.0}).document["camera"]
    assert "fov" not in camera and camera["orthographic"] == 8.0
    assert not np.array_equal(picture(scene), picture(ruby))
    own = scene.replace(material="mine", materials={"mine": {"index": 1.5}})
    assert own.replace(materials={"other": {"index": 1.6}}).document["material"].keys() == {"mine", "other"}
    with pytest.raises(gemtrace.InputError, match="one for each of 1 stones"):
        scene.replace(material=["ruby", "ruby"])
    with pytest.raises(gemtrace.InputError, match="did you mean"):
        scene.replace(material="rubby")
    with pytest.raises(TypeError):
        scene.replace(stone=[])  # type: ignore[call-arg]


def test_solids_from_arrays_are_stones() -> None:
    box = np.array([[x, y, z] for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    faces = np.array([corners for a, b, c, d in sides for corners in ([a, b, c], [a, c, d])])
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    cube = gemtrace.Cut.from_planes(normals, np.ones(6))
    stones: list[gemtrace.table.Stone] = [
        {"mesh": (box, faces), "material": "n-bk7"},
        {"mesh": (box.tolist(), faces.astype(">i2")), "material": "n-bk7"},
        {"mesh": gemtrace.Cut.from_mesh(box, faces), "material": "n-bk7"},
        {"cut": cube, "material": "n-bk7"},
    ]
    pictures = [picture(gemtrace.Scene(camera=CAMERA, stones=[stone])) for stone in stones]
    for other in pictures[1:]:
        np.testing.assert_array_equal(pictures[0], other)


def test_views_hold_the_scene_in_other_ways(scene: gemtrace.Scene) -> None:
    with scene.open(backend="cpu") as view:
        before = view.render()
        turned = view.render(turn=10.0, tilt=5.0)
        assert not np.array_equal(before.rgb(), turned.rgb())
        posed = scene.replace(pose={"turn": 10.0, "tilt": 5.0})
        np.testing.assert_array_equal(turned.rgb(), posed.render(backend="cpu").rgb())
        np.testing.assert_array_equal(turned.rgb(), view.render(posed).rgb())
        # Beside the scene's own pose, as in a turntable; and nothing is kept.
        np.testing.assert_array_equal(view.render(posed, turn=-10.0, tilt=-5.0).rgb(), before.rgb())
        np.testing.assert_array_equal(view.render().rgb(), before.rgb())
        green = view.render(material="emerald", size=3.0).rgb()
        np.testing.assert_array_equal(green, scene.replace(material="emerald", pose={"size": 3.0}).render(backend="cpu").rgb())
        with pytest.raises(gemtrace.InputError, match="turn: nan"):
            view.render(turn=float("nan"))
        with pytest.raises(gemtrace.InputError, match="size"):
            view.render(size=-1.0)
        with pytest.raises(TypeError):
            view.render(turn="a")  # type: ignore[arg-type]
    with pytest.raises(gemtrace.InputError, match="closed"):
        view.render()
    view.close()


def test_settings_that_are_none(scene: gemtrace.Scene) -> None:
    bad: list[tuple[dict[str, Any], type[Exception], str]] = [
        ({"backend": "gpu"}, gemtrace.InputError, "unknown backend 'gpu'; valid: auto, cpu"),
        ({"backend": "cpu", "device": 7}, gemtrace.InputError, "no device 7"),
        ({"device": -1}, gemtrace.InputError, "device: -1"),
        ({"threads": 0}, gemtrace.InputError, "threads: 0"),
        ({"quality": "best"}, gemtrace.UnknownNameError, "unknown quality 'best'"),
        ({"coverage": "line"}, gemtrace.UnknownNameError, "unknown coverage"),
        ({"samples": 0}, gemtrace.InputError, "samples: 0"),
        ({"samples": 10**6}, gemtrace.InputError, "samples"),
        ({"samples": 2.5}, TypeError, "."),
        ({"tolerance": -1.0}, gemtrace.InputError, "tolerance: -1"),
        ({"tolerance": float("nan")}, gemtrace.InputError, "tolerance: NaN"),
        ({"resolution": (0, 4)}, gemtrace.InputError, "resolution: 0"),
        ({"resolution": (10**6, 4)}, gemtrace.InputError, "1000000"),
        ({"resolution": 16}, TypeError, "."),
        ({"progress": 3}, TypeError, "progress"),
    ]
    for arguments, error, words in bad:
        with pytest.raises(error, match=words):
            scene.render(**{"backend": "cpu", **arguments})
    assert scene.render(backend="cpu").finished


def test_devices() -> None:
    found = gemtrace.devices()
    assert {"cpu", "reference"} <= {device["backend"] for device in found}
    assert all(set(device) >= {"index", "name", "kind", "memory", "hardware"} for device in found)
    assert gemtrace.load(ROOT / "scenes/brilliant.toml").render(backend="reference", resolution=(4, 4), samples=1).finished


def test_a_saved_scene_is_the_same(tmp_path: Path, program: Program) -> None:
    light = np.random.default_rng(1).random((6, 12, 3), np.float32)
    scene = gemtrace.Scene(
        camera=CAMERA,
        film={"width": 16, "height": 12},
        environment={"image": light},
        stones=[{"cut": gemtrace.Cut.shape("step"), "width": 5.0, "material": "diamond"}, {**STONE, "position": (6, 0, 0)}],
        render={"quality": "draft"},
    )
    path = scene.save(tmp_path / "own.toml")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["own-1.obj", "own-2.exr", "own.toml"]
    np.testing.assert_allclose(picture(gemtrace.load(path)), picture(scene), atol=1e-3)
    program("render", path, "--backend", "cpu", "-o", tmp_path / "x.png")
    # One from a file keeps the names of its files, as full paths.
    moved = gemtrace.load(ROOT / "scenes/brilliant.toml").replace(film={"width": 16}).save(tmp_path / "moved.toml")
    np.testing.assert_array_equal(picture(gemtrace.load(moved)), picture(gemtrace.load(ROOT / "scenes/brilliant.toml")))
    for name, error, words in [
        ("own.json", gemtrace.InputError, "'.toml'"),
        ("nowhere/own.toml", gemtrace.OutputError, "no folder"),
        ("moved.toml", gemtrace.InputError, "is an input"),
    ]:
        with pytest.raises(error, match=words):
            gemtrace.load(moved).save(tmp_path / name)
