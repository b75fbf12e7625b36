"""What the tests share: a small scene, and the program beside which the package is held."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import gemtrace
import pytest

ROOT = Path(__file__).parents[2]
PROGRAM = Path(os.environ.get("GEMTRACE_PROGRAM", ROOT / "target/release/gemtrace"))

Program = Callable[..., str]


@pytest.fixture(scope="session")
def scene() -> gemtrace.Scene:
    """A ruby of 24 × 32 pixels."""
    return gemtrace.Scene(
        camera={"position": (3.0, -11.0, 28.0), "look_at": (0.0, 0.0, 0.0)},
        stones=[{"shape": "round-brilliant", "width": 6.5, "material": "ruby"}],
        film={"width": 32, "height": 24},
        render={"quality": "draft"},
    )


@pytest.fixture(scope="session")
def program() -> Program:
    """The command line; what it writes to the standard output."""

    def run(*arguments: object) -> str:
        command = [str(PROGRAM), *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    return run
