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

# The GPU backends run on Mesa's software driver. Debian 12 has one without ray tracing; its backports have a newer.
software_gpu() {
  compgen -G '/usr/share/vulkan/icd.d/lvp_icd*.json' >/dev/null && return
  command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ] || return
  local codename backports=()
  codename=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
  if [ "$codename" = bookworm ] && [ -f /etc/apt/sources.list.d/debian.sources ]; then
    awk -v RS= 'NR==1' /etc/apt/sources.list.d/debian.sources |
      sed "s/^Suites:.*/Suites: $codename-backports/" >/etc/apt/sources.list.d/backports.sources
    backports=(-t "$codename-backports")
  fi
  apt-get update -q && apt-get install -y -q "${backports[@]}" mesa-vulkan-drivers && apt-get install -y -q libvulkan1
}
if software_gpu; then
  # A backend named here that finds no device is a failure, not a reason to skip.
  export REQUIRE_BACKENDS="${REQUIRE_BACKENDS-cpu,wgpu}"
else
  echo "test.sh: no Vulkan driver was found or installed; the tests of the GPU backends are skipped" >&2
fi

# The maths half must stand without the rendering half.
cargo check --release --package spectral-core --no-default-features
cargo test --release --workspace "$@"
