#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Judges default cameras and cameras of files, through the whole program, by pictures of distances.

Asserted: a thing takes up 80 % of the side that it fills most, in the middle of a picture of any shape; a closed room
is seen from within, by every pixel; a box that is open in front is looked into; --camera N and NAME take the file's
cameras, a file of that name wins, and an unknown name is answered in one line that lists them.
"""
import json
import os
import pathlib
import re
import struct
import subprocess
import tempfile

MASTER = pathlib.Path(os.environ["TESSERA_BIN"]) / "tessera-master"
SIDES = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]  # outward; the last at +z


def box(path, lower, upper, inward, without=()):
    lines = []
    for i in range(8):
        lines.append("v " + " ".join(str((upper if i >> axis & 1 else lower)[axis]) for axis in range(3)))
    for number, side in enumerate(SIDES):
        if number not in without:
            lines.append("f " + " ".join(str(i + 1) for i in (reversed(side) if inward else side)))
    path.write_text("\n".join(lines) + "\n")


def run(*words):
    return subprocess.run([MASTER, "render", *map(str, words), "--renderer", "primary", "--quiet"], capture_output=True, text=True)


def distances(scene, size, *options):
    out = scene.with_suffix(".pfm")
    done = run(scene, "-o", out, "--size", size, *options)
    assert done.returncode == 0, done.stderr
    return rows_of(out)


def rows_of(out):
    """Returns the rows of the picture of distances, from the top; 0 where nothing is."""
    head, width, height, scale, pixels = re.match(rb"(P[Ff])\s+(\d+)\s+(\d+)\s+(\S+)\n(.*)", out.read_bytes(), re.S).groups()
    width, height, bands = int(width), int(height), 3 if head == b"PF" else 1
    values = struct.unpack(f"{'<' if float(scale) < 0 else '>'}{width * height * bands}f", pixels)
    return [values[y * width * bands:(y + 1) * width * bands:bands] for y in reversed(range(height))]


def silhouette(rows):
    """Returns the first and last row and column with anything in them."""
    ys = [y for y, row in enumerate(rows) if any(row)]
    xs = [x for x in range(len(rows[0])) if any(row[x] for row in rows)]
    return ys[0], ys[-1], xs[0], xs[-1]


def check_framing(folder):
    for name, upper in (("cube", (1, 1, 1)), ("tower", (1, 8, 1)), ("plank", (12, 0.2, 1)), ("far", (1, 1, 1))):
        scene = folder / f"{name}.obj"
        away = 500 if name == "far" else 0
        box(scene, (away, 0, 0), (upper[0] + away, *upper[1:]), inward=False)
        for width, height in ((160, 120), (120, 160), (200, 60)):
            top, bottom, left, right = silhouette(distances(scene, f"{width}x{height}"))
            shares = (bottom - top + 1) / height, (right - left + 1) / width
            pixel = 1 / min(width, height)  # a pixel's centre is up to half a pixel from the silhouette's edge
            assert abs(max(shares) - 0.8) <= pixel, (name, width, height, shares)
            assert abs(top + bottom + 1 - height) <= 2 and abs(left + right + 1 - width) <= 2, (name, top, bottom, left, right)


def check_rooms(folder):
    room = folder / "room.obj"
    box(room, (0, 0, 0), (6, 2.7, 4), inward=True)
    for size in ("160x120", "60x160"):
        rows = distances(room, size)
        assert all(all(row) for row in rows), "a pixel of a closed room shows nothing"
        assert max(map(max, rows)) <= (6 * 6 + 2.7 * 2.7 + 4 * 4) ** 0.5, "the eye stands outside"
    # A camera that looks round in the room never looks out of it.
    done = run(room, "-o", folder / "orbit%04d.pfm", "--size", "32x24", "--frames", "0:4", "--orbit", "360")
    assert done.returncode == 0, done.stderr
    for number in range(5):
        assert all(map(all, rows_of(folder / f"orbit{number:04d}.pfm"))), f"frame {number} of the orbit leaves the room"
    stage = folder / "stage.obj"
    box(stage, (0, 0, 0), (6, 4, 4), inward=True, without=(5,))
    rows = distances(stage, "160x120")
    top, bottom, left, right = silhouette(rows)
    assert abs((right - left + 1) / 160 - 0.8) < 1 / 120, "the stage does not fill the picture"
    assert rows[60][80] > 4, "the back wall is not seen through the open side"


def gltf(path):
    cameras = [{"type": "perspective", "name": name, "perspective": {"yfov": 0.5, "znear": 0.1}} for name in ("near", "away")]
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "name": "near", "translation": [0.25, 0.25, 3]},
                  {"camera": 1, "name": "away", "translation": [0.25, 0.25, 7]}],
        "cameras": cameras, "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,"
                     "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}))


def check_names(folder):
    scene = folder / "two.gltf"
    gltf(scene)

    def middle(camera):
        return round(distances(scene, "33x33", "--camera", camera)[16][16], 3)

    assert (middle("1"), middle("2"), middle("near"), middle("away")) == (3, 7, 3, 7)
    (folder / "away").write_text("eye 0.25 0.25 5\ntarget 0.25 0.25 0\n")
    os.chdir(folder)
    assert middle("away") == 5, "a camera file of that name does not win"
    for wrong in ("3", "far"):
        done = run(scene, "-o", folder / "x.pfm", "--camera", wrong)
        assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
        assert f"--camera {wrong}:" in done.stderr and "1 'near', 2 'away'" in done.stderr, done.stderr


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_framing(folder)
        check_rooms(folder)
        check_names(folder)


main()
