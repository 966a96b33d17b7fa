#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A field of copies of CAD files on slaves: memory, bytes sent, frames per second, error, the bits of one process, one slave killed.

    measure.py [FILE...] [--copies N] [--arrange flat|instances] [--slaves N] [--size WxH] [--frames N] [--json OUT]

Without files it takes three small ones that make_cad_files writes. TESSERA_BIN names the folder of the programs. Exit code 1 when a picture differs from that of one
process, or when preparing the scene takes more memory than the master reckons. Speeds are of this machine with what else runs on it; nothing is judged by them.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "cluster"))
import cluster_lib  # noqa: E402

PATIENCE_S = 3600  # slaves that share a busy machine take minutes to build


def memory_kib(pid, key):
    """Returns VmRSS, what the process has now, or VmHWM, the most that it had."""
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1])
    return 0


def camera_over(side):
    return f"{-0.15 * side},{0.35 * side},{-0.25 * side} {0.5 * side},0,{0.45 * side} 0,1,0 45"


def camera_of(options):
    return camera_over((options.copies * len(options.files)) ** 0.5)


def counts_of(plan):
    run = subprocess.run([cluster_lib.program("cad_field"), plan], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if run.returncode:
        sys.exit(run.stderr.strip())
    return json.loads(run.stderr)


def memory_of(plan):
    """What one process takes for the scene, and what a master reckons of it, in bytes."""
    run = subprocess.run([cluster_lib.program("cad_memory"), plan], capture_output=True, text=True)
    if run.returncode:
        sys.exit(run.stderr.strip())
    return json.loads(run.stdout)


def error_of(plan, options):
    """How far hits of the picture's rays are from their surfaces, over the scene's diagonal."""
    width, height = options.size.split("x")
    run = subprocess.run([cluster_lib.program("cad_error"), plan, width, height, camera_of(options)], capture_output=True, text=True)
    if run.returncode:
        sys.exit(run.stderr.strip())
    return json.loads(run.stdout)


def finished(cluster, render):
    run = cluster.finish(render, PATIENCE_S)
    if run.code:
        sys.exit(f"exit code {run.code}: {run.stderr}")
    return run


def measure(options):
    with cluster_lib.Cluster() as cluster:
        plan = cluster.folder / "field.step"
        if not options.files:
            subprocess.run([cluster_lib.program("make_cad_files"), cluster.folder], check=True)
            options.files = [cluster.folder / name for name in ("tray.step", "rods.step", "rods.igs")]
        plan.write_text(f"copies {options.copies}\narrange {options.arrange}\n" + "".join(f"file {file}\n" for file in options.files))
        os.environ["TESSERA_IMPORT"] = cluster_lib.program("cad_field")
        made = counts_of(plan)
        memory = memory_of(plan)
        error = error_of(plan, options)
        still = ["--size", options.size, "--camera", camera_of(options)]
        alone = finished(cluster, cluster.start_render(str(plan), *still, "--local", "1", "--threads", "2", connect=False))
        cluster.serve()
        cluster.slaves(options.slaves)
        names = [f"slave-{i + 1}" for i in range(options.slaves)]
        pids = [cluster.processes[name].pid for name in names]
        empty = [memory_kib(pid, "VmRSS") for pid in pids]
        run = finished(cluster, cluster.start_render(str(plan), *still, "--frames", f"0:{options.frames - 1}"))
        rest = [memory_kib(pid, "VmRSS") for pid in pids]
        peak = [memory_kib(pid, "VmHWM") for pid in pids]

        # Again, and one is killed while it holds tiles of a frame.
        render = cluster.start_endless(str(plan), *still)
        victim = names[-1]
        cluster_lib.wait_until(f"{victim} with tiles", lambda: (cluster.slave_status(victim) or {}).get("tiles_in_flight"),
                               seconds=PATIENCE_S)
        cluster.processes.pop(victim).kill()
        cluster.wait_for_frames(2, render)
        killed = cluster.stop_render(render)
        made_here = run.digests + killed.digests
        patches = made["patches"]
        after_first = [line["seconds"] for line in run.stats[1:]] or [run.stats[0]["seconds"]]
        return made | {
            "slaves": options.slaves, "size": options.size, "frames": options.frames, "processors": os.cpu_count(),
            "load": round(os.getloadavg()[0], 1), "block_bytes_a_patch": round(made["block_bytes"] / patches),
            "prepared_bytes_a_patch": round(memory["prepared"] / patches),
            "reckoned_bytes": memory["reckoned"], "taken_bytes_at_the_peak": memory["taken_at_the_peak"],
            "slave_bytes_a_patch": [round(1024 * (r - e) / patches) for r, e in zip(rest, empty)],
            "slave_peak_bytes_a_patch": [round(1024 * (p - e) / patches) for p, e in zip(peak, empty)],
            "scene_bytes_sent": sum(line["scene_bytes"] for line in run.stats),
            "build_seconds": run.stats[0]["build_seconds"],
            "pixel_bytes_a_frame": round(sum(line["bytes_from_slaves"] for line in run.stats) / options.frames),
            "error_p99.9": f"{error['error_p999']:.1e}", "error_worst": f"{error['error_worst']:.1e}", "error_of_hits": error["hits"],
            "frames_per_second": round(len(after_first) / sum(after_first), 3),
            "rays_a_frame": round(sum(line["rays_primary"] + line["rays_shadow"] for line in run.stats) / options.frames),
            "tiles_reissued_after_kill": sum(line["tiles_reissued"] for line in killed.stats),
            "pictures_that_differ": sum(digest != alone.digests[0] for digest in made_here), "pictures_compared": len(made_here)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", type=pathlib.Path, nargs="*")
    parser.add_argument("--copies", type=int, default=42, help="of each file; 42 of the seven make 106,512 patches")
    parser.add_argument("--arrange", choices=["flat", "instances"], default="flat")
    parser.add_argument("--slaves", type=int, default=3)
    parser.add_argument("--size", default="960x540")
    parser.add_argument("--frames", type=int, default=6)
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    options.files = [file.resolve() for file in options.files]
    begin = time.monotonic()
    result = measure(options) | {"date": time.strftime("%Y-%m-%d"), "whole_seconds": round(time.monotonic() - begin)}
    for key, value in result.items():
        print(f"{key:28} {value:,}" if isinstance(value, int) else f"{key:28} {value}")
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n")
    if result["taken_bytes_at_the_peak"] > result["reckoned_bytes"]:
        print("preparing the scene takes more than is reckoned")
        return 1
    return 1 if result["pictures_that_differ"] else 0


if __name__ == "__main__":
    sys.exit(main())
