"""The roofline plot (Williams, Waterman & Patterson 2009) as SVG: the limits of arithmetic and memory."""

import math
from xml.sax.saxutils import escape

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 640, 400, 64, 24, 24, 56
X = (0.25, 256.0)  # operations a byte
Y = (0.005, 1.4)  # share of the peak


def place(x, y):
    """Pixels of a point, both axes logarithmic."""
    across = (math.log(x) - math.log(X[0])) / (math.log(X[1]) - math.log(X[0]))
    up = (math.log(y) - math.log(Y[0])) / (math.log(Y[1]) - math.log(Y[0]))
    return LEFT + across * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)


def text(x, y, words, anchor="start"):
    """Text at a position in pixels."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(words)}</text>'


def line(start, end, style):
    """A line between two points of the plot."""
    (x1, y1), (x2, y2) = place(*start), place(*end)
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>'


def axes():
    """Ticks and names."""
    grey = 'stroke="#ddd"'
    for x in (0.25, 1, 4, 16, 64, 256):
        at, bottom = place(x, Y[0])
        yield line((x, Y[0]), (x, Y[1]), grey)
        yield text(at, bottom + 18, f"{x:g}", "middle")
    for y in (0.01, 0.1, 1):
        left, at = place(X[0], y)
        yield line((X[0], y), (X[1], y), grey)
        yield text(left - 8, at + 4, f"{y:.0%}", "end")
    yield text(WIDTH / 2, HEIGHT - 14, "useful operations a byte of the lights looked up", "middle")
    yield text(LEFT, 16, "share of the measured peak of multiply-adds")


def draw(roofs):
    """The plot: `roofs` and `slopes` by name, as shares of the peak and of the peak a byte; `points` at one `intensity`."""
    parts = list(axes())
    for name, slope in roofs["slopes"].items():
        ridge = min(1 / slope, X[1])
        start = max(X[0], Y[0] / slope)
        parts.append(line((start, start * slope), (ridge, ridge * slope), 'stroke="#36c" stroke-width="2"'))
        x, y = place(start, start * slope)
        parts.append(text(x + 10, y - 10 if start > X[0] else y - 6, name))
    for name, roof in roofs["roofs"].items():
        least = min(roof / slope for slope in roofs["slopes"].values())
        parts.append(line((max(least, X[0]), roof), (X[1], roof), 'stroke="#c33" stroke-width="2"'))
        x, y = place(X[1], roof)
        parts.append(text(x - 4, y - 6, {"avx512": "AVX-512", "avx2": "AVX2"}.get(name, name), "end"))
    for name, share in roofs["points"].items():
        x, y = place(roofs["intensity"], share)
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="#222"/>')
        parts.append(text(x + 10, y + 4, f"{name}: {share:.0%}"))
    body = "\n".join(parts)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">'
    return f'{head}\n<rect width="100%" height="100%" fill="#fff"/>\n{body}\n</svg>\n'
