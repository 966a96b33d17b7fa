#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The bits of a picture do not depend on slaves, threads, tiles, frames in flight or the kind of session.

--slaves N compares so many slaves with one process. --small has two slaves and few settings, for sanitizers.
"""
import pathlib
import sys
import tempfile

import cluster_lib

SIZE = ["--size", "150x110", "--aa", "2"]
TILES = ["16", "32", "40", "auto"]
FLIGHTS = ["1", "2"]
# Scene and renderer, frames, tile sizes. One scene has every combination, the others have the ends of the range, and
# each tile size with one number of frames in flight, which changes from cluster to cluster: over all six every pair is
# there three times.
EVERY = "builtin:cornell direct"
GLOBAL = "builtin:cornell igi"  # its filter reaches over the borders of tiles
# Each frame is another version of 131,000 triangles, which each slave builds anew. The third replaces the first.
MOVING = "builtin:waves direct"
PATCHES = "builtin:teapot direct"
# A wave with a round hole in it, above a dome of another degree, which has weights.
TRIMMED_FILE = """2
3 3
""" + "".join(f"{i} {j} {(i * j) % 2}\n" for i in range(4) for j in range(4)) + """trim 1 out
loop 4 2
0.8 0.5 1
0.8 0.8 0.70710678
0.5 0.8 1
0.2 0.8 0.70710678
0.2 0.5 1
0.2 0.2 0.70710678
0.5 0.2 1
0.8 0.2 0.70710678
2 2
""" + "".join(f"{1.5 * i} {1.5 * j} {-2 if i == j == 1 else -1} {2 if i == 1 else 1}\n" for i in range(3) for j in range(3))
FOLDER = tempfile.TemporaryDirectory()
pathlib.Path(FOLDER.name, "trimmed.bpt").write_text(TRIMMED_FILE)
TRIMMED = f"{FOLDER.name}/trimmed.bpt path"
SCENES = [(EVERY, "0:1", TILES), (MOVING, "0:2", ["16", "auto"]), (GLOBAL, "0:1", ["7", "64"]),
          (PATCHES, "0:0", ["16"]), (TRIMMED, "0:0", ["32"])]
REFERENCE = [(scene, frames, ["auto"]) for scene, frames, _ in SCENES]
SMALL = [(EVERY, "0:1", ["32"]), (MOVING, "0:1", ["32"]), (GLOBAL, "0:1", ["16"]), (TRIMMED, "0:0", ["32"])]


class Table:
    def __init__(self):
        self.expected = {}
        self.wrong = 0

    def add(self, scene, how, run, frames):
        assert len(run.digests) == frames, f"{scene} {how}: {len(run.digests)} lines of statistics, {frames} frames"
        expected = self.expected.setdefault(scene, run.digests)
        is_same = run.digests == expected
        self.wrong += not is_same
        short = " ".join(digest[:8] for digest in run.digests)
        print(f"{scene.rpartition('/')[2]:22} {how:58} {short}{'' if is_same else '   DIFFERS'}", flush=True)


def options_of(name, frames, tile, flight):
    scene, renderer = name.split()
    return [scene, "--renderer", renderer, "--vpls", "12", *SIZE, "--frames", frames, "--tile", tile, "--frames-in-flight", flight]


def count_of(frames):
    first, last = frames.split(":")
    return int(last) - int(first) + 1


def flights_of(scene, place, turn):
    """Returns the numbers of frames in flight to render with, at the tile size of that place in its list."""
    return FLIGHTS if scene == EVERY else [FLIGHTS[(place + turn) % 2]]


def through_daemons(table, slaves, threads, scenes, turn):
    with cluster_lib.Cluster() as cluster:
        cluster.serve()
        # Tiles take a moment, so that no slave is done with a frame before another has begun.
        cluster.slaves(slaves, "--test-tile-sleep-ms", "4", threads=threads)
        for scene, frames, tiles in scenes:
            for place, tile in enumerate(tiles):
                for flight in flights_of(scene, place, turn):
                    run = cluster.render(*options_of(scene, frames, tile, flight))
                    table.add(scene, f"connect: {slaves} slaves x {threads} threads, tiles {tile}, {flight} in flight",
                              run, count_of(frames))
        done = {slave["name"]: slave["tiles_done"] for slave in cluster.status()["slaves"]}
        assert len(done) == slaves and all(done.values()), f"not every slave took part: {done}"


def in_process(table, slaves, threads, scenes, turn):
    with cluster_lib.Cluster() as cluster:
        for scene, frames, tiles in scenes:
            for place, tile in enumerate(tiles):
                if scene == MOVING and len(tiles) > 1 and place != turn % 2:
                    continue  # the same number of daemons builds it, too
                flight = FLIGHTS[place % 2]
                run = cluster.render(*options_of(scene, frames, tile, flight), "--local", str(slaves), "--threads",
                                     str(threads), connect=False)
                table.add(scene, f"in process: {slaves} slaves x {threads} threads, tiles {tile}, {flight} in flight",
                          run, count_of(frames))


def main():
    table = Table()
    if "--small" in sys.argv:
        in_process(table, 1, 2, SMALL, 0)
        through_daemons(table, 2, 2, SMALL, 0)
    else:
        slaves = int(sys.argv[sys.argv.index("--slaves") + 1])
        in_process(table, 1, 1, REFERENCE, 0)  # all numbers of slaves are compared with it
        for threads in (1, 2):
            turn = slaves // 2 + threads
            in_process(table, slaves, threads, SCENES, turn)
            through_daemons(table, slaves, threads, SCENES, turn)
    assert len(set(map(tuple, table.expected.values()))) == len(table.expected), "two scenes with one digest"
    animated = table.expected[MOVING]
    assert len(set(animated)) == len(animated), "the animated scene does not move"
    print(f"{table.wrong} rows differ")
    return 1 if table.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
