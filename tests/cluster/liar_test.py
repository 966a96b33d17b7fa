#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""--audit finds slaves that send other pixels than they render; slaves that built another scene get no tiles."""
import unittest

import cluster_lib

SLOW = ["--test-tile-sleep-ms", "5"]  # so that every slave gets tiles
LYING = [*SLOW, "--test-wrong-tile-every", "3"]
FRAME = ["--size", "128x96", "--tile", "16"]
SCENE = "builtin:cornell"


class Liars(unittest.TestCase):
    def expected(self, cluster):
        """Returns the digest of each frame, since all show one still picture."""
        return cluster.render(SCENE, *FRAME, "--local", "1", connect=False).digests[0]

    def outvoted(self, share=None, lying=LYING):
        """Renders until the liar is out, and three frames more, since two may have been in flight. Returns: whether
        each is right."""
        with cluster_lib.Cluster() as cluster:
            expected = self.expected(cluster)
            cluster.serve(*([] if share is None else ["--audit", share]))
            for name, options in (("honest-1", SLOW), ("honest-2", SLOW), ("liar", lying)):
                cluster.slave(name, *options)
            cluster.wait_for_slaves(3)
            render = cluster.start_endless(SCENE, *FRAME)
            cluster_lib.wait_until("somebody is out", lambda: cluster.status()["quarantined"])
            cluster.wait_for_frames(3, render)
            status = cluster.status()
            run = cluster.stop_render(render)
            self.assertEqual({s["name"] for s in status["slaves"]}, {"honest-1", "honest-2"})
            self.assertEqual([q["name"] for q in status["quarantined"]], ["liar"])
            self.assertIn("audit", status["quarantined"][0]["reason"])
            self.assertRegex(status["quarantined"][0]["reason"], r"; frames with tiles of it: [0-9]+")
            print(f"--audit {share}: {status['quarantined'][0]['reason']}")
            return [digest == expected for digest in run.digests]

    def test_of_three_the_third_decides_and_no_pixel_is_wrong(self):
        right = self.outvoted("100")
        self.assertEqual(right, [True] * len(right))

    def test_a_sample_finds_the_liar_too_and_from_then_on_pictures_are_right(self):
        # Of 48 tiles a frame the liar renders a third, lies in a third of those, and a fifth is compared, so that it is
        # found within some frames. The pictures before may be wrong, the last cannot.
        right = self.outvoted("20")
        print(f"frames right: {right}")
        self.assertTrue(right[-1])

    def test_nobody_has_to_ask_for_audits_of_three_certificates(self):
        # One tile in a hundred is compared, and the liar lies in each of its own.
        self.assertTrue(self.outvoted(lying=[*SLOW, "--test-wrong-tile-every", "1"])[-1])

    def test_of_two_nobody_decides_and_the_frame_fails_with_both_names(self):
        with cluster_lib.Cluster() as cluster:
            expected = self.expected(cluster)
            cluster.serve("--audit", "100")
            cluster.slave("honest", *SLOW)
            cluster.slave("liar", *LYING)
            cluster.wait_for_slaves(2)
            run = cluster.finish(cluster.start_render(SCENE, *FRAME, "--frames", "0:3"))
            print(run.stderr.strip())
            self.assertEqual(run.code, 3)
            self.assertIn("'honest'", run.stderr)
            self.assertIn("'liar'", run.stderr)
            self.assertEqual(set(run.digests) - {expected}, set(), "what the liar had no part in")
            self.assertEqual(len(cluster.status()["slaves"]), 2, "neither is known to be wrong")

    def test_a_slave_with_another_scene_gets_no_tiles(self):
        with cluster_lib.Cluster() as cluster:
            expected = self.expected(cluster)
            cluster.serve()
            cluster.slave("honest", *SLOW)
            cluster.slave("liar", *SLOW, "--test-wrong-scene")
            cluster.wait_for_slaves(2)
            self.assertEqual(cluster.render(SCENE, *FRAME).digests, [expected])
            liar = cluster.slave_status("liar")
            self.assertEqual((liar["tiles_issued"], liar["tiles_done"]), (0, 0))
            lines = [line for line in (cluster.folder / "master.log").read_text().splitlines() if "scene-differs" in line]
            self.assertEqual(len(lines), 1, lines)
            self.assertIn("'liar'", lines[0])
            cluster.end("honest")
            run = cluster.finish(cluster.start_render(SCENE, *FRAME))
            self.assertEqual(run.code, 3, "nobody is left who has the scene")
            self.assertIn("another scene", run.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
