#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes measured tables into documents, from the results that lie in tests/bench/results.

    tables.py            rewrites what stands between the marks of every document
    tables.py --check    names the documents that differ from their results; exit code 1 if any do

In a document, between two marks:

    <!-- results: FILE.json VIEW -->
    <!-- end of results -->

FILE is what `tessera-bench --json` has written, or an object with "run" (commit, processor, compiler, date, command) and
"tables", each of which has "columns" and "rows". VIEW is the name of one of these tables, or of a view of views.py. Several files,
separated by commas, are runs of one command: a cell then shows the range that they span.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import textwrap

from result_file import RUN_KEYS
from views import table_of

ROOT = pathlib.Path(__file__).resolve().parents[2]
RESULTS = ROOT / "tests" / "bench" / "results"
MARKS = re.compile(r"(<!-- results: (?P<files>\S+) (?P<view>[^>]+?) -->\n).*?(<!-- end of results -->)", re.S)


def caption(runs):
    run = runs[0]["run"]
    missing = [key for key in RUN_KEYS if key not in run]
    if missing:
        raise SystemExit(f"tables.py: a result lacks {', '.join(missing)}")
    times = f" ({len(runs)} runs)" if len(runs) > 1 else ""
    text = f"`{run['command']}`{times}: {run['commit']}, {run['processor']}, {run['compiler']}, {run['date'][:10]}."
    return textwrap.fill(text, 100, break_long_words=False, break_on_hyphens=False)


def markdown(runs, view):
    columns, rows = table_of(runs, view)
    lines = ["| " + " | ".join(str(cell) for cell in row) + " |" for row in [columns, *rows]]
    lines.insert(1, "|" + "---|" * len(columns))
    return "\n".join(lines) + "\n\n" + caption(runs) + "\n"


def filled(text):
    def fill(match):
        runs = [json.loads((RESULTS / name).read_text()) for name in match["files"].split(",")]
        return match[1] + "\n" + markdown(runs, match["view"]) + "\n" + match[4]
    return MARKS.sub(fill, text)


def documents():
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode == 0:
        return [ROOT / name for name in listed.stdout.split() if (ROOT / name).is_file()]
    return [path for path in sorted(ROOT.rglob("*.md")) if not {"build", "out"} & set(path.relative_to(ROOT).parts)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="changes nothing; exit code 1 where a document differs")
    options = parser.parse_args()
    count = differing = 0
    for path in documents():
        text = path.read_text(encoding="utf-8")
        if "<!-- results: " not in text:
            continue
        count += len(MARKS.findall(text))
        new = filled(text)
        if new == text:
            continue
        differing += 1
        if options.check:
            print(f"{path.relative_to(ROOT)} is not what tables.py makes of its results")
        else:
            path.write_text(new, encoding="utf-8")
    print(f"{count} tables, {differing} documents {'differ' if options.check else 'rewritten'}")
    return 1 if options.check and differing else 0


if __name__ == "__main__":
    sys.exit(main())
