#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes scenes of every material as OBJ and MTL and renders them through the whole program.

    materials_test.py [--gltf FOLDER]   as a test: small pictures; with those of FOLDER's files that are there
    materials_test.py FOLDER       keeps scenes and larger PNGs there, to look at: spheres by roughness and metalness,
                                   mirror and glass in a box, marble, wood and brick

Asserted: no warning, no error, the same digest with one thread and tiles of 16 pixels as with two and 64, and that igi
shows what path shows, within a relative mean square error that is stated for each scene.
"""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile


class ObjFile:
    def __init__(self, name):
        self.lines, self.count = [f"mtllib {name}.mtl"], 0

    def sphere(self, centre, radius, material, around=64):
        self.lines.append(f"usemtl {material}")
        rows, first = around // 2, self.count + 1
        for i in range(rows + 1):
            for j in range(around):
                theta, phi = math.pi * i / rows, 2 * math.pi * j / around
                n = (math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi))
                self.lines.append("v " + " ".join(f"{c + radius * k:.6f}" for c, k in zip(centre, n)))
                self.lines.append("vn " + " ".join(f"{k:.6f}" for k in n))
        for i in range(rows):
            for j in range(around):
                a, b = first + i * around + j, first + i * around + (j + 1) % around
                corners = [a, b, b + around, a + around]
                if i == 0:
                    corners = [a, b + around, a + around]
                if i == rows - 1:
                    corners = [a, b, a + around]
                self.lines.append("f " + " ".join(f"{k}//{k}" for k in corners))
        self.count += (rows + 1) * around

    def quad(self, corners, material):
        self.lines.append(f"usemtl {material}")
        self.lines += ["v %g %g %g" % corner for corner in corners] + ["vn 0 1 0"] * 4
        self.lines.append("f -4 -3 -2 -1")
        self.count += 4

    def write(self, folder, name, materials):
        (folder / f"{name}.obj").write_text("\n".join(self.lines) + "\n")
        (folder / f"{name}.mtl").write_text(materials)


def write_spheres(folder):
    obj = ObjFile("spheres")
    materials = "newmtl floor\nKd .5 .5 .5\nnewmtl back\nKd .3 .4 .6\nnewmtl lamp\nKd 0 0 0\nKe 12 11 9\n"
    for row in range(3):
        for column in range(7):
            name = f"s{row}{column}"
            materials += f"newmtl {name}\nKd .9 .55 .2\nPr {column / 6:.3f}\nPm {row / 2}\n"
            obj.sphere(((column - 3) * 1.05, 0.5 + row * 1.05, 0), 0.5, name)
    obj.quad([(-8, 0, 6), (8, 0, 6), (8, 0, -2), (-8, 0, -2)], "floor")
    obj.quad([(-8, 0, -2), (8, 0, -2), (8, 8, -2), (-8, 8, -2)], "back")
    obj.quad([(-3, 7, 1), (-1, 7, 1), (-1, 7, 4), (-3, 7, 4)], "lamp")
    obj.write(folder, "spheres", materials)
    return "0,2,9 0,1.5,0 0,1,0 30"


def write_box(folder):
    obj = ObjFile("box")
    obj.sphere((-0.45, 0.35, -0.3), 0.35, "mirror")
    obj.sphere((0.45, 0.35, 0.25), 0.35, "glass")
    obj.quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)], "white")
    obj.quad([(-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)], "white")
    obj.quad([(-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)], "white")
    obj.quad([(-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)], "red")
    obj.quad([(1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)], "green")
    obj.quad([(-.3, 1.99, -.3), (.3, 1.99, -.3), (.3, 1.99, .3), (-.3, 1.99, .3)], "lamp")
    obj.write(folder, "box", "newmtl white\nKd .73 .71 .68\nnewmtl red\nKd .61 .06 .06\nnewmtl green\nKd .12 .44 .11\n"
              "newmtl lamp\nKd 0\nKe 17 12 6.5\nnewmtl mirror\nKd 0\nKs .95 .95 .95\nillum 3\n"
              "newmtl glass\nKd 0\nNi 1.5\nillum 7\n")
    return "0,1,3.9 0,1,0 0,1,0 39"


def write_stone(folder):
    obj = ObjFile("stone")
    obj.sphere((-1.2, 0.8, 0), 0.8, "marble")
    obj.sphere((1.3, 0.7, -.3), 0.7, "wood")
    obj.sphere((0.1, 0.4, 0.9), 0.4, "mirror")
    obj.quad([(-4, 0, 8), (4, 0, 8), (4, 0, -2), (-4, 0, -2)], "wood")
    obj.quad([(-4, 0, -2), (4, 0, -2), (4, 5, -2), (-4, 5, -2)], "brick")
    obj.quad([(-4, 0, 4), (-4, 0, -2), (-4, 5, -2), (-4, 5, 4)], "brick")
    obj.quad([(-1, 4.9, 1), (1, 4.9, 1), (1, 4.9, 3), (-1, 4.9, 3)], "lamp")
    obj.write(folder, "stone", "newmtl marble\nKd .85 .83 .8\nKs .04 .04 .04\nNs 400\n"
              "# tessera surface marble frequency 2 turbulence 2 vein .2 .25 .22\n"
              "newmtl wood\nKd .65 .42 .22\n# tessera surface wood frequency 9 wobble .4 grain .4 dark .35 .18 .08\n"
              "newmtl brick\nKd .62 .25 .18\n"
              "# tessera surface brick width .5 height .16 joint .02 variation .4 mortar .6 .58 .55\n"
              "newmtl lamp\nKd 0\nKe 15 14 12\nnewmtl mirror\nKd 0\nKs .9 .9 .9\nillum 3\n")
    return "0,1.8,6 0,1.2,0 0,1,0 40"


SCENES = {"spheres": write_spheres, "box": write_box, "stone": write_stone}
MASTER = pathlib.Path(os.environ["TESSERA_BIN"]) / "tessera-master"


# Bounds of the relMSE of igi to path, with 128x80 pixels, 16 samples and 4 passes: about twice what was measured. The
# box has caustics, which igi leaves out.
AGREES = {"spheres": 0.03, "box": 0.03, "stone": 0.016}
AGREES_GLTF = {"Fox.glb": 0.0003, "FlightHelmet/FlightHelmet.gltf": 0.0004}


def render_file(folder, file, out, *options):
    """Returns the last line of the statistics."""
    stats = folder / "stats.jsonl"
    stats.unlink(missing_ok=True)
    run = subprocess.run([MASTER, "render", file, "-o", out, "--stats", stats, "--environment", "constant:.15,.18,.25", "--bounces", "3",
                          *options], cwd=folder, capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, f"{file}: {run.stderr}"
    # Of a file that holds motion the program says so, and nothing else.
    warnings = [line for line in (run.stderr + run.stdout).splitlines() if "warning" in line]
    assert not warnings, warnings
    return json.loads(stats.read_text().splitlines()[-1])


def render(folder, scene, camera, out, *options):
    """Returns the digest of the picture."""
    return render_file(folder, f"{scene}.obj", out, "--camera", camera, *options)["digest"]


def check_agreement(folder, name, file, bound, *options):
    small = ["--size", "128x80", *options]
    render_file(folder, file, "reference.pfm", "--renderer", "path", "--aa", "256", "--passes", "2", "--seed", "9", *small)
    line = render_file(folder, file, "igi.pfm", "--renderer", "igi", "--aa", "16", "--passes", "4", "--reference", "reference.pfm", *small)
    print(f"igi to path, {name}: relMSE {line['rel_mse']:.6f} (at most {bound})")
    assert line["rel_mse"] <= bound, name


def keep(folder):
    for scene, write in SCENES.items():
        camera = write(folder)
        render(folder, scene, camera, f"{scene}.png", "--renderer", "path", "--aa", "64", "--size", "800x500")
        render(folder, scene, camera, f"{scene}-igi.png", "--renderer", "igi", "--aa", "16", "--vpls", "128", "--size", "800x500")


def test(gltf):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for scene, write in SCENES.items():
            camera = write(folder)
            for renderer in ["direct", "igi", "path"]:
                common = ["--renderer", renderer, "--aa", "2", "--size", "120x80"]
                one = render(folder, scene, camera, "a.pfm", *common, "--threads", "1", "--tile", "16")
                two = render(folder, scene, camera, "b.pfm", *common, "--threads", "2", "--tile", "64")
                assert one == two, f"{scene} {renderer}: {one} and {two}"
                print(f"{scene} {renderer}: {one[:16]}")
            check_agreement(folder, scene, f"{scene}.obj", AGREES[scene], "--camera", camera)
        for file, bound in AGREES_GLTF.items():
            if (gltf / file).is_file():
                check_agreement(folder, file, gltf / file, bound)
            else:
                print(f"{file} is not here: left out")


if __name__ == "__main__":
    if len(sys.argv) == 2:
        keep(pathlib.Path(sys.argv[1]))
    else:
        test(pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else ".").absolute())
