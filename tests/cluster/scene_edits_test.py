#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A scene that is changed piece by piece while frames show it: any cluster, whatever happens to it, shows what a
single process shows of the same scene sent whole."""
import os
import random
import signal
import subprocess
import time
import unittest

import cluster_lib

SEED = int(os.environ.get("TESSERA_SEED", 7))
FRAMES = 40


def lines_of(*words):
    run = subprocess.run([cluster_lib.program(words[0]), *map(str, words[1:])], capture_output=True, text=True,
                         timeout=cluster_lib.PATIENCE_S)
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout.splitlines()


def processor_seconds(pid):
    with open(f"/proc/{pid}/stat") as stat:
        fields = stat.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Edits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        print(f"TESSERA_SEED={SEED}")
        cls.expected = lines_of("edits_app", "whole", SEED, FRAMES)
        assert len(set(cls.expected)) > FRAMES / 2, "frames differ"

    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(self.cluster.__exit__, None, None, None)

    def app(self):
        """Starts the application. Returns: its process, whose lines are in digests as they come."""
        out = self.cluster.folder / "digests"
        app = self.cluster.start("digests", [cluster_lib.program("edits_app"), "edit", str(SEED), str(FRAMES),
                                             self.cluster.address, str(self.cluster.keys / "app")])
        app.lines = lambda: (out.with_suffix(".log")).read_text().splitlines()
        return app

    def wait_for(self, app, frames):
        cluster_lib.wait_until(f"{frames} frames", lambda: len(app.lines()) >= frames or app.poll() is not None)
        self.assertIn(app.poll(), (None, 0), app.lines()[-1:])

    def expect_right(self, app):
        self.wait_for(app, FRAMES)
        self.assertEqual(app.wait(cluster_lib.PATIENCE_S), 0, app.lines()[-1:])
        self.assertEqual(app.lines(), self.expected)

    def test_any_number_of_slaves_with_and_without_relay(self):
        for slaves, relay in ((1, "on"), (2, "off"), (5, "on"), (5, "off")):
            with self.subTest(slaves=slaves, relay=relay):
                self.cluster.serve("--relay", relay)
                self.cluster.slaves(slaves)
                self.expect_right(self.app())
                for name in [n for n in self.cluster.processes if n.startswith("slave-")] + ["master"]:
                    self.cluster.end(name)
                (self.cluster.folder / "digests.log").unlink()

    def test_slaves_that_join_die_hang_and_come_back(self):
        rng = random.Random(SEED)
        self.cluster.serve()
        self.cluster.slaves(2)
        app = self.app()
        self.wait_for(app, 3)
        self.cluster.slave("joins")
        self.wait_for(app, 3 + rng.randrange(1, 5))
        self.cluster.processes["slave-1"].kill()
        self.cluster.processes["slave-1"].wait()
        self.wait_for(app, 10)
        hangs = self.cluster.processes["slave-2"]
        hangs.send_signal(signal.SIGSTOP)
        self.wait_for(app, 16 + rng.randrange(4))
        self.cluster.processes.pop("slave-1")
        self.cluster.slave("slave-1")
        self.wait_for(app, 24)
        hangs.send_signal(signal.SIGCONT)
        self.wait_for(app, 30)
        self.cluster.processes["joins"].kill()
        self.cluster.processes["joins"].wait()
        self.expect_right(app)

    def test_one_of_ten_thousand_objects_moves(self):
        master = self.cluster.serve()
        self.cluster.slaves(1)
        frames, per_second = 120, 30
        before, began = processor_seconds(master.pid), time.monotonic()
        digests = lines_of("moving", self.cluster.address, self.cluster.keys / "app", frames, per_second)
        used, took = processor_seconds(master.pid) - before, time.monotonic() - began
        print(f"{frames / took:.1f} commits a second, each {1000 * used / frames:.2f} ms of the master's processor: "
              f"{100 * used / frames * per_second:.1f} % of a core at {per_second} a second")
        self.assertEqual(digests[:60], digests[60:], "after 60 frames it is where it was")
        self.assertGreater(len(set(digests)), 30)


if __name__ == "__main__":
    cluster_lib.main()
