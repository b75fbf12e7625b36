#!/usr/bin/env bash
# Measures the GPUs of a machine, unattended, in at most eight minutes: correctness first, then speed.
#
#   scripts/gpu.sh prepare FOLDER            where the project is built: packs program, measuring program, scenes and
#                                            the Vulkan loader (Debian's packages), some 30 MB; keep it out of git
#   FOLDER/gpu.sh measure OUT [ARCHIVE]      on the machine with the GPU, where nothing need be installed
#   scripts/gpu.sh small OUT                 here, at a tiny size: that it works
#
# OUT gets gpu.json and gpu.md (every form of every device: agreement with the processor, times, multiply-adds a
# second), and a file for each step; ARCHIVE (.tar.gz) all of it. A step that fails or hangs does not stop the others.
set -uo pipefail
here=$(cd "$(dirname "$0")" && pwd)

prepare() {
    local to=$1 target=${CARGO_TARGET_DIR:-target}
    cd "$here/.." || return 1
    cargo build --release --workspace --bin gemtrace --example gpu || return 1
    mkdir -p "$to/deb" && cp "$here/gpu.sh" "$to/" && cp -r scenes "$to/"
    strip -o "$to/gemtrace" "$target/release/gemtrace"
    strip -o "$to/gpu" "$target/release/examples/gpu"
    (cd "$to/deb" && apt-get download libvulkan1 libegl1 libglvnd0 libgl1 libglx0 >/dev/null 2>&1)
    du -sh "$to"
}

step() { # step NAME SECONDS COMMAND...
    local name=$1 limit=$2 start
    shift 2
    start=$(date +%s%N)
    timeout "$limit" "$@" >"$OUT/$name.txt" 2>&1
    printf '%-12s rc %-4s %7d ms  %s\n' "$name" $? $((($(date +%s%N) - start) / 1000000)) \
        "$(grep -av '^$' "$OUT/$name.txt" | tail -n 1 | cut -c1-160)" | tee -a "$OUT/table.txt"
}

measure() {
    OUT=$1
    mkdir -p "$OUT" && : >"$OUT/table.txt"
    if ! ldconfig -p | grep -q libvulkan; then
        for deb in "$here"/deb/*.deb; do [ -e "$deb" ] && dpkg -x "$deb" /; done
        ldconfig
    fi
    # Where a container has the driver's files, but not where the loader looks.
    local found
    found=$(find /usr/local /opt -name nvidia_icd.json 2>/dev/null | head -n 1)
    [ -n "$found" ] && export VK_DRIVER_FILES=$found
    command -v nvidia-smi >/dev/null && step card 20 nvidia-smi
    step devices 60 "$here/gemtrace" devices
    step gpu 330 "$here/gpu" "$OUT"
    for backend in vulkan wgpu cpu; do
        step "picture-$backend" 40 "$here/gemtrace" render "$here/scenes/brilliant.toml" --backend "$backend" \
            --quality normal --size 1024x1024 -o "$OUT/$backend.png"
    done
    [ -z "${2:-}" ] || tar czf "$2" -C "$OUT" .
    cat "$OUT/gpu.md" "$OUT/table.txt"
}

case ${1:-} in
prepare) prepare "${2:?a folder}" ;;
measure) measure "${2:?a folder for results}" "${3:-}" ;;
small) cd "$here/.." && cargo run --release --workspace --example gpu -- "${2:?a folder for results}" small ;;
*) sed -n '2,12p' "$0" && exit 2 ;;
esac
