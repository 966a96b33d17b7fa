#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A large scene goes to one slave and to eight over links of one rate: slave feeds slave (--relay on), or the master
feeds each (off). Prints times and ratios.

All get it also when one of the chain is killed in the middle, and when no slave reaches another.
Skipped (77) where this machine has no fault lab.
"""
import json
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "faultlab"))
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402
import scene_noise  # noqa: E402

NEEDS = ("root", "netns", "rate", "cut")
RATE_KBIT = 50_000
# The scene is a texture of noise: 16 MiB that no codec shrinks, and nothing to build. Where the question is only who
# feeds whom, 4 MiB, which are 64 chunks, are enough: on one machine nine processes share what a byte costs.
SIDE_PX = 2048
SMALL_PX = 1024
SLAVES = 8


class Relay(unittest.TestCase):
    def run_case(self, slaves, relay, fault=None, side_px=SMALL_PX, are_apart=False):
        """Returns: for each slave left, seconds from announcement to the whole scene and bytes that slaves fed it."""
        with faultlab.Lab(slaves + 1) as lab:
            with cluster_lib.Cluster(host=lab.addr(1), prefix=lab.enter) as cluster:
                scene = scene_noise.write_scene(cluster.folder, side_px)
                for node in range(1, slaves + 2):
                    lab.shape(node, rate=RATE_KBIT)
                # The first frame waits for so many slaves; one of them may be gone by then.
                cluster.serve("--relay", relay, "--slaves", str(slaves - 1 if fault else slaves))
                for i in range(slaves):
                    cluster.slave(f"slave-{i + 1}", "--log-format", "json", "--log-level", "debug",
                                  "--test-tile-sleep-ms", "200", node=i + 2)
                cluster.wait_for_slaves(slaves)
                if are_apart:  # before there is a scene, which would be passed on meanwhile
                    for node in range(2, slaves + 1):
                        lab.cut(node, peer=range(node + 1, slaves + 2))
                # Frames go on until the last slave has it all, since the scene goes with the application.
                render = cluster.start_render(scene, "--size", "64x48", "--tile", "16", "--frames", "0:9999")
                gone = fault(lab, cluster) if fault else set()
                names = {f"slave-{i + 1}" for i in range(slaves)} - gone
                received = cluster_lib.wait_until("the scene everywhere", lambda: self.received(cluster, names))
                self.assertIsNone(render.poll(), "it has failed")
                render.terminate()
                cluster.finish(render)
                self.master_log = (cluster.folder / "master.log").read_text(errors="replace")
                return received

    @staticmethod
    def received(cluster, names):
        """Returns seconds and relayed bytes by slave, None while one lacks the scene. The first line of each counts:
        one that is lost and comes back with the scene says so again, with nothing relayed."""
        found = {}
        for name in names:
            for line in (cluster.folder / f"{name}.log").read_text(errors="replace").splitlines():
                if '"scene-received"' in line:
                    fields = json.loads(line)
                    found.setdefault(name, (float(fields["seconds"]), int(fields["relayed_bytes"])))
        return found if len(found) == len(names) else None

    def test_eight_slaves_take_hardly_longer_than_one(self):
        one = max(s for s, _ in self.run_case(1, "on", side_px=SIDE_PX).values())
        eight = self.run_case(SLAVES, "on", side_px=SIDE_PX)
        slowest = max(s for s, _ in eight.values())
        relayed = sum(1 for _, b in eight.values() if b > 0)
        print(f"1 slave: {one:.2f} s; {SLAVES} slaves, --relay on: {slowest:.2f} s, ratio {slowest / one:.2f}, {relayed} fed by slaves")
        self.assertGreaterEqual(relayed, SLAVES - 2)
        if cluster_lib.is_quiet():
            self.assertLess(slowest / one, 3)  # the stated 1.5 is not asserted, since shared processors decide the rest

    def test_without_relay_the_master_sends_each_byte_eight_times(self):
        eight = self.run_case(SLAVES, "off")
        print(f"{SLAVES} slaves, --relay off: {max(s for s, _ in eight.values()):.2f} s")
        self.assertEqual(sum(b for _, b in eight.values()), 0)

    def test_a_relay_that_dies_in_the_middle_costs_a_retry(self):
        def kill_one(lab, cluster):
            cluster_lib.wait_until("a quarter of the scene sent", lambda: any(
                s["bytes_sent"] > SIDE_PX * SIDE_PX for s in (cluster.status() or {"slaves": []})["slaves"]))
            cluster.processes["slave-4"].kill()
            return {"slave-4"}
        rest = self.run_case(SLAVES, "on", kill_one, SIDE_PX)
        print(f"{SLAVES} slaves, one killed at a quarter of the scene: {max(s for s, _ in rest.values()):.2f} s for the others")

    def test_slaves_that_cannot_reach_each_other_are_fed_by_the_master(self):
        rest = self.run_case(SLAVES, "on", are_apart=True)
        print(f"{SLAVES} slaves, none of which reaches another: {max(s for s, _ in rest.values()):.2f} s")
        self.assertEqual(sum(b for _, b in rest.values()), 0)
        self.assertRegex(self.master_log, " relay-(failed|bypassed): ", "the plan names a feeder for all but the first")


if __name__ == "__main__":
    able = faultlab.probe()
    missing = [need for need in NEEDS if not able.get(need)]
    if missing:
        cluster_lib.skip("this machine's fault lab lacks: " + ", ".join(missing))
    cluster_lib.main()
