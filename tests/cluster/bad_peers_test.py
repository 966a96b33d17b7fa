#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""However bad a peer is, it leaves a render beside it whole, one line of the log that names it and says why, a master
that lives, and no descriptor. Prints "peer: line" for each (bad_peers.py has them).

    bad_peers_test.py [WORD]     those whose names hold WORD
"""
import json
import os
import pathlib
import sys
import unittest

import cluster_lib

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "faults"))
import bad_peers  # noqa: E402
import watch  # noqa: E402

SCENE, FRAME = "builtin:cornell", ["--size", "64x48", "--tile", "16"]
SLOW = ["--test-tile-sleep-ms", "40", "--log-format", "json"]
PATIENCE_S = 60  # for a line
ONLY = sys.argv.pop() if len(sys.argv) > 1 and not sys.argv[-1].startswith("-") else ""


def complaints(log, since):
    """Returns the lines of a JSON log from line `since` on that warn of something."""
    found = []
    for line in log.read_text(errors="replace").splitlines()[since:]:
        event = json.loads(line)
        is_orderly = "goodbye" in event.get("reason", "")
        if event["level"] in ("warning", "error") or (event["event"] == "application-left" and not is_orderly):
            found.append((event, line))
    return found


def tiles_of(picture):
    """Returns the pixels of each tile of a PFM, whose rows begin at the bottom."""
    pixel_bytes, edge = 12, 16
    kind, size, scale, data = picture.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert (kind, float(scale)) == (b"PF", -1.0), (kind, scale)
    rows = [data[y * width * pixel_bytes:(y + 1) * width * pixel_bytes] for y in range(height)][::-1]
    return [b"".join(row[x * pixel_bytes:(x + edge) * pixel_bytes] for row in rows[y:y + edge])
            for y in range(0, height, edge) for x in range(0, width, edge)]


class BadPeers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cluster_lib.Cluster()
        cls.cluster.__enter__()
        cls.addClassCleanup(cls.cluster.__exit__, None, None, None)
        cls.expected = cls.cluster.render(SCENE, *FRAME, "--local", "1", connect=False).digests[0]
        cls.tiles = tiles_of(next(cls.cluster.folder.glob("out-1-*.pfm")))
        cls.cluster.serve("--log-format", "json", "--relay", "on")
        cls.cluster.slaves(2, *SLOW)
        cls.place = bad_peers.Place(cls.cluster, cls.tiles)

    def lines_of(self, render):
        path = render.tessera[1]
        return path.read_text().count("\n") if path.exists() else 0

    def visit(self, title, drive, event, words, log_of="master"):
        """Lets the peer do its harm. Checks its line, and that the descriptors are back."""
        log = self.cluster.folder / f"{log_of}.log"
        pid = self.cluster.processes[log_of].pid
        before, since = watch.descriptors(pid), len(log.read_text().splitlines())
        names = drive(self.place)

        def about_it():
            return [(e, line) for e, line in complaints(log, since) if any(name in line for name in names)]
        cluster_lib.wait_until(f"a line about {title} ({names}) in\n" + log.read_text()[-2000:], about_it, PATIENCE_S)
        told = about_it()
        print(f"{title}: {told[0][0]['event']}: {told[0][0]['text']}" +
              "".join(f" {key}={told[0][0][key]}" for key in ("reason", "peer", "address") if key in told[0][0]))
        self.assertEqual([e["event"] for e, _ in told], [event], "one line, by its name")
        self.assertIn(words, told[0][1])
        self.assertIsNone(self.cluster.processes[log_of].poll(), "it lives")
        cluster_lib.wait_until("descriptors are back", lambda: watch.descriptors(pid) <= before)

    def chosen(self, peers):
        return [one for one in peers if ONLY in one[0]]

    def beside_a_render(self, peers, log_of="master"):
        render = self.cluster.start_endless(SCENE, *FRAME)
        cluster_lib.wait_until("a frame", lambda: self.lines_of(render))
        for title, *what in self.chosen(peers):
            with self.subTest(title):
                done = self.lines_of(render)
                self.visit(title, *what, log_of)
                cluster_lib.wait_until("a frame more", lambda: self.lines_of(render) > done)
        run = self.cluster.stop_render(render)
        self.assertEqual(set(run.digests), {self.expected}, "every frame is right")
        self.assertEqual(sum(line["error"] != "" for line in run.stats if "error" in line), 0)
        cluster_lib.wait_until("both slaves are here", lambda: {s["name"] for s in self.cluster.status()["slaves"]} ==
                               {"slave-1", "slave-2"})

    def test_strangers_at_the_door(self):
        self.beside_a_render(bad_peers.STRANGERS)

    def test_guests_with_good_keys(self):
        self.beside_a_render(bad_peers.GUESTS)

    def test_slaves(self):
        self.beside_a_render(bad_peers.SLAVES)

    def test_watchers(self):
        self.beside_a_render(bad_peers.WATCHERS)

    def test_visitors_of_a_slave_that_feeds_others(self):
        self.beside_a_render(bad_peers.VISITORS, "slave-1")

    def test_applications(self):
        """Only one may be there at a time, so the render comes after each."""
        for title, *what in self.chosen(bad_peers.APPLICATIONS):
            with self.subTest(title):
                cluster_lib.wait_until("without an application", lambda: not self.cluster.status()["has_application"])
                self.visit(title, *what)
                cluster_lib.wait_until("without an application", lambda: not self.cluster.status()["has_application"])
                self.assertEqual(self.cluster.render(SCENE, *FRAME).digests, [self.expected])


if __name__ == "__main__":
    os.environ.setdefault("TESSERA_BIN", "build/release/bin")
    cluster_lib.main(verbosity=1)
