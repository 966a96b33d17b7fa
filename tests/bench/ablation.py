#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what each technique of Benthin's section 8.3 is worth: each on and off, over links of several round trips.

Four slaves of two threads run in network namespaces (tests/faultlab). Their tiles take a stated time by sleeping, so
that the network alone is measured: two slaves need 150 ms a tile, the others 190 and 225. Every frame has a scene of
its own (builtin:waves), which travels over links of 50 Mbit/s. Prints a table of utilisation (time on render threads /
thread time) and frames per second; --json FILE has all figures.
"""
import argparse
import os
import pathlib
import statistics
import sys

sys.dont_write_bytecode = True
TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / folder) for folder in ("bench", "faultlab", "cluster")]
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402
import result_file  # noqa: E402

TILE_MS = (150, 150, 190, 225)
THREADS = 2
LINK_KBIT = 50_000
TECHNIQUES = {
    "all on": [],
    "static balancing": ["--schedule", "static"],
    "no prefetching": ["--prefetch", "0"],
    "one frame in flight": ["--frames-in-flight", "1"],
    "scenes sent between frames": ["--scene-transfer", "sync"],
}
WARM_UP = 4  # frames until paces are learnt


def measure(cluster, options, frames, size):
    """Measures one run. The master and its application are one process, so that no frame waits for an application."""
    port = cluster_lib.free_port()
    cluster.port = port
    for i, tile_ms in enumerate(TILE_MS):
        cluster.slave(f"slave-{i + 1}", "--test-tile-sleep-ms", str(tile_ms), "--log-level", "warn", threads=THREADS, node=i + 2)
    render = cluster.start_render(
        "builtin:waves", "--listen", cluster.address, "--keys", str(cluster.keys / "master"), "--slaves", str(len(TILE_MS)),
        "--size", size, "--tile", "32", "--renderer", "primary", "--pixels", "half", "--frames", f"0:{frames - 1}", *options, connect=False)
    run = cluster.finish(render, 600)
    for i in range(len(TILE_MS)):
        cluster.end(f"slave-{i + 1}")
    if run.code != 0:
        sys.exit(f"ablation: render failed: {run.stderr}")
    stats = run.stats[WARM_UP:]
    span = stats[-1]["completed_at"] - run.stats[WARM_UP - 1]["completed_at"]
    return {
        "utilisation": sum(s["render_seconds"] for s in stats) / (span * THREADS * len(TILE_MS)),
        "frames_per_second": len(stats) / span,
        "prefetch_max": max(s["prefetch_max"] for s in stats),
        "duplicated": sum(s["tiles_duplicated"] for s in stats) / sum(s["tiles"] for s in stats),
        "build_seconds": statistics.median(s["build_seconds"] for s in stats),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--size", default="320x256", help="80 tiles of 32 x 32: ten for each thread")
    parser.add_argument("--round-trips", default="0,1,10,50", help="ms")
    parser.add_argument("--only", help="one technique")
    parser.add_argument("--json", help="write a result for tables.py, and all figures")
    options = parser.parse_args()
    able = faultlab.probe()
    if not (able.get("root") and able.get("netns") and able.get("delay")):
        cluster_lib.skip("this machine's fault lab lacks root, netns or delay")
    round_trips = [float(text) for text in options.round_trips.split(",")]
    results = []
    print(f"{'':28}" + "".join(f"{f'{rtt:g} ms':>18}" for rtt in round_trips), flush=True)
    for name, words in TECHNIQUES.items():
        if options.only and options.only not in name:
            continue
        print(f"{name:28}", end="", flush=True)
        for rtt in round_trips:
            with faultlab.Lab(1 + len(TILE_MS)) as lab:
                for node in range(2, 2 + len(TILE_MS)):
                    lab.shape(node, delay=rtt / 2, rate=LINK_KBIT)
                with cluster_lib.Cluster(host=lab.addr(1), prefix=lab.enter) as cluster:
                    figures = measure(cluster, words, options.frames, options.size)
            results.append({"technique": name, "round_trip_ms": rtt, **figures})
            print(f"{100 * figures['utilisation']:9.1f} % {figures['frames_per_second']:5.2f}/s", end="", flush=True)
        print(flush=True)
    if options.json:
        rows = [[name] + [f"{100 * r['utilisation']:.1f} %, {r['frames_per_second']:.2f}" for r in results if r["technique"] == name]
                for name in dict.fromkeys(r["technique"] for r in results)]
        columns = ["utilisation, frames/s; round trip"] + [f"{rtt:g} ms" for rtt in round_trips]
        result_file.write(options.json, cluster_lib.program("tessera-master"), {"techniques": (columns, rows)}, figures=results)


if __name__ == "__main__":
    os.environ.setdefault("TESSERA_BIN", str(TESTS.parent / "build" / "release" / "bin"))
    main()
