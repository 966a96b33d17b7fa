#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plants bugs in copies of the product's sources and looks whether the simulation finds them.

    tests/sim/planted_bugs.py [--build build/release] [--seeds 1000] [--only NAME ...]

Each tests/sim/planted/*.patch is one bug. Its files are copied and patched in a scratch folder,
compiled with the build's own commands, and linked before the build's libraries into a tessera-sim
of their own; that runs up to N seeds. Prints a table. Exit code 0: every bug was found; 1: one was
not, or a patch does not apply any more.
"""

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))


def patched_files(patch):
    return re.findall(r"^\+\+\+ b/(\S+)", patch, re.M)


def compile_command(build, path):
    with open(os.path.join(build, "compile_commands.json")) as f:
        for entry in json.load(f):
            if os.path.realpath(entry["file"]) == os.path.realpath(os.path.join(ROOT, path)):
                return shlex.split(entry["command"]), entry["directory"]
    raise SystemExit(f"planted_bugs: {path} is not compiled in {build}; build tessera-sim first")


def link_command(build):
    out = subprocess.run(["ninja", "-C", build, "-t", "commands", "tessera-sim"],
                         capture_output=True, text=True, check=True).stdout
    line = out.strip().splitlines()[-1]
    line = re.sub(r"^: && ", "", line)
    line = re.sub(r" && :$", "", line)
    return shlex.split(line)


def build_mutant(build, patch_path, scratch):
    """Returns the program with the bug, or raises SystemExit with the reason."""
    with open(patch_path) as f:
        patch = f.read()
    objects = []
    for path in patched_files(patch):
        target = os.path.join(scratch, path)
        os.makedirs(os.path.dirname(target), exist_ok=True)
        with open(os.path.join(ROOT, path), "rb") as source, open(target, "wb") as copy:
            copy.write(source.read())
    applied = subprocess.run(["patch", "-p1", "--no-backup-if-mismatch", "-F", "1", "-d", scratch,
                              "-i", patch_path], capture_output=True, text=True)
    if applied.returncode != 0:
        raise SystemExit(f"planted_bugs: {os.path.basename(patch_path)} does not apply any more; "
                         f"plant the bug anew:\n{applied.stdout}{applied.stderr}")
    for path in patched_files(patch):
        command, folder = compile_command(build, path)
        output = os.path.join(scratch, path.replace("/", "_") + ".o")
        command[command.index("-o") + 1] = output
        command[command.index("-c") + 1] = os.path.join(scratch, path)
        command = [word for word in command if word != "-Werror"]
        compiler = 1 if command[0].endswith("ccache") else 0
        command[compiler + 1:compiler + 1] = ["-I" + scratch]  # patched headers come first
        subprocess.run(command, cwd=folder, check=True)
        objects.append(output)
    link = link_command(build)
    program = os.path.join(scratch, "tessera-sim")
    link[link.index("-o") + 1] = program
    first_library = next(i for i, word in enumerate(link) if word.endswith(".a"))
    link[first_library:first_library] = objects
    subprocess.run(link, cwd=build, check=True)
    return program


def note_of(patch_path):
    with open(patch_path) as f:
        return f.readline().lstrip("# ").strip()


def hunt(program, seeds):
    """Returns (seed, invariant, what it said, seconds); seed is None when nothing was found."""
    begin = time.monotonic()
    run = subprocess.run([program, "--seeds", str(seeds)], capture_output=True, text=True)
    taken = time.monotonic() - begin
    found = re.search(r"FAILED seed (\d+)[^:]*: (I\d): (.*)", run.stdout)
    if not found:
        return None, "", "", taken
    return int(found[1]), found[2], found[3], taken


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("--seeds", type=int, default=1000)
    parser.add_argument("--only", nargs="*", default=[])
    arguments = parser.parse_args()
    build = os.path.abspath(arguments.build)
    folder = os.path.join(HERE, "planted")
    names = sorted(name[:-6] for name in os.listdir(folder) if name.endswith(".patch"))
    missed = []
    print("| bug | what was done | found at seed | by | it said | seconds |")
    print("|---|---|---|---|---|---|", flush=True)
    for name in names:
        if arguments.only and name not in arguments.only:
            continue
        patch = os.path.join(folder, name + ".patch")
        with tempfile.TemporaryDirectory(prefix="tessera-planted-") as scratch:
            program = build_mutant(build, patch, scratch)
            seed, invariant, said, taken = hunt(program, arguments.seeds)
        if seed is None:
            missed.append(name)
        print(f"| {name} | {note_of(patch)} | {seed or 'not found'} | {invariant} | {said} | "
              f"{taken:.1f} |", flush=True)
    if missed:
        print(f"not found within {arguments.seeds} seeds: {', '.join(missed)}", file=sys.stderr)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
