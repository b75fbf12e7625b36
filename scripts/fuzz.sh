#!/usr/bin/env bash
# Fuzzes what the program reads, target after target, each for a while. A finding ends it and is kept in fuzz/artifacts.
#
#     scripts/fuzz.sh SECONDS [TARGET…]
#
# It needs a C++ compiler, and no nightly Rust: the instrumentation is a pass of LLVM that stable compilers have, too.
# (With cargo-fuzz and a nightly compiler, `cargo fuzz run TARGET` does the same with a memory checker besides.)
# New inputs that reach new code go to fuzz/target/corpus; FUZZ_MEMORY is the limit of memory, MB [default: 1024].
set -euo pipefail
cd "$(dirname "$0")/../fuzz"
seconds=${1:?how many seconds for each target?}
shift
targets=("$@")
[ $# -gt 0 ] || targets=(scene asc gem gcs obj stl ply environment part manifest)

target=${CARGO_TARGET_DIR:-target}
host=$(rustc -vV | sed -n 's/^host: //p')
coverage="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-trace-compares"
coverage+=" -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
# With --target, build scripts and macros are compiled without.
RUSTFLAGS="$coverage --cfg fuzzing ${RUSTFLAGS-}" \
  cargo build --release --bins --target "$host" --target-dir "$target"

for name in "${targets[@]}"; do
  mkdir -p "$target/corpus/$name" "artifacts/$name"
  log="$target/corpus/$name.log"
  if ! "$target/$host/release/$name" "$target/corpus/$name" "corpus/$name" -max_total_time="$seconds" -timeout=20 \
    -rss_limit_mb="${FUZZ_MEMORY:-1024}" -max_len=65536 -artifact_prefix="artifacts/$name/" -print_final_stats=1 >"$log" 2>&1
  then
    tail -n 40 "$log"
    echo "fuzz: FAILED: $name, see fuzz/artifacts/$name" >&2
    exit 1
  fi
  figure() { sed -n "s/^stat::$1: *//p" "$log"; }
  runs=$(figure number_of_executed_units)
  echo "$name: $seconds s, $runs runs, $(figure new_units_added) new inputs, peak $(figure peak_rss_mb) MB, no finding"
done
