#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Versions of a scene in a row, each with other meshes: memory of master and slave is flat.

version_memory_test.py [VERSIONS]: 100,000 of them are the long form."""
import pathlib
import statistics
import sys
import time

import cluster_lib

VERSIONS = int(sys.argv[1]) if len(sys.argv) > 1 else 1500
# What each version leaves behind adds up: 512 KiB is 870 bytes of each of the 600 in between. The first half is not
# judged, since the allocator's heaps of all threads find their sizes in it: they grow by steps, sooner or later as the
# threads fall in with each other. Samples of a tenth of the run are taken together, since one may catch two scenes
# where another one catches three.
FROM, TO = 0.5, 0.9
GROWTH_MAX_KIB = 512


def resident_kib(pid):
    """Returns what a process holds in memory of its own."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(status.split("RssAnon:")[1].split()[0])


with cluster_lib.Cluster() as cluster:
    watched = {"master": cluster.serve().pid}
    cluster.slaves(1)
    watched["slave"] = cluster.processes["slave-1"].pid
    app = cluster.start("app", [cluster_lib.program("edits_app"), "steady", "7", str(VERSIONS), cluster.address,
                                str(cluster.keys / "app")])
    log = open(cluster.folder / "app.log")
    done, samples = 0, {name: [] for name in watched}
    ended = False
    while not ended:
        ended = app.poll() is not None  # before what it printed last is read
        lines = log.read().count("\n")
        done += lines
        if lines == 0:
            time.sleep(0.02)
            continue
        for name, pid in watched.items():
            samples[name].append((done, resident_kib(pid)))
    log.close()
    text = (cluster.folder / "app.log").read_text().splitlines()
    assert app.returncode == 0 and len(text) == VERSIONS, text[-1:]
    frames_open = cluster.status()["frames_open"]
for name, found in samples.items():
    parts = [[kib for at, kib in found if low < at / VERSIONS <= low + 0.1] for low in (FROM, TO)]
    first, last = map(statistics.median, parts)
    print(f"{name}: {first} KiB after half of {VERSIONS} versions, {last} KiB at their end "
          f"({len(parts[0])} and {len(parts[1])} samples)")
    assert last - first < GROWTH_MAX_KIB, f"the {name}'s memory grows"
assert frames_open == 0, f"{frames_open} frames are still open"
