"""From linear sRGB to a spectrum: our method against those of colour-science and Mitsuba, with the same colours.

Every spectrum is judged as light under D65 by colour-science's own tables (CIE 1931 2°, D65, 5 nm), sRGB's primaries
and the white of that grid: none of ours goes into the judgement.
"""

import statistics
import time
import warnings

import mitsuba as mi
import numpy as np

warnings.filterwarnings("ignore", message='.*"Matplotlib" related API features are not available.*')
import colour  # noqa: E402
from colour.recovery import RGB_to_sd_Mallett2019, RGB_to_sd_Smits1999, jakob2019  # noqa: E402
from scipy.optimize import minimize  # noqa: E402

COUNT, SEED = 10_000, 20_261_122
NM = np.arange(380.0, 781.0, 5.0)
SHAPE = colour.SpectralShape(380, 780, 5)


class Judge:
    """Tables of the grid, and measures of spectra."""

    def __init__(self):
        matching = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(SHAPE).values
        self.white = colour.SDS_ILLUMINANTS["D65"].copy().align(SHAPE).values
        self.luminance = matching[:, 1]
        light = matching * self.white[:, None]
        self.rows = light / light[:, 1].sum()
        white = self.rows.sum(axis=0)
        primaries = colour.RGB_COLOURSPACES["sRGB"].primaries
        columns = np.column_stack([primaries, 1.0 - primaries.sum(axis=1)]).T
        self.to_xyz = columns * np.linalg.solve(columns, white)
        self.white_xy = white[:2] / white.sum()

    def figures(self, colours, reflectances):
        """Round trip, ΔE00, smoothness and range of spectra relative to D65 (n × 81)."""
        xyz = reflectances @ self.rows
        error = np.abs(xyz @ np.linalg.inv(self.to_xyz).T - colours).sum(axis=1) / colours.max(axis=1)
        labs = [colour.XYZ_to_Lab(c, self.white_xy) for c in (colours @ self.to_xyz.T, xyz)]
        apart = colour.delta_E(*labs, method="CIE 2000")
        bend = np.diff(reflectances, 2, axis=1) / colours.max(axis=1)[:, None]
        return {
            "colours": len(colours),
            "error_median": float(np.median(error)),
            "error_worst": float(error.max()),
            "delta_e_mean": float(apart.mean()),
            "delta_e_worst": float(apart.max()),
            "roughness": float(np.sqrt((bend**2).mean())),
            "lowest": float(reflectances.min()),
            "highest": float(reflectances.max()),
        }


def compare(gemtrace):
    """All methods with the same colours; times are ratios to ours."""
    judge = Judge()
    colours = np.random.default_rng(SEED).random((COUNT, 3))
    rows, ours = [], None
    for name, way in (
        ("gemtrace: Smits's bases, refined", lambda c: refined(gemtrace, c, judge)),
        ("Smits 1999 (colour-science)", lambda c: one_by_one(RGB_to_sd_Smits1999, c, boxes)),
        ("Mallett and Yuksel 2019 (colour-science)", lambda c: one_by_one(RGB_to_sd_Mallett2019, c, values)),
        ("Jakob and Hanika 2019 (Mitsuba's tables)", tables),
        ("Jakob and Hanika 2019 (colour-science)", optimised),
    ):
        reflectances, seconds = way(colours)
        ours = ours or seconds
        rows.append({"way": name, **judge.figures(colours, reflectances), "time": seconds / ours})
    return {"seed": SEED, "rows": rows}


def refined(gemtrace, colours, judge):
    """Ours: radiance, so divided by D65; our white sets the unit."""
    path = gemtrace.folder / "colours.txt"
    np.savetxt(path, colours, fmt="%.17g")
    answers = [gemtrace.ask("spectrum", "--list", path) for _ in range(3)]
    radiance = np.array([c["radiance"] for c in answers[0]["colours"]])
    unit = gemtrace.ask("spectrum", 1, 1, 1)["radiance"] @ judge.luminance / (judge.white @ judge.luminance)
    return radiance / (unit * judge.white), statistics.median(answer["seconds"] for answer in answers)


def one_by_one(way, colours, read):
    """A function of colour-science, applied to one colour at a time."""
    start = time.perf_counter()
    found = [way(c) for c in colours]
    seconds = time.perf_counter() - start
    return np.array([read(sd) for sd in found]), seconds


def values(sd):
    """A spectrum on our grid."""
    return np.interp(NM, sd.wavelengths, sd.values)


def boxes(sd):
    """Smits's ten numbers are the heights of ten boxes over 380–720 nm, whatever wavelengths the data name."""
    place = np.clip(((NM - 380.0) / 34.0).astype(int), 0, 9)
    return sd.values[place]


def fetched(colours):
    """Jakob and Hanika's coefficients by their own tables, as in Mitsuba (n × 3, for λ in nm)."""
    before = mi.variant()
    mi.set_variant("scalar_spectral")
    try:
        found = [mi.srgb_model_fetch(mi.Color3f(*map(float, c))) for c in colours]
        return np.array([[float(v) for v in f] for f in found])
    finally:
        mi.set_variant(before)


def sigmoid(coefficients):
    """Jakob and Hanika's spectra, equations 1 and 2."""
    a, b, c = coefficients.T[:, :, None]
    x = (a * NM + b) * NM + c
    return 0.5 + x / (2.0 * np.sqrt(1.0 + x**2))


def tables(colours):
    """Their tables."""
    start = time.perf_counter()
    reflectances = sigmoid(fetched(colours))
    return reflectances, time.perf_counter() - start


def optimised(colours):
    """colour-science's optimisation, starting from the tables; starting from grey takes many times as long."""
    matching = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(SHAPE)
    light = colour.SDS_ILLUMINANTS["D65"].copy().align(SHAPE)
    white = colour.XYZ_to_xy(colour.sd_to_XYZ(light, matching))
    first, span = SHAPE.start, SHAPE.end - SHAPE.start
    close = colour.difference.JND_CIE1976 / 100
    begun = fetched(colours)
    start = time.perf_counter()
    found = []
    for rgb, (a, b, c) in zip(colours, begun, strict=True):
        target = colour.XYZ_to_Lab(colour.RGB_to_XYZ(rgb, "sRGB"), white)
        # With the range mapped to 0 to 1.
        guess = [a * span**2, (2.0 * a * first + b) * span, (a * first + b) * first + c]
        try:
            best = minimize(
                jakob2019.error_function, guess, (target, matching, light, close), method="L-BFGS-B", jac=True
            ).x
        except jakob2019.StopMinimizationEarlyError as enough:
            best = enough.coefficients
        found.append(jakob2019.dimensionalise_coefficients(best, SHAPE))
    return sigmoid(np.array(found)), time.perf_counter() - start
