#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles each header alone, with the options of a source in its folder or the nearest one above or beside it.

    headers_alone.py COMPILE_COMMANDS < NAMES       exit code 1 when one does not compile
"""
import concurrent.futures
import json
import os
import pathlib
import shlex
import subprocess
import sys


def options_of(command):
    """Returns the compiler and its options, without what names the source and the object."""
    words, kept, skip = shlex.split(command["command"]), [], False
    for word in words:
        if skip:
            skip = False
        elif word in ("-o", "-c", "-MF", "-MT", "-MQ"):
            skip = word != "-c"
        elif word != command["file"] and not word.startswith("-M") and not word.endswith("ccache"):
            kept.append(word)
    return kept


def nearest(header, commands, root):
    """Returns the command of the source that shares most folders with the header."""
    def shared(command):
        return len(pathlib.PurePath(os.path.commonpath([root / header, command["file"]])).parts)
    return max(commands, key=shared)


def count_wrong(things, compile_one, told):
    """Compiles all side by side, and prints what is wrong of each. Returns: of how many something is."""
    wrong = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for thing, (code, said) in zip(things, pool.map(compile_one, things)):
            if code != 0:
                wrong += 1
                print(told(thing, said))
    return wrong


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    root = pathlib.Path.cwd()
    tops = set(os.listdir(root)) - {"build"}
    commands = [c for c in json.loads(pathlib.Path(sys.argv[1]).read_text())
                if c["file"].endswith(".cpp") and os.path.relpath(c["file"], root).split("/")[0] in tops]
    # A _text.h is included within a namespace that has what it calls, so it cannot compile alone.
    headers = [line.strip() for line in sys.stdin if line.strip() and not line.strip().endswith("_text.h")]

    def compile_alone(header):
        command = nearest(header, commands, root)
        run = subprocess.run([*options_of(command), "-fsyntax-only", "-x", "c++", "-"], input=f'#include "{header}"\n',
                             text=True, capture_output=True, cwd=command["directory"])
        return run.returncode, run.stderr

    wrong = count_wrong(headers, compile_alone, lambda header, said:
                        f"{header} does not compile alone:\n" + "\n".join(said.splitlines()[:6]))
    print(f"{len(headers)} headers, {wrong} do not compile alone")
    return 1 if wrong or not headers else 0


if __name__ == "__main__":
    sys.exit(main())
