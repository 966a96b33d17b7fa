#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders the moving scenes of the thesis's pictures F7.5 and F7.6 as it did, beside its figures: 144 waving cones, as triangles
and as patches, and 32,768 teapots, as one surface, as instances of one and as instances of a mesh.

Start-up is from the start of the program to the end of the first frame, which takes its samples from the second on; memory is
the most that the process, master and slave in one, has held. CPU time of all threads stands beside, since machines are shared.
--json FILE writes a result for tables.py.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / folder) for folder in ("bench", "cluster")]
import cluster_lib  # noqa: E402
import result_file  # noqa: E402

# Scene, what it stands for, and the thesis's figure.
SCENES = [("cones", "F7.5, patches", ""), ("cones-mesh", "F7.5, triangles", "6.6 frames/s"),
          ("teapots-apart", "F7.6, one surface", ""), ("teapots", "F7.6, instances", "4.42 s start-up, 2 frames/s"),
          ("teapots-mesh", "F7.6, instances of triangles", "")]
COLUMNS = ["scene", "stands for", "frames/s", "CPU-s a frame", "start-up, s", "CPU-s", "memory, MB", "primitives built: first frame", "each later frame",
           "the thesis"]


def cpu_of(process):
    """Returns the CPU-seconds of a process so far."""
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def end_of(process):
    """Waits for a process. Returns its CPU-seconds and the most memory that it held, in bytes."""
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def has_line(path):
    return path.exists() and "\n" in path.read_text(encoding="utf-8")


def measure(scene, frames, size):
    with tempfile.TemporaryDirectory(prefix="tessera-motion-") as scratch:
        stats = pathlib.Path(scratch) / "stats.jsonl"
        begun = time.monotonic()
        process = subprocess.Popen(
            [cluster_lib.program("tessera-master"), "render", f"builtin:{scene}", "--frames", f"0:{frames - 1}", "--orbit", "30",
             "--renderer", "direct", "--aa", "1", "--exposure", "0", "--size", size, "--quiet", "--stats", str(stats), "-o",
             str(pathlib.Path(scratch) / "f%04d.png")])
        while not has_line(stats):
            if process.poll() is not None:
                sys.exit(f"thesis_motion: rendering {scene} ended with {process.returncode}")
            time.sleep(0.01)
        first, first_cpu = time.monotonic() - begun, cpu_of(process)
        cpu, peak = end_of(process)
        if process.returncode != 0:
            sys.exit(f"thesis_motion: rendering {scene} ended with {process.returncode}")
        rows = [json.loads(line) for line in stats.read_text(encoding="utf-8").splitlines()]
    at = [row["completed_at"] for row in rows]
    rate = (len(at) - 1) / (at[-1] - at[0])
    later = statistics.median(row["built_primitives"] for row in rows[1:])
    return rate, (cpu - first_cpu) / (frames - 1), first, first_cpu, peak, rows[0]["built_primitives"], later


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=12)
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--scene", nargs="+", choices=[name for name, _, _ in SCENES])
    parser.add_argument("--json", help="write a result for tables.py")
    options = parser.parse_args()
    rows = []
    for name, what, thesis in SCENES:
        if options.scene and name not in options.scene:
            continue
        rate, cpu, first, first_cpu, peak, built, later = measure(name, options.frames, options.size)
        rows.append([name, what, f"{rate:.2f}", f"{cpu:.2f}", f"{first:.2f}", f"{first_cpu:.2f}", f"{peak / 1e6:.0f}", f"{built:,}", f"{later:,.0f}", thesis])
        print(*rows[-1], sep=" | ", flush=True)
        if options.json:
            result_file.write(options.json, cluster_lib.program("tessera-master"), {"motion": (COLUMNS, rows)})


if __name__ == "__main__":
    os.environ.setdefault("TESSERA_BIN", str(TESTS.parent / "build" / "release" / "bin"))
    main()
