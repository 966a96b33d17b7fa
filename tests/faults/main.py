#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs rows of the fault matrix with real processes in the lab, and prints one line for each.

    main.py                 the small set, as on every change
    main.py --all           every row
    main.py F13 F17         these rows
    main.py --list          what there is

A row that does not hold is run once more, since it holds then if only a loaded machine was to blame; both runs' figures
are printed. Exit code: 0 all rows hold, 1 some do not, 77 this machine has no lab (skipped, not passed).
"""
import argparse
import pathlib
import subprocess
import sys
import time
import traceback

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "bench")]
import result_file  # noqa: E402
import stage  # noqa: E402
from report import Report  # noqa: E402
from rows import ROWS, SMALL  # noqa: E402

NEEDS = ("root", "netns", "cut", "portcut", "reset", "delay", "rate", "loss")


def run_row(lab, name, options):
    report = Report(name, options.seed)
    try:
        with stage.Stage(lab, report, options.logs, not options.all) as one:
            ROWS[name](one, report)
            report.note(f"this machine was late by {1e3 * one.sampler.late:.0f} ms at most")
    except Exception as error:  # a row that breaks off does not hold; the others still run
        report.error = f"{type(error).__name__}: {str(error)[:300]}"
        if not isinstance(error, AssertionError):
            traceback.print_exc()
    return report


def write_table(options, rows):
    """Writes what is known so far, so that a run that is broken off has not been for nothing."""
    program = stage.cluster_lib.program("tessera-master")
    words = [*options.rows, *(["--all"] if options.all else []), *(["--part", options.part] if options.part != "1/1" else [])]
    run = {**result_file.run_facts(program), "command": " ".join(["tests/faults.sh", *words])}
    result_file.write(options.table, program, {"figures": (["row", "what", "figures and their bounds", "verdict"], rows)}, run=run)


def rewrite_documents(options):
    """Brings the documents up to date where the table is a result that they show."""
    results = HERE.parent / "bench" / "results"
    if pathlib.Path(options.table).resolve().parent == results.resolve():
        subprocess.run([sys.executable, str(HERE.parent / "bench" / "tables.py")], check=True)


def run_rows(names, options, out):
    failed, table = [], []
    with stage.Lab() as lab:
        for name in names:
            began = time.monotonic()
            reports = [run_row(lab, name, options)]
            while not reports[-1].holds and len(reports) <= options.repeats:
                reports.append(run_row(lab, name, options))
            holds = "held" if len(reports) == 1 else "held the second time" if len(reports) == 2 else f"held at try {len(reports)}"
            outcome = holds if reports[-1].holds else "FAILED"
            if outcome == "FAILED":
                failed.append(name)
            title = ROWS[name].__doc__.strip().splitlines()[0]
            print(f"{name} {outcome} [{time.monotonic() - began:.0f} s] {title} " +
                  " | first: ".join(r.text() for r in reversed(reports)), flush=True)
            table.append([name, title, reports[-1].figures_text(), outcome])
            if options.table:
                write_table(options, table)
            if out:
                out.write("".join(r.json("FAILED" if not r.holds else "held") + "\n" for r in reports))
                out.flush()
    return failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", nargs="*", metavar="ROW", help="F01 to F68")
    parser.add_argument("--all", action="store_true", help="every row")
    parser.add_argument("--small", action="store_true", help="the small set (the default)")
    parser.add_argument("--part", metavar="I/N", default="1/1", help="every N-th of them, from the I-th")
    parser.add_argument("--list", action="store_true", help="print the rows and what they do")
    parser.add_argument("--seed", type=int, default=1, help="of what is drawn by chance (default: 1)")
    parser.add_argument("--repeats", type=int, default=1, help="how often a row that does not hold is run again")
    parser.add_argument("--json", metavar="FILE", help="write one JSON object per run of a row")
    parser.add_argument("--table", metavar="FILE", help="write row, what, figures and bounds, verdict; in tests/bench/results, documents follow")
    parser.add_argument("--logs", metavar="DIR", help="keep the logs of rows that do not hold, in DIR/ROW")
    options = parser.parse_args()
    if options.list:
        for name, row in sorted(ROWS.items()):
            print(name, "small" if name in SMALL else "     ", row.__doc__.strip().splitlines()[0])
        return 0
    names = [n[:3].upper() + n[3:] for n in options.rows] or (sorted(ROWS) if options.all else [n for n in SMALL if n in ROWS])
    names = stage.cluster_lib.part_of(names, options.part)
    unknown = [n for n in names if n not in ROWS]
    if unknown:
        parser.error(f"no such row: {', '.join(unknown)}; see --list")
    able = stage.faultlab.probe()
    missing = [need for need in NEEDS if not able.get(need)]
    if missing:
        print("skipped: this machine's fault lab lacks " + ", ".join(missing))
        return 77
    out = open(options.json, "w", encoding="utf-8") if options.json else None
    failed = run_rows(names, options, out)
    if options.table:
        rewrite_documents(options)
    print(f"{len(names) - len(failed)} of {len(names)} rows hold" + (f"; FAILED: {', '.join(failed)}" if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
