"""docs/verification.md from the figures."""

from pathlib import Path

import comparison

TEXT = Path(__file__).parent / "page.md"


def write(result):
    """The whole page: `page.md` with its fields filled in, and a dash for each part that was not measured."""
    parts = {
        "versions": ", ".join(f"{name} {version}" for name, version in result["versions"].items()),
        "pictures": part(result, "deterministic", pictures),
        "devices": part(result, "deterministic", devices),
        "deterministic": part(result, "deterministic", deterministic),
        "verdict": part(result, "deterministic", verdict),
        "stochastic": part(result, "stochastic", stochastic),
        "colour": part(result, "colour", colour),
        "dispersion": part(result, "dispersion", dispersion),
        "without": part(result, "dispersion", lambda found: ", ".join(found["without"])),
        "database": part(result, "dispersion", lambda found: found["database"][:7]),
    }
    text = TEXT.read_text(encoding="utf-8")
    for name, value in parts.items():
        text = text.replace(f"{{{{{name}}}}}", value)
    return text


def part(result, name, show):
    """The figures of a part."""
    return show(result[name]) if name in result else "–"


def table(head, rows):
    """A Markdown table; all columns but the first are numbers."""
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def percent(share):
    """A share, to a hundredth of a per cent."""
    return f"{100.0 * share:.2f} %"


def small(number):
    """A small number, two digits."""
    return f"{number:.1e}"


def pictures(found):
    """Each scene once."""
    names = [row["scene"] for row in found["rows"] if row["polarized"]]
    return table(["scene", "gemtrace (`cpu`) · Mitsuba · 1000 × the difference"],
                 [[name, f"![{name}](verification/{name}.png)"] for name in names])


def devices(found):
    """The devices."""
    return "\n".join(f"* `{name}`: {device}" for name, device in found["devices"].items())


def deterministic(found):
    """A row for each scene and kind of throughput, with the worst wavelength of every backend."""
    backends = list(found["devices"])
    rows = []
    for row in found["rows"]:
        kind = "polarised" if row["polarized"] else "scalar"
        cells = [row["scene"], kind, str(row["itself"][0]["pixels"])]
        for figures in [*(row["backends"][b] for b in backends), row["itself"]]:
            cells.append(f"{small(worst(figures, 'median'))} · {percent(worst(figures, 'off'))}")
        rows.append(cells)
    return table(["scene", "light", "pixels", *(f"`{b}`" for b in backends), "Mitsuba moved"], rows)


def verdict(found):
    """The number of comparisons, and whether all are within the bounds."""
    all_figures = [f for row in found["rows"] for figures in row["backends"].values() for f in figures]
    failing = sum(not comparison.holds(f) for f in all_figures)
    worst_median, worst_off = worst(all_figures, "median"), worst(all_figures, "off")
    sentence = f"Of {len(all_figures)} comparisons (scene, light, backend, wavelength) "
    sentence += "all are within the bounds" if failing == 0 else f"**{failing} exceed the bounds**"
    return f"{sentence}; the largest median is {small(worst_median)}, the largest share of pixels {percent(worst_off)}."


def worst(figures, key):
    """The largest of a figure over the wavelengths."""
    return max(f[key] for f in figures)


def stochastic(found):
    """A row for each scene."""
    rows = [
        [
            f"{row['scene']}, {row['nm']:g} nm" + (", polarised" if row["polarized"] else ""),
            str(row["blocks"]),
            percent(row["within"]),
            f"{row['worst']:.2f} / {row['bound']:.2f}",
            f"{row['mean_square']:.2f}",
            " → ".join(f"{100.0 * d:.3f}" for d in row["differences"]),
            f"{row['slope']:.2f}",
            f"{row['bias']:+.1e} ± {row['bias_error']:.1e}",
        ]
        for row in found["rows"]
    ]
    head = ["scene", "blocks", "within", "largest z / bound", "mean z²", "mean difference, %", "exponent"]
    return table([*head, "mean picture"], rows)


def colour(found):
    """A row for each method."""
    rows = [
        [
            row["way"],
            str(row["colours"]),
            f"{small(row['error_median'])} / {small(row['error_worst'])}",
            f"{row['delta_e_mean']:.4f} / {row['delta_e_worst']:.4f}",
            f"{row['roughness']:.4f}",
            f"{row['lowest']:.3f} – {row['highest']:.3f}",
            f"{row['time']:.3g}",
        ]
        for row in found["rows"]
    ]
    head = ["way", "colours", "round trip, median / worst", "ΔE00, mean / worst", "roughness", "range", "time"]
    return table(head, rows)


def dispersion(found):
    """A row for each material."""
    rows = [
        [
            row["material"],
            row["entry"],
            row["model"],
            f"{row['from']}–{row['to']}",
            small(row["n"]),
            small(row["k"]) if "k" in row else "",
        ]
        for row in found["rows"]
    ]
    return table(["material", "entry", "model", "nm", "largest Δn", "largest Δk"], rows)
