#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs `tessera-bench update` over links of stated rates, with slaves in network namespaces (tests/faultlab).

Each row of the matrix is a lab of its own: a master with its application, and slaves of one thread, all of them behind
links of one rate. --json FILE joins what the runs have measured. --quick is a test: one slave on this machine, two small
scenes; it looks that no picture differs and that the figures are whole.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / folder) for folder in ("bench", "faultlab", "cluster")]
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402
import result_file  # noqa: E402

KINDS = ["camera", "light", "material", "one object moved", "all objects moved", "1 % of the vertices", "all vertices"]
FIGURES = ("first_of_kind_seconds", "first_pixel_seconds", "tile_seconds", "beyond_seconds", "beyond_least_seconds", "frame_seconds",
           "build_seconds", "master_cpu_seconds", "slave_cpu_seconds", "slave_cpu_still_seconds", "scene_bytes", "built_primitives", "frames_per_second")
LINKS_KBIT = {"1 Gbit/s": 1_000_000, "100 Mbit/s": 100_000}
ALONE_ABOVE = 1_000_000  # triangles; so large a scene goes to one slave
RUN_SECONDS = 3000


def bench(prefix, *words):
    """Starts the suite, whose figures go to a file. Returns the process and the path of the file."""
    handle, path = tempfile.mkstemp(suffix=".json")
    os.close(handle)
    return subprocess.Popen([*prefix, cluster_lib.program("tessera-bench"), "update", *words, "--json", path]), pathlib.Path(path)


def finish(process, path):
    code = process.wait(RUN_SECONDS)
    text = path.read_text(encoding="utf-8")
    path.unlink()
    if code != 0:
        sys.exit(f"update: tessera-bench ended with {code}")
    return json.loads(text)["update"]


def check(scenes):
    """Raises AssertionError where a figure is not there, or a picture differs."""
    for scene in scenes:
        assert [edit["name"] for edit in scene["edits"]] == KINDS, scene["edits"]
        assert scene["scene_bytes"] > 0 and scene["build_seconds"] > 0, scene
        for edit in scene["edits"]:
            missing = [key for key in FIGURES if not isinstance(edit.get(key), (int, float))]
            assert not missing, (edit["name"], missing)
            assert edit["pictures"] > 0 and edit["pictures_wrong"] == 0, edit
            assert edit["frame_seconds"] >= edit["first_pixel_seconds"] > 0, edit
        camera, light, moved, some, every = (scene["edits"][i] for i in (0, 1, 3, 5, 6))
        assert camera["built_primitives"] == light["built_primitives"] == 0, "what did not change is built"
        assert moved["built_primitives"] < scene["objects"] < every["built_primitives"], "what moved is what is built"
        assert camera["scene_bytes"] < light["scene_bytes"] < every["scene_bytes"], "what changed is what travels"
        assert some["scene_bytes"] < every["scene_bytes"], "one vertex in a hundred travels as all of them do"


def measure(slaves, link, triangles, repeats):
    with faultlab.Lab(slaves + 1) as lab:
        for node in range(1, slaves + 2):
            lab.shape(node, rate=LINKS_KBIT[link])
        with cluster_lib.Cluster(host=lab.addr(1), prefix=lab.enter) as cluster:
            cluster.port = cluster_lib.free_port()
            process, path = bench(lab.enter(1), "--listen", cluster.address, "--keys", str(cluster.keys / "master"), "--slaves",
                                  str(slaves), "--triangles", str(triangles), "--link-name", link, "--repeats", str(repeats))
            for i in range(slaves):
                cluster.slave(f"slave-{i + 1}", "--quiet", node=i + 2)
            scenes = finish(process, path)
    check(scenes)
    return scenes


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--slaves", type=int, nargs="+", default=[1, 4, 8])
    parser.add_argument("--links", nargs="+", choices=list(LINKS_KBIT), default=list(LINKS_KBIT))
    parser.add_argument("--triangles", type=int, nargs="+", default=[10_000, 100_000, 1_000_000, 10_000_000])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", help="write a result for tables.py")
    options = parser.parse_args()
    if options.quick:
        scenes = finish(*bench([], "--quick"))
        check(scenes)
        assert len(scenes) == 2, len(scenes)
        return
    able = faultlab.probe()
    if not (able.get("root") and able.get("netns") and able.get("rate")):
        cluster_lib.skip("this machine's fault lab lacks root, netns or rate")
    found = []
    for triangles in options.triangles:
        for slaves in options.slaves:
            if slaves > 1 and triangles > ALONE_ABOVE:
                continue
            for link in options.links:
                found += measure(slaves, link, triangles, options.repeats)
                if options.json:  # what is measured so far is not lost
                    result_file.write(options.json, cluster_lib.program("tessera-master"), {}, update=found)


if __name__ == "__main__":
    os.environ.setdefault("TESSERA_BIN", str(TESTS.parent / "build" / "release" / "bin"))
    main()
