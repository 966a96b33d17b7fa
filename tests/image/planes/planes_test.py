#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests planes of a picture through the whole program: the bits, the names and the values of --aov, and what
--background transparent leaves of the colour.

    planes_test.py [--part files|bits-direct|bits-igi] [--keep FOLDER]

--keep leaves the pictures there, to look at.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "cluster"))
import cluster_lib
import picture_files

AOVS = "albedo,normal,depth,position,object,material,samples"
CHANNELS = ["albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z", "Z", "P.X", "P.Y", "P.Z", "object", "material", "samples"]
ALL = ["--aov", AOVS, "--background", "transparent"]
SIZE = ["--size", "96x72"]
STEADY = ["--light", "studio", "--exposure", "0"]

# Two squares that look along +z: one of 2 x 2 at z = 0, and one of 8 x 8 behind it at z = -4, smoothed to look up.
CARDS = """mtllib cards.mtl
o near
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
usemtl red
f 1 2 3 4
o far
v -4 -4 -4
v 4 -4 -4
v 4 4 -4
v -4 4 -4
vn 0 1 1
usemtl blue
f 5//1 6//1 7//1 8//1
"""
CARD_COLOURS = "newmtl red\nKd .75 .25 .125\nnewmtl blue\nKd .125 .25 .5\n"
CARD_CAMERA = "0,0,4 0,0,0 0,1,0 90"  # 8 units wide at z = 0, 16 behind


def ball(around=32):
    """Returns an OBJ file of a smooth sphere of radius 1 round the origin, and nothing else."""
    lines = []
    for i in range(around // 2 + 1):
        for j in range(around):
            theta, phi = 2 * math.pi * i / around, 2 * math.pi * j / around
            x, y, z = math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi)
            lines += [f"v {x:.6f} {y:.6f} {z:.6f}", f"vn {x:.6f} {y:.6f} {z:.6f}"]
    for i in range(around // 2):
        for j in range(around):
            a, b = 1 + i * around + j, 1 + i * around + (j + 1) % around
            corners = [a, b, b + around, a + around]
            if i in (0, around // 2 - 1):  # at a pole two corners are one point
                corners.remove(b if i == 0 else b + around)
            lines.append("f " + " ".join(f"{k}//{k}" for k in corners))
    return "\n".join(lines) + "\n"


class NoSuchIsa(Exception):
    """The program says that this processor lacks the instruction set asked for."""


class Folder:
    def __init__(self, path):
        self.path, self.runs = pathlib.Path(path), 0
        (self.path / "ball.obj").write_text(ball())
        self.ball = str(self.path / "ball.obj")

    def render(self, scene, name, *options):
        """Renders a picture. Returns its path and the digests. Throws: NoSuchIsa where this processor lacks it."""
        self.runs += 1
        out, stats = self.path / name, self.path / f"stats-{self.runs}.jsonl"
        words = [cluster_lib.program("tessera-master"), "render", scene, "--quiet", "--stats", str(stats), "-o", str(out), *options]
        run = subprocess.run(words, capture_output=True, text=True, timeout=cluster_lib.PATIENCE_S)
        if run.returncode == 1 and ": this CPU does not have it; " in run.stderr:
            raise NoSuchIsa(run.stderr.strip())
        assert run.returncode == 0 and "warning" not in run.stderr, f"{' '.join(words)}: {run.stderr}"
        return out, [json.loads(line)["digest"] for line in stats.read_text().splitlines()]

    def exr(self, scene, name, *options):
        return picture_files.Exr(self.render(scene, name, *options)[0])


def check_colour_stays(folder):
    """Colour has the bits that it has without planes; planes are the same whatever the renderer."""
    planes = None
    for renderer in ("direct", "path", "igi"):
        options = [*SIZE, *STEADY, "--renderer", renderer, "--aa", "2"]
        plain = folder.exr("builtin:teapot-mesh", f"plain-{renderer}.exr", *options)
        rich = folder.exr("builtin:teapot-mesh", f"aov-{renderer}.exr", *options, "--aov", AOVS)
        assert sorted(plain.channels) == ["B", "G", "R"], plain.channels.keys()
        assert sorted(rich.channels) == sorted(["R", "G", "B", *CHANNELS]), rich.channels.keys()
        for name in "RGB":
            assert plain.bits(name) == rich.bits(name), f"{renderer}: {name} is not what it is without planes"
        here = {name: rich.bits(name) for name in CHANNELS}
        assert planes in (None, here), f"{renderer}: planes are not those of the other renderers"
        planes = here
    black = folder.exr(folder.ball, "black.exr", *options, "--background", "black")
    clear = folder.exr(folder.ball, "clear.exr", *options, "--background", "transparent")
    assert sorted(clear.channels) == ["A", "B", "G", "R"]
    for name in "RGB":
        assert black.bits(name) == clear.bits(name), "a transparent background adds nothing"
    for alpha, red, green, blue in zip(*(clear.values(name) for name in "ARGB")):
        assert 0 <= alpha <= 1 and (alpha > 0 or red == green == blue == 0)
    # The sum of alpha is the area of the ball's silhouette, a circle of 0.8 of the height in diameter, as its camera
    # frames it; a polygon of 32 corners covers 0.994 of its circle.
    area = sum(clear.values("A")) / (math.pi * (0.4 * clear.height) ** 2)
    assert 0.9 < area < 1.1, area
    print("colour keeps its bits with planes, and with a transparent background those before black")


def check_values(folder):
    (folder.path / "cards.obj").write_text(CARDS)
    (folder.path / "cards.mtl").write_text(CARD_COLOURS)
    scene = str(folder.path / "cards.obj")
    look = ["--camera", CARD_CAMERA, *STEADY, "--renderer", "direct", "--aa", "1", "--size", "80x80"]
    exr = folder.exr(scene, "cards.exr", *look, "--aov", AOVS)

    def at(x, y, *names):
        return [exr.values(name)[80 * y + x] for name in names]

    def near(found, *expected):
        assert all(f == e or abs(f - e) < 1e-5 for f, e in zip(found, expected)), f"{found} is not {expected}"

    # Pixels in the middle of the near card, of what is seen of the far one beside it, and of nothing. A pixel is a
    # tenth of a unit wide at z = 0 and a fifth at z = -4.
    near(at(40, 40, "Z", "P.X", "P.Y", "P.Z"), 4, 0.05, -0.05, 0)
    near(at(40, 40, "N.X", "N.Y", "N.Z", "albedo.R", "albedo.G", "albedo.B"), 0, 0, 1, 0.75, 0.25, 0.125)
    near(at(58, 22, "Z", "P.X", "P.Y", "P.Z"), 8, 3.7, 3.5, -4)
    near(at(58, 22, "N.X", "N.Y", "N.Z", "albedo.R", "albedo.G", "albedo.B"), 0, math.sqrt(0.5), math.sqrt(0.5), 0.125, 0.25, 0.5)
    near(at(2, 2, "Z", "P.X", "N.Z", "albedo.R", "object", "material"), math.inf, 0, 0, 0, 0, 0)
    materials = [at(x, y, "material")[0] for x, y in ((40, 40), (58, 22))]
    assert len(set(materials)) == 2 and min(materials) >= 1, materials
    assert all(o >= 1 for o in (at(40, 40, "object")[0], at(58, 22, "object")[0]))
    assert set(exr.values("samples")) == {1.0}
    half = folder.exr(scene, "half.exr", *look, "--aov", AOVS, "--pixels", "half")
    assert all(half.channels[name][0] == picture_files.HALF for name in "RGB")
    assert all(half.bits(name) == exr.bits(name) for name in CHANNELS), "planes are floats, also beside half colour"
    assert all(abs(h - f) <= f / 1024 for name in "RGB" for h, f in zip(half.values(name), exr.values(name)))
    several = folder.exr(scene, "passes.exr", *look[:-4], "--size", "80x80", "--aa", "3", "--passes", "2", *ALL)
    assert set(several.values("samples")) == {6.0}, "samples of all passes"
    alpha = several.values("A")
    assert alpha[80 * 40 + 40] == 1 and alpha[80 * 2 + 2] == 0
    assert all(abs(6 * a - round(6 * a)) < 1e-5 for a in alpha), "shares of six samples"
    print("planes hold the depth, position, normal, colour and numbers of two cards")


def check_alpha_of_png(folder):
    look = [*SIZE, *STEADY, "--renderer", "direct", "--aa", "4"]
    clear = picture_files.Png(folder.render(folder.ball, "clear.png", *look, "--background", "transparent")[0])
    black = picture_files.Png(folder.render(folder.ball, "black.png", *look, "--background", "black")[0])
    assert clear.channels == 4 and black.channels == 3
    whole = part = 0
    for with_alpha, opaque in zip(clear.pixels, black.pixels):
        whole += with_alpha[3] == 255
        part += 0 < with_alpha[3] < 255
        if with_alpha[3] == 255:
            assert with_alpha[:3] == opaque, "a pixel that is covered has the code of the picture without alpha"
        elif with_alpha[3] == 0:
            assert with_alpha[:3] == (0, 0, 0)
        else:
            assert all(c >= o for c, o in zip(with_alpha, opaque)), "colour is not multiplied by alpha"
    assert clear.pixels[0][3] == 0 and whole > 500 and part > 50, f"{whole} pixels covered, {part} in part"
    print(f"a PNG has alpha: {whole} pixels covered, {part} in part")


def check_bits(folder, renderer):
    """The digest, which covers the planes, is the same on any cluster and instruction set and with any tiles."""
    options = [*SIZE, "--vpls", "8", "--aa", "2", *STEADY, *ALL]
    digests = {}
    for isa in ("scalar", "sse4", "avx2", "avx512"):
        try:
            _, digests[isa] = folder.render("builtin:room", f"isa-{isa}.exr", *options, "--renderer", renderer, "--isa", isa)
        except NoSuchIsa as lack:
            assert isa != "scalar", lack
            print(f"skipped: {lack}")
    for tile in ("7", "64"):
        _, digests[f"tiles of {tile}"] = folder.render("builtin:room", "tiles.exr", *options, "--renderer", renderer, "--tile", tile)
    for slaves in (1, 3):
        with cluster_lib.Cluster() as cluster:
            cluster.serve("--audit", "20")
            cluster.slaves(slaves)
            run = cluster.finish(cluster.start_render("builtin:room", *options, "--renderer", renderer,
                                                      output=str(folder.path / f"cluster-{slaves}.exr")))
            assert run.code == 0, run.stderr
            digests[f"slaves: {slaves}"] = run.digests
    print(renderer, {how: digest[0][:8] for how, digest in digests.items()})
    assert len({tuple(digest) for digest in digests.values()}) == 1, "the digests differ"
    first, last = (picture_files.Exr(folder.path / f"cluster-{slaves}.exr") for slaves in (1, 3))
    assert all(first.bits(name) == last.bits(name) for name in [*"RGBA", *CHANNELS])


PARTS = {
    "files": [check_values, check_colour_stays, check_alpha_of_png],
    "bits-direct": [lambda folder: check_bits(folder, "direct")],
    "bits-igi": [lambda folder: check_bits(folder, "igi")],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", choices=[*PARTS, "all"], default="all")
    parser.add_argument("--keep", metavar="FOLDER")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Folder(options.keep or temporary)
        for part, checks in PARTS.items():
            if options.part in (part, "all"):
                for check in checks:
                    check(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
