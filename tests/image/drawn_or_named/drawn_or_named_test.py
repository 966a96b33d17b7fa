#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Drawn or named: for every key of glTF 2.0, its extensions, OBJ, MTL and PLY the product renders a small file.

    drawn_or_named_test.py [--table FILE] [--keep FOLDER] [WORD ...]

Each key is one of
    drawn       the picture differs from that of the same file without the key, as the case says (or is that of an equal
                file that says it by other keys)
    named       one line of the program says what is not drawn
    refused     the file is not drawn, and the line says why
    no picture  the key says nothing of the picture, by the format's definition; the picture is the same, and no line is
                printed
Silence is red. --table writes the table that a person reads; WORDs choose cases whose key holds one of them.
"""
import argparse
import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile
import threading

import core_cases  # noqa: F401
import extension_cases  # noqa: F401
import obj_cases  # noqa: F401
from expectations import CASES, Picture
from gltf_file import GltfFile
from obj_file import CAMERA, ObjFile, PlyFile

PROGRAMS = pathlib.Path(os.environ["TESSERA_BIN"])
OPTIONS = ["--renderer", "path", "--bounces", "2", "--aa", "16", "--size", "32x32", "--seed", "1", "--threads", "1",
           "--environment", "constant:.05,.05,.05"]


FILES = {".obj": ObjFile, ".ply": PlyFile}


class Rendered:
    def __init__(self, folder, name, make, suffix):
        folder = folder / name
        folder.mkdir(exist_ok=True)
        self.path = folder / ("scene" + suffix)
        file = FILES.get(suffix, GltfFile)()
        if make is not None:
            make(file)
        file.write(self.path)
        run = subprocess.run([PROGRAMS / "tessera-master", "render", self.path, "-o", folder / "picture.pfm", *OPTIONS,
                              *(["--camera", CAMERA] if suffix in FILES else [])],
                             capture_output=True, text=True, timeout=120)
        self.code = run.returncode
        lines = (run.stderr + run.stdout).splitlines()
        # Lines about the file itself count; they name it with its folder, which is taken away.
        self.lines = [line.replace(str(folder) + "/", "") for line in lines
                      if ("scene" + suffix + ": " in line or "scene.mtl: " in line) and not line.startswith("loaded ")]
        self.picture = Picture(folder / "picture.pfm") if run.returncode == 0 else None
        self.said = "\n".join(lines[-5:])


class Runner:
    def __init__(self, folder):
        self.folder, self.bases, self.lock = folder, {}, threading.Lock()

    def base(self, case):
        """Returns the file to compare with. It is rendered once; who asks meanwhile waits for it."""
        key = (case.base, case.suffix)
        with self.lock:
            is_mine = key not in self.bases
            name = f"base{len(self.bases)}"
            made = self.bases.setdefault(key, concurrent.futures.Future())
        if is_mine:
            try:
                made.set_result(Rendered(self.folder, name, case.base, case.suffix))
            except BaseException as error:
                made.set_exception(error)
        return made.result()

    def judge(self, case, number):
        """Returns what is wrong, or None, and the line of the table."""
        made = Rendered(self.folder, f"case{number}", case.make, case.suffix)
        told = made.lines[0] if made.lines else ""
        if case.state in ["named", "refused"]:
            found = [line for line in made.lines if case.says in line]
            if (made.code == 0) != (case.state == "named"):
                return f"exit code {made.code}: {made.said}", told
            if not found:
                return f"no line says '{case.says}'; there are {made.lines}", told
            return None, found[0]
        if made.code != 0:
            return f"exit code {made.code}: {made.said}", told
        if made.lines:
            return f"says {made.lines}", told
        base = self.base(case)
        if base.code != 0:
            return f"the file to compare with: {base.said}", told
        return case.check(made.picture, base.picture), case.why or ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--table", type=pathlib.Path)
    parser.add_argument("--keep", type=pathlib.Path, help="keeps files and pictures there")
    parser.add_argument("words", nargs="*")
    options = parser.parse_args()
    cases = [case for case in CASES if not options.words or any(word in case.key for word in options.words)]
    with tempfile.TemporaryDirectory() as name:
        folder = options.keep or pathlib.Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        runner = Runner(folder)
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            answers = list(pool.map(runner.judge, cases, range(len(cases))))
    rows = ["| key | state | |", "|---|---|---|"]
    for case, (wrong, line) in zip(cases, answers):
        rows.append(f"| {case.key} | {'**WRONG**' if wrong else case.state} | {(wrong or line)} |".replace("\n", " "))
        if wrong:
            print(f"{case.key} ({case.state}): {wrong}")
    if options.table:
        options.table.write_text("\n".join(rows) + "\n")
    counts = {state: sum(case.state == state for case in cases) for state in sorted({case.state for case in cases})}
    wrongs = sum(wrong is not None for wrong, _ in answers)
    print(f"{len(cases)} keys: " + ", ".join(f"{count} {state}" for state, count in counts.items()) + f"; {wrongs} wrong")
    return 1 if wrongs else 0


if __name__ == "__main__":
    sys.exit(main())
