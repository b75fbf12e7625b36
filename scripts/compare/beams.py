#!/usr/bin/env python3
"""Measures areas against points: error and CPU time, one thread, one run. Writes docs/beams.json and docs/beams-table.md.

Usage: scripts/compare/beams.py [--program target/release/gemtrace] [--edge 32] [--only main,others] [--out docs]

Errors are ΔE00, 95th percentile over the pixels of a window, against areas of 81 offsets with `threshold = 1e-6`; at most 64
events, as in the default quality, and 256 for the other stones, as in the quality `final`. Times are those of user CPU, less what the same scene costs with one sample of one pixel; only their ratios are written.
"""

import argparse
import json
import math
import resource
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import convergence

ROOT = Path(__file__).resolve().parents[2]
WHITE = (0.95047, 1.0, 1.08883)
POINTS = (1, 9, 27, 81, 243, 729)
OFFSETS = (1, 3, 9, 27)
LEVELS = (0.1, 0.03, 0.01)


def scene(stone, position, look_at, size, film="", light="hall", up="[0.0, 0.0, 1.0]"):
    """A scene; `size` is `fov` or `orthographic` of 512 rows of pixels."""
    return {"stone": stone, "position": position, "look_at": look_at, "size": size, "film": film, "light": light, "up": up}


BRILLIANT = f'cut = "{ROOT}/scenes/cuts/brilliant.asc"\nwidth = 6.5\nmaterial = "diamond"'
STEP = f'cut = "{ROOT}/scenes/cuts/step.gem"\ncrystal = false\nrotation = [0.0, 0.0, 35.0]'
PORTUGUESE = f'cut = "{ROOT}/scenes/cuts/portuguese.gcs"\nwidth = 10.0\nmaterial = "quartz"\ncrystal = false'
EYE = [0.0, -20.0, 26.2]
PARALLEL = {"up": "[0.0, 1.0, 0.0]"}

MAIN = {
    "diamond": scene(BRILLIANT, EYE, [0.0, 0.0, -0.45], ("fov", 14.0)),
    "sapphire": scene(STEP + '\nwidth = 6.0\nmaterial = "sapphire"', [0.0, -16.0, 28.0], [0.0, 0.0, -0.6], ("fov", 14.0),
                      light="apartment"),
    "quartz": scene(PORTUGUESE, [0.0, 0.0, 30.0], [0.0, 0.0, 0.0], ("orthographic", 11.0), **PARALLEL),
}
# The density of 256 rows, so that a small window has much of a stone.
OTHERS = {
    "step cut": scene(STEP + '\nwidth = 6.0\nmaterial = "sapphire"', [0.0, -16.0, 28.0], [1.5, -0.8, 0.0], ("fov", 28.0)),
    "Portuguese cut": scene(PORTUGUESE, [0.0, 0.0, 30.0], [2.5, 1.0, 0.0], ("orthographic", 22.0), **PARALLEL),
    "girdle of a diamond, from the side": scene(BRILLIANT, [0.0, -30.0, 3.0], [0.4, -3.0, -0.1], ("fov", 20.0)),
    "strong absorption: a ruby of 14 mm": scene(STEP + '\nwidth = 14.0\nmaterial = "ruby"', [0.0, -36.0, 62.0],
                                                [2.5, -1.0, 0.0], ("fov", 28.0), light="apartment"),
    "outline, transparent background": scene(STEP + '\nwidth = 6.0\nmaterial = "emerald"', [0.0, -18.0, 27.0],
                                             [3.0, -1.0, 0.0], ("fov", 28.0), 'background = "transparent"', "lobby"),
    "outline, coloured background": scene(PORTUGUESE, [0.0, -18.0, 27.0], [0.0, -4.4, 0.0], ("fov", 28.0),
                                          'background = "#204060"', "lobby"),
    "diamond, tilted by 35°": scene(BRILLIANT + "\nrotation = [35.0, 10.0, 0.0]", EYE, [0.5, 0.5, 0.0], ("fov", 28.0)),
    "quartz, a fifth of the size": scene(PORTUGUESE, [0.0, -18.0, 27.0], [0.0, 0.0, 0.0], ("fov", 70.0)),
}


def toml(what, edge, render):
    """The middle `edge` × `edge` pixels."""
    kind, size = what["size"]
    if kind == "fov":
        size = 2.0 * math.degrees(math.atan(math.tan(math.radians(size / 2.0)) * edge / 512))
    else:
        size *= edge / 512
    keys = "".join(f"{key} = {value}\n" for key, value in render.items())
    return (f'format = 1\n[camera]\nposition = {what["position"]}\nlook_at = {what["look_at"]}\nup = {what["up"]}\n'
            f'{kind} = {size!r}\n[film]\nwidth = {edge}\nheight = {edge}\n{what["film"]}\n'
            f'[environment]\nimage = "{ROOT}/scenes/environments/{what["light"]}.exr"\nrotation = 20.0\n'
            f'[[stone]]\n{what["stone"]}\n[render]\nwavelengths = {{ count = 8 }}\n{keys}')


def exr(data):
    """The XYZ of every pixel of an EXR of 32-bit floats in scan lines, compressed by ZIP."""
    header, at = {}, 8
    while data[at]:
        name, kind, _ = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        (length,) = struct.unpack_from("<i", data, at)
        header[name] = data[at + 4:at + 4 + length]
        at += 4 + length
    names, rest = [], header[b"channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        names, rest = [*names, name.decode()], rest[16:]
    left, top, right, bottom = struct.unpack("<iiii", header[b"dataWindow"])
    width, rows, pixels = right - left + 1, bottom - top + 1, []
    for offset in struct.unpack_from(f"<{-(-rows // 16)}q", data, at + 1):
        row, length = struct.unpack_from("<ii", data, offset)
        count = min(16, bottom - row + 1)
        block = data[offset + 8:offset + 8 + length]
        if length != count * width * 4 * len(names):
            block = bytearray(zlib.decompress(block))
            for i in range(1, len(block)):
                block[i] = (block[i - 1] + block[i] - 128) & 255
            half = (len(block) + 1) // 2
            block[::2], block[1::2] = block[:half], block[half:]
        values = struct.unpack(f"<{len(block) // 4}f", block)
        for line in range(count):
            of = {name: values[(line * len(names) + k) * width:][:width] for k, name in enumerate(names)}
            pixels.extend(zip(*([of[c] for c in "RGB"] if "R" in of else [of[c] for c in "XYZ"])))
    return pixels


class Renders:
    """The program, and a folder for what it writes."""

    def __init__(self, program, folder):
        self.program, self.folder = program, Path(folder)

    def run(self, what, edge, options, **render):
        """The pixels, and the seconds of user CPU."""
        (self.folder / "scene.toml").write_text(toml(what, edge, render), encoding="utf-8")
        command = [self.program, "render", "scene.toml", "--backend", "cpu", "--threads", "1", "--space", "xyz", "-q",
                   "-o", "out.exr", *map(str, options)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run(command, cwd=self.folder, check=True)
        spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        return exr((self.folder / "out.exr").read_bytes()), spent

    def overhead(self, what):
        """What a scene costs before its first sample."""
        return min(self.run(what, 1, ["--samples", 1, "--coverage", "points"])[1] for _ in range(3))

    def converged(self, what, edge, depth):
        return self.run(what, edge, ["--coverage", "area", "--samples", 81], threshold=1e-6, max_depth=depth)[0]


def lab(xyz):
    """CIELAB."""
    f = [t ** (1 / 3) if t > (6 / 29) ** 3 else t / (3 * (6 / 29) ** 2) + 4 / 29
         for t in (max(v, 0.0) / w for v, w in zip(xyz, WHITE))]
    return 116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])


def delta_e(first, second):
    """CIEDE2000 (Sharma, Wu & Dalal 2005)."""
    (l1, a1, b1), (l2, a2, b2) = first, second
    ratio = lambda c: math.sqrt(c**7 / (c**7 + 25**7))
    g = 1 + 0.5 * (1 - ratio((math.hypot(a1, b1) + math.hypot(a2, b2)) / 2))
    c1, c2 = math.hypot(a1 * g, b1), math.hypot(a2 * g, b2)
    h1, h2 = (math.degrees(math.atan2(b, a * g)) % 360 for a, b in ((a1, b1), (a2, b2)))
    turn = 0.0 if c1 * c2 == 0 else (h2 - h1 + 180) % 360 - 180
    dh = 2 * math.sqrt(c1 * c2) * math.sin(math.radians(turn) / 2)
    h = h1 + h2 if c1 * c2 == 0 else (h1 + turn / 2) % 360
    l, c = (l1 + l2) / 2, (c1 + c2) / 2
    cos = lambda degrees: math.cos(math.radians(degrees))
    t = 1 - 0.17 * cos(h - 30) + 0.24 * cos(2 * h) + 0.32 * cos(3 * h + 6) - 0.2 * cos(4 * h - 63)
    dl = (l2 - l1) / (1 + 0.015 * (l - 50) ** 2 / math.sqrt(20 + (l - 50) ** 2))
    dc, dh = (c2 - c1) / (1 + 0.045 * c), dh / (1 + 0.015 * c * t)
    rotation = -2 * ratio(c) * math.sin(math.radians(60 * math.exp(-(((h - 275) / 25) ** 2))))
    return math.sqrt(max(dl * dl + dc * dc + dh * dh + rotation * dc * dh, 0.0))


def p95(picture, reference):
    """The ΔE00 that 95 % of the pixels do not exceed."""
    return sorted(delta_e(lab(a), lab(b)) for a, b in zip(picture, reference))[len(picture) * 95 // 100]


def rmse(picture, reference):
    """Root mean square of the differences of X, Y and Z, as a share of the mean luminance."""
    squares = [(a - b) ** 2 for p, q in zip(picture, reference) for a, b in zip(p, q)]
    return math.sqrt(sum(squares) / len(squares)) / (sum(q[1] for q in reference) / len(reference))


def measured(renders, what, edge, options, against, overhead):
    """Errors and time of one setting."""
    picture, spent = renders.run(what, edge, options)
    return {"p95": p95(picture, against), "rmse": rmse(picture, against), "cpu": max(spent - overhead, 1e-3)}


def curves(renders, what, edge, against, overhead):
    """Points and areas by their number."""
    of = lambda options: measured(renders, what, edge, options, against, overhead)
    return {
        "areas": {n: of(["--coverage", "area", "--samples", n]) for n in OFFSETS},
        "points": {n: of(["--coverage", "points", "--samples", n, "--tolerance", 1e-9]) for n in POINTS if n * edge**2 < 1e6},
    }


def time_to(curve, level):
    """The time at which the RMSE of a curve falls to a level, along straight lines of logarithms; beyond its ends, by the
    slope of the last part. Returns it and whether it lies beyond."""
    ends = sorted(curve.values(), key=lambda point: point["cpu"])
    logs = [(math.log(point["rmse"]), math.log(point["cpu"])) for point in ends]
    (e, t), (f, s) = next(((a, b) for a, b in zip(logs, logs[1:]) if b[0] <= math.log(level)), (logs[-2], logs[-1]))
    beyond = not min(e, f) <= math.log(level) <= max(e, f)
    return math.exp(t + (s - t) * (math.log(level) - e) / (f - e)), beyond


def defaults(renders, what, edge, against, overhead, rounds):
    """The default quality by points and by areas, in turn."""
    found = {"points": [], "area": []}
    for _ in range(rounds):
        for coverage, results in found.items():
            results.append(measured(renders, what, edge, ["--coverage", coverage], against, overhead))
    ratios = sorted(p["cpu"] / a["cpu"] for p, a in zip(found["points"], found["area"]))
    return {"points": found["points"][0]["p95"], "areas": found["area"][0]["p95"], "ratios": ratios}


def main_scenes(renders, options, result):
    for name, what in MAIN.items():
        # The others take less time, of which the program's start would be a large part.
        edge = options.edge if name == "diamond" else 2 * options.edge
        result["pixels"][name] = edge**2
        against, overhead = renders.converged(what, edge, 64), renders.overhead(what)
        result["default"][name] = defaults(renders, what, edge, against, overhead, options.rounds)
        print(name, result["default"][name], file=sys.stderr)
        save(options, result)
        result["curves"][name] = curves(renders, what, edge, against, overhead)
        save(options, result)


def other_scenes(renders, options, result):
    edge = options.edge // 2
    result["pixels"]["each of the other stones"] = edge**2
    for name, what in OTHERS.items():
        against = renders.converged(what, edge, 256)
        result["others"][name] = {
            quality: p95(renders.run(what, edge, ["--quality", quality, "--coverage", "area"])[0], against)
            for quality in ("normal", "final")
        }
        save(options, result)
        if name == "step cut":
            many = renders.run(what, edge, ["--coverage", "points", "--samples", 4096], threshold=1e-6, max_depth=256)[0]
            result["many points"] = {"scene": name, "p95": p95(against, many)}
        print(name, result["others"][name], file=sys.stderr)
        save(options, result)


def processor():
    """The processor's name."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    info = dict(line.split(":", 1) for line in lines if ":" in line)
    name = next((value.strip() for key, value in info.items() if key.startswith("model name")), "unknown")
    return f"{name} {'with' if 'avx512f' in str(info.values()) else 'without'} AVX-512"


def save(options, result):
    """Times mean nothing on another machine: each curve's are relative to areas of 27 offsets."""
    result = json.loads(json.dumps(result))
    for curve in result["curves"].values():
        unit = curve["areas"]["27"]["cpu"]
        for points in curve.values():
            for point in points.values():
                point["cpu"] = round(point["cpu"] / unit, 4)
    for name, curve in result["curves"].items():
        result["equal RMSE"][name] = {}
        for level in LEVELS:
            times = {kind: time_to(curve[kind], level) for kind in ("points", "areas")}
            result["equal RMSE"][name][f"{level:g}"] = {
                "ratio": times["points"][0] / times["areas"][0],
                "extrapolated": [kind for kind, (_, beyond) in times.items() if beyond],
            }
    (options.out / "beams.json").write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    (options.out / "beams-table.md").write_text(convergence.table(result), encoding="utf-8")
    if "diamond" in result["curves"]:
        (options.out / "beams-convergence.svg").write_text(convergence.plot(result["curves"]), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/gemtrace")
    parser.add_argument("--out", type=Path, default=ROOT / "docs")
    parser.add_argument("--edge", type=int, default=32, help="pixels along a window; the other stones' windows are half as wide")
    parser.add_argument("--only", help="main or others; the figures of the other stay as the last run left them")
    parser.add_argument("--rounds", type=int, default=2, help="of the default quality")
    options = parser.parse_args()
    options.program = options.program.resolve()
    result = {"processor": processor(), "default": {}, "curves": {}, "equal RMSE": {}, "others": {}}
    if options.only:
        result |= json.loads((options.out / "beams.json").read_text(encoding="utf-8"))
    result["pixels"] = result.get("pixels", {})
    with tempfile.TemporaryDirectory() as folder:
        renders = Renders(options.program, folder)
        if options.only != "others":
            main_scenes(renders, options, result)
        if options.only != "main":
            other_scenes(renders, options, result)


if __name__ == "__main__":
    main()
