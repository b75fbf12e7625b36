"""The table: Markdown for people, JSON for what else there is to know."""

import json
import statistics

HEAD = """<!-- Written by scripts/compare/run.sh. -->

Ratios of one run: {rounds} rounds in an order that rotates, one core of an {machine} unless said. The figure is the
median of the ratios inside each round; the spread is the least and the greatest of them.

| What | Ratio | Spread | Must | Aim | Caveat |
|---|---|---|---|---|---|
"""


def figure(value):
    """Three significant digits."""
    if value is None:
        return "–"
    digits = 0 if value >= 100 else 1 if value >= 10 else 2
    return f"{value:.{digits}f}"


def bound(value, line):
    """A target with its direction."""
    return "–" if value is None else f"{'≤' if line.better == 'less' else '≥'} {value:g}"


def row(line):
    if line.not_run:
        cells = ["not run", "–"]
        caveat = f"not run: {line.not_run}"
    else:
        cells = [
            f"{figure(statistics.median(line.ratios))}×",
            f"{figure(min(line.ratios))}–{figure(max(line.ratios))}",
        ]
        caveat = line.caveat
    cells = [line.what, *cells, bound(line.must, line), bound(line.aim, line), caveat]
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"


def machine():
    """The processor's instruction set, by which ratios of kernels differ most."""
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        flags = info.read()
    return "x86-64 processor with AVX-512" if "avx512f" in flags else "x86-64 processor without AVX-512"


def write(options, lines, raw):
    """Writes the table and the raw figures to the output folder."""
    options.out.mkdir(parents=True, exist_ok=True)
    head = HEAD.format(rounds=options.rounds, machine=machine())
    text = head + "\n".join(map(row, lines)) + "\n"
    figures = {
        "lines": [
            {"what": l.what, "ratios": l.ratios, "must": l.must, "aim": l.aim, "not_run": l.not_run}
            for l in lines
        ],
        "raw": raw,
    }
    for name, content in [
        ("performance-table.md", text),
        ("performance-table.json", json.dumps(figures, indent=1, ensure_ascii=False) + "\n"),
    ]:
        temporary = options.out / f".{name}.part"
        temporary.write_text(content, encoding="utf-8")
        temporary.replace(options.out / name)
    print(text)
