#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks whether the simulation is right: predicts small clusters, then runs them in the lab.

    tests/sim/compare_lab.py [--frames 16] [--repeat 3] [--json OUT.json]

Each case is first given to `tessera-sim predict`; all predictions are printed before the first real
process starts. Then real masters and slaves, whose tiles take a stated time by sleeping, run over
network namespaces with the stated delay and rate. Of several runs the fastest counts: what else the
machine does holds a cluster up and never speeds it up. Exit code 0: every measurement is within 10 %
of its prediction; 1: one is not; 77: this machine has no network namespaces.
"""

import argparse
import json
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / folder) for folder in ("bench", "cluster", "faultlab", "faults")]
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402
import result_file  # noqa: E402
import watch  # noqa: E402

TOLERANCE = 0.10
WARM_UP = 4  # frames that are not measured
# A tile takes this much more than it sleeps, for waking up and rendering its pixels.
TILE_OVERHEAD_MS = 0.3
# Share of payload in the bytes that a shaped link counts: full packets of TCP with timestamps over Ethernet.
WIRE_SHARE = 1448 / 1514
SIZE = (320, 240)
TILE = 32
# Each case: name, slaves, threads, tile_ms, one-way delay_ms, Mbit/s of the master's link (0: the lab's
# own), frames in flight.
CASES = [
    ("one slave", 1, 2, 60, 0, 0, 2),
    ("three slaves", 3, 2, 60, 0, 0, 2),
    ("three slaves, 10 ms away", 3, 2, 60, 10, 0, 2),
    ("three slaves, 40 ms away", 3, 2, 60, 40, 0, 2),
    ("three slaves, 3 Mbit/s into the master", 3, 2, 30, 0, 3, 2),
    ("three slaves, 20 ms away, one frame in flight", 3, 2, 60, 20, 0, 1),
]


def predict(case, frames):
    _, slaves, threads, tile_ms, delay_ms, mbit, in_flight = case
    words = dict(slaves=slaves, threads=threads, width=SIZE[0], height=SIZE[1], spread=0, frames=frames,
                 tile_ms=tile_ms + TILE_OVERHEAD_MS, delay_ms=delay_ms + 0.1, mbit=WIRE_SHARE * mbit, record_us=18,
                 in_flight=in_flight)
    out = subprocess.run([cluster_lib.program("tessera-sim"), "predict", *(f"{k}={v}" for k, v in words.items())],
                         check=True, capture_output=True, text=True).stdout
    return json.loads(out)["frames_per_s"]


def measure(lab, case, frames):
    _, slaves, threads, tile_ms, delay_ms, mbit, in_flight = case
    for node in range(1, slaves + 2):
        lab.shape(node)
    if mbit:
        lab.shape(1, rate=1000 * mbit)
    for node in range(2, slaves + 2):
        if delay_ms:
            lab.shape(node, delay=delay_ms)
    prefix = lambda node: ["ip", "netns", "exec", lab.node(node)["ns"]]  # noqa: E731
    with cluster_lib.Cluster(host=lab.addr(1), prefix=prefix) as cluster:
        cluster.port = cluster_lib.free_port()
        # The simulation knows nothing of coded pixels, whose size depends on the picture.
        render = cluster.start_render(
            "builtin:cornell", "--renderer", "primary", "--orbit", "30", "--size", f"{SIZE[0]}x{SIZE[1]}",
            "--tile", str(TILE), "--pixels", "display8", "--pixel-coding", "off", "--frames",
            f"0:{frames + WARM_UP - 1}", "--frames-in-flight", str(in_flight), "--listen", cluster.address,
            "--slaves", str(slaves), "--keys", str(cluster.keys / "master"), connect=False)
        times = watch.Frames(render.tessera[1])
        for i in range(slaves):
            cluster.slave(f"slave-{i + 1}", "--test-tile-sleep-ms", str(tile_ms), "--quiet", threads=threads, node=2 + i)
        run = cluster.finish(render, 180)
        times.stop()
        if run.code != 0:
            raise SystemExit(f"compare_lab: the render failed: {run.stderr}")
        for i in range(slaves):
            cluster.end(f"slave-{i + 1}")
    return frames / (times.times[-1] - times.times[-1 - frames])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=16)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--json")
    arguments = parser.parse_args()
    predictions = [predict(case, arguments.frames) for case in CASES]
    print("predictions, frames/s:")
    for case, prediction in zip(CASES, predictions):
        print(f"  {case[0]}: {prediction:.3f}", flush=True)
    report, rows, worst = [], [], 0.0
    print("| case | slaves x threads | tile ms | predicted | measured | difference | slowest run |")
    print("|---|---|---|---|---|---|---|")
    with faultlab.Lab(1 + max(case[1] for case in CASES)) as lab:
        for case, prediction in zip(CASES, predictions):
            name, slaves, threads, tile_ms = case[:4]
            runs = [measure(lab, case, arguments.frames) for _ in range(arguments.repeat)]
            difference = max(runs) / prediction - 1
            worst = max(worst, abs(difference))
            report.append({"case": name, "predicted": prediction, "measured": runs, "difference": difference})
            rows.append([name, f"{slaves} x {threads}", f"{tile_ms}", f"{prediction:.3f}", f"{max(runs):.3f}",
                         f"{100 * difference:+.1f} %", f"{min(runs):.3f}"])
            print("| " + " | ".join(rows[-1]) + " |", flush=True)
    if arguments.json:
        columns = ["case", "slaves x threads", "tile ms", "predicted", "measured", "difference", "slowest run"]
        result_file.write(arguments.json, cluster_lib.program("tessera-master"), {"predictions": (columns, rows)}, figures=report)
    print(f"greatest difference {100 * worst:.1f} %, bound {100 * TOLERANCE:.0f} %")
    return 1 if worst > TOLERANCE else 0


if __name__ == "__main__":
    sys.exit(main())
