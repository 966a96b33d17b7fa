#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Records what the tiles of a scene cost, for tessera-sim: tests/sim/costs/*.csv.

    tests/sim/record_costs.py [--only NAME ...] [--repeat 3]

Renders each scene below with one thread and --trace, several times, and keeps the least time of each
tile: whatever else the machine did only adds to it. A file holds a comment with the command, a line
`width,height,tile edge,frames`, and microseconds, one line for each row of tiles, frame after frame.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "cluster")]
import cluster_lib  # noqa: E402

WIDTH, HEIGHT, EDGE, FRAMES = 640, 480, 32, 4
COLUMNS, ROWS = -(-WIDTH // EDGE), -(-HEIGHT // EDGE)
# With these samples per pixel one thread of today is about as fast as a CPU of the thesis's cluster.
SCENES = {"waves": 4, "cornell": 4, "teapot": 2, "room": 4}
BUILTINS = {"teapot": "teapot-mesh"}  # where they have other names


def words(scene):
    return ["render", f"builtin:{BUILTINS.get(scene, scene)}", "--renderer", "direct", "--aa", str(SCENES[scene]), "--size",
            f"{WIDTH}x{HEIGHT}", "--tile", str(EDGE), "--pixels", "display8", "--threads", "1", "--orbit", "12",
            "--frames", f"0:{FRAMES - 1}", "--quiet"]


def render(scene):
    """Returns the microseconds of each tile, by (frame, tile)."""
    with tempfile.TemporaryDirectory(prefix="tessera-costs-") as scratch:
        trace = pathlib.Path(scratch) / "trace.json"
        subprocess.run([cluster_lib.program("tessera-master"), *words(scene), "--trace", str(trace), "-o",
                        str(pathlib.Path(scratch) / "f%04d.png")], check=True)
        events = json.loads(trace.read_text(encoding="utf-8"))["traceEvents"]
    return {(event["args"]["frame"], event["args"]["tile"]): event["dur"]
            for event in events if event["ph"] == "X" and "tile" in event.get("args", {})}


def record(scene, repeat):
    runs = [render(scene) for _ in range(repeat)]
    costs = {key: min(run[key] for run in runs) for key in runs[0]}
    if len(costs) != FRAMES * COLUMNS * ROWS:
        raise SystemExit(f"record_costs: {scene}: {len(costs)} tiles of {FRAMES * COLUMNS * ROWS} are in the trace")
    lines = [f"# tessera-master {' '.join(words(scene))} --trace: microseconds a tile, least of {repeat} runs",
             f"{WIDTH},{HEIGHT},{EDGE},{FRAMES}"]
    for frame in range(FRAMES):
        for row in range(ROWS):
            lines.append(",".join(f"{costs[frame, row * COLUMNS + column]:.0f}" for column in range(COLUMNS)))
    (HERE / "costs" / f"{scene}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    values = sorted(costs.values())
    print(f"| {scene} | {SCENES[scene]} | {1e6 * FRAMES / sum(values):.2f} | {values[0] / 1e3:.2f} | "
          f"{values[len(values) // 2] / 1e3:.2f} | {values[-1] / 1e3:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", default=list(SCENES))
    parser.add_argument("--repeat", type=int, default=3)
    arguments = parser.parse_args()
    print("| scene | samples a pixel | frames/s of one thread | least, median, greatest ms a tile | | |")
    print("|---|---|---|---|---|---|")
    for scene in arguments.only:
        record(scene, arguments.repeat)


if __name__ == "__main__":
    main()
