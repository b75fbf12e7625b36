"""The measurements that are repeated in rounds, and their lines."""

from dataclasses import dataclass
from typing import Callable

from line import Line, Measurement, NotRun

# Useful operations, counted by hand from the source of the packets (backend-cpu: planes, incidence,
# texel, block). A fused multiply-add, sum, product, quotient, root, minimum, maximum or comparison of
# floating-point numbers is one operation, as the units that do the former do the others; selections, gathers,
# searches for a facet and failed guesses do not count.
EXIT = 13  # the intersection of a ray with the plane of its facet, and that it lies ahead
SIDE = 4  # that the point is on the inner side of one side of the facet
INCIDENCE = 6  # cos² beyond the surface and its root
POLARIZED = 57  # the frame turned 37, the row times the matrix 20
REFLECTED = 12  # direction 4, one Newton step 7, threshold 1
TEXELS = 48  # Bytes of the four texels that a ray which leaves looks up; all else stays in the first cache.
LEAVING = 116  # Fresnel's amplitudes 10, refraction 14, angles on the image 56, bilinear 18, spectrum 17, sum 1


@dataclass
class Comparison:
    """A line and the measurements it is made of; `same`: the first two must have the same results."""

    what: str
    must: float | None
    aim: float | None
    names: list
    ratio: Callable
    caveat: str
    same: bool = False
    better: str = "more"


def measurements(options):
    """The measurements that are repeated in rounds."""
    peers, ours, work = options.peers, options.ours, options.work
    embree = work / "embree"
    brilliant, internal = work / "brilliant.mesh", work / "internal.rays"
    torus, torus_rays = work / "torus.mesh", work / "torus.rays"
    heap, heap_rays = work / "heap.mesh", work / "heap.rays"
    both = "0,1"
    return [
        Measurement("peak", [peers, "peak"]),
        Measurement("polarized", [ours, "render", "best", "polarized", 1]),
        Measurement("obvhs polarized", [peers, "baseline", "polarized"]),
        Measurement("scalar", [ours, "render", "best", "scalar", 1]),
        Measurement("obvhs scalar", [peers, "baseline", "scalar"]),
        Measurement("avx2", [ours, "render", "avx2", "polarized", 1]),
        Measurement("avx512", [ours, "render", "avx512", "polarized", 1]),
        Measurement("two cores", [ours, "render", "best", "polarized", 2], both),
        Measurement("exits", [ours, "exits", "best", work]),
        Measurement("embree packets", [embree, "trace", brilliant, internal, "packets16", "cached"]),
        Measurement("embree single", [embree, "trace", brilliant, internal, "single", "cached"]),
        Measurement("heap", [ours, "heap", "best"]),
        Measurement("bandwidth", [peers, "bandwidth"]),
        Measurement("embree heap", [embree, "trace", heap, heap_rays, "single"]),
        Measurement("torus", [ours, "trace", torus, torus_rays]),
        Measurement("embree torus", [embree, "trace", torus, torus_rays, "single", "robust"]),
        Measurement("build", [ours, "build", torus]),
        Measurement("embree build", [embree, "build", torus]),
    ]


def share_of_peak(render, baseline, peak):
    """Useful operations over the peak of the core; both renderers have the same surface events."""
    events = baseline["events"] * (EXIT + SIDE * baseline["sides"] + INCIDENCE + POLARIZED + REFLECTED)
    return (events + baseline["leaving"] * LEAVING) / render["cpu"] / max(peak.values())


def intersecting(exits, render, baseline):
    """Time to intersect as many rays as a render has events, over that of the render."""
    return exits["cpu"] / exits["rays"] * baseline["events"] / render["cpu"]


def roofline(results):
    """For the roofline plot: operations a second and a byte; None if a measurement is missing."""
    names = ["peak", "bandwidth", "polarized", "avx2", "obvhs polarized"]
    if not all(results.get(name) for name in names):
        return None
    peak, bandwidth, best, avx2, baseline = (results[name][-1] for name in names)
    events = baseline["events"] * (EXIT + SIDE * baseline["sides"] + INCIDENCE + POLARIZED + REFLECTED)
    operations = events + baseline["leaving"] * LEAVING
    roof = max(peak.values())
    return {
        "intensity": operations / (baseline["leaving"] * TEXELS),
        "points": {"gemtrace": operations / best["cpu"] / roof, "gemtrace, AVX2": operations / avx2["cpu"] / roof},
        "roofs": {name: rate / roof for name, rate in peak.items()},
        "slopes": {name: rate / roof for name, rate in bandwidth.items()},
    }


def agree(first, second, allowed=1e-3):
    """Refuses a comparison of renderers whose pictures, or whose hits, differ."""
    for a, b in zip(first, second):
        if abs(a["mean"] - b["mean"]) > allowed * abs(b["mean"]):
            raise NotRun(f"results differ: mean {a['mean']:.6g} and {b['mean']:.6g}")


def quotient(first, second):
    """The ratio of CPU times: how many times as fast the second is."""
    return first["cpu"] / second["cpu"]


def wall(first, second):
    """The ratio of wall times."""
    return first["wall"] / second["wall"]


COMPARISONS = [
    Comparison(
        "One convex stone, all shading, against the same renderer over obvhs CWBVH, single rays",
        20, 35, ["obvhs polarized", "polarized"], quotient,
        "polarised; 57 facets and 64 of the girdle, 32 wavelengths, at most 16 events. The peer is this repository's "
        "own scalar loop with obvhs's traversal and the angle functions of the C library", same=True),
    Comparison(
        "The same without polarisation", 20, 35, ["obvhs scalar", "scalar"], quotient,
        "the mean of s and p at every event", same=True),
    Comparison(
        "Polarised against unpolarised transport, time", 1.8, None, ["polarized", "scalar"], quotient,
        "a ratio of times", better="less"),
    Comparison(
        "Intersections of internal rays, one brilliant, against Embree 16-packets",
        10, 18, ["embree packets", "exits"], quotient,
        "one convex stone of some 250 triangles only; the same rays in the same packets of wavelengths, from the "
        "second cache. Embree supports any mesh, and returns full hit records", same=True),
    Comparison(
        "The same against Embree single rays", 15, 28, ["embree single", "exits"], quotient, "as above", same=True),
    Comparison(
        "Share of the measured peak of fused multiply-adds",
        0.4, 0.55, ["polarized", "obvhs polarized", "peak"], share_of_peak,
        "useful operations only, one each however simple, counted by hand: 88 and 4 for each side of the facet at a "
        "reflection, 116 more for a ray that leaves; the peak is that of the widest registers"),
    Comparison(
        "Share of a render's time that goes to intersections", None, None, ["exits", "polarized", "obvhs polarized"],
        intersecting, "of the first line; the rest is shading, the look-up of lights and work shared by wavelengths",
        better="less"),
    Comparison(
        "AVX2 against AVX-512, speed", 0.6, 0.75, ["avx512", "avx2"], quotient,
        "the same program with either instruction set"),
    Comparison(
        "Two cores against one", 1.9, 1.97, ["polarized", "two cores"], wall,
        "wall time of two threads on two cores against one thread on one; meaningful only on an idle machine"),
    Comparison(
        "A million triangles of stones, internal rays, against Embree single rays",
        1.2, 2, ["embree heap", "heap"], quotient,
        "4096 brilliants, separate and convex: a ray inside a stone knows which one, and tests its planes alone; Embree "
        "does not have this information", same=True),
    Comparison(
        "Incoherent rays, a mesh of a million triangles, against Embree robust single rays",
        0.7, 1, ["embree torus", "torus"], quotient,
        "a torus; gemtrace's traversal is exact at edges too", same=True),
    Comparison(
        "Building the hierarchy of a million triangles against Embree HIGH, time",
        4, 1.5, ["build", "embree build"], quotient,
        "one core; a torus, where spatial splits are tried without success: other meshes cost more", better="less"),
]


def line(comparison, results, failed):
    """The line of a comparison."""
    made = Line(comparison.what, comparison.must, comparison.aim, comparison.caveat, comparison.better)
    try:
        for name in comparison.names:
            if name in failed:
                raise failed[name]
        series = [results[name] for name in comparison.names]
        if comparison.same:
            agree(*series[:2])
        made.ratios = [comparison.ratio(*results) for results in zip(*series)]
    except NotRun as reason:
        made.not_run = str(reason)
    return made


def lines(results, failed):
    """All lines."""
    return [line(comparison, results, failed) for comparison in COMPARISONS]
