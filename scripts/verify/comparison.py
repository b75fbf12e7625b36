"""The comparison of two pictures: per pixel without noise, per block of pixels with noise."""

import numpy as np
from scipy import stats

MEDIAN, OFF, OFF_BY = 1e-4, 5e-3, 1e-2
FAMILY = 0.05
WITHIN = 0.9975


def deterministic(expected, found, stone):
    """Relative differences over the stone at one wavelength; absolute if the expected value is almost zero."""
    pairs = expected[stone], found[stone]
    difference = np.abs(pairs[1] - pairs[0])
    error = np.where(pairs[0] > 1e-6, difference / np.maximum(pairs[0], 1e-6), difference)
    return {
        "pixels": int(stone.sum()),
        "median": float(np.median(error)),
        "off": float((error > OFF_BY).mean()),
        "worst": float(error.max()),
        "mean_ratio": float(pairs[1].mean() / pairs[0].mean()),
    }


def holds(figures):
    """Whether a wavelength is within the bounds."""
    return figures["median"] < MEDIAN and figures["off"] <= OFF


def blocks(picture, size):
    """Means over blocks of size × size pixels; leading axes stay."""
    *lead, height, width = picture.shape
    return picture.reshape(*lead, height // size, size, width // size, size).mean(axis=(-3, -1))


def stochastic(passes, expected, samples):
    """Independent passes (n × blocks) of a noisy renderer against the expected values (blocks).

    `samples` is a pass's samples a pixel. The bound is Student's for the number of passes, corrected after Šidák so
    that with probability 0.95 no block of a right picture is beyond it. Blocks without variance show the light alone,
    and are left out.
    """
    count = len(passes)
    passes, expected = passes.reshape(count, -1), expected.ravel()
    deviation = passes.std(axis=0, ddof=1)
    chosen = deviation > 1e-4 * expected
    passes, expected, deviation = passes[:, chosen], expected[chosen], deviation[chosen]
    score = (passes.mean(axis=0) - expected) / (deviation / np.sqrt(count))
    share = 1.0 - (1.0 - FAMILY) ** (1.0 / len(expected))
    bound = stats.t.ppf(1.0 - share / 2.0, count - 1)
    within = float((np.abs(score) <= bound).mean())
    steps = [count >> k for k in (3, 2, 1, 0)]
    differences = [mean_difference(passes, expected, step) for step in steps]
    slope = np.polyfit(np.log2(steps), np.log2(differences), 1)[0]
    return {
        "blocks": len(expected),
        "bound": float(bound),
        "within": within,
        "worst": float(np.abs(score).max()),
        "mean_square": float((score**2).mean()),
        "samples": [samples * step for step in steps],
        "differences": differences,
        "slope": float(slope),
        "bias": float(passes.mean() / expected.mean() - 1.0),
        "bias_error": float(passes.mean(axis=1).std(ddof=1) / np.sqrt(count) / expected.mean()),
    }


def mean_difference(passes, expected, step):
    """The mean relative difference of `step` passes together, over all blocks and all such groups of passes."""
    groups = passes.reshape(-1, step, passes.shape[1]).mean(axis=1)
    return float((np.abs(groups - expected) / expected.mean()).mean())
