#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Damaged STEP and IGES files through the real importer: each ends with a scene, or with one line that names the file and
exit code 1, within the importer's limits.

The files are three small ones that make_cad_files writes, and those of TESSERA_CAD_FILES where there are any; 60 of them
are damaged, or 1,000 with TESSERA_LONG=1, from TESSERA_SEED (1), which is printed. Some damages are by hand: each has its
line here.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
BIN = pathlib.Path(os.environ["TESSERA_BIN"])
POINT = re.compile(rb"CARTESIAN_POINT\('',\([^()]*,[^()]*,[^()]*\)\)")


def importer(path):
    """Returns: exit code, lines of the importer's own."""
    run = subprocess.run([BIN / "tessera-import", path], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                         stderr=subprocess.PIPE)
    lines = run.stderr.decode(errors="replace").strip().split("\n")
    return run.returncode, [line for line in lines if line.startswith("tessera-import: ")]


def by_hand(tray, rods):
    """Name, bytes, what the line says."""
    vertex = re.search(rb"VERTEX_POINT\('',#\d+\)", tray).group()
    usage = re.search(rb"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\('[^']*','[^']*','[^']*',)(#\d+),(#\d+)", tray)
    weight = re.compile(rb"(RATIONAL_B_SPLINE_SURFACE\(\(\s*\()1\.")
    return [
        ("cut.step", tray[:len(tray) // 2], "is cut off: its end is missing"),
        ("flat.step", POINT.sub(b"CARTESIAN_POINT('',(0.,0.,0.))", tray), "no face is left: face 1 "),
        ("crash.step", tray.replace(vertex, b"VERTEX_POINT('',#1)", 1), "Open CASCADE crashed .segmentation fault.; entity #"),
        ("circle.step", tray.replace(usage.group(), usage.group(1) + usage.group(2) + b"," + usage.group(2), 1), "part of itself"),
        ("weight.step", weight.sub(rb"\g<1>-1.", rods, count=1), None),
        ("number.step", re.sub(rb"(CARTESIAN_POINT\('',\()[^,]*", rb"\g<1>NaN", tray, count=1), None),
        ("text.step", b"ISO-10303-21;\nEND-ISO-10303-21;\n", "not readable as STEP"),
        ("empty.igs", b"", "does not begin as an IGES file"),
    ]


def check_by_hand(folder):
    wrong = 0
    tray, rods = (folder / "tray.step").read_bytes(), (folder / "rods.step").read_bytes()
    for name, data, expected in by_hand(tray, rods):
        path = folder / name
        path.write_bytes(data)
        code, lines = importer(path)
        text = lines[0].removeprefix(f"tessera-import: {folder}/") if lines else ""
        is_right = code == 1 and len(lines) == 1 and text.startswith(name + ": ") and re.search(expected or ".", text)
        if expected is None and code == 0 and not lines:
            is_right = True  # what is damaged may be left out, as long as the rest is drawn
        print(f"{name}: exit code {code}: {text}" + ("" if is_right else "   WRONG"))
        wrong += not is_right
    return wrong


def main():
    count, seed = "1000" if "TESSERA_LONG" in os.environ else "60", os.environ.get("TESSERA_SEED", "1")
    given = pathlib.Path(os.environ.get("TESSERA_CAD_FILES", "absent"))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([BIN / "make_cad_files", folder], check=True)
        files = sorted(folder.glob("*s*")) + [f for f in sorted(given.glob("*")) if f.suffix in (".step", ".stp", ".iges", ".igs")]
        wrong = check_by_hand(folder)
        run = subprocess.run([sys.executable, HERE.parent / "damaged_files.py", *files, "--count", count, "--seed", seed,
                              "--seconds", "600", "--memory-mb", "2048", "--show", "12"])
    return 1 if wrong or run.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
