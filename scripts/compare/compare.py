"""Measures gemtrace and its peers in turn, and writes the table of ratios; see run.sh."""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import kernels
import pictures
import roofline
import table
from line import NotRun


class Bench:
    """Runs programs and records their output."""

    def __init__(self, options):
        self.options = options
        self.raw = {}

    def run(self, name, command, cores):
        """The JSON that `command` prints, on the given cores; appended to the raw figures of `name`."""
        pinned = ["taskset", "-c", cores, *map(str, command)]
        try:
            done = subprocess.run(pinned, capture_output=True, text=True, timeout=3600)
        except (OSError, subprocess.TimeoutExpired) as failure:
            raise NotRun(f"{name}: {failure}") from failure
        if done.returncode != 0:
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            raise NotRun(f"{name}: stopped with {done.returncode}: {last}")
        # Libraries print what they like before and behind it.
        found = [line[line.index("{"):] for line in done.stdout.splitlines() if "{" in line]
        try:
            result = json.loads(found[-1])
        except (IndexError, json.JSONDecodeError) as failure:
            raise NotRun(f"{name}: no result in what it printed") from failure
        self.raw.setdefault(name, []).append(result)
        return result

    def rounds(self, measurements):
        """By measurement its results, one a round; the order rotates, so that all meet the same machine."""
        results = {m.name: [] for m in measurements}
        failed = {}
        for number in range(self.options.rounds):
            shift = number % len(measurements)
            for m in measurements[shift:] + measurements[:shift]:
                if m.name in failed:
                    continue
                try:
                    results[m.name].append(self.run(m.name, m.command, m.cores or self.options.core))
                except NotRun as failure:
                    failed[m.name] = failure
                    print(f"compare: {failure}", file=sys.stderr)
        return results, failed


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--peers", type=Path, required=True)
    parser.add_argument("--ours", type=Path, required=True,
                        help="the same program as people build it, without asking for this machine's instructions")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--core", default="1", help="the core that measurements are pinned to")
    parser.add_argument("--only", help="kernels, mitsuba, indicatrix, luxcore: separated by commas; other "
                        "lines stay as the last run left them")
    options = parser.parse_args()
    wanted = options.only.split(",") if options.only else ["kernels", *pictures.PEERS]

    bench = Bench(options)
    made = {}
    if "kernels" in wanted:
        bench.run("record", [options.peers, "record", options.work], options.core)
        bench.run("meshes", [options.peers, "meshes", options.work], options.core)
        results, failed = bench.rounds(kernels.measurements(options))
        made["kernels"] = kernels.lines(results, failed)
        if roofs := kernels.roofline(results):
            table.replace(options.out / "roofline.svg", roofline.draw(roofs))
    made |= pictures.lines(bench, [peer for peer in pictures.PEERS if peer in wanted])
    table.write(options.out, made)
    # Times mean nothing on another machine or another day: they stay with the build.
    table.replace(options.work / "raw.json", json.dumps(bench.raw, indent=1) + "\n")


if __name__ == "__main__":
    try:
        main()
    except NotRun as reason:
        sys.exit(f"compare: {reason}")
