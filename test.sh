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

# As root where we are not: the packages below are the only thing that needs it.
apt() { if [ "$(id -u)" = 0 ]; then apt-get "$@"; else sudo apt-get "$@"; fi; }

# Build scripts and linking want a C toolchain, which a bare container lacks.
if ! command -v cc >/dev/null 2>&1 && command -v apt-get >/dev/null 2>&1; then
  apt update -q && apt install -y -q gcc libc6-dev
fi

# A software Vulkan device with ray queries, so that the GPU backends run without a GPU: Mesa 24 or later. Debian 12
# has it in its backports, whose suite stands beside the main one on the same mirror.
mesa=$(dpkg-query -W -f '${Version}' mesa-vulkan-drivers 2>/dev/null || echo 0)
if command -v apt-get >/dev/null 2>&1 && { dpkg --compare-versions "$mesa" lt 24 || ! ldconfig -p | grep -q libvulkan; }; then
  . /etc/os-release
  suite=()
  if [ "${VERSION_CODENAME:-}" = bookworm ] && [ -f /etc/apt/sources.list.d/debian.sources ]; then
    backports=$(awk -v RS= 'NR==1' /etc/apt/sources.list.d/debian.sources | sed "s/^Suites:.*/Suites: bookworm-backports/")
    list=/etc/apt/sources.list.d/backports.sources
    if [ ! -f "$list" ]; then
      if [ "$(id -u)" = 0 ]; then echo "$backports" > "$list"; else echo "$backports" | sudo tee "$list" >/dev/null; fi
    fi
    suite=(-t bookworm-backports)
  fi
  apt update -q
  apt install -y -q "${suite[@]}" mesa-vulkan-drivers
  apt install -y -q libvulkan1
fi

# Counts instructions, for the test that holds them to a figure.
if ! command -v valgrind >/dev/null 2>&1 && command -v apt-get >/dev/null 2>&1; then
  apt update -q && apt install -y -q valgrind
fi
# Callgrind knows x86-64 here; elsewhere there is nothing to compare with.
command -v valgrind >/dev/null 2>&1 && export REQUIRE_VALGRIND=1

# The live view is tested in a real browser, and what its page offers to all by axe-core, whose licence is not ours.
browser() { command -v chromium || command -v chromium-browser || command -v google-chrome; }
if ! browser >/dev/null && command -v apt-get >/dev/null 2>&1; then
  apt update -q && apt install -y -q --no-install-recommends chromium fonts-dejavu-core
fi
if ! command -v npm >/dev/null 2>&1 && command -v apt-get >/dev/null 2>&1; then
  apt update -q && apt install -y -q --no-install-recommends npm
fi
axe=target/axe/node_modules/axe-core/axe.min.js
if [ ! -f "$axe" ] && command -v npm >/dev/null 2>&1; then
  npm install --silent --no-audit --no-fund --prefix target/axe axe-core@4
fi
# Where both are there, no test of the page may be skipped.
if browser >/dev/null && [ -f "$axe" ]; then export REQUIRE_BROWSER=1; fi

# The maths half must stand without the rendering half.
cargo check --release --package gemtrace-core --no-default-features
# A backend without a device is a failure here, not a skip. `vulkan` alone is met by any Vulkan device; the software
# device above has all three forms of intersection, which a GPU need not have, so each is demanded by name as well.
forms=vulkan/ray-query,vulkan/ray-tracing-pipeline,vulkan/software
REQUIRE_BACKENDS=${REQUIRE_BACKENDS-cpu,wgpu,vulkan,$forms} cargo test --release --workspace "$@"

# The Python package: its wheel, where there is no Rust. Debian has environments in a package of their own.
if ! python3 -c 'import ensurepip, venv' 2>/dev/null && command -v apt-get >/dev/null 2>&1; then
  apt update -q && apt install -y -q --no-install-recommends python3-venv
fi
python/test.sh
