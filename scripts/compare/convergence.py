"""The table and the plot of beams.py."""

import math

from roofline import escape

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 640, 420, 64, 24, 24, 56
COLOURS = {"diamond": "#222", "sapphire": "#26c", "quartz": "#b50"}

HEAD = """<!-- Written by scripts/compare/beams.py: change it there. -->

Measured on an {processor}, one thread, in windows of so many pixels: {windows}. Errors are ΔE00, 95th percentile, against areas of 81 offsets with a threshold of 10⁻⁶,
with at most 64 events, for the other stones 256. Times are user CPU, as ratios.

"""


def default_rows(result):
    """The default quality, and times at equal RMSE."""
    yield "| | points, default | areas, default | CPU time, points : areas | at 10 % RMSE | 3 % | 1 % |\n|---|---|---|---|---|---|---|"
    for name, row in result["default"].items():
        cells = []
        for found in result["equal RMSE"].get(name, {}).values():
            cells.append("–" if found["extrapolated"] else f"{found['ratio']:.3g}×")
        cells = cells or ["–"] * 3
        ratios = row["ratios"]
        spread = f"{ratios[0]:.2g}–{ratios[-1]:.2g}×"
        yield f"| {name} | {row['points']:.2f} | {row['areas']:.2f} | {spread} | {' | '.join(cells)} |"
    yield "\n*–: beyond the measured numbers of samples.*\n"


def curve_rows(result):
    """Errors by number of samples."""
    for name, curve in result["curves"].items():
        for kind, points in curve.items():
            head = " | ".join(points)
            yield f"| {name}, {kind} | {head} |\n|---|{'---|' * len(points)}"
            yield f"| ΔE00, p95 | {' | '.join(format(p['p95'], '.3g') for p in points.values())} |"
            yield f"| CPU time | {' | '.join(format(p['cpu'], '.3g') for p in points.values())} |\n"


def other_rows(result):
    """The other stones."""
    yield "| areas, against the converged picture | normal | final |\n|---|---|---|"
    for name, row in result["others"].items():
        yield f"| {name} | {row['normal']:.2f} | {row['final']:.2f} |"
    if "many points" in result:
        many = result["many points"]
        yield f"\nThe converged areas of the {many['scene']} differ from 4,096 points by p95 {many['p95']:.2f}."


def table(result):
    """Markdown."""
    windows = ", ".join(f"{name} {count}" for name, count in result["pixels"].items())
    return HEAD.format(**result, windows=windows) + "\n".join([*default_rows(result), *curve_rows(result), *other_rows(result)]) + "\n"


def plot(curves):
    """Error against CPU time, points and areas, as SVG; both axes logarithmic."""
    every = [p for curve in curves.values() for points in curve.values() for p in points.values()]
    low = [math.floor(math.log10(min(p[key] for p in every))) for key in ("cpu", "p95")]
    high = [math.ceil(math.log10(max(p[key] for p in every))) for key in ("cpu", "p95")]

    def place(x, y):
        across, up = ((math.log10(v) - a) / (b - a) for v, a, b in zip((x, y), low, high))
        return LEFT + across * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)

    parts = []
    for k in range(low[0], high[0] + 1):
        (x, y), (_, top) = place(10.0**k, 10.0 ** low[1]), place(10.0**k, 10.0 ** high[1])
        parts.append(f'<path d="M{x:.1f} {y:.1f}V{top:.1f}" stroke="#ddd"/>'
                     f'<text x="{x:.1f}" y="{y + 18:.1f}" text-anchor="middle">{10.0**k:g}</text>')
    for k in range(low[1], high[1] + 1):
        (x, y), (right, _) = place(10.0 ** low[0], 10.0**k), place(10.0 ** high[0], 10.0**k)
        parts.append(f'<path d="M{x:.1f} {y:.1f}H{right:.1f}" stroke="#ddd"/>'
                     f'<text x="{x - 8:.1f}" y="{y + 4:.1f}" text-anchor="end">{10.0**k:g}</text>')
    for name, curve in curves.items():
        for kind, points in curve.items():
            at = [place(p["cpu"], p["p95"]) for p in points.values()]
            dashes = ' stroke-dasharray="5 4"' if kind == "points" else ""
            way = "L".join(f"{x:.1f} {y:.1f}" for x, y in at)
            parts.append(f'<path d="M{way}" fill="none" stroke="{COLOURS[name]}" stroke-width="2"{dashes}/>')
            for (x, y), number in zip(at, points):
                parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{COLOURS[name]}"/>'
                             f'<text x="{x + 5:.1f}" y="{y - 5:.1f}" font-size="10">{number}</text>')
            x, y = at[-1]
            y += 18 if kind == "areas" else -16
            parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="end" fill="{COLOURS[name]}">'
                         f'{escape(f"{name}, {kind}")}</text>')
    parts.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 14}" text-anchor="middle">'
                 'CPU time, in units of areas of 27 offsets of the same scene</text>')
    parts.append(f'<text x="{LEFT}" y="16">error: ΔE00, 95th percentile; numbers are samples a pixel</text>')
    body = "\n".join(parts)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">'
    return f'{head}\n<rect width="100%" height="100%" fill="#fff"/>\n{body}\n</svg>\n'
