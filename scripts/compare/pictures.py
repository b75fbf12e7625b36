"""Comparisons at equal error with Monte Carlo renderers.

The converged picture is gemtrace's own, with many samples; a peer with another mean is not compared. A peer gets the number of
samples that it needs for the error of the line, and gemtrace the cheapest of several settings that reaches this error. Errors
are those of X, Y and Z over the pixels that the stone covers completely.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np

from line import Line, NotRun

HERE = Path(__file__).parent
# Samples a pixel, wavelengths a sample, the largest number of events on a path, and the threshold.
CONVERGED = (64, 32, 64, 1e-4)
# Eight wavelengths represent every colour. For an error of a tenth, paths need not be followed to the end: the remaining light
# leaves at the last event.
GRIDS = [(1, 8), (1, 16), (2, 8), (3, 8), (4, 6), (6, 4), (1, 32), (4, 8), (2, 16), (9, 8), (4, 16), (16, 8), (25, 8), (36, 8)]
DEPTHS = [(16, 1e-2), (24, 1e-2), (24, 1e-3), (64, 1e-4)]
MOST_SAMPLES = 4096
# The allowed relative difference of a peer's mean, for its noise and the paths it ends.
SAME_MEAN = 0.02


def rmse(picture, reference):
    """Root mean square of the differences, as a share of the mean luminance."""
    return float(np.sqrt(np.mean((picture - reference) ** 2)) / reference[:, 1].mean())


def noise(picture, reference):
    """The same for the displayed pictures, over the luminance of the brightest hundredth, at which both are clipped."""
    white = np.percentile(reference[:, 1], 99)
    difference = np.clip(picture, 0, white) - np.clip(reference, 0, white)
    return float(np.sqrt(np.mean(difference**2)) / white)


@dataclass
class Peer:
    """A renderer, its command for a number of samples, and its target."""

    name: str
    what: str
    must: float
    aim: float
    mode: str
    error: Callable
    target: float
    first: int
    command: Callable
    caveat: str
    rounds: int = 3


def python(script):
    """The command of a script of this folder."""

    def command(options, samples, seed, out):
        return [sys.executable, HERE / script, options.work, samples, seed, out]

    return command


def indicatrix(options, samples, seed, out):
    """The command of indicatrix's path tracer; other seeds are later samples of its sequence."""
    return [options.peers, "indicatrix", samples, seed * MOST_SAMPLES, out]


PEERS = {
    peer.name: peer
    for peer in [
        Peer("mitsuba",
             "CPU time to 10 % RMSE of the converged dispersive diamond, against 32 monochrome Mitsuba passes",
             100, 200, "scalar", rmse, 0.10, 4, python("mitsuba_passes.py"),
             "256², unpolarised in both, so not gemtrace's default; Mitsuba has no dispersion of its own. Its "
             "compilation and loading are not counted. RMSE over the stone, as a share of its mean"),
        Peer("indicatrix", "CPU time to 25 dB, against indicatrix's spectral path tracer",
             50, 200, "polarized", noise, 10 ** (-25 / 20), 4, indicatrix,
             "256², polarised and dispersive in both, the same Sellmeier formula; PSNR over the stone, white being "
             "the brightest hundredth"),
        Peer("luxcore", "CPU time to 16.5 dB, against 32 monochrome LuxCore passes",
             None, None, "scalar", noise, 10 ** (-16.5 / 20), 4, python("luxcore_passes.py"),
             "256², unpolarised in both; PSNR as above. LuxCore's own dispersion chooses a new wavelength at every "
             "refraction, so its pictures converge to another result. Pass by pass its mean is ours, but it does not "
             "exceed about 18 dB, for an unknown reason", 1),
    ]
}


class Studio:
    """Renders, and keeps the converged pictures."""

    def __init__(self, bench):
        self.bench, self.options, self.converged = bench, bench.options, {}
        described = bench.run("scene", [self.options.peers, "describe", self.options.work], self.options.core)
        (self.options.work / "scene.json").write_text(json.dumps(described), encoding="utf-8")
        self.size = described["size"]

    def pixels(self, file, channels):
        """The floats of a file, a row a pixel."""
        return np.fromfile(file, np.float32).reshape(self.size**2, channels).astype(float)

    def ours(self, mode, setting):
        """gemtrace's picture and what it cost."""
        out = self.options.work / "ours.f32"
        command = [self.options.ours, "picture", mode, *setting, out]
        result = self.bench.run(" ".join(map(str, ["picture", mode, *setting])), command, self.options.core)
        return self.pixels(out, 4), result

    def reference(self, mode):
        """The stone's pixels and the converged picture there."""
        if mode not in self.converged:
            pixels = self.ours(mode, CONVERGED)[0]
            stone = pixels[:, 3] >= 1
            self.converged[mode] = stone, pixels[stone, :3]
        return self.converged[mode]

    def theirs(self, peer, samples, seed):
        """A peer's error, mean luminance and cost."""
        stone, reference = self.reference(peer.mode)
        out = self.options.work / f"{peer.name}.f32"
        result = self.bench.run(peer.name, peer.command(self.options, samples, seed, out), self.options.core)
        picture = self.pixels(out, 3)[stone]
        result.update(samples=samples, error=peer.error(picture, reference))
        result["mean"] = float(picture[:, 1].mean() / reference[:, 1].mean())
        return result


def samples_needed(studio, peer):
    """The fewest samples with which a peer reaches the target, from its errors, which decrease with a power of the samples."""
    tried = []
    samples = peer.first
    while samples <= MOST_SAMPLES:
        tried.append(studio.theirs(peer, samples, 0))
        if tried[-1]["error"] <= peer.target:
            break
        samples *= 2
    else:
        raise NotRun(f"{peer.name}: {tried[-1]['error']:.3f} after {MOST_SAMPLES} samples, not {peer.target:.3f}")
    if abs(tried[-1]["mean"] - 1) > SAME_MEAN:
        raise NotRun(f"{peer.name}: its mean is {tried[-1]['mean']:.3f} of gemtrace's: another scene")
    if len(tried) == 1:
        return samples
    below, above = tried[-2:]
    power = np.log(below["error"] / above["error"]) / np.log(above["samples"] / below["samples"])
    return int(np.ceil(below["samples"] * (below["error"] / peer.target) ** (1 / power)))


def cheapest(studio, peer):
    """The cheapest of our settings that reaches the target."""
    stone, reference = studio.reference(peer.mode)
    enough, most = [], float("inf")
    for setting in [grid + depth for depth in DEPTHS for grid in GRIDS]:
        if setting[0] * setting[1] > most:
            continue
        picture, result = studio.ours(peer.mode, setting)
        result["error"] = peer.error(picture[stone, :3], reference)
        if result["error"] <= peer.target:
            enough.append((result["cpu"], setting))
            most = setting[0] * setting[1]
    if not enough:
        raise NotRun("gemtrace: none of the settings is near enough")
    return min(enough)[1]


def line(studio, peer):
    """A line of the table."""
    made = Line(peer.what, peer.must, peer.aim, peer.caveat)
    try:
        samples, setting = samples_needed(studio, peer), cheapest(studio, peer)
        for seed in range(1, min(peer.rounds, studio.options.rounds) + 1):
            theirs = studio.theirs(peer, samples, seed)["cpu"]
            made.ratios.append(theirs / studio.ours(peer.mode, setting)[1]["cpu"])
        grid, depth, threshold = setting[:2], *setting[2:]
        made.caveat += (f". {samples} samples against {grid[0]} of {grid[1]} wavelengths, followed for at most "
                        f"{depth} events and down to a throughput of {threshold:g}")
    except (NotRun, OSError, ValueError) as reason:
        made.not_run = str(reason)
        print(f"compare: {reason}", file=sys.stderr)
    return made


def lines(bench, peers):
    """By peer its lines."""
    if not peers:
        return {}
    studio = Studio(bench)
    return {peer: [line(studio, PEERS[peer])] for peer in peers}
