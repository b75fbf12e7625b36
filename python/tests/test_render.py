"""Renders that are followed, stopped, interrupted, and many at once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import gemtrace
import numpy as np
import pytest

LONG: gemtrace.table.Render = {"samples": 400, "coverage": "points", "max_depth": 64, "threshold": 0.0}


@pytest.fixture
def long(scene: gemtrace.Scene) -> gemtrace.Scene:
    """A picture that takes some seconds."""
    return scene.replace(film={"width": 256, "height": 256}, render=LONG)


def test_progress_is_told(long: gemtrace.Scene) -> None:
    heard: list[tuple[int, int]] = []
    film = long.render(backend="cpu", samples=4, resolution=(96, 96), progress=lambda done, total: heard.append((done, total)))
    done = [step for step, _ in heard]
    assert film.finished and done == sorted(done) and heard[-1] == (4 * 96 * 96,) * 2


def test_progress_can_stop(long: gemtrace.Scene) -> None:
    film = long.render(backend="cpu", progress=lambda done, total: False)
    assert not film.finished and film.provenance["partial"] and "not finished" in repr(film)
    assert film.samples.max() < 400 and film.rgb().shape == (256, 256, 3)


def test_an_exception_ends_the_render(long: gemtrace.Scene) -> None:
    def fail(done: int, total: int) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough") as found:
        long.render(backend="cpu", progress=fail)
    assert any(entry.name == "fail" for entry in found.traceback)
    # The last call, at the end, may raise as well.
    with pytest.raises(LookupError):
        long.render(backend="cpu", resolution=(4, 4), samples=1, progress=fail)
    with pytest.raises(TypeError):
        long.render(backend="cpu", progress=dict)  # type: ignore[arg-type]
    assert long.render(backend="cpu", resolution=(4, 4), samples=1).finished


def test_a_callback_may_render(long: gemtrace.Scene) -> None:
    with long.open(backend="cpu") as view:
        inner: list[gemtrace.Film] = []

        def render(done: int, total: int) -> bool:
            inner.append(view.render(resolution=(8, 8), samples=1))
            return False

        assert not view.render(progress=render).finished
        assert inner[0].finished


def test_ctrl_c_keeps_what_is_finished(tmp_path: Path) -> None:
    # A shell that runs the tests in the background has its programs ignore the signal.
    code = f"""
import gemtrace, signal
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = gemtrace.Scene(camera={{"position": (3, -11, 28), "look_at": (0, 0, 0)}}, film={{"width": 512, "height": 512}},
    stones=[{{"shape": "round-brilliant", "width": 6.5, "material": "ruby"}}], render={LONG!r})
print("ready", flush=True)
try:
    scene.render(backend="cpu", samples=60000)
except KeyboardInterrupt as stopped:
    assert isinstance(stopped, gemtrace.Interrupted) and stopped.film is not None
    film = stopped.film
    assert not film.finished and film.samples.max() > 0, film.samples.max()
    film.save({str(tmp_path / "part.png")!r})
    print("kept")
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    time.sleep(3.0)
    sent = time.monotonic()
    os.kill(process.pid, signal.SIGINT)
    try:
        out, _ = process.communicate(timeout=60)
    finally:
        process.kill()
    assert (out, process.returncode) == ("kept\n", 0) and (tmp_path / "part.png").exists()
    assert time.monotonic() - sent < 30.0


def test_other_threads_run_meanwhile(long: gemtrace.Scene) -> None:
    films: list[gemtrace.Film] = []
    stop = threading.Event()
    thread = threading.Thread(target=lambda: films.append(long.render(backend="cpu", progress=lambda *_: not stop.is_set())))
    thread.start()
    turns, start = 0, time.monotonic()
    while time.monotonic() - start < 0.5:
        turns += 1
    stop.set()
    thread.join()
    assert turns > 1000 and not films[0].finished


def test_threads_give_the_same_pictures(scene: gemtrace.Scene) -> None:
    expected = scene.render(backend="cpu").rgb()
    found: list[np.ndarray] = []
    with scene.open(backend="cpu") as view:
        work = [lambda: found.append(scene.render(backend="cpu").rgb()), lambda: found.append(view.render().rgb())]
        threads = [threading.Thread(target=work[i % 2]) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len(found) == 8
    for picture in found:
        np.testing.assert_array_equal(picture, expected)
    np.testing.assert_array_equal(scene.render(backend="cpu", threads=1).rgb(), expected)


def test_a_render_goes_on_in_a_child(scene: gemtrace.Scene) -> None:
    """Spawned processes import the package anew, as pools of workers do."""
    code = "import gemtrace; print(len(gemtrace.materials), gemtrace.__version__)"
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split()
    assert int(out[0]) == len(gemtrace.materials) and out[1] == gemtrace.__version__
