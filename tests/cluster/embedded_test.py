#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""By default one process renders with a slave inside, nothing listens, and Ctrl-C leaves whole pictures only."""
import os
import pathlib
import signal
import unittest

import cluster_lib

LONG = ["--size", "320x240", "--frames", "0:200"]


def sockets_of(pid):
    """Returns the inodes of the sockets that a process holds."""
    inodes = set()
    for link in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        try:
            target = os.readlink(link)
        except FileNotFoundError:
            continue
        if target.startswith("socket:["):
            inodes.add(target[8:-1])
    return inodes


def internet_sockets():
    inodes = set()
    for table in ("tcp", "tcp6", "udp", "udp6"):
        path = pathlib.Path("/proc/net", table)
        if path.exists():
            inodes |= {line.split()[9] for line in path.read_text().splitlines()[1:]}
    return inodes


class Embedded(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(self.cluster.__exit__, None, None, None)

    def start_and_wait_for_a_picture(self):
        self.output = self.cluster.folder / "pictures"
        self.output.mkdir()
        render = self.cluster.start_render("builtin:waves", *LONG, connect=False, output=str(self.output / "%04d.png"))
        cluster_lib.wait_until("one picture", lambda: list(self.output.glob("*.png")) or render.poll() is not None)
        self.assertIsNone(render.poll())
        return render

    def test_it_has_no_internet_socket(self):
        render = self.start_and_wait_for_a_picture()
        mine = sockets_of(render.pid)
        self.assertTrue(mine, "the slave inside is reached over a socket pair")
        self.assertEqual(mine & internet_sockets(), set())
        render.send_signal(signal.SIGINT)
        self.cluster.finish(render)

    def test_ctrl_c_keeps_whole_pictures_and_leaves_nothing_else(self):
        for presses in (1, 2):
            with self.subTest(presses=presses):
                render = self.start_and_wait_for_a_picture()
                for _ in range(presses):
                    render.send_signal(signal.SIGINT)
                run = self.cluster.finish(render)
                self.assertNotEqual(run.code, 0)
                self.assertIn("interrupted", run.stderr)
                self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
                files = sorted(path.name for path in self.output.iterdir())
                self.assertEqual([name for name in files if not name.endswith(".png") or name[0] == "."], [])
                for path in self.output.iterdir():
                    self.assertTrue(path.read_bytes().endswith(b"IEND\xaeB`\x82"), f"{path.name} is cut off")
                    path.unlink()
                self.output.rmdir()


if __name__ == "__main__":
    unittest.main(verbosity=2)
