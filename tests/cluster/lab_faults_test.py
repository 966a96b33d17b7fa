#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Silent cuts, hangs, resets and a full disk, made in network namespaces (tests/faultlab), spoil no picture.

Skipped (77) where this machine cannot make namespaces.
"""
import os
import pathlib
import signal
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "faultlab"))
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402

NEEDS = ("root", "netns", "cut", "reset", "tmpfs")
SLOW = ["--test-tile-sleep-ms", "40"]
FRAME = ["--size", "256x192", "--tile", "16"]
SCENE = "builtin:cornell"


class LabFaults(unittest.TestCase):
    def setUp(self):
        self.lab = faultlab.Lab(3)
        self.lab.__enter__()
        self.addCleanup(self.lab.__exit__, None, None, None)
        self.cluster = cluster_lib.Cluster(
            host=self.lab.addr(1), prefix=self.lab.enter)
        self.cluster.__enter__()
        self.addCleanup(self.end_cluster)
        self.cluster.serve()
        self.cluster.slave("slave-1", *SLOW, node=2)
        self.cluster.slave("slave-2", *SLOW, node=3)
        self.cluster.wait_for_slaves(2)
        self.expected = self.cluster.render(SCENE, *FRAME, "--local", "1", connect=False).digests

    def end_cluster(self):
        self.lab.heal()
        self.cluster.__exit__(None if self._outcome.success else AssertionError, None, None)

    def start_and_wait_for_tiles(self):
        render = self.cluster.start_render(SCENE, *FRAME)
        cluster_lib.wait_until("slave-2 with tiles", lambda: (self.cluster.slave_status("slave-2") or {}).get("tiles_in_flight"))
        return render

    def expect_same_picture(self, render):
        run = self.cluster.finish(render)
        self.assertEqual(run.code, 0, run.stderr)
        self.assertEqual(run.digests, self.expected)
        return run

    def test_f13_a_silent_cut_costs_no_pixel_and_heals(self):
        render = self.start_and_wait_for_tiles()
        self.lab.cut(3)
        self.expect_same_picture(render)
        cluster_lib.wait_until("without the slave", lambda: len(self.cluster.status()["slaves"]) == 1)
        self.lab.heal(3)
        self.cluster.wait_for_slaves(2)
        self.expect_same_picture(self.cluster.start_render(SCENE, *FRAME))

    def test_f02_a_hanging_slave_is_found_by_its_silence(self):
        render = self.cluster.start_endless(SCENE, *FRAME)
        cluster_lib.wait_until("slave-2 with tiles", lambda: (self.cluster.slave_status("slave-2") or {}).get("tiles_in_flight"))
        pid = self.cluster.processes["slave-2"].pid
        os.kill(pid, signal.SIGSTOP)
        self.cluster.wait_for_frames(2, render)
        run = self.cluster.stop_render(render)
        self.assertEqual(set(run.digests), set(self.expected), "one still picture")
        self.assertGreater(sum(line["tiles_reissued"] for line in run.stats), 0)
        cluster_lib.wait_until("without the slave", lambda: len(self.cluster.status()["slaves"]) == 1)
        os.kill(pid, signal.SIGCONT)
        self.cluster.wait_for_slaves(2)
        self.expect_same_picture(self.cluster.start_render(SCENE, *FRAME))

    def test_f14_f15_f16_one_connection_or_both_lost(self):
        for kind in ("reset", "tile_port", "scene_port"):
            with self.subTest(kind):
                render = self.start_and_wait_for_tiles()
                if kind == "reset":
                    self.lab.reset(3)
                else:
                    self.lab.cut(3, port=[self.cluster.slave_status("slave-2")[kind]])
                self.expect_same_picture(render)
                self.lab.heal(3)
                self.cluster.wait_for_slaves(2)

    def test_f11_a_full_disk_names_the_file_and_leaves_none(self):
        folder = self.cluster.folder / "full"
        left = self.cluster.folder / "left"
        folder.mkdir()
        # The folder is listed by the same shell, since no other process sees the disk that is mounted on it.
        listed = 'folder=$1 left=$2; shift 2; "$@"; code=$?; ls -A "$folder" >"$left"; exit $code'
        run = self.lab.exec(1, ["sh", "-c", listed, "sh", str(folder), str(left), cluster_lib.program("tessera-master"), "render", "--quiet",
                                SCENE, "--renderer", "direct", "--size", "400x400", "-o", str(folder / "big.pfm")],
                            tmpfs=[f"{folder}:64k"], timeout=60)
        self.assertEqual(run.returncode, 1, run.stdout)
        self.assertIn("big.pfm", run.stdout)
        self.assertIn("No space left", run.stdout)
        self.assertEqual(len(run.stdout.strip().splitlines()), 1, run.stdout)
        self.assertEqual(left.read_text(), "", "no file is left")


if __name__ == "__main__":
    able = faultlab.probe()
    missing = [need for need in NEEDS if not able.get(need)]
    if missing:
        cluster_lib.skip("this machine's fault lab lacks: " + ", ".join(missing))
    unittest.main(verbosity=2)
