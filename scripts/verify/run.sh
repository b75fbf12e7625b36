#!/usr/bin/env bash
# Installs Mitsuba 3 and the other requirements, renders the scenes with it and with every gemtrace backend of this machine, and writes docs/verification.md with its pictures and raw figures, and tests/data/mitsuba.
#
# Usage: scripts/verify/run.sh [--only deterministic,stochastic,colour,dispersion]
#
# Needs Rust and Python 3.11 or later. Outside the repository it installs only the Debian packages named here, and only as
# root; everything else goes to target/verify.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
work=${VERIFY_FOLDER:-$root/target/verify}
mkdir -p "$work"

packages=(libllvm19 python3-venv)
missing=()
for package in "${packages[@]}"; do
    dpkg -s "$package" >/dev/null 2>&1 || missing+=("$package")
done
if [ "${#missing[@]}" -gt 0 ]; then
    if [ "$(id -u)" = 0 ]; then
        { apt-get update -q && apt-get install -qy --no-install-recommends "${missing[@]}"; } >&2 ||
            echo "verify: not all Debian packages were installed: ${missing[*]}" >&2
    else
        echo "verify: these Debian packages are missing and only root can install them: ${missing[*]}" >&2
    fi
fi

python="$work/venv/bin/python"
[ -x "$python" ] || python3 -m venv "$work/venv"
"$python" -m pip install -q -r "$here/requirements.txt"

# Mitsuba compiles with LLVM 19 or later.
llvm=$(dpkg -L libllvm19 2>/dev/null | grep -m1 'libLLVM.*\.so' || true)
[ -z "$llvm" ] || export DRJIT_LIBLLVM_PATH="$llvm"

# With many small matrix products, threads would mostly wait for each other.
export OPENBLAS_NUM_THREADS=1

target=${CARGO_TARGET_DIR:-$root/target}
cargo build -q --release --manifest-path "$root/Cargo.toml" -p gemtrace-cli
gemtrace="$target/release/gemtrace"

# The parts of the scenes; the files are the same every time.
parts="$here/scenes/parts"
mkdir -p "$parts"
"$python" "$here/stage.py" "$parts"
cuts="$root/spectral-core/data/cuts"
for cut in brilliant:srb_diamond_57 step:emerald_step_49 portuguese:portuguese_161; do
    "$gemtrace" -q cut "$cuts/${cut#*:}.asc" --mesh "$parts/${cut%%:*}.obj"
done

# Plates of crystals: a test holds the table against our surfaces.
"$python" "$here/crystals.py" 10000 "$work/plates.txt"
PLATES="$work/plates.txt" cargo test -q --release --manifest-path "$root/Cargo.toml" -p gemtrace-core --test crystal_plate -- --nocapture

exec "$python" "$here/verify.py" --gemtrace "$gemtrace" --work "$work" --root "$root" "$@"
