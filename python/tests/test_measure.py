"""Measurements, against the command line."""

from __future__ import annotations

import json
from typing import Any

import gemtrace
import numpy as np
import pytest
from conftest import ROOT, Program

CUT = "spectral-core/data/cuts/srb_quartz_57.asc"


def test_figures_are_those_of_the_command_line(program: Program) -> None:
    arguments = ["measure", ROOT / "scenes/brilliant.toml", "--tilt", "0,10", "--size", "24x24", "--experimental", "--json"]
    said = json.loads(program(*arguments))
    found = gemtrace.measure(gemtrace.load(ROOT / "scenes/brilliant.toml"), [0.0, 10.0], rays=24, experimental=True)
    assert found.tilt.tolist() == [0.0, 10.0] and found.table is not None
    for index, position in enumerate(said["positions"]):
        for part, curves in (("stone", found.stone), ("table", found.table)):
            for name, curve in curves.items():
                assert abs(position[part][name] - curve[index]) < 1e-9, (part, name)
    said = json.loads(program("measure", ROOT / CUT, "--material", "quartz", "--size", "24x24", "--json"))
    cut = gemtrace.measure(gemtrace.cut(ROOT / CUT), material="quartz", rays=24)
    for name, curve in cut.stone.items():
        assert abs(said["positions"][0]["stone"][name] - curve[0]) < 1e-9, name


def test_light_is_accounted_for(scene: gemtrace.Scene) -> None:
    seen = gemtrace.measure(scene, np.array([[0.0], [15.0]]), rays=24, models=["iso"], material="diamond", width=4.0, about="y")
    assert seen.tilt.shape == (2,) and seen.dropped.shape == (2,)
    whole = seen.stone["iso"] + seen.stone["extinction"] + seen.stone["leakage"] + seen.stone["missing"]
    np.testing.assert_allclose(whole, 1.0, atol=1e-5)
    assert gemtrace.measure(scene, [], rays=8).tilt.shape == (0,)
    heard: list[int] = []
    gemtrace.measure(scene, rays=300, eye=None, head=0.0, progress=lambda done, total: heard.append(done))


def test_measurements_that_are_none(scene: gemtrace.Scene) -> None:
    def stop(done: int, total: int) -> None:
        raise LookupError("enough")

    two = scene.replace(stones=[{"shape": "step", "width": 3.0, "material": "ruby"}, {"shape": "step", "width": 3.0, "material": "ruby", "position": (9, 0, 0)}])
    cut = gemtrace.Cut.shape("step")
    bad: list[tuple[Any, dict[str, Any], type[Exception], str]] = [
        (two, {}, gemtrace.InputError, "this one has 2"),
        (cut, {}, gemtrace.InputError, "material"),
        (cut, {"material": "rubby"}, gemtrace.InputError, "did you mean 'ruby'"),
        (scene, {"tilt": np.nan}, gemtrace.InputError, "tilt: nan"),
        (scene, {"tilt": "a"}, TypeError, "tilt"),
        (scene, {"head": -1.0}, gemtrace.InputError, "head: -1.0"),
        (scene, {"head": 91.0}, gemtrace.InputError, "half-angle"),
        (scene, {"rays": 0}, gemtrace.InputError, "rays: 0"),
        (scene, {"rays": 2.5}, TypeError, "."),
        (scene, {"eye": 0.1}, gemtrace.InputError, "."),
        (scene, {"eye": "far"}, TypeError, "."),
        (scene, {"about": "z"}, gemtrace.UnknownNameError, "unknown axis 'z'"),
        (scene, {"models": ["iso", "sun"]}, gemtrace.UnknownNameError, "sun"),
        (scene, {"backend": "gpu"}, gemtrace.InputError, "unknown backend"),
        (scene, {"width": 0.0}, gemtrace.InputError, "size"),
        (scene, {"rays": 1500, "progress": stop}, LookupError, "enough"),
    ]
    for subject, arguments, error, words in bad:
        with pytest.raises(error, match=words):
            gemtrace.measure(subject, **{"rays": 8, **arguments})
    with pytest.raises(AttributeError):
        gemtrace.measure(None)  # type: ignore[arg-type]
