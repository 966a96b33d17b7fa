#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Has clang check the lock annotations of every source that sees common/base/mutex.h, without making code of it.

    lock_annotations.py COMPILE_COMMANDS       of a tree configured for clang; exit code 1 when one is wrong
"""
import json
import os
import pathlib
import re
import subprocess
import sys

from headers_alone import count_wrong, options_of

MUTEX = "common/base/mutex.h"
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def sees_mutex(source, root, known):
    """Whether a file of the tree includes the header, directly or by others."""
    if source not in known:
        known[source] = False  # for headers that include each other
        path = root / source
        text = path.read_text(errors="replace") if path.is_file() else ""
        known[source] = any(name == MUTEX or sees_mutex(name, root, known) for name in INCLUDE.findall(text))
    return known[source]


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    root, known = pathlib.Path.cwd(), {}
    commands = [c for c in json.loads(pathlib.Path(sys.argv[1]).read_text())
                if sees_mutex(os.path.relpath(c["file"], root), root, known)]

    def check(command):
        run = subprocess.run([*options_of(command), "-fsyntax-only", command["file"]], text=True, capture_output=True,
                             cwd=command["directory"])
        return run.returncode, run.stderr

    wrong = count_wrong(commands, check, lambda command, said: f"{os.path.relpath(command['file'], root)}:\n{said}")
    print(f"{len(commands)} sources with locks, {wrong} wrong")
    return 1 if wrong or not commands else 0


if __name__ == "__main__":
    sys.exit(main())
