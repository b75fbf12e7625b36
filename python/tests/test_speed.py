"""What Python adds to the library: many small renders, and many turns of one scene, in processor time.

`pytest -s python/tests/test_speed.py` prints the figures. The library's are those of `gemtrace/examples/many.rs`.
"""

from __future__ import annotations

import os
import resource
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import gemtrace
import pytest
from conftest import ROOT

SCENE = ROOT / "scenes/brilliant.toml"
MANY = Path(os.environ.get("GEMTRACE_MANY", ROOT / "target/release/examples/many"))
ROUNDS = 5


def library(mode: str, count: int) -> tuple[float, float]:
    """Seconds of processor time for so many pictures, without those for one, and the sum that the library prints."""

    def spent(count: int) -> tuple[float, float]:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        out = subprocess.run([MANY, SCENE, mode, str(count)], check=True, capture_output=True, text=True).stdout
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, float(out)

    one, _ = spent(1)
    many, total = spent(count)
    return (many - one) * count / (count - 1), total


def package(render: Callable[[int], gemtrace.Film], count: int) -> tuple[float, float]:
    """The same from Python; the sum is that of the first pixels, as in the example."""
    render(0)
    start = time.process_time()
    total = sum(float(render(frame).xyz[0, 0, 1]) for frame in range(count))
    return time.process_time() - start, total


def same(count: int) -> tuple[float, float]:
    scene = gemtrace.load(SCENE)
    return package(lambda _: scene.render(backend="cpu", threads=1, quality="draft", resolution=(64, 64)), count)


def turned(count: int) -> tuple[float, float]:
    scene = gemtrace.load(SCENE)
    with scene.open(backend="cpu", threads=1) as view:
        return package(lambda frame: view.render(turn=360.0 * frame / count, quality="draft", resolution=(64, 64)), count)


def fresh(count: int) -> tuple[float, float]:
    def render(frame: int) -> gemtrace.Film:
        scene = gemtrace.load(SCENE).replace(pose={"turn": 360.0 * frame / count})
        return scene.render(backend="cpu", threads=1, quality="draft", resolution=(64, 64))

    return package(render, count)


def compared(mode: str, run: Callable[[int], tuple[float, float]], count: int) -> tuple[float, float]:
    """The least processor time of some rounds, of the library and of the package in turn; the pictures are the same."""
    library_times, package_times = [], []
    for _ in range(ROUNDS):
        of_library, wanted = library(mode, count)
        of_package, found = run(count)
        assert found == pytest.approx(wanted, rel=1e-12)
        library_times.append(of_library)
        package_times.append(of_package)
    return min(library_times), min(package_times)


def test_a_hundred_small_renders_cost_no_more_than_a_tenth() -> None:
    of_library, of_package = compared("same", same, 100)
    ratio = of_package / of_library
    print(f"\n100 drafts of 64²: library {of_library:.3f} s, package {of_package:.3f} s, ratio {ratio:.3f}")
    assert ratio <= 1.10


def test_turning_saves_what_it_saves_in_the_library() -> None:
    times = {mode: compared(mode, run, 360) for mode, run in (("turned", turned), ("fresh", fresh))}
    (library_turned, turned_), (library_fresh, fresh_) = times["turned"], times["fresh"]
    print(
        f"\n360 turns: library {library_turned:.3f} s turned and {library_fresh:.3f} s fresh, a share of"
        f" {library_turned / library_fresh:.3f}; package {turned_:.3f} s and {fresh_:.3f} s, {turned_ / fresh_:.3f}"
    )
    # Each pair was timed in turn, so that the load of the machine is the same for both.
    assert turned_ / library_turned <= 1.10 and fresh_ / library_fresh <= 1.10
    assert turned_ < fresh_
