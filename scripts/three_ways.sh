#!/usr/bin/env bash
# Renders the README's scene with each backend and compares: writes docs/three-ways.png and prints the figures.
#
# Every backend is chosen by name, so none is replaced by another. A software device takes minutes.
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
mask=scenes/.three-ways-mask.toml # beside the scene, for the paths in it
trap 'rm -rf "$work" "$mask"' EXIT

render() { cargo run --release --quiet --package gemtrace-cli -- render "$1" --backend "$2" --space xyz \
  --samples 16 --output "$work/$3.exr"; }

for backend in cpu wgpu vulkan; do render scenes/brilliant.toml "$backend" "$backend"; done
# The coverage of the stone, from a picture without a background.
sed 's/^background = "environment"/background = "transparent"/' scenes/brilliant.toml > "$mask"
render "$mask" cpu mask

cargo run --release --quiet --package gemtrace-tests --example three_ways -- \
  docs/three-ways.png "$work/mask.exr" "$work/cpu.exr" "$work/wgpu.exr" "$work/vulkan.exr"
