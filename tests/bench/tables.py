#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes measured tables and plots into documents, from the results that lie in tests/bench/results.

    tables.py            rewrites what stands between the marks of every document, and the pictures named there
    tables.py --check    names the documents and pictures that differ from their results; exit code 1 if any do

In a document, between two marks:

    <!-- results: FILE.json VIEW -->            <!-- plot: FILE.json VIEW PICTURE.svg -->
    <!-- end of results -->                     <!-- end of plot -->

FILE is what `tessera-bench --json` has written, or an object with "run" (commit, processor, compiler, date, command) and
"tables", each of which has "columns" and "rows". VIEW is the name of one of these tables, or of a view of views.py; of a plot
it is one of plots.py. Several files, separated by commas, are runs of one command: a cell then shows the range that they span.
PICTURE is a path from the document's folder.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import textwrap

from plots import plot_of
from result_file import RUN_KEYS
from views import table_of

ROOT = pathlib.Path(__file__).resolve().parents[2]
RESULTS = ROOT / "tests" / "bench" / "results"
MARKS = re.compile(r"(<!-- results: (?P<files>\S+) (?P<view>[^>]+?) -->\n).*?(<!-- end of results -->)", re.S)
ISA_NAMES = {"scalar": "scalar", "sse4": "SSE4", "avx2": "AVX2", "avx512": "AVX-512"}
OPENING = re.compile(r"^<!-- (?:results|plot): ", re.M)
PLOT_MARKS = re.compile(r"(<!-- plot: (?P<files>\S+) (?P<view>[^>]+?) (?P<picture>\S+\.svg) -->\n).*?(<!-- end of plot -->)", re.S)


def caption(runs):
    run = runs[0]["run"]
    missing = [key for key in RUN_KEYS if key not in run]
    if missing:
        raise SystemExit(f"tables.py: a result lacks {', '.join(missing)}")
    times = f" ({len(runs)} runs)" if len(runs) > 1 else ""
    kernels = ISA_NAMES.get(runs[0].get("isa"), "")
    if kernels in run["processor"]:
        kernels = ""  # results of before kernels were named apart
    where = run["processor"] + (f", {kernels} kernels" if kernels else "")
    text = f"`{run['command']}`{times}: {run['commit']}, {where}, {run['compiler']}, {run['date'][:10]}."
    return textwrap.fill(text, 100, break_long_words=False, break_on_hyphens=False)


def markdown(runs, view):
    columns, rows = table_of(runs, view)
    lines = ["| " + " | ".join(str(cell) for cell in row) + " |" for row in [columns, *rows]]
    lines.insert(1, "|" + "---|" * len(columns))
    return "\n".join(lines) + "\n\n" + caption(runs) + "\n"


def read_runs(names):
    return [json.loads((RESULTS / name).read_text(encoding="utf-8")) for name in names.split(",")]


def products(document, text):
    """Path -> text of what the results make of a document and of its pictures; how many tables and plots it has."""
    made = {}

    def table(match):
        return match[1] + "\n" + markdown(read_runs(match["files"]), match["view"]) + "\n" + match[4]

    def plot(match):
        runs = read_runs(match["files"])
        title, made[document.parent / match["picture"]] = plot_of(runs, match["view"])
        captions = "\n\n".join(dict.fromkeys(caption([run]) for run in runs))
        return f"{match[1]}\n![{title}]({match['picture']})\n\n{captions}\n\n{match[5]}"

    new, tables = MARKS.subn(table, text)
    made[document], plots = PLOT_MARKS.subn(plot, new)
    if tables + plots != len(OPENING.findall(text)):
        raise SystemExit(f"tables.py: {document.relative_to(ROOT)} has a mark without its end, or without a view")
    return made, tables, plots


def documents():
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode == 0:
        return [ROOT / name for name in listed.stdout.split() if (ROOT / name).is_file()]
    return [path for path in sorted(ROOT.rglob("*.md")) if not {"build", "out"} & set(path.relative_to(ROOT).parts)]


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="changes nothing; exit code 1 where a document or picture differs")
    options = parser.parse_args(arguments)
    table_count = plot_count = differing = 0
    for document in documents():
        text = document.read_text(encoding="utf-8")
        if "<!-- results: " not in text and "<!-- plot: " not in text:
            continue
        made, tables, plots = products(document, text)
        table_count, plot_count = table_count + tables, plot_count + plots
        for path, new in made.items():
            if path.is_file() and path.read_text(encoding="utf-8") == new:
                continue
            differing += 1
            if options.check:
                print(f"{path.resolve().relative_to(ROOT)} is not what tables.py makes of its results")
            else:
                path.write_text(new, encoding="utf-8")
    print(f"{table_count} tables, {plot_count} plots, {differing} files {'differ' if options.check else 'rewritten'}")
    return 1 if options.check and differing else 0


if __name__ == "__main__":
    sys.exit(main())
