#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Pixels on a slow link are coded: the same picture, fewer bytes. A fast one, or --pixel-coding off, has them plain.

Prints a line for each case. A slave codes where that takes less time than it saves, so on a machine whose processors
are busy with something else the bytes are printed and not judged; the pictures always are. Skipped (77) where this
machine has no fault lab.
"""
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "faultlab"))
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402

NEEDS = ("root", "netns", "rate")
SLOW_KBIT = 8000
SCENE = "builtin:room"
FRAME = ["--size", "240x180", "--tile", "32", "--frames", "0:5"]


class PixelsOnALink(unittest.TestCase):
    def run_case(self, rate_kbit, mode, pixels):
        with faultlab.Lab(2) as lab:
            with cluster_lib.Cluster(host=lab.addr(1), prefix=lab.enter) as cluster:
                if rate_kbit:
                    lab.shape(2, rate=rate_kbit)
                cluster.serve("--pixel-coding", mode)
                cluster.slave("slave-1", threads=2, node=2)
                cluster.wait_for_slaves(1)
                run = cluster.render(SCENE, *FRAME, "--pixels", pixels)
        last = run.stats[2:]  # the first frames bring the scene and the link's measure
        received = sum(line["bytes_from_slaves"] for line in last)
        seconds = sum(line["seconds"] for line in last)
        print(f"{pixels} at {rate_kbit or 'full'} kbit/s, coding {mode}: {received / len(last):.0f} bytes a frame, "
              f"{seconds / len(last):.3f} s a frame")
        return run.digests, received, seconds

    def test_a_slow_link_codes_and_the_picture_is_the_same(self):
        for pixels in ("float", "half", "display8"):
            with self.subTest(pixels):
                digests, plain, _ = self.run_case(SLOW_KBIT, "off", pixels)
                coded_digests, coded, _ = self.run_case(SLOW_KBIT, "auto", pixels)
                self.assertEqual(coded_digests, digests)
                if cluster_lib.is_quiet():
                    self.assertLess(coded, 0.85 * plain)

    def test_a_fast_link_does_not(self):
        _, plain, _ = self.run_case(None, "off", "half")
        _, coded, _ = self.run_case(None, "auto", "half")
        # Coded pixels are about half as many bytes; a few tiles are coded while the link is still being measured.
        if cluster_lib.is_quiet():
            self.assertGreater(coded, 0.8 * plain)


if __name__ == "__main__":
    able = faultlab.probe()
    missing = [need for need in NEEDS if not able.get(need)]
    if missing:
        cluster_lib.skip("this machine's fault lab lacks: " + ", ".join(missing))
    unittest.main(verbosity=2)
