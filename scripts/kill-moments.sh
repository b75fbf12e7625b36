#!/usr/bin/env bash
# Kills a render at 40 moments and a batch at 28, evenly spread over their time, with SIGKILL. After each, every file under
# its own name must be whole; and the same command again must leave what an undisturbed run leaves, bit for bit, and
# nothing else. (`kill-test.sh` counts what a killed batch renders twice.)
#
#     scripts/kill-moments.sh [GEMTRACE]
#
# GEMTRACE is the program to test [target/release/gemtrace].
set -euo pipefail
cd "$(dirname "$0")/.."
gemtrace=$(realpath "${1:-${CARGO_TARGET_DIR:-target}/release/gemtrace}")
scene=$PWD/scenes/brilliant.toml
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "kill-moments: FAILED: $*" >&2; exit 1; }
now() { date +%s%N; }

cat >"$work/sweep.toml" <<END
format = 1
base = "$scene"
cuts = ["round-brilliant", "step"]
materials = ["diamond", "ruby", "quartz"]
files = ["png", "exr"]
END
render() { "$gemtrace" render "$scene" -o "$1/a.png" -o "$1/a.exr" --backend cpu --size 400x400 --samples 1 --quiet; }
batch() { "$gemtrace" batch "$work/sweep.toml" -o "$1" --backend cpu --size 200x200 --samples 1 --quiet; }

# Times are in manifests and on the page, and the first of a picture's lines says no more than that it was begun.
pictures() { (cd "$1" && find . -type f \( -name '*.png' -o -name '*.exr' \) -exec sha256sum {} + | sort -k2); }
hidden() { find "$1" -name '.*' -type f | wc -l; }

moments() { # COMMAND COUNT
  local begun ended took killed=0 early=0
  mkdir -p "$work/$1/calm"
  begun=$(now); "$1" "$work/$1/calm"; ended=$(now)
  took=$((ended - begun))
  pictures "$work/$1/calm" >"$work/$1/expected"
  for ((i = 0; i < $2; i++)); do
    folder=$work/$1/$i
    mkdir "$folder"
    # As its own process, so that it and nothing around it is killed.
    "$1" "$folder" 2>/dev/null & shell=$!
    sleep "$(printf '%d.%09d' $((took * i / $2 / 1000000000)) $((took * i / $2 % 1000000000)))"
    child=$(pgrep -P "$shell" || true)
    if [ -n "$child" ] && kill -KILL $child 2>/dev/null; then killed=$((killed + 1)); fi
    wait "$shell" 2>/dev/null || true
    before=$(hidden "$folder")
    [ "$before" = 0 ] || early=$((early + 1))
    pictures "$folder" | while read -r line; do
      grep -qxF "$line" "$work/$1/expected" || fail "$1, moment $i: torn: $line"
    done
    "$1" "$folder"
    pictures "$folder" | cmp -s - "$work/$1/expected" || fail "$1, moment $i: the pictures differ"
    [ "$(hidden "$folder")" = 0 ] || fail "$1, moment $i: left behind: $(find "$folder" -name '.*' -type f)"
    rm -r "$folder"
  done
  echo "$1: killed at $killed of $2 moments in $((took / 1000000)) ms, $early times while a file was written:" \
    "0 torn, 0 left after the next run, all bits the same"
}

moments render 40
moments batch 28
