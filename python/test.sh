#!/usr/bin/env bash
# Builds the wheel of the Python package, installs it where there is no Rust, and tests it.
set -euo pipefail
cd "$(dirname "$0")/.."

python=${PYTHON:-python3}
place=target/python
pip() { "$1/bin/python" -m pip --disable-pip-version-check install --quiet "${@:2}"; }

# An environment; one that works already is kept.
environment() {
  if ! "$1/bin/python" -c '' 2>/dev/null; then
    rm -rf "$1"
    "$python" -m venv "$1"
  fi
}

environment "$place/build"
pip "$place/build" 'maturin>=1.16,<2'
rm -rf "$place/wheels"
"$place/build/bin/maturin" build --release --locked --quiet --out "$place/wheels"
wheel=$(echo "$place"/wheels/*.whl)

# Nothing but the wheel and what it names, and no program but Python.
rm -rf "$place/empty"
environment "$place/empty"
pip "$place/empty" "$wheel"
env -i PATH=/nowhere HOME="$HOME" "$place/empty/bin/python" -I python/examples/first.py "$place/first.png"

environment "$place/tools"
pip "$place/tools" -r python/tests/requirements.txt
pip "$place/tools" --force-reinstall --no-deps "$wheel"
# The program and the examples beside which the package is held; `test.sh` has built them.
cargo test --release --workspace --no-run --quiet
PATH="$PWD/$place/tools/bin:$PATH"
GEMTRACE_WHEEL=$wheel pytest --quiet "$@"
pytest --quiet -W ignore --nbmake --nbmake-timeout=300 python/notebooks
mypy
# The stub of the extension module says what is built.
python -m mypy.stubtest gemtrace._gemtrace --mypy-config-file pyproject.toml
