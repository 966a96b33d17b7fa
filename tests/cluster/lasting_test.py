#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An application outlives its master's deaths and pauses, and its own: each frame comes, once, with its bits."""
import os
import signal
import sys
import time
import unittest

import cluster_lib

SLOW = ["--test-tile-sleep-ms", "5"]
FRAME = ["--size", "256x192", "--tile", "16"]
SCENE = "builtin:waves"  # each frame is another picture of another scene
LAST = 39


class Lasting(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(lambda: self.cluster.__exit__(None if self._outcome.success else AssertionError, None, None))
        self.master = self.cluster.serve("--heartbeat", "200", "--heartbeats-missed", "5")

    def wait_for_lines(self, render, count):
        def done():
            assert render.poll() is None, f"it has ended: {render.communicate()[1]}"
            stats = render.tessera[1]
            return stats.exists() and len(stats.read_text().splitlines()) >= count
        cluster_lib.wait_until(f"{count} frames", done)

    def start_master_again(self):
        self.master.kill()
        self.master.wait()
        del self.cluster.processes["master"]
        time.sleep(0.5)  # somebody has to notice first
        self.master = self.cluster.start("master", [
            cluster_lib.program("tessera-master"), "serve", "--listen", self.cluster.address, "--keys",
            str(self.cluster.keys / "master")])

    @staticmethod
    def stand_still(pid, seconds):
        os.kill(pid, signal.SIGSTOP)
        time.sleep(seconds)
        os.kill(pid, signal.SIGCONT)

    def test_forty_frames_through_two_deaths_and_two_pauses(self):
        frames = ["--frames", f"0:{LAST}"]
        expected = self.cluster.render(SCENE, *FRAME, *frames, "--local", "1", connect=False).digests
        self.cluster.slaves(2, *SLOW)
        render = self.cluster.start_render(SCENE, *FRAME, *frames)
        self.wait_for_lines(render, 4)
        self.start_master_again()
        self.wait_for_lines(render, 12)
        self.stand_still(self.master.pid, 3)
        self.wait_for_lines(render, 18)
        self.stand_still(render.pid, 10)
        self.wait_for_lines(render, 24)
        self.start_master_again()
        run = self.cluster.finish(render)
        self.assertEqual(run.code, 0, run.stderr)
        self.assertEqual(run.digests, expected)
        self.assertEqual(len(run.digests), LAST + 1)

    def test_a_master_that_is_asked_to_end_is_waited_for(self):
        frames = ["--frames", "0:5"]
        expected = self.cluster.render(SCENE, *FRAME, *frames, "--local", "1", connect=False).digests
        self.cluster.slaves(1, *SLOW)
        render = self.cluster.start_render(SCENE, *FRAME, *frames)
        self.wait_for_lines(render, 2)
        self.cluster.end("master")
        self.cluster.start("master", [cluster_lib.program("tessera-master"), "serve", "--listen", self.cluster.address,
                                      "--keys", str(self.cluster.keys / "master")])
        run = self.cluster.finish(render)
        self.assertEqual(run.code, 0, run.stderr)
        self.assertEqual(run.digests, expected)

    def test_it_says_that_it_waits_and_can_be_stopped_meanwhile(self):
        self.cluster.slaves(1, *SLOW)
        words = [cluster_lib.program("tessera-master"), "render", SCENE, *FRAME, "--frames", "0:99", "--connect",
                 self.cluster.address, "--keys", str(self.cluster.keys / "app"), "-o",
                 str(self.cluster.folder / "out-%04d.pfm")]
        render = self.cluster.start("render", words)
        cluster_lib.wait_until("a frame", lambda: (self.cluster.status() or {}).get("frames_done"))
        self.cluster.end("master")
        log = self.cluster.folder / "render.log"
        cluster_lib.wait_until("a word", lambda: "is away and looked for" in log.read_text(errors="replace"))
        render.terminate()
        del self.cluster.processes["render"]
        self.assertEqual(render.wait(cluster_lib.PATIENCE_S), 1)
        self.assertIn("interrupted", log.read_text(errors="replace"))

    def test_a_slower_pulse_forgives_a_pause_of_a_slave(self):
        self.cluster.end("master")
        self.cluster.serve("--heartbeat", "1000", "--heartbeats-missed", "20")
        self.cluster.slaves(2)
        self.stand_still(self.cluster.processes["slave-1"].pid, 4)
        self.cluster.render(SCENE, *FRAME)
        self.assertNotIn("slave-lost", (self.cluster.folder / "master.log").read_text(errors="replace"))

    def test_status_tells_the_pulse_that_was_asked_for(self):
        pace = self.cluster.status()
        self.assertEqual((pace["heartbeat_ms"], pace["heartbeats_missed_max"]), (200, 5))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
