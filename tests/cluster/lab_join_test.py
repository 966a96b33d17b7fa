#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""F08: a slave joins in mid-animation and needs a large scene; the frames in work hardly notice. Prints the figures.

Skipped (77) where this machine has no fault lab.
"""
import pathlib
import statistics
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "faultlab"))
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402
import scene_noise  # noqa: E402

NEEDS = ("root", "netns", "rate")
RATE_KBIT = 50_000
FRAMES_ALONE = 9  # frames to measure without a joiner; with one, those count in which it receives
SIDE_PX = 2048  # 16 MiB take the link 2.7 s


class Join(unittest.TestCase):
    def run_case(self, joins):
        """Returns: seconds of the frames while the joiner receives (else of FRAMES_ALONE), and all digests."""
        with faultlab.Lab(3) as lab:
            with cluster_lib.Cluster(host=lab.addr(1), prefix=lab.enter) as cluster:
                scene = scene_noise.write_scene(cluster.folder, SIDE_PX)
                for node in (1, 2, 3):
                    lab.shape(node, rate=RATE_KBIT)
                cluster.serve()
                cluster.slave("slave-1", "--test-tile-sleep-ms", "10", node=2)
                cluster.wait_for_slaves(1)
                # 8 x 6 tiles of 10 ms on one thread take about half a second a frame.
                render = cluster.start_endless(scene, "--size", "128x96", "--tile", "16")

                def done():
                    return (cluster.status() or {}).get("frames_done", 0)
                cluster_lib.wait_until("frames", lambda: done() >= 5)
                first = done() + 1
                if joins:
                    cluster.slave("slave-2", "--test-tile-sleep-ms", "10", node=3)
                    cluster_lib.wait_until("the scene there", lambda: (cluster.slave_status("slave-2") or {}).get("scene_version"))
                    last = done() - 1
                    cluster_lib.wait_until("its tiles", lambda: (cluster.slave_status("slave-2") or {}).get("tiles_done"))
                    cluster.wait_for_frames(1, render)
                else:
                    last = first + FRAMES_ALONE
                    cluster_lib.wait_until("enough of them", lambda: done() >= last)
                run = cluster.stop_render(render)
                # Frames count until the joiner draws its first tile.
                alone = [line["seconds"] for line in run.stats[first:max(last, first + 1)] if line["slaves"] == 1]
                return alone, run.digests

    def test_f08_a_late_joiner_does_not_disturb(self):
        alone, expected = self.run_case(False)
        beside, digests = self.run_case(True)
        self.assertEqual(len(set(expected)), 1, "one still scene")
        self.assertEqual(set(digests), set(expected))
        growth = statistics.median(beside) / statistics.median(alone) - 1
        print(f"median frame {statistics.median(alone):.3f} s alone, {statistics.median(beside):.3f} s over {len(beside)} frames "
              f"while a joiner receives {SIDE_PX * SIDE_PX * 4 >> 20} MiB: {100 * growth:+.1f} %")
        if cluster_lib.is_quiet():
            self.assertLess(growth, 0.25)  # the stated 5 % is not asserted, since shared processors decide the rest


if __name__ == "__main__":
    able = faultlab.probe()
    missing = [need for need in NEEDS if not able.get(need)]
    if missing:
        cluster_lib.skip("this machine's fault lab lacks: " + ", ".join(missing))
    unittest.main(verbosity=2)
