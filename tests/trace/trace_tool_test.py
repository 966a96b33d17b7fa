#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks tessera-trace, used as a person does, against rational arithmetic, which knows no rounding.

A ray hits a triangle if it meets the closed triangle at tmin <= t <= tmax. Rays are aimed at random
points, corners and edges; scenes lie at every scale. Reported t may be off by 4 roundings of float32,
and so may limits.
"""
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import unittest
from fractions import Fraction

TOOL = sys.argv.pop(1)
ROUNDINGS = Fraction(4, 2**24)


def f32(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def sub(p, q):
    return [a - b for a, b in zip(p, q)]


def cross(p, q):
    return [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]


def dot(p, q):
    return sum(a * b for a, b in zip(p, q))


def exact_t(ray, triangle):
    """Returns t, u, v where the line of the ray meets the closed triangle, else None."""
    o, d = [Fraction(x) for x in ray[:3]], [Fraction(x) for x in ray[3:6]]
    a, b, c = ([Fraction(x) for x in p] for p in triangle)
    e1, e2 = sub(b, a), sub(c, a)
    p = cross(d, e2)
    volume = dot(e1, p)
    if volume == 0:
        return None
    s = sub(o, a)
    u, q = dot(s, p) / volume, cross(s, e1)
    v = dot(d, q) / volume
    if u < 0 or v < 0 or u + v > 1:
        return None
    return dot(e2, q) / volume, u, v


def run(*arguments):
    return subprocess.run([TOOL, *map(str, arguments)], capture_output=True, text=True, timeout=120)


class TraceTool(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write_scene(self, triangles):
        path = self.folder / "scene.obj"
        with path.open("w") as out:
            for triangle in triangles:
                for p in triangle:
                    out.write("v %.9g %.9g %.9g\n" % tuple(p))
            for i in range(len(triangles)):
                out.write("f %d %d %d\n" % (3 * i + 1, 3 * i + 2, 3 * i + 3))
        return path

    def write_rays(self, rays):
        path = self.folder / "rays.f32"
        path.write_bytes(b"".join(struct.pack("<8f", *ray) for ray in rays))
        return path

    def hits(self, scene, rays, *options):
        path = self.folder / "hits.bin"
        result = run(scene, rays, path, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return list(struct.iter_unpack("<IfI5f", path.read_bytes()))

    def judge(self, ray, triangles, hit):
        is_hit, t, primitive, u, v, *normal = hit
        tmin, tmax = Fraction(ray[6]), ray[7]
        for i, triangle in enumerate(triangles):
            exact = exact_t(ray, triangle)
            if exact is None:
                self.assertFalse(is_hit and primitive == i, "hits what it misses")
                continue
            slack = abs(exact[0]) * ROUNDINGS
            if is_hit and primitive == i:
                self.assertLessEqual(abs(Fraction(t) - exact[0]), slack)
                self.assertLess(max(abs(u - exact[1]), abs(v - exact[2])), 1e-6)
                self.assertTrue(0 <= u <= 1 and 0 <= v and u + v <= 1 + 1e-7)
                self.assertTrue(ray[6] <= t <= ray[7])
                n = cross(sub(triangle[1], triangle[0]), sub(triangle[2], triangle[0]))
                size = max(map(abs, n))
                if size > 0:
                    self.assertGreater(dot([x / size for x in n], normal), 0)
            inside = exact[0] - slack >= tmin and (tmax == float("inf") or exact[0] + slack <= Fraction(tmax))
            if inside:
                self.assertTrue(is_hit, "misses triangle %d" % i)
                self.assertGreaterEqual(exact[0] + slack + abs(Fraction(t)) * ROUNDINGS, Fraction(t))

    def make(self, rng, scale, offset, count=40, aspect=1.0):
        point = lambda r=1.0: [rng.uniform(-r, r) for _ in range(3)]
        triangles = []
        for i in range(count):
            a = point()
            edges = [point(0.5), point(0.5)]
            if i % 4 == 0:
                edges[1] = [x + aspect * y for x, y in zip(edges[0], point(0.1))]
            corners = [a] + [[p + q for p, q in zip(a, e)] for e in edges]
            triangles.append([[f32(x * scale + o) for x, o in zip(p, offset)] for p in corners])
        return triangles

    def aim(self, rng, triangles, scale, offset, count=256):
        rays = []
        for i in range(count):
            origin = [f32(rng.uniform(-2, 2) * scale + o) for o in offset] if i % 64 < 32 or i == 0 else rays[-1][:3]
            a, b, c = rng.choice(triangles)
            kind = rng.randrange(4)
            u, v = rng.random(), rng.random()
            target = {0: a, 1: [(x + y) / 2 for x, y in zip(a, b)],
                      2: [x + u * (y - x) for x, y in zip(b, c)],
                      3: [x + u * 0.5 * (y - x) + v * 0.5 * (z - x) for x, y, z in zip(a, b, c)]}[kind]
            direction = [f32(t - o) for t, o in zip(target, origin)]
            if rng.randrange(16) == 0:
                direction[rng.randrange(3)] = rng.choice([0.0, -0.0, 1e-42])
            if not any(direction):
                direction[0] = 1.0
            limits = rng.choice([(0, float("inf")), (0.5, 1.5), (0, 0.75)])
            rays.append((*origin, *direction, *map(f32, limits)))
        return rays

    def test_every_scale_agrees_with_rational_arithmetic(self):
        for scale, offset in [(1, [0] * 3), (1e-6, [0] * 3), (1e6, [0] * 3), (1, [1e4, -2e4, 3e4]),
                              (1e-20, [0] * 3), (1e15, [0] * 3)]:
            with self.subTest(scale=scale, offset=offset):
                rng = random.Random(42)
                triangles = self.make(rng, scale, offset, aspect=1e-5)
                rays = self.aim(rng, triangles, scale, offset)
                scene, file = self.write_scene(triangles), self.write_rays(rays)
                hits = self.hits(scene, file)
                self.assertGreater(sum(h[0] for h in hits), len(rays) // 4)
                for ray, hit in zip(rays, hits):
                    self.judge(ray, triangles, hit)
                for structure in ("kd", "kd-quality", "bvh-quality"):
                    self.assertEqual(self.hits(scene, file, "--structure", structure), hits)

    def test_answers_do_not_depend_on_bundles_threads_or_instruction_sets(self):
        rng = random.Random(7)
        triangles = self.make(rng, 1, [0] * 3, count=400)
        rays = self.aim(rng, triangles, 1, [0] * 3, count=20000)
        scene, file = self.write_scene(triangles), self.write_rays(rays)
        first = self.hits(scene, file)
        for options in (["--bundle", 1], ["--bundle", 4], ["--bundle", 16], ["--threads", 3],
                        ["--structure", "kd"], ["--structure", "bvh"], ["--structure", "kd", "--bundle", 1],
                        ["--isa", "scalar"], ["--isa", "sse4"]):
            self.assertEqual(self.hits(scene, file, *options), first, options)
        anything = self.hits(scene, file, "--any")
        self.assertEqual([h[0] for h in anything], [h[0] for h in first])
        self.assertTrue(all(not any(h[1:]) for h in anything))

    def test_text_in_and_out(self):
        scene = self.folder / "quad.obj"
        scene.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf -1 -1 -1\n")
        rays = self.folder / "rays.csv"
        nan_ray = "nan,0,0,0,0,1,0,inf"
        body = ["0.25,0.5,1,0,0,-2,0,inf", "0.75,0.5,1,0,0,-1,0,0.5", "0.5,0.25,-3,0,0,1,0,3", nan_ray]
        for head in ([], ["ox,oy,oz,dx,dy,dz,tmin,tmax"]):
            rays.write_text("\n".join(head + body))
            result = run(scene, rays, self.folder / "hits.csv")
            self.assertEqual(result.returncode, 0)
            self.assertIn("1 degenerate", result.stderr)
            lines = (self.folder / "hits.csv").read_text().split("\n")
            self.assertEqual(lines[0], "ray,hit,t,prim,u,v,ngx,ngy,ngz")
            self.assertEqual(lines[1:], ["0,1,0.5,1,0.25,0.25,0,0,1", "1,0,,,,,,,", "2,1,3,0,0.25,0.25,0,0,1",
                                         "3,0,,,,,,,", ""])

    def test_patches_are_hit_where_their_surface_is(self):
        # z = x^2 + y^2 over [0, 1]^2 and, beside it, with a weight at every point, over [2, 3] x [0, 1].
        square = [0, 0, 1]
        lines = ["2"]
        for shift, weight in ((0, ""), (2, " 2")):
            lines += ["2 2"] + [f"{shift + i / 2} {j / 2} {square[i] + square[j]}{weight}"
                                for i in range(3) for j in range(3)]
        scene = self.folder / "scene.bpt"
        scene.write_text("# paraboloids\n" + "\n".join(lines) + "\n")
        rng = random.Random(3)
        places = [(rng.uniform(-0.5, 3.5), rng.uniform(-0.5, 1.5)) for _ in range(2000)]
        rays = [(f32(x), f32(y), 4, 0, 0, -2, 0, float("inf")) for x, y in places]
        hits = self.hits(scene, self.write_rays(rays))
        self.assertGreater(sum(h[0] for h in hits), 400)
        for (x, y, *_), (is_hit, t, patch, u, v, *normal) in zip(rays, hits):
            inside = 0 <= y <= 1 and (0 <= x <= 1 or 2 <= x <= 3)
            self.assertEqual(is_hit, inside, (x, y))
            if not inside:
                continue
            exact_u = x - 2 * (x >= 2)
            self.assertEqual(patch, int(x >= 2))
            self.assertLess(max(abs(u - exact_u), abs(v - y)), 1e-6)
            self.assertLess(abs(t - (4 - exact_u**2 - y**2) / 2), 1e-6)
            size = max(map(abs, normal))
            self.assertLess(max(abs(a / normal[2] - b) for a, b in zip(normal, (-2 * exact_u, -2 * y, 1))), 1e-5 * size)
            self.assertGreater(normal[2], 0)

    def test_wrong_use_says_what_is_wrong(self):
        scene = self.write_scene([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
        rays = self.write_rays([(0, 0, 1, 0, 0, -1, 0, 9)])
        out = self.folder / "hits"
        (self.folder / "bad.csv").write_text("0,0,1,0,0,-1,0,1\n0,0,x,0,0,1,0,1\n")
        (self.folder / "short.csv").write_text("0,0,1,0,0,-1,0\n")
        (self.folder / "odd.f32").write_bytes(bytes(33))
        (self.folder / "nan.obj").write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        (self.folder / "degree.bpt").write_text("1\n0 3\n")
        (self.folder / "empty.bpt").write_text("")
        (self.folder / "index.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n")
        for arguments, code, words in [
                ([scene, rays], 2, "HITS"), ([scene, rays, out, "--bundle", "5"], 2, "--bundle"),
                ([self.folder / "no.obj", rays, out], 1, "No such file"),
                ([scene, self.folder / "no.f32", out], 1, "No such file"),
                ([scene, self.folder / "bad.csv", out], 1, "line 2"),
                ([scene, self.folder / "short.csv", out], 1, "needs 8 numbers"),
                ([scene, self.folder / "odd.f32", out], 1, "whole number of rays"),
                ([self.folder / "nan.obj", rays, out], 1, "vertex 1"),
                ([self.folder / "index.obj", rays, out], 1, ":4: vertex 4"),
                ([self.folder / "degree.bpt", rays, out], 1, "degree.bpt:2: patch 0: degrees must lie in 1 to 15"),
                ([self.folder / "empty.bpt", rays, out], 1, "empty.bpt: no patches"),
                ([rays, rays, out], 1, "none of .obj, .ply, .bpt"),
                ([scene, rays, self.folder / "no" / "hits"], 1, "cannot be written")]:
            result = run(*arguments)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn(words, result.stderr)
            self.assertFalse(out.exists())
            self.assertEqual([p for p in self.folder.iterdir() if p.name.endswith(".part")], [])


if __name__ == "__main__":
    unittest.main()
