#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""While it works, `render` shows one row with the time on a terminal, however narrow, and plain lines in a pipe."""
import fcntl
import os
import pty
import re
import struct
import subprocess
import termios
import unittest

import cluster_lib

# 48 tiles of 30 ms and more on one thread take 1.5 s a frame, which is enough to know how fast it goes.
SLOW = ["--test-tile-sleep-ms", "30"]
FRAME = ["--size", "128x96", "--tile", "16", "--renderer", "direct"]
COLUMNS = 60


def terminal(columns):
    """Returns both ends of a terminal of that width."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", 24, columns, 0, 0))
    return ours, theirs


def read_all(descriptor):
    data = b""
    while True:
        try:
            more = os.read(descriptor, 65536)
        except OSError:  # the writer has ended
            more = b""
        if not more:
            return data.decode()
        data += more


class Progress(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(self.cluster.__exit__, None, None, None)

    def words(self, *options):
        return [cluster_lib.program("tessera-master"), "render", "builtin:cornell", *FRAME, *options,
                "-o", str(self.cluster.folder / "p-%04d.png")]

    def test_a_terminal_shows_one_row_with_the_time_once(self):
        self.cluster.serve()
        self.cluster.slaves(1, *SLOW)
        ours, theirs = terminal(COLUMNS)
        render = subprocess.Popen(self.words("--frames", "0:3", "--connect", self.cluster.address, "--keys",
                                             str(self.cluster.keys / "app")), stdin=subprocess.DEVNULL, stderr=theirs)
        os.close(theirs)
        text = read_all(ours)
        os.close(ours)
        self.assertEqual(render.wait(cluster_lib.PATIENCE_S), 0, text)
        print(text.replace("\r", "\n").replace("\033[K", "|"))
        lines = text.replace("\r\n", "\n").split("\n")
        kept = [line.rpartition("\r")[2].replace("\033[K", "") for line in lines if line]
        self.assertEqual(len(kept), 2, "what was loaded, and what was written: no row is left behind")
        self.assertRegex(kept[0], r"^loaded builtin:cornell: \d+ triangles \([\d.]+ s\)$")
        self.assertRegex(kept[1], r"p-0003\.png \(.* s\)$")
        rows = [row.partition("\033[K")[0] for line in lines for row in line.split("\r")[1:]]
        rows = [row for row in rows if row]
        self.assertGreater(len(rows), 4)
        for row in rows:
            self.assertLess(len(row), COLUMNS, row)
            self.assertLessEqual(row.count(" left"), 1, row)
        self.assertTrue(any(" spent" in row for row in rows))
        self.assertTrue(any(re.search(r", about \d+ s left: ", row) for row in rows), rows)

    def test_a_pipe_gets_whole_lines(self):
        run = subprocess.run(self.words(), stdin=subprocess.DEVNULL, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertNotIn("\r", run.stderr)
        self.assertNotIn("\033", run.stderr)
        lines = run.stderr.splitlines()
        self.assertRegex(lines[0], r"^loaded builtin:cornell: \d+ triangles \([\d.]+ s\)$")
        self.assertRegex(lines[-1], r"^wrote .*p-0000\.png \(.* s\)$")
        for line in lines[1:-1]:
            self.assertRegex(line, r"\((\d+ %, )?.* spent(, about .* left)?\)$")


if __name__ == "__main__":
    unittest.main(verbosity=2)
