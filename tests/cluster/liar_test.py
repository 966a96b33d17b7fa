#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Slaves that lie: pixels that are not what they render, found by --audit; a scene that is not the one they were sent."""
import unittest

import cluster_lib

SLOW = ["--test-tile-sleep-ms", "5"]  # so that every slave gets tiles
LYING = [*SLOW, "--test-wrong-tile-every", "3"]
FRAME = ["--size", "128x96", "--tile", "16"]
SCENE = "builtin:cornell"


class Liars(unittest.TestCase):
    def expected(self, cluster, *options):
        return cluster.render(SCENE, *FRAME, *options, "--local", "1", connect=False).digests

    def outvoted(self, share, frames):
        with cluster_lib.Cluster() as cluster:
            expected = self.expected(cluster, *frames)
            cluster.serve("--audit", share)
            for name, options in (("honest-1", SLOW), ("honest-2", SLOW), ("liar", LYING)):
                cluster.slave(name, *options)
            cluster.wait_for_slaves(3)
            run = cluster.render(SCENE, *FRAME, *frames)
            status = cluster.status()
            self.assertEqual({s["name"] for s in status["slaves"]}, {"honest-1", "honest-2"})
            self.assertEqual([q["name"] for q in status["quarantined"]], ["liar"])
            self.assertIn("audit", status["quarantined"][0]["reason"])
            print(f"--audit {share}: {status['quarantined'][0]['reason']}")
            return [a == b for a, b in zip(run.digests, expected)]

    def test_of_three_the_third_decides_and_no_pixel_is_wrong(self):
        self.assertEqual(self.outvoted("100", []), [True])

    def test_a_sample_finds_the_liar_too_and_from_then_on_pictures_are_right(self):
        # Of 8 frames of 48 tiles the liar renders a third, lies in a third of those, and a fifth is compared: that none
        # of 42 lies is, has a chance of 1e-4; the pictures before may be wrong, the last cannot.
        right = self.outvoted("20", ["--frames", "0:7"])
        print(f"frames right: {right}")
        self.assertTrue(right[-1])

    def test_of_two_nobody_decides_and_the_frame_fails_with_both_names(self):
        with cluster_lib.Cluster() as cluster:
            cluster.serve("--audit", "100")
            cluster.slave("honest", *SLOW)
            cluster.slave("liar", *LYING)
            cluster.wait_for_slaves(2)
            run = cluster.finish(cluster.start_render(SCENE, *FRAME))
            print(run.stderr.strip())
            self.assertEqual(run.code, 1)
            self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
            self.assertIn("'honest'", run.stderr)
            self.assertIn("'liar'", run.stderr)
            self.assertEqual(run.digests, [])
            self.assertEqual(len(cluster.status()["slaves"]), 2, "neither is known to be wrong")

    def test_a_slave_with_another_scene_gets_no_tiles(self):
        with cluster_lib.Cluster() as cluster:
            expected = self.expected(cluster)
            cluster.serve()
            cluster.slave("honest", *SLOW)
            cluster.slave("liar", *SLOW, "--test-wrong-scene")
            cluster.wait_for_slaves(2)
            self.assertEqual(cluster.render(SCENE, *FRAME).digests, expected)
            liar = cluster.slave_status("liar")
            self.assertEqual((liar["tiles_issued"], liar["tiles_done"]), (0, 0))
            lines = [line for line in (cluster.folder / "master.log").read_text().splitlines() if "scene-differs" in line]
            self.assertEqual(len(lines), 1, lines)
            self.assertIn("'liar'", lines[0])
            cluster.end("honest")
            run = cluster.finish(cluster.start_render(SCENE, *FRAME))
            self.assertEqual(run.code, 1, "nobody is left who has the scene")
            self.assertIn("another scene", run.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
