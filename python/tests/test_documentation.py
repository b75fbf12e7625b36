"""Every public name says what it takes and gives: shapes, units, errors; and the package is what it claims to be."""

from __future__ import annotations

import doctest
import inspect
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import gemtrace
import pytest
from conftest import ROOT

UNITS = r"\b(mm|nm|µm|degrees|radians|pixels?|stops|bytes|shares?|[Uu]nits?|relative|seconds|s,|1/mm|g/cm³|ΔE00|dtype|percent|TOML)\b"
ERRORS = r"Raises|raises|[Ee]rrors?\b"
SHAPES = r"\([^()]*(H|W|F|V|T|N|λ|m|…|rows|3)[^()]*\)|shape"


def public() -> Iterator[tuple[str, object]]:
    """Every name of the package, and every method and property of its classes."""
    yield "gemtrace", gemtrace
    places = [(f"gemtrace.{name}", getattr(gemtrace, name)) for name in gemtrace.__all__]
    tables = [
        (f"gemtrace.table.{name}", thing)
        for name, thing in vars(gemtrace.table).items()
        if inspect.isclass(thing) and thing.__module__ == "gemtrace.table"
    ]
    for place, thing in places + tables:
        yield place, thing
        if inspect.isclass(thing) and not place.startswith("gemtrace.table."):
            fields = getattr(thing, "_fields", ())
            for name, member in vars(thing).items():
                if not name.startswith("_") and name not in fields and (callable(member) or isinstance(member, (property, classmethod)) or inspect.isdatadescriptor(member)):
                    yield f"{place}.{name}", member


ALL = dict(public())


@pytest.mark.parametrize("name", ALL)
def test_every_public_name_is_documented(name: str) -> None:
    thing = ALL[name]
    function = getattr(thing, "func", getattr(thing, "fget", getattr(thing, "__func__", thing)))
    text = inspect.getdoc(function) or ""
    assert len(text) > 30, f"{name} has no docstring"
    if inspect.isclass(thing) and issubclass(thing, BaseException):
        return
    assert re.search(ERRORS, text), f"{name} does not say what errors there are"
    assert re.search(UNITS, text), f"{name} has no units"
    if re.search("Floats|Singles|NDArray|ArrayLike|Indices", str(getattr(function, "__annotations__", ""))):
        assert re.search(SHAPES, text), f"{name} does not say what shapes"


def test_the_docstrings_examples_work() -> None:
    for name, module in sorted(sys.modules.items()):
        if name == "gemtrace" or name.startswith("gemtrace."):
            assert doctest.testmod(module).failed == 0, name


def test_all_is_everything() -> None:
    assert gemtrace.__all__ == sorted(gemtrace.__all__, key=lambda name: (not name[0].isupper(), name))
    assert not [name for name in gemtrace.__all__ if not hasattr(gemtrace, name)]
    assert re.fullmatch(r"\d+\.\d+\.\d+", gemtrace.__version__)
    assert "site-packages" in (gemtrace.__file__ or ""), "the tests are for the wheel that was installed"


def test_the_wheel() -> None:
    wheel = os.environ.get("GEMTRACE_WHEEL")
    if wheel is None:
        pytest.skip("python/test.sh says which wheel is tested")
    path = ROOT / wheel
    assert re.search(r"-cp310-abi3-manylinux_2_\d+_\w+\.whl$|-cp310-abi3-(macosx|win)", path.name), path.name
    names = zipfile.ZipFile(path).namelist()
    for file in ("py.typed", "_gemtrace.pyi", "__init__.py"):
        assert f"gemtrace/{file}" in names
    for licence in ("LICENSE-APACHE", "LICENSE-MIT", "NOTICE"):
        assert any(name.endswith(f"licenses/{licence}") for name in names), names
    assert not [name for name in names if "test" in name or name.endswith(".ipynb")]


@pytest.mark.parametrize("example", sorted((ROOT / "python/examples").glob("*.py")), ids=lambda path: path.stem)
def test_examples_run(example: Path, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, str(example), str(tmp_path / "out.png")], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out.png").stat().st_size > 500
