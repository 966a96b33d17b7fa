#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures how far builds and rendering go on at once, from the traces of `tessera-master render` of scenes that deform in
every frame, with two frames in flight.

It shows the time from the end of a frame to the end of the next, beside that from a frame's first tile to its last and that of
a build, which both last longer because the other one runs. All figures are medians over frames, and ratios over runs.

--json FILE writes a result for tables.py; --quick is a test: a short run of one scene, of which it looks that the trace has it all.
"""
import argparse
import array
import base64
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / folder) for folder in ("bench", "cluster")]
import cluster_lib  # noqa: E402
import result_file  # noqa: E402

SEA_CELLS = 708  # along a side: 1,002,528 triangles
WARM_UP = 3  # frames at the beginning, and at the end, that are no steady state
MASTER_PROCESS = 1
US = 1e-6


def sea(path, cells=SEA_CELLS):
    """Writes a glTF file of a square of triangles whose corners all rise and fall, by one morph target."""
    side = cells + 1
    places, deltas, corners = array.array("f"), array.array("f"), array.array("I")
    for row in range(side):
        for column in range(side):
            x, z = 12 * (column / cells - 0.5), 12 * (row / cells - 0.5)
            places.extend((x, 0.25 * math.sin(1.3 * x) + 0.18 * math.sin(0.9 * z - 1.1 * x), z))
            deltas.extend((0, 0.25 * math.cos(1.7 * x + 0.4 * z) + 0.06 * math.sin(4.1 * x + 3.3 * z), 0))
    for row in range(cells):
        for column in range(cells):
            a = row * side + column
            corners.extend((a, a + side, a + 1, a + 1, a + side, a + side + 1))
    times, weights = array.array("f", (0, 1, 2)), array.array("f", (0, 1, 0))
    arrays = [places, deltas, corners, times, weights]
    views, at = [], 0
    for values in arrays:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(values) * 4})
        at += len(values) * 4
    shapes = [("VEC3", 5126, 3), ("VEC3", 5126, 3), ("SCALAR", 5125, 1), ("SCALAR", 5126, 1), ("SCALAR", 5126, 1)]
    accessors = []
    for view, (values, (kind, component, width)) in enumerate(zip(arrays, shapes)):
        accessor = {"bufferView": view, "componentType": component, "type": kind, "count": len(values) // width}
        if view in (0, 1, 3):
            accessor["min"] = [min(values[axis::width]) for axis in range(width)]
            accessor["max"] = [max(values[axis::width]) for axis in range(width)]
        accessors.append(accessor)
    data = b"".join(values.tobytes() for values in arrays)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 2, "targets": [{"POSITION": 1}]}], "weights": [0]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
                        "samplers": [{"input": 3, "output": 4}]}],
        "buffers": [{"byteLength": at, "uri": uri}], "bufferViews": views, "accessors": accessors}), encoding="utf-8")


def render(scene, frames, extra):
    """Returns the ends of frames, their tiles, and builds, in steady state: (begin, end) of each in microseconds."""
    with tempfile.TemporaryDirectory(prefix="tessera-beside-") as scratch:
        trace = pathlib.Path(scratch) / "trace.json"
        subprocess.run([cluster_lib.program("tessera-master"), "render", scene, "--frames", f"0:{frames - 1}", "--frames-in-flight",
                        "2", "--quiet", *extra, "--trace", str(trace), "-o", str(pathlib.Path(scratch) / "f%04d.pfm")],
                       check=True)
        events = json.loads(trace.read_text(encoding="utf-8"))["traceEvents"]
    ends, tiles, builds = {}, {}, {}
    for event in (e for e in events if e["ph"] == "X"):
        args, span = event["args"], (event["ts"], event["ts"] + event["dur"])
        if "tile" in args:
            tiles.setdefault(args["frame"], []).append(span)
        elif event["pid"] == MASTER_PROCESS:
            ends[args["frame"]] = span[1]
        elif "built_primitives" in args:  # what came in by then is a row of its own, of the same version
            builds[args["scene_version"]] = span
    steady = sorted(ends)[WARM_UP:-WARM_UP]
    return [ends[f] for f in steady], [tiles[f] for f in steady], [builds[v] for v in sorted(builds)[WARM_UP:-WARM_UP]]


def covered(spans, others):
    """Returns the share of the time of `spans` in which at least one of `others` runs."""
    both = 0
    for begin, end in spans:
        at = begin
        for other_begin, other_end in sorted(o for o in others if o[1] > begin and o[0] < end):
            both += max(0, min(other_end, end) - max(other_begin, at))
            at = max(at, min(other_end, end))
    return both / sum(end - begin for begin, end in spans)


def measure(scene, frames, runs, extra):
    periods, renderings, buildings, beside = [], [], [], []
    for _ in range(runs):
        ends, tiles, builds = render(scene, frames, extra)
        steps = [US * (b - a) for a, b in zip(ends, ends[1:])]
        periods.append(statistics.median(steps))
        renderings.append(statistics.median(US * (max(t[1] for t in of) - min(t[0] for t in of)) for of in tiles))
        buildings.append(statistics.median(US * (end - begin) for begin, end in builds))
        beside.append(covered(builds, [t for of in tiles for t in of]))
    middle = statistics.median
    ratio = middle(p / max(r, b) for p, r, b in zip(periods, renderings, buildings))
    return {"period": middle(periods), "rendering": middle(renderings), "building": middle(buildings), "ratio": ratio,
            "beside": middle(beside)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", help="write a result for tables.py")
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory(prefix="tessera-beside-") as scratch:
        path = pathlib.Path(scratch) / "sea.gltf"
        scenes = [("waves", "builtin:waves", 2)]
        if not options.quick:
            sea(path)
            scenes.append((f"sea of {2 * SEA_CELLS**2:,} triangles", str(path), 1))
        for name, scene, samples in scenes:
            frames = 12 if options.quick else options.frames
            extra = ["--size", "160x120" if options.quick else "640x480", "--renderer", "direct", "--exposure", "0", "--aa",
                     "1" if options.quick else str(samples)]
            if not scene.startswith("builtin:"):
                extra += ["--camera", "0,3.2,8.5 0,-0.3,0 0,1,0 42"]
            found = measure(scene, frames, 1 if options.quick else options.runs, extra)
            assert found["building"] > 0 and found["rendering"] > 0, found
            rows.append([name, *(f"{1e3 * found[key]:.1f}" for key in ("period", "rendering", "building")), f"{found['ratio']:.2f}",
                         f"{100 * found['beside']:.0f} %"])
            print(*rows[-1], sep=" | ", flush=True)
    if options.json:
        columns = ["scene", "from frame to frame, ms", "rendering, ms", "building, ms", "to the greater of both",
                   "of a build beside tiles"]
        result_file.write(options.json, cluster_lib.program("tessera-master"), {"beside": (columns, rows)})


if __name__ == "__main__":
    os.environ.setdefault("TESSERA_BIN", str(TESTS.parent / "build" / "release" / "bin"))
    main()
