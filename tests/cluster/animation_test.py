#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An animated glTF file: frames follow their times, travel as their times alone, and are the same bits on any cluster."""
import base64
import functools
import json
import os
import pathlib
import struct
import subprocess
import unittest

import cluster_lib

SHARED = pathlib.Path(__file__).parents[3] / "shared/scenes/gltf"  # files of others, where they are
SIZE = ["--size", "120x90", "--renderer", "direct", "--aa", "1", "--light", "studio", "--exposure", "0"]
CAMERA = ["--camera", "1,1,6 0,-0.7,0 0,1,0 40"]  # the usual one sees what moves
NO_ISA = "this CPU does not have"  # what a master says of an instruction set
SIDE = 60  # the sheet has 2 * SIDE^2 triangles, so that its vertices are far more than a frame's bytes


def gltf(path_of_file, camera=()):
    """A sheet on two joints, of which one swings, and a second one that morphs. `camera`: where one is along x at each key of
    the first animation; of one place only: where it stands."""
    data = b""
    doc = {"asset": {"version": "2.0"}, "scene": 0, "buffers": [], "bufferViews": [], "accessors": [], "meshes": [],
           "nodes": [], "skins": [], "animations": []}

    def accessor(rows, shape, code, component):
        nonlocal data
        data += b"\0" * (-len(data) % 4)
        packed = b"".join(struct.pack(f"<{len(row)}{code}", *row) for row in rows)
        doc["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        data += packed
        entry = {"bufferView": len(doc["bufferViews"]) - 1, "componentType": component, "count": len(rows), "type": shape}
        if shape == "VEC3":
            entry.update(min=[min(r[i] for r in rows) for i in range(3)], max=[max(r[i] for r in rows) for i in range(3)])
        doc["accessors"].append(entry)
        return len(doc["accessors"]) - 1

    grid = [(i / SIDE, j / SIDE) for j in range(SIDE + 1) for i in range(SIDE + 1)]
    positions = accessor([(2 * u - 1, 2 * v - 1, 0.0) for u, v in grid], "VEC3", "f", 5126)
    target = accessor([(0.0, 0.0, u * v) for u, v in grid], "VEC3", "f", 5126)
    joints = accessor([(0, 1, 0, 0)] * len(grid), "VEC4", "B", 5121)
    weights = accessor([(1 - u, u, 0.0, 0.0) for u, v in grid], "VEC4", "f", 5126)
    at = lambda i, j: j * (SIDE + 1) + i
    corners = [k for j in range(SIDE) for i in range(SIDE)
               for k in (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))]
    indices = accessor([(k,) for k in corners], "SCALAR", "H", 5123)
    doc["meshes"] = [
        {"primitives": [{"attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights},
                         "indices": indices}]},
        {"primitives": [{"attributes": {"POSITION": positions}, "indices": indices,
                         "targets": [{"POSITION": target}]}]}]
    doc["nodes"] = [{"name": "still"}, {"name": "swings"}, {"mesh": 0, "skin": 0}, {"mesh": 1, "translation": [0, -1.5, 0]}]
    doc["skins"] = [{"joints": [0, 1]}]
    doc["scenes"] = [{"nodes": [0, 1, 2, 3]}]
    times = accessor([(0.0,), (0.5,), (1.0,)], "SCALAR", "f", 5126)
    turns = accessor([(0, 0, 0, 1.0), (0, 0.6, 0, 0.8), (0, 0, 0, 1.0)], "VEC4", "f", 5126)
    bends = accessor([(0.0,), (1.0,), (-1.0,)], "SCALAR", "f", 5126)
    doc["animations"] = [
        {"name": name, "samplers": [{"input": times, "output": output}],
         "channels": [{"sampler": 0, "target": {"node": node, "path": path}}]}
        for name, output, node, path in [("swing", turns, 1, "rotation"), ("bend", bends, 3, "weights")]]
    if camera:
        doc["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]
        doc["nodes"].append({"camera": 0, "translation": [camera[0], -0.7, 6]})
        doc["scenes"][0]["nodes"].append(4)
    if len(camera) > 1:
        places = accessor([(x, -0.7, 6.0) for x in camera], "VEC3", "f", 5126)
        doc["animations"][0]["samplers"].append({"input": times, "output": places})
        doc["animations"][0]["channels"].append({"sampler": 1, "target": {"node": 4, "path": "translation"}})
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    doc["buffers"] = [{"byteLength": len(data), "uri": uri}]
    pathlib.Path(path_of_file).write_text(json.dumps(doc))


class Animation(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(self.cluster.__exit__, None, None, None)
        self.file = str(self.cluster.folder / "moves.gltf")
        gltf(self.file)

    def alone(self, scene, *options, code=0):
        path = self.cluster.folder / "stats.jsonl"
        run = subprocess.run([cluster_lib.program("tessera-master"), "render", scene, *options, *SIZE, "--stats", path,
                              "-o", str(self.cluster.folder / "p-%04d.exr")], capture_output=True, text=True,
                             timeout=cluster_lib.PATIENCE_S)
        self.assertEqual(run.returncode, code, run.stderr)
        return run.stderr, [json.loads(line) for line in path.read_text().splitlines()] if code == 0 else []

    def test_frames_follow_their_times(self):
        told, frames = self.alone(self.file, "--frames", "0:24", "--fps", "24", *CAMERA)
        digests = [f["digest"] for f in frames]
        self.assertIn("animation 'swing', 1 s; others: 'bend'", told)
        self.assertGreater(len(set(digests)), 10)
        self.assertEqual(digests[0], digests[24])  # it swings back
        _, bent = self.alone(self.file, "--frames", "0:12", "--animation", "bend", *CAMERA)
        _, both = self.alone(self.file, "--frames", "0:12", "--animation", "all", *CAMERA)
        self.assertEqual(len({frames[6]["digest"], bent[6]["digest"], both[6]["digest"]}), 3)
        _, rest = self.alone(self.file, "--frames", "0:2", "--animation", "none", *CAMERA)
        self.assertEqual(len({f["digest"] for f in rest} | {digests[0]}), 1)
        told, _ = self.alone(self.file, "--animation", "swim", code=1)
        self.assertIn("--animation swim: the scene has 'swing', 'bend'; or say all, or none", told)

    def test_a_frame_travels_as_its_time(self):
        self.cluster.serve()
        self.cluster.slaves(1)
        run = self.cluster.render(self.file, "--frames", "0:9", *SIZE)
        carried = [f["scene_bytes"] for f in run.stats]
        print(f"{carried} bytes of scenes")
        self.assertGreater(carried[0], 40_000)
        # The last frames may still be sent beside those before; each has its share by then.
        self.assertLessEqual(sum(carried[1:]), 1024 * len(carried[1:]))

    @functools.cached_property
    def scenes(self):
        """The file made here, and those of others that are here."""
        others = [str(SHARED / name) for name in ("Fox.glb", "AnimatedMorphCube/AnimatedMorphCube.gltf")]
        there = [scene for scene in others if os.path.exists(scene)]
        print(f"{len(there)} of {len(others)} files of others are here")
        return [self.file] + there

    def test_every_instruction_set_makes_the_same_bits(self):
        for scene in self.scenes:
            found = {}
            for isa in ("scalar", "sse4", "avx2", "avx512"):
                path = self.cluster.folder / f"{isa}.jsonl"
                run = subprocess.run([cluster_lib.program("tessera-master"), "render", scene, "--frames", "0:5", "--fps", "7", "--isa", isa,
                                      *SIZE, "--stats", path, "-o", str(self.cluster.folder / "p-%04d.exr")],
                                     capture_output=True, text=True, timeout=cluster_lib.PATIENCE_S)
                if run.returncode != 0 and NO_ISA in run.stderr:
                    continue
                self.assertEqual(run.returncode, 0, run.stderr)
                frames = [json.loads(line) for line in path.read_text().splitlines()]
                self.assertEqual({frame["isa"] for frame in frames}, {isa})
                found[isa] = [frame["digest"] for frame in frames]
            print(f"{pathlib.Path(scene).name}: {', '.join(found)}")
            self.assertEqual(len(set(map(tuple, found.values()))), 1, found)
            self.assertGreater(len(set(found["scalar"])), 3, scene)

    def test_a_camera_that_moves_is_followed(self):
        places = [0.0, 1.0, 2.0]
        gltf(self.file, camera=places)
        moving = [f["digest"] for f in self.alone(self.file, "--frames", "0:2", "--fps", "2")[1]]
        self.assertEqual(len(set(moving)), 3)
        for frame, x in enumerate(places):
            gltf(self.file, camera=[x])
            still = self.alone(self.file, "--frames", f"{frame}:{frame}", "--fps", "2")[1]
            self.assertEqual([f["digest"] for f in still], [moving[frame]], frame)

    def test_any_cluster_makes_the_same_bits(self):
        expected = [[f["digest"] for f in self.alone(scene, "--frames", "0:5", "--fps", "7")[1]] for scene in self.scenes]
        self.cluster.serve()
        self.cluster.slaves(3)
        for scene, digests in zip(self.scenes, expected):
            run = self.cluster.render(scene, "--frames", "0:5", "--fps", "7", *SIZE)
            self.assertEqual(run.digests, digests, scene)
            self.assertGreater(len(set(digests)), 3, scene)


if __name__ == "__main__":
    cluster_lib.main()
