#!/usr/bin/env bash
# Renders scenes on the CPU by two programs, or by what two commits build, and compares their pixels bit by bit.
#
#     scripts/same-bits.sh A B      # each a commit, or a `gemtrace` that has been built
#
# Both render the scenes of this checkout. Files may differ in what they say about their making, which is not compared.
# Exit code 1: a picture differs; 2: one could not be made. Commits are built in CARGO_TARGET_DIR, if it is set.
set -euo pipefail
[ $# = 2 ] || { sed -n '2,7s/^# \?//p' "$0" >&2; exit 2; }
work=$(mktemp -d)
root=$(realpath "$(dirname "$0")/..")
cleanup() {
  git -C "$root" worktree remove --force "$work/source" 2>/dev/null || true
  rm -rf "$work"
}
trap cleanup EXIT
fail() { echo "same-bits: $*" >&2; exit 2; }

# The programs, as $work/a/gemtrace and $work/b/gemtrace.
provide() {
  mkdir -p "$work/$1"
  if [ -f "$2" ] && [ -x "$2" ]; then
    ln -s "$(realpath "$2")" "$work/$1/gemtrace"
    return
  fi
  git -C "$root" worktree add --quiet --detach "$work/source" "$2" || fail "'$2' is neither a program nor a commit"
  target=${CARGO_TARGET_DIR:-$work/target}
  (cd "$work/source" && CARGO_TARGET_DIR=$target cargo build --release --quiet) || fail "'$2' does not build"
  cp "$target/release/gemtrace" "$work/$1/"
  git -C "$root" worktree remove --force "$work/source"
}
provide a "$1"
provide b "$2"

cp -r "$root/scenes" "$work/scenes"
cd "$work/scenes"
# NAME FROM [LINES]: a scene with other lines under [render], which stands last in FROM.
vary() { { cat "$2"; printf '%s\n' "${@:3}"; } > "$1"; }
vary scalar.toml ruby.toml 'polarized = false'
vary scalar-tree.toml pair.toml 'polarized = false'
vary dropped.toml quartz.toml 'samples = 4' 'max_depth = 5' 'leftover = "drop"'
vary planes.toml transparent.toml 'samples = 1' 'spectral = true'
# Stones in each other and in contact, and a metal within.
cat > nested.toml <<'SCENE'
format = 1
[camera]
position = [0.0, -20.0, 26.0]
look_at = [0.0, 0.0, 0.0]
[[stone]]
shape = "round-brilliant"
width = 6.0
material = "diamond"
[[stone]]
shape = "step"
width = 1.5
material = "ruby"
position = [0.4, 0.1, -0.6]
[[stone]]
shape = "step"
width = 0.5
material = "gold"
position = [-1.2, 0.0, -0.4]
priority = 1
[ground]
mirror = true
[render]
samples = 4
wavelengths = { count = 5 }
max_depth = 12
threshold = 1e-2
SCENE

# Renders one case by both and compares every picture that comes of it; the arguments follow `gemtrace`.
different=0
compare() {
  local name=$1
  shift
  for side in a b; do
    mkdir "$work/$side/$name"
    (cd "$work/$side/$name" && "$work/$side/gemtrace" "$@" --backend cpu --quiet > said 2>&1) || fail "$name: $side: $(cat "$work/$side/$name/said")"
  done
  python3 "$root/scripts/pixels.py" "$name" "$work/a/$name" "$work/b/$name" || different=1
}
render() { compare "$1" render "$work/scenes/$2" --output "$1.exr" --output "$1.png" "${@:3}"; }
small=(--size 128x128)
render chain-draft brilliant.toml "${small[@]}" --quality draft
render chain-normal sapphire.toml --size 48x48 --quality normal
render chain-16-bits brilliant.toml "${small[@]}" --samples 5 --bits 16 --space rec2020
render chain-orthographic quartz.toml "${small[@]}" --quality draft
render chain-scalar scalar.toml "${small[@]}" --samples 4
render chain-drop dropped.toml "${small[@]}"
render chain-spectral planes.toml --size 64x64
render spectral cookbook/spectral.toml --size 96x96
render tree pair.toml "${small[@]}" --samples 2
render tree-normal tray.toml --size 64x48 --quality normal
render tree-scalar scalar-tree.toml "${small[@]}" --samples 2
render nested nested.toml "${small[@]}"
render metal ring.toml --size 96x72 --samples 2
render ground tray.toml "${small[@]}" --quality draft
render gold-ground cookbook/gold.toml --size 96x48 --samples 2
compare part render "$work/scenes/pair.toml" "${small[@]}" --samples 2 --shard 2/3 --output part.exr
compare turntable turntable "$work/scenes/tray.toml" --size 64x48 --quality draft --frames 3 --exr --output frames
compare tilt tilt "$work/scenes/ring.toml" --size 64x48 --quality draft --frames 2 --exr --output frames
exit $different
