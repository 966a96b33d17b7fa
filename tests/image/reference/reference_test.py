#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares path and igi with pictures of another renderer (Mitsuba, 4096 samples a pixel; scenes of the Ignis project).

    reference_test.py FOLDER [AA]     FOLDER: reference-gi of the scene collection; exit code 77 where it is absent

The scene files (JSON) become OBJ and MTL for `tessera-master render`. Asserted: the mean of the picture within 1 % (igi
with 64 VPLs: 5 %), and that of each of 8 x 8 parts within the noise that the samples leave. Printed: both, and the
relative RMSE of the pixels.
"""
import array
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

MEAN_BOUND = 0.01
PART_BOUND = 0.03  # share of the mean radiance: 1,024 pixels of 64 samples are noisier than the whole
# All pixels of igi gather from the same VPLs, so that the picture is off as a whole: with 64 of them, over 60 seeds, by
# a standard deviation of 1.4 % on the Cornell box. A row holds VPLs, bound of the mean, bound of a part.
IGI = ((64, 0.05, 0.25), (1024, MEAN_BOUND, 0.10))


def merged(path):
    """Returns a scene file with its externals."""
    scene = json.loads(path.read_text())
    for external in scene.pop("externals", []):
        for key, value in merged(path.parent / external["filename"]).items():
            scene.setdefault(key, value)
    return scene


def transformed(words, matrix):
    x, y, z = (float(w) for w in words)
    rows = [matrix[4 * r:4 * r + 4] for r in range(3)]
    return [r[0] * x + r[1] * y + r[2] * z + r[3] for r in rows]


def write_obj(scene, folder, out):
    """Writes each entity's mesh, moved to its place, with its material; numbers of vertices count on over files."""
    lines, materials = ["mtllib scene.mtl"], []
    bsdfs = {b["name"]: b["reflectance"] for b in scene["bsdfs"]}
    radiance = {l["entity"]: l["radiance"] for l in scene["lights"] if l["type"] == "area"}
    shapes = {s["name"]: s for s in scene["shapes"]}
    first = 0
    for entity in scene["entities"]:
        shape = shapes[entity["shape"]]
        matrix = shape.get("transform", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])
        materials.append(f"newmtl {entity['name']}\nKd {' '.join(map(str, bsdfs[entity['bsdf']]))}")
        if entity["name"] in radiance:
            materials.append(f"Ke {' '.join(map(str, radiance[entity['name']]))}")
        lines.append(f"usemtl {entity['name']}")
        count = 0
        for line in (folder / shape["filename"]).read_text().splitlines():
            words = line.split()
            if words[:1] == ["v"]:
                count += 1
                lines.append("v " + " ".join(repr(x) for x in transformed(words[1:4], matrix)))
            elif words[:1] == ["f"]:
                lines.append("f " + " ".join(str(first + int(w.split("/")[0])) for w in words[1:]))
        first += count
    (out / "scene.obj").write_text("\n".join(lines) + "\n")
    (out / "scene.mtl").write_text("\n".join(materials) + "\n")


def camera_of(scene):
    camera = scene["camera"]
    place = camera["transform"]
    if len(place) == 1:
        look = place[0]["lookat"]
        eye, direction, up = look["origin"], look["direction"], look["up"]
    else:
        eye, direction, up = place[3:12:4], place[2:11:4], place[1:10:4]
    target = [e + d for e, d in zip(eye, direction)]
    text = [",".join(repr(float(x)) for x in v) for v in (eye, target, up)]
    return " ".join(text + [str(camera["fov"])])


def read_pfm(path):
    """Returns width, height, and rows from the top, three floats a pixel."""
    with open(path, "rb") as file:
        assert file.readline().strip() == b"PF", path
        width, height = map(int, file.readline().split())
        assert float(file.readline()) < 0, "little-endian is expected"
        values = array.array("f", file.read())
    row = 3 * width
    return width, height, [values[row * y:row * (y + 1)] for y in reversed(range(height))]


def mean_of(rows, x0, x1, y0, y1):
    total = sum(sum(rows[y][3 * x0:3 * x1]) for y in range(y0, y1))
    return total / (3 * (x1 - x0) * (y1 - y0))


def relative_rmse(image, reference):
    """Returns sqrt(mean((a - b)^2 / (b^2 + 0.01 mean^2)))."""
    mean = mean_of(reference, 0, len(reference[0]) // 3, 0, len(reference))
    total = sum((a - b) ** 2 / (b * b + 0.01 * mean * mean) for p, q in zip(image, reference) for a, b in zip(p, q))
    return math.sqrt(total / (3 * len(reference) * len(reference[0]) / 3))


def check(name, folder, scene_file, reference_file, options, aa, out, mean_bound=MEAN_BOUND, part_bound=PART_BOUND):
    scene = merged(folder / "evaluation" / scene_file)
    write_obj(scene, folder / "evaluation", out)
    bounces = scene["technique"]["max_depth"] - 2
    for light in scene["lights"]:
        if light["type"] == "constant":
            options = [*options, "--environment", "constant:" + ",".join(map(str, light["radiance"]))]
    subprocess.run(
        [os.environ["TESSERA_BIN"] + "/tessera-master", "render", str(out / "scene.obj"), "-o", str(out / "picture.pfm"), "--quiet",
         "--size", "256x256", "--camera", camera_of(scene), "--aa", str(aa), "--bounces", str(bounces), *options], check=True)
    width, height, image = read_pfm(out / "picture.pfm")
    _, _, reference = read_pfm(folder / "evaluation" / "references" / reference_file)
    mean, wanted = mean_of(image, 0, width, 0, height), mean_of(reference, 0, width, 0, height)
    edge, worst = width // 8, 0
    for y in range(0, height, edge):
        for x in range(0, width, edge):
            part = mean_of(image, x, x + edge, y, y + edge) - mean_of(reference, x, x + edge, y, y + edge)
            worst = max(worst, abs(part) / wanted)
    print(f"{name}: mean {mean:.6f}, reference {wanted:.6f} ({100 * (mean / wanted - 1):+.3f} %), worst of 64 parts "
          f"{100 * worst:.2f} % of it, relative RMSE {relative_rmse(image, reference):.4f} at {aa} samples a pixel")
    assert abs(mean / wanted - 1) < mean_bound, f"{name}: the mean is off"
    assert worst < part_bound, f"{name}: a part of the picture is off"


def main():
    folder = pathlib.Path(sys.argv[1])
    aa = int(sys.argv[2]) if len(sys.argv) > 2 else 64
    if not folder.is_dir():
        print("skipped: the scenes with references are not here")
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix="tessera-reference-") as out:
        out = pathlib.Path(out)
        cornell = ("cbox-d6.json", "ref-cbox-d6-4096.pfm")
        room = ("room.json", "ref-room-4096.pfm")
        path = ["--renderer", "path"]
        check("path: Cornell box, path length 6", folder, *cornell, path, aa, out)
        check("path: room under a constant sky, path length 4", folder, *room, path, aa, out)
        for vpls, mean_bound, part_bound in IGI:
            igi = ["--renderer", "igi", "--vpls", str(vpls), "--clamp", "auto", "--compensate", "on"]
            for name, files in (("Cornell box, path length 6", cornell), ("room, path length 4", room)):
                check(f"igi, {vpls} VPLs: {name}", folder, *files, igi, 4, out, mean_bound, part_bound)


if __name__ == "__main__":
    main()
