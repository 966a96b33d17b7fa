#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs two builds of tessera-bench in turns: what the new one gains for each kind of ray, and whether answers differ.

    compare.py OLD NEW [--pairs N] [--json FILE] [-- ARGUMENTS OF tessera-bench core]

OLD and NEW are programs (build the old commit in a clone). Each pair runs one after the other, in an order that
changes, on one processor where the system lets it. Of each row the median of the pairs' ratios counts; their least and
greatest are printed, too.
Exit code 1: a row has other hits or another sum of t, or only one of the builds has it.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

import result_file


def run(program, arguments, path):
    """Returns the figures of each row, by (scene, kind, row)."""
    pinned = ["taskset", "-c", str(max(os.sched_getaffinity(0)))]
    if subprocess.run([*pinned, "true"], capture_output=True, check=False).returncode != 0:
        pinned = []
    done = subprocess.run([*pinned, program, "core", *arguments, "--json", path], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"compare.py: {program} ended with {done.returncode}: {done.stderr.strip()[-300:]}")
    return {(scene["scene"], rays["kind"], row["name"]): row
            for scene in json.loads(path.read_text())["core"] for rays in scene["rays"] for row in rays["rows"]}


def main():
    own, rest = sys.argv[1:], []
    if "--" in own:
        own, rest = own[:own.index("--")], own[own.index("--") + 1:]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--json", help="write a result for tables.py")
    options = parser.parse_args(own)
    ratios, rates, faults = {}, {}, []
    with tempfile.TemporaryDirectory() as folder:
        for pair in range(options.pairs):
            found = {}
            for which in ["old", "new"][::1 if pair % 2 == 0 else -1]:
                found[which] = run(getattr(options, which), rest, pathlib.Path(folder) / "run.json")
            old, new = found["old"], found["new"]
            for key in {**old, **new}:
                if key not in old or key not in new:
                    faults.append(f"{' '.join(key)}: only the {'old' if key in old else 'new'} build has it")
                    continue
                if any(old[key][what] != new[key][what] for what in ("hits", "sum_t")):
                    faults.append(f"{' '.join(key)}: {old[key]['hits']} hits, sum of t {old[key]['sum_t']}; "
                                  f"now {new[key]['hits']}, {new[key]['sum_t']}")
                ratios.setdefault(key, []).append(new[key]["mrays_per_cpu_second"] / old[key]["mrays_per_cpu_second"])
                rates.setdefault(key, []).append(new[key]["mrays_per_cpu_second"])
            print(f"pair {pair + 1} of {options.pairs} is done", file=sys.stderr, flush=True)
    columns = ["scene", "rays", "way", "new to old", "least", "greatest", "Mrays per CPU-second, new"]
    rows = [[*key, *(f"{value:.3f}" for value in (statistics.median(values), min(values), max(values))),
             f"{statistics.median(rates[key]):.2f}"] for key, values in ratios.items()]
    for row in [columns, *rows]:
        print("| " + " | ".join(row) + " |")
    for fault in sorted(set(faults)):
        print(fault)
    print(f"{len(rows)} rows, answers of {len({f.partition(':')[0] for f in faults if 'hits' in f})} differ")
    if options.json:
        result_file.write(options.json, options.new, {"compared": (columns, rows)})
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
