#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`--stats` says what scenes cost, and what has not changed costs nothing: nothing is built twice."""
import json
import subprocess
import unittest

import cluster_lib

FRAME = ["--size", "96x64", "--renderer", "direct", "--quiet"]


class SceneCosts(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(self.cluster.__exit__, None, None, None)

    def render(self, *options):
        path = self.cluster.folder / "stats.jsonl"
        subprocess.run([cluster_lib.program("tessera-master"), "render", *options, *FRAME, "--stats", path,
                        "-o", str(self.cluster.folder / "p-%04d.exr")], check=True, timeout=cluster_lib.PATIENCE_S)
        return [json.loads(line) for line in path.read_text().splitlines()]

    def test_a_moving_light_builds_nothing_again(self):
        for in_flight in ("1", "2"):
            frames = self.render("builtin:evening", "--frames", "0:23", "--frames-in-flight", in_flight)
            built = [f["built_primitives"] for f in frames]
            print(f"{in_flight} in flight: {built}")
            self.assertEqual(built, [268246] + 23 * [0])

    def test_what_travels_and_waits_between_frames_is_counted(self):
        frames = self.render("builtin:waves", "--frames", "0:7", "--frames-in-flight", "1")
        carried = sum(f["scene_bytes"] for f in frames)
        waited = sum(f["scene_wait_seconds"] for f in frames)
        worked = sum(f["seconds"] for f in frames)
        print(f"{carried} bytes of scenes, waited {waited:.3f} s for them, worked {worked:.3f} s, ended after "
              f"{frames[-1]['completed_at']:.3f} s")
        # Each version is a new mesh of 66,049 vertices, whose positions travel, and whose normals do not.
        positions = 8 * 257 * 257 * 12
        self.assertGreater(carried, positions // 16)
        self.assertLess(carried - frames[0]["scene_bytes"], positions)
        # With one frame in flight, a frame waits for everything that is built.
        self.assertGreater(waited, 0)
        self.assertEqual(sum(f["built_primitives"] for f in frames), 8 * 151808)
        self.assertLessEqual(waited + worked, frames[-1]["completed_at"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
