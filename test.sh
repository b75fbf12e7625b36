#!/usr/bin/env bash
# Installs what the tests need and runs them all.
#
# The release profile: the suite traces some hundred million rays, and a debug build would take an hour.
set -euo pipefail
cd "$(dirname "$0")"

if ! command -v cargo >/dev/null 2>&1; then
  echo "test.sh: cargo was not found; install Rust 1.95 or later (https://rustup.rs)" >&2
  exit 1
fi
# Build scripts and linking want a C toolchain, which a bare container lacks.
if ! command -v cc >/dev/null 2>&1 && command -v apt-get >/dev/null 2>&1; then
  apt-get update -q && apt-get install -y -q gcc libc6-dev
fi

# The maths half must stand without the rendering half.
cargo check --release --package spectral-core --no-default-features
cargo test --release --workspace "$@"
