"""The scenes of `scenes/` in both renderers: pictures without noise, and pictures with."""

import dataclasses
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

import comparison
import scene as scenes
import splitting
import stochastic
import world

SCENES = Path(__file__).parent / "scenes"
ORDER = (
    "brilliant-diamond",
    "step-sapphire",
    "step-ruby",
    "brilliant-moissanite",
    "portuguese-quartz",
    "drilled-bead",
    "two-stones",
    "metal-plate",
    "slab-grazing",
    "diamond-grazing",
    "furnace",
)
# Mitsuba against itself with its camera moved by this distance (mm): the effect of rounding at facet edges.
NUDGE = 3e-6
# With noise: scene, wavelength, polarised, our own samples a pixel (a square number: a grid).
NOISY = (
    ("brilliant-diamond", 550.0, False, 4096),
    ("step-sapphire", 590.0, False, 4096),
    ("portuguese-quartz", 550.0, False, 4096),
    ("drilled-bead", 500.0, False, 256),
    ("two-stones", 640.0, False, 1024),
    ("metal-plate", 600.0, False, 1024),
    ("slab-grazing", 550.0, True, 4096),
    ("diamond-grazing", 550.0, True, 4096),
)
# Where s and p are exchanged for the test of that fault.
EXCHANGED = "slab-grazing"
NOISY_SIZE, BLOCK = 64, 4
PASSES, SAMPLES = 64, 64


def say(*words):
    """Prints progress."""
    print("verify:", *words, file=sys.stderr, flush=True)


def load(gemtrace, path):
    """A scene for Mitsuba."""
    return scenes.load(path, gemtrace.program, world.read_image)


def exact(gemtrace, devices, pictures, references):
    """Every scene without noise, polarised and not, by every backend; keeps pictures and references."""
    rows = []
    for name in ORDER:
        kept = {}
        for polarized in (False, True):
            world.use(polarized)
            path = gemtrace.variant(SCENES / f"{name}.toml", polarized=polarized)
            scene = load(gemtrace, path)
            kept[polarized] = expected = splitting.render(scene)
            moved = dataclasses.replace(scene, position=scene.position + NUDGE)
            row = {
                "scene": name,
                "polarized": polarized,
                "wavelengths": scene.wavelengths,
                "lost": expected.lost,
                "itself": judge(expected, splitting.render(moved).radiance),
                "backends": {},
            }
            for backend in devices:
                found = gemtrace.render(path, backend)
                row["backends"][backend] = judge(expected, found)
                if polarized and backend == "cpu":
                    triptych(pictures / f"{name}.png", found, expected.radiance)
            rows.append(row)
            worst = max(f["off"] for figures in row["backends"].values() for f in figures)
            say(name, "polarised" if polarized else "scalar", f"at most {100.0 * worst:.2f} % off")
        keep(references / f"{name}.exr", scene, {"scalar": kept[False], "polarized": kept[True]})
    world.use(polarized=True)
    scene = load(gemtrace, gemtrace.variant(SCENES / f"{EXCHANGED}.toml", wavelengths=[550.0]))
    keep(references / "faults/s-and-p-exchanged.exr", scene, {"polarized": splitting.render(scene, exchanged=True)})
    return rows


def judge(expected, found):
    """The figures, wavelength by wavelength."""
    pairs = zip(expected.radiance, found, strict=True)
    return [comparison.deterministic(a, b, expected.stone) for a, b in pairs]


def keep(path, scene, kept):
    """A reference for the tests: pictures by name and the stone's pixels in one EXR image."""
    path.parent.mkdir(parents=True, exist_ok=True)
    planes = {"stone": kept["polarized"].stone}
    for prefix, picture in kept.items():
        for nm, plane in zip(scene.wavelengths, picture.radiance, strict=True):
            planes[f"{prefix}.S0.{nm:g}nm"] = plane
    pixels = np.stack([np.asarray(plane, np.float32) for plane in planes.values()], axis=-1)
    form = mi.Bitmap.PixelFormat.MultiChannel
    bitmap = mi.Bitmap(pixels, pixel_format=form, channel_names=list(planes))
    bitmap.metadata()["comments"] = (
        f"Mitsuba {mi.__version__}, every split of a ray followed through its own intersections and BSDFs, one"
        f" wavelength at a time; written by scripts/verify from scenes/{scene.name}.toml"
    )
    bitmap.write(str(path))


def triptych(path, found, expected):
    """Ours, Mitsuba's, and a thousand times their difference: the longest wavelength as red, the shortest as blue."""
    channels = [len(found) - 1, len(found) // 2, 0]
    pictures = [found, expected, 1e3 * np.abs(found - expected)]
    scale = 0.8 / np.quantile(expected, 0.98)
    strip = np.concatenate([np.stack([p[c] for c in channels], axis=-1) for p in pictures], axis=1)
    strip = np.repeat(np.repeat(scale * strip, 3, axis=0), 3, axis=1).astype(np.float32)
    shown = mi.Bitmap(strip).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True)
    shown.write(str(path))


def noisy(gemtrace, backend="cpu"):
    """Some scenes by Mitsuba's path tracer, against gemtrace's average over the same pixels."""
    rows = []
    for name, nm, polarized, samples in NOISY:
        world.use(polarized)
        settings = {"width": NOISY_SIZE, "height": NOISY_SIZE, "wavelengths": [nm], "polarized": polarized}
        scene = load(gemtrace, gemtrace.variant(SCENES / f"{name}.toml", **settings))
        path = gemtrace.variant(SCENES / f"{name}.toml", **settings, samples=samples)
        expected = comparison.blocks(gemtrace.render(path, backend)[0], BLOCK)
        found = comparison.blocks(stochastic.passes(scene, 0, PASSES, SAMPLES, seed=1), BLOCK)
        figures = comparison.stochastic(found, expected, SAMPLES)
        rows.append({"scene": name, "nm": nm, "polarized": polarized, "ours": samples, **figures})
        say(name, "with noise:", f"{100.0 * figures['within']:.2f} % within, slope {figures['slope']:.3f}")
    return rows
