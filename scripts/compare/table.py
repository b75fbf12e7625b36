"""The table as Markdown, and as JSON with the ratio of every round."""

import json
import statistics
from dataclasses import asdict

from line import Line

# The order of the table.
GROUPS = ["kernels", "mitsuba", "indicatrix", "luxcore"]

HEAD = """<!-- Written by scripts/compare/run.sh: change it there. -->

Each ratio comes from one run with gemtrace and its peer in turn, by CPU time of one core of an {machine} unless stated otherwise.
The figure is the median of the ratios within each round; the spread is their smallest and largest value. Lines without a target are for
information.

| What | Ratio | Spread | Rounds | Must | Aim | Caveat |
|---|---|---|---|---|---|---|
"""


def figure(value):
    """Two or three significant digits."""
    digits = 0 if value >= 100 else 1 if value >= 10 else 2
    return f"{value:.{digits}f}"


def bound(value, line):
    """A target with its direction."""
    return "–" if value is None else f"{'≤' if line.better == 'less' else '≥'} {value:g}"


def row(line):
    """A line in Markdown."""
    if line.not_run:
        cells, caveat = ["not run", "–", "0"], f"not run: {line.not_run}"
    else:
        spread = f"{figure(min(line.ratios))}–{figure(max(line.ratios))}"
        cells = [f"{figure(statistics.median(line.ratios))}×", spread, str(len(line.ratios))]
        caveat = line.caveat
    cells = [line.what, *cells, bound(line.must, line), bound(line.aim, line), caveat]
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"


def machine():
    """The processor's instruction set, on which the ratios of kernels depend most."""
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        return f"x86-64 processor {'with' if 'avx512f' in info.read() else 'without'} AVX-512"


def replace(file, text):
    """Writes under another name first, so that readers never see an incomplete file."""
    temporary = file.with_name(f".{file.name}.part")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(file)


def write(folder, made):
    """Writes the measured lines, by group; other groups do not change."""
    folder.mkdir(parents=True, exist_ok=True)
    figures = folder / "performance-table.json"
    kept = json.loads(figures.read_text(encoding="utf-8")) if figures.exists() else {}
    for group, lines in made.items():
        kept[group] = {"lines": [asdict(line) for line in lines]}
    replace(figures, json.dumps(kept, indent=1, ensure_ascii=False) + "\n")
    rows = [row(Line(**line)) for group in GROUPS if group in kept for line in kept[group]["lines"]]
    text = HEAD.format(machine=machine()) + "\n".join(rows) + "\n"
    replace(folder / "performance-table.md", text)
    print(text)
