#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs `tessera-sim scaling` and keeps its series as results: tests/bench/results/scaling-*.json.

    tests/sim/record_scaling.py [thesis] [large]

tests/bench/tables.py makes the tables and plots of scaling.md of them. A run is one thread in virtual time:
how fast the machine is does not matter.
"""
import argparse
import csv
import io
import os
import pathlib
import subprocess
import sys

TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / folder) for folder in ("bench", "cluster")]
import cluster_lib  # noqa: E402
import result_file  # noqa: E402
import scaling_series  # noqa: E402

NAMES = ("thesis", "large")


def value(word):
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            pass
    return word


def record(name):
    done = subprocess.run([cluster_lib.program("tessera-sim"), "scaling", name], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"record_scaling.py: tessera-sim scaling {name} ended with {done.returncode}: {done.stderr.strip()[-300:]}")
    columns, *rows = csv.reader(io.StringIO(done.stdout))
    path = TESTS / "bench" / "results" / f"scaling-{name}.json"
    result_file.write(path, cluster_lib.program("tessera-master"),
                      {scaling_series.TABLE: (columns, [[value(word) for word in row] for row in rows])})
    print(f"{len(rows)} rows in {path.name}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="|".join(NAMES), help="which series; both if none is named")
    names = parser.parse_args().names or NAMES
    if set(names) - set(NAMES):
        parser.error(f"there are {' and '.join(NAMES)}")
    for name in names:
        record(name)


if __name__ == "__main__":
    os.environ.setdefault("TESSERA_BIN", str(TESTS.parent / "build" / "release" / "bin"))
    main()
