# SPDX-License-Identifier: Apache-2.0
"""Makes the head that every result has, and writes files of tables with it, which tests/bench/tables.py reads."""
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys

RUN_KEYS = ("commit", "processor", "compiler", "date", "command")


def first_line(command):
    try:
        lines = subprocess.run(command, capture_output=True, text=True, check=False).stdout.splitlines()
    except OSError:
        return ""
    return lines[0] if lines else ""


def processor():
    text = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
    name, family = (re.search(rf"^{key}\s*: (.*)$", text, re.M) for key in ("model name", "cpu family"))
    return f"{name[1] if name else 'unknown'}{f' (family {family[1]})' if family else ''}, {os.cpu_count()} threads"


def run_facts(program):
    """Returns what a reader of a result needs. `program` is the one that was measured; its version names the commit."""
    return {
        "commit": first_line([program, "--version"]).split(" ")[-1],
        "processor": processor(),
        "compiler": "gcc " + first_line(["g++", "-dumpfullversion"]),
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"),
        "command": " ".join([pathlib.Path(sys.argv[0]).name, *sys.argv[1:]]),
    }


def write(path, program, tables, **more):
    """Writes a result. `tables` maps a name to (columns, rows). A row is a line, so that versions can be compared."""
    result = {"run": run_facts(program), **more,
              "tables": {name: {"columns": columns, "rows": rows} for name, (columns, rows) in tables.items()}}
    text = json.dumps(result, ensure_ascii=False, indent=1)
    flat = re.sub(r"\[\n\s+([^\[\]{}]*?)\n\s+\]", lambda m: "[" + re.sub(r"\n\s+", " ", m[1]) + "]", text)
    pathlib.Path(path).write_text(flat + "\n", encoding="utf-8")
