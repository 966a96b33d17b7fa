#!/usr/bin/env python3
"""Does the simulation tell the truth? Predicts small clusters, then runs them in the lab.

    tests/sim/compare_lab.py [--frames 24] [--json OUT.json]

Each case is first given to `tessera-sim predict`; all predictions are printed before the first real
process starts. Then real masters and slaves, whose tiles take a stated time by sleeping, run over
network namespaces with the stated delay and rate. Exit code 0: every measurement is within 10 % of
its prediction; 1: one is not; 77: this machine has no network namespaces.
"""

import argparse
import json
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / folder) for folder in ("cluster", "faultlab", "faults")]
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402
import watch  # noqa: E402

TOLERANCE = 0.10
WARM_UP = 4  # frames
# A tile takes this much more than it sleeps: waking up, rendering black pixels, coding them.
TILE_OVERHEAD_MS = 0.3
SIZE = (320, 240)
TILE = 32
# name, slaves, threads, tile_ms, one-way delay_ms, Mbit/s of the master's link (0: the lab's own)
CASES = [
    ("one slave", 1, 2, 20, 0, 0),
    ("three slaves", 3, 2, 20, 0, 0),
    ("three slaves, far away", 3, 2, 20, 10, 0),
    ("three slaves, slow uplink", 3, 2, 10, 0, 10),
    ("three slaves, one frame in flight", 3, 2, 20, 5, 0),
]


def in_flight(name):
    return 1 if "one frame" in name else 2


def predict(case, frames):
    name, slaves, threads, tile_ms, delay_ms, mbit = case
    words = dict(slaves=slaves, threads=threads, width=SIZE[0], height=SIZE[1], spread=0, frames=frames,
                 tile_ms=tile_ms + TILE_OVERHEAD_MS, delay_ms=delay_ms + 0.1, mbit=mbit, record_us=10,
                 in_flight=in_flight(name))
    out = subprocess.run([cluster_lib.program("tessera-sim"), "predict", *(f"{k}={v}" for k, v in words.items())],
                         check=True, capture_output=True, text=True).stdout
    return json.loads(out)["frames_per_s"]


def measure(lab, case, frames):
    name, slaves, threads, tile_ms, delay_ms, mbit = case
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
        render = cluster.start_render(
            "builtin:cornell", "--renderer", "primary", "--orbit", "30", "--size", f"{SIZE[0]}x{SIZE[1]}",
            "--tile", str(TILE), "--pixels", "display8", "--frames", f"0:{frames + WARM_UP - 1}",
            "--frames-in-flight", str(in_flight(name)), "--listen", cluster.address, "--slaves", str(slaves),
            "--keys", str(cluster.keys / "master"), connect=False)
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
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--json")
    arguments = parser.parse_args()
    predictions = [predict(case, arguments.frames) for case in CASES]
    print("predictions, frames/s:")
    for case, prediction in zip(CASES, predictions):
        print(f"  {case[0]}: {prediction:.2f}", flush=True)
    report, worst = [], 0.0
    print("| case | slaves x threads | tile ms | delay ms | Mbit/s | predicted | measured | difference |")
    print("|---|---|---|---|---|---|---|---|")
    with faultlab.Lab(1 + max(case[1] for case in CASES)) as lab:
        for case, prediction in zip(CASES, predictions):
            name, slaves, threads, tile_ms, delay_ms, mbit = case
            measured = measure(lab, case, arguments.frames)
            difference = measured / prediction - 1
            worst = max(worst, abs(difference))
            report.append({"case": name, "predicted": prediction, "measured": measured, "difference": difference})
            print(f"| {name} | {slaves} x {threads} | {tile_ms} | {delay_ms} | {mbit or '-'} | {prediction:.2f} | "
                  f"{measured:.2f} | {100 * difference:+.1f} % |", flush=True)
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    print(f"greatest difference {100 * worst:.1f} %, bound {100 * TOLERANCE:.0f} %")
    return 1 if worst > TOLERANCE else 0


if __name__ == "__main__":
    sys.exit(main())
