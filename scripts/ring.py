#!/usr/bin/env python3
"""Writes the torus of scenes/ring.toml: `scripts/ring.py > scenes/meshes/ring.obj`. No packages needed."""

from math import cos, pi, sin

RADIUS, TUBE = 2.75, 0.35  # mm: of the ring's middle line, of its cross-section
AROUND, ACROSS = 96, 24

print(f"# torus, {RADIUS} mm to the middle of a tube of {TUBE} mm; written by scripts/ring.py")
for i in range(AROUND):
    turn = 2 * pi * i / AROUND
    for j in range(ACROSS):
        tilt = 2 * pi * j / ACROSS
        out = RADIUS + TUBE * cos(tilt)
        print(f"v {out * cos(turn):.6f} {out * sin(turn):.6f} {TUBE * sin(tilt):.6f}")
for i in range(AROUND):
    for j in range(ACROSS):
        corner = lambda a, b: 1 + (a % AROUND) * ACROSS + b % ACROSS
        print("f", corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1))
