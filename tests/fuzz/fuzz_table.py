#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Says what the runs of tests/fuzz.sh came to: executions of each target, inputs kept, findings.

Usage: fuzz_table.py BUILD_FOLDER [--json FILE] TARGET...

Runs of an older program count nothing: each line of runs.txt names the program (digest) that ran. With --json the table
becomes a result for tests/bench/tables.py. Exit code 1: a target as it is built now has a finding.
"""
import hashlib
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
import result_file  # noqa: E402

COLUMNS = ["target", "executions", "seconds", "inputs kept", "findings"]


def digest_of(program):
    return hashlib.sha256(program.read_bytes()).hexdigest()[:16] if program.exists() else "not built"


def rows_of(folder, names):
    log = folder / "runs.txt"
    runs = [line.split() for line in log.read_text().splitlines()] if log.exists() else []
    rows = []
    for name in names:
        digest = digest_of(folder / "bin" / name)
        own = [[int(word) for word in run[2:]] for run in runs if run[:2] == [name, digest]]
        kept = folder / "corpus" / name
        inputs = sum(1 for _ in kept.iterdir()) if kept.is_dir() else 0
        executions, seconds, findings = (sum(run[i] for run in own) for i in range(3))
        rows.append([name, executions, seconds, inputs, findings])
    return rows


def main():
    words = sys.argv[1:]
    json_path = None
    if "--json" in words:
        at = words.index("--json")
        json_path = words[at + 1]
        del words[at:at + 2]
    folder, names = pathlib.Path(words[0]), words[1:]
    rows = rows_of(folder, names)
    total = ["all", *(sum(row[i] for row in rows) for i in range(1, len(COLUMNS)))]
    printed = [[f"{cell:,}" if isinstance(cell, int) else cell for cell in row] for row in [*rows, total]]
    for row in [COLUMNS, *printed]:
        print(f"{row[0]:24}" + "".join(f"{cell:>19}" for cell in row[1:]))
    if json_path:
        run = result_file.run_facts("true") | {
            "commit": result_file.first_line(["git", "-C", str(ROOT), "rev-parse", "--short=8", "HEAD"]),
            "compiler": result_file.first_line(["clang++-14", "--version"]),
            "command": "tests/fuzz.sh",
        }
        result_file.write(json_path, "true", {"targets": (COLUMNS, printed)}, run=run)
    return 1 if total[-1] else 0


if __name__ == "__main__":
    sys.exit(main())
