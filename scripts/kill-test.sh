#!/usr/bin/env bash
# Renders two hundred pictures, killed with SIGKILL at three random times and restarted, and compares with an undisturbed run.
#
#     scripts/kill-test.sh [GEMTRACE [OPTIONS…]]
#
# GEMTRACE is the program to test [target/release/gemtrace]; the options go to every `gemtrace batch`.
set -euo pipefail
cd "$(dirname "$0")/.."
gemtrace=$(realpath "${1:-${CARGO_TARGET_DIR:-target}/release/gemtrace}")
sweep=$PWD/scenes/sweeps/catalogue.toml
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
batch=("$gemtrace" batch "$sweep" --backend cpu "${@:2}")
fail() { echo "kill-test: FAILED: $*" >&2; exit 1; }

"${batch[@]}" --output "$work/calm" --quiet
count() { grep -c "\"status\":\"$1\"" "$work/killed/manifest.jsonl" 2>/dev/null || true; }
for third in 0 1 2; do
  "${batch[@]}" --output "$work/killed" --quiet &
  # Somewhere in this third of the pictures, and anywhere within a picture.
  target=$((third * 66 + 1 + RANDOM % 65))
  while [ "$(count done)" -lt "$target" ] 2>/dev/null || [ ! -e "$work/killed/manifest.jsonl" ]; do sleep 0.01; done
  sleep "0.0$((RANDOM % 10))"
  kill -KILL $!
  wait $! 2>/dev/null && fail "it ended before it was killed"
  echo "killed with $(count done) pictures done and $(count started) begun"
done
"${batch[@]}" --output "$work/killed"
[ "$(count done)" = 200 ] || fail "$(count done) pictures are recorded"
[ "$(count started)" -le 203 ] || fail "$(count started) pictures were begun: more than three of them twice"
diff --recursive --brief --exclude='manifest*' --exclude=index.html "$work/calm" "$work/killed" || fail "the pictures differ"
leftovers=$(find "$work/killed" -name '.*' -type f)
[ -z "$leftovers" ] || fail "left behind: $leftovers"
echo "kill-test: passed, $(count started) pictures begun for 200"
