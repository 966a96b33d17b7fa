#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Slaves die, hang, leave or join while frames are rendered, and every picture stays the same, to the bit."""
import os
import signal
import time
import unittest

import cluster_lib

# Tiles sleep, so that a frame is certainly under way when something is done to it.
SLOW = ["--test-tile-sleep-ms", "40"]
FRAME = ["--size", "256x192", "--tile", "16"]
SCENE = "builtin:cornell"


class SlaveFaults(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(self.end_cluster)
        self.cluster.serve()

    def end_cluster(self):
        self.cluster.__exit__(None if self._outcome.success else AssertionError, None, None)

    def expected(self, *options):
        return self.cluster.render(SCENE, *FRAME, *options, "--local", "1", connect=False).digests

    def wait_until_it_holds_tiles(self, name):
        held = cluster_lib.wait_until(f"{name} with tiles", lambda: (self.cluster.slave_status(name) or {}).get("tiles_in_flight"))
        print(f"{name} holds {held} tiles")
        return held

    def start_with_two(self):
        """Starts to render without an end on two slaves, the second of which holds tiles when this returns."""
        expected = self.expected()
        self.cluster.slaves(2, *SLOW)
        render = self.cluster.start_endless(SCENE, *FRAME)
        self.wait_until_it_holds_tiles("slave-2")
        return expected, render

    def stand_still(self, pid, seconds):
        os.kill(pid, signal.SIGSTOP)
        time.sleep(seconds)
        os.kill(pid, signal.SIGCONT)

    def finish(self, render, expected):
        run = self.cluster.finish(render)
        self.assertEqual(run.code, 0, run.stderr)
        self.assertEqual(run.digests, expected)
        return run

    def stop(self, render, expected):
        """Stops after the frame in work and one more. Each must be the same still picture."""
        self.cluster.wait_for_frames(2, render)
        run = self.cluster.stop_render(render)
        self.assertEqual(set(run.digests), set(expected))
        return run

    def test_a_slave_killed_in_mid_frame_costs_no_pixel(self):
        expected, render = self.start_with_two()
        self.cluster.processes["slave-2"].kill()
        run = self.stop(render, expected)
        self.assertGreater(sum(line["tiles_reissued"] for line in run.stats), 0)
        self.assertIsNone(self.cluster.slave_status("slave-2"))

    def test_a_slave_asked_to_end_in_mid_frame_costs_no_pixel(self):
        expected, render = self.start_with_two()
        self.cluster.end("slave-2")
        self.stop(render, expected)

    def test_a_slave_that_hangs_is_left_behind_and_comes_back(self):
        expected, render = self.start_with_two()
        os.kill(self.cluster.processes["slave-2"].pid, signal.SIGSTOP)
        self.stop(render, expected)
        os.kill(self.cluster.processes["slave-2"].pid, signal.SIGCONT)
        self.cluster.wait_for_slaves(2)
        self.assertEqual(self.cluster.render(SCENE, *FRAME).digests, expected)

    def test_the_only_slave_dies_and_the_next_one_ends_the_frame(self):
        expected = self.expected()
        self.cluster.slaves(1, *SLOW)
        render = self.cluster.start_render(SCENE, *FRAME)
        self.wait_until_it_holds_tiles("slave-1")
        self.cluster.processes["slave-1"].kill()
        self.cluster.processes["slave-1"].wait()
        self.cluster.slave("slave-9")
        self.finish(render, expected)

    def test_a_slave_joins_in_mid_sequence(self):
        scene = "builtin:waves"
        self.cluster.slaves(1, *SLOW)
        render = self.cluster.start_endless(scene, *FRAME)
        self.cluster.wait_for_frames(1, render)
        self.cluster.slave("slave-2", *SLOW)
        cluster_lib.wait_until("it draws", lambda: (self.cluster.slave_status("slave-2") or {}).get("tiles_done"))
        self.cluster.wait_for_frames(1, render)
        run = self.cluster.stop_render(render)
        self.assertEqual(run.stats[0]["slaves"], 1)
        frames = len(run.digests)
        self.assertGreater(frames, 1)
        expected = self.cluster.render(scene, *FRAME, "--frames", f"0:{frames - 1}", "--local", "1", connect=False).digests
        self.assertEqual(run.digests, expected)

    def test_a_master_that_stands_still_for_a_while_loses_no_picture(self):
        expected, render = self.start_with_two()
        self.stand_still(self.cluster.processes["master"].pid, 3)
        self.stop(render, expected)

    def test_an_application_that_stands_still_for_a_while_loses_no_picture(self):
        expected, render = self.start_with_two()
        self.stand_still(render.pid, 10)
        self.stop(render, expected)

    def test_an_application_that_is_killed_frees_the_cluster_for_the_next(self):
        expected = self.expected()
        self.cluster.slaves(1, *SLOW)
        first = self.cluster.start_render(SCENE, *FRAME)
        self.wait_until_it_holds_tiles("slave-1")
        first.kill()
        first.communicate()
        cluster_lib.wait_until("without an application", lambda: not self.cluster.status()["has_application"])
        self.assertEqual(self.cluster.render(SCENE, *FRAME).digests, expected)

    def test_a_second_application_is_told_that_the_cluster_is_busy(self):
        self.cluster.slaves(1, *SLOW)
        first = self.cluster.start_endless(SCENE, *FRAME)
        self.wait_until_it_holds_tiles("slave-1")
        second = self.cluster.finish(self.cluster.start_render(SCENE, *FRAME))
        self.assertEqual(second.code, 1)
        self.assertIn("busy", second.stderr)
        self.assertEqual(len(second.stderr.splitlines()), 1, second.stderr)
        self.cluster.wait_for_frames(2, first)
        self.cluster.stop_render(first)


if __name__ == "__main__":
    cluster_lib.main()
