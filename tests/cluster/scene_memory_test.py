#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""F09, F10: a scene that does not fit is refused before it is sent. Slaves that can hold it go on; when none can, the
frame says why."""
import sys
import unittest

sys.dont_write_bytecode = True
import cluster_lib  # noqa: E402
import scene_noise  # noqa: E402

FRAME = ["--size", "64x48", "--frames", "0:1"]
SIDE_PX = 3072  # 36 MiB of texels: 72 MiB as bytes and decoded, and 48 with mip levels, while these are made
SMALL_MIB, LARGE_MIB = 60, 1000  # values of --memory, of which the programs themselves take some 20


class SceneMemory(unittest.TestCase):
    def test_f10_too_large_for_all_and_a_smaller_one_still_goes(self):
        with cluster_lib.Cluster() as cluster:
            scene = scene_noise.write_scene(cluster.folder, SIDE_PX)
            cluster.serve(*cluster_lib.CALM)
            cluster.slaves(2, "--memory", str(SMALL_MIB))
            for _ in range(2):
                run = cluster.finish(cluster.start_render(scene, *FRAME))
                self.assertEqual(run.code, 3)
                print(run.stderr.strip())
                self.assertRegex(run.stderr, r"needs about 12\d MiB")
                self.assertRegex(run.stderr, rf"largest slave, 'slave-\d', may take {SMALL_MIB} MiB")
            cluster.render("builtin:cornell", *FRAME)
            log = (cluster.folder / "master.log").read_text(errors="replace")
            self.assertNotIn("slave-lost", log)
            self.assertEqual(log.count("scene-failed"), 2, "one attempt for each slave")
            self.assertLess(cluster.status()["slaves"][0]["tiles_done"], 100000)

    def test_f09_one_that_cannot_hold_it_stays_and_the_other_renders(self):
        with cluster_lib.Cluster() as cluster:
            scene = scene_noise.write_scene(cluster.folder, SIDE_PX)
            cluster.serve("--slaves", "2")
            cluster.slave("slave-1", "--memory", str(SMALL_MIB))
            cluster.slave("slave-2", "--memory", str(LARGE_MIB))
            cluster.wait_for_slaves(2)
            run = cluster.render(scene, *FRAME)
            self.assertEqual(run.digests, cluster.render(scene, *FRAME, "--local", "1", connect=False).digests)
            self.assertEqual(len(cluster.status()["slaves"]), 2)
            cluster.render("builtin:cornell", *FRAME)


if __name__ == "__main__":
    unittest.main(verbosity=2)
