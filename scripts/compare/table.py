"""The table: Markdown for people, JSON with the ratio of every round."""

import json
import statistics
from dataclasses import asdict

from line import Line

# The order of the table.
GROUPS = ["kernels", "mitsuba", "indicatrix", "luxcore"]

HEAD = """<!-- Written by scripts/compare/run.sh: change it there. -->

Each ratio is of one run, gemtrace and its peer in turn, by CPU time of one core of an {machine} unless said. The figure
is the median of the ratios inside each round, the spread their least and greatest. A line without a target was not
asked for.

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
    """The processor's instruction set, by which ratios of kernels differ most."""
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        return f"x86-64 processor {'with' if 'avx512f' in info.read() else 'without'} AVX-512"


def replace(file, text):
    """Writes under another name first, so that nobody reads half a file."""
    temporary = file.with_name(f".{file.name}.part")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(file)


def write(folder, made):
    """Writes the lines made, by group; other groups stay as they were."""
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
