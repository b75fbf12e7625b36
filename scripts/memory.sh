#!/usr/bin/env bash
# Renders scenes of ten million triangles, of a 16,384 × 8,192 environment, and of both, and checks that none takes more
# than 4 GiB of memory. Needs GNU time (Debian: `apt install time`), 2 GB of disk and some minutes.
#
#     scripts/memory.sh [TRIANGLES [TEXELS ACROSS]]
set -euo pipefail
cd "$(dirname "$0")/.."

limit=$((4 << 20)) # KiB
if ! env time -f %M true >/dev/null 2>&1; then
  echo "memory.sh: GNU time was not found; on Debian, 'apt install time'" >&2
  exit 1
fi
cargo build --release --quiet --package gemtrace-cli --example large_scene --bins
target=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
folder=$(mktemp -d "$target/memory.XXXXXX")
trap 'rm -rf "$folder"' EXIT
"$target/release/examples/large_scene" "$folder" "$@"

failed=0
printf '%-10s %10s %8s\n' scene 'peak, MiB' seconds
for scene in round hills stl exr hdr both both-stl; do
  env time -f '%M %e' -o "$folder/figures" "$target/release/gemtrace" --quiet render "$folder/$scene.toml" \
    --backend cpu --output "$folder/$scene.png" >/dev/null
  read -r peak seconds <"$folder/figures"
  printf '%-10s %10d %8s\n' "$scene" $((peak >> 10)) "$seconds"
  if [ "$peak" -gt "$limit" ]; then failed=1; fi
done
if [ "$failed" = 1 ]; then
  echo "memory.sh: a scene took more than 4 GiB" >&2
  exit 1
fi
