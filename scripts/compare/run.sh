#!/usr/bin/env bash
# Installs the peers, runs the same scenes on each in turn, and writes docs/performance-table.md and the raw figures. For
# Debian 12 with Rust.
#
# Usage: scripts/compare/run.sh [--rounds N] [--core N] [--only NAME,…]
#
# --only measures some of the groups kernels, mitsuba, indicatrix and luxcore; the lines of the others do not change.
#
# Outside the repository it installs only the Debian packages named here, and only as root. Everything else goes to
# target/compare. If a peer cannot be installed or fails, its line says so.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
work=${COMPARE_FOLDER:-$root/target/compare}
mkdir -p "$work"

warn() { echo "compare: $*" >&2; }

packages=(g++ libembree-dev libtbb-dev libllvm19 python3-venv util-linux)
missing=()
for package in "${packages[@]}"; do
    dpkg -s "$package" >/dev/null 2>&1 || missing+=("$package")
done
if [ "${#missing[@]}" -gt 0 ]; then
    if [ "$(id -u)" = 0 ]; then
        { apt-get update -q && apt-get install -qy --no-install-recommends "${missing[@]}"; } >&2 ||
            warn "not all Debian packages were installed: ${missing[*]}"
    else
        warn "these Debian packages are missing and only root can install them: ${missing[*]}"
    fi
fi

python="$work/venv/bin/python"
[ -x "$python" ] || python3 -m venv "$work/venv"
"$python" -m pip install -q numpy==2.4.6
for peer in mitsuba==3.9.1 pyluxcore==2.11.2; do
    "$python" -m pip install -q "$peer" || warn "$peer was not installed"
done

# Peers are compiled for this machine. gemtrace is compiled as usual, since it chooses its instructions at run time.
RUSTFLAGS="-C target-cpu=native" CARGO_TARGET_DIR="$work/cargo" \
    cargo build -q --release --manifest-path "$here/peers/Cargo.toml"
CARGO_TARGET_DIR="$work/portable" cargo build -q --release --manifest-path "$here/peers/Cargo.toml"
g++ -std=c++17 -O3 -march=native -Wall -Wextra "$here/embree.cpp" -lembree3 -o "$work/embree" ||
    warn "the Embree program was not compiled"

# Mitsuba compiles with LLVM 19 or later.
llvm=$(dpkg -L libllvm19 2>/dev/null | grep -m1 'libLLVM.*\.so' || true)
[ -z "$llvm" ] || export DRJIT_LIBLLVM_PATH="$llvm"

exec "$python" "$here/compare.py" --work "$work" --peers "$work/cargo/release/peers" \
    --ours "$work/portable/release/peers" --out "$root/docs" "$@"
