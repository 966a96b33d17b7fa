# SPDX-License-Identifier: Apache-2.0
"""Rows about scenes that are larger than a slave's memory or read at a trickle."""
import pathlib
import re
import struct
import subprocess
import time

import moving
import peer
from stage import FRAME, MOVING, MOVING_VERSION_MIB, cluster_lib, wait_until


def large_scene(path, side):
    """Writes a binary PLY of a wavy square of 2 side^2 triangles. Returns: its path."""
    with open(path, "wb") as out:
        out.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {(side + 1) ** 2}\nproperty float x\n"
                  f"property float y\nproperty float z\nelement face {2 * side * side}\n"
                  "property list uchar int vertex_indices\nend_header\n".encode())
        for y in range(side + 1):
            out.write(b"".join(struct.pack("<3f", x, y, (x * 7 + y * 13) % 5 / 4) for x in range(side + 1)))
        for y in range(side):
            row, below = y * (side + 1), (y + 1) * (side + 1)
            out.write(b"".join(struct.pack("<B3iB3i", 3, row + x, row + x + 1, below + x, 3, row + x + 1, below + x + 1, below + x)
                               for x in range(side)))
    return path


SIDE = 700            # 980,000 triangles
SMALL_MIB = 96        # memory of a slave that cannot hold them
FILE_FRAME = [*FRAME, "--frames", "0:3", "--orbit", "10"]


def large_file(stage):
    """Returns: a file of 2 SIDE^2 triangles, which all move where the row's scenes do."""
    if stage.moves:
        return str(moving.waving_scene(stage.cluster.folder / "large.glb", SIDE))
    return str(large_scene(stage.cluster.folder / "large.ply", SIDE))


def versions_offered(stage):
    """Returns: how many versions of a scene a slave is offered before it can have answered one: those in flight."""
    return 2 if stage.moves else 1


def f09(stage, report):
    """When one slave of two has too little memory for the scene, the other renders the picture."""
    scene = large_file(stage)
    expected = stage.cluster.render(scene, *FILE_FRAME, "--local", "1", connect=False).digests
    stage.serve()
    stage.slave("large", sleep_ms=5)
    stage.cluster.wait_for_slaves(1)
    pid = stage.slave("small", node=4, sleep_ms=5, limits={"mem": SMALL_MIB})
    stage.cluster.wait_for_slaves(2)
    began = stage.now()
    run = stage.cluster.render(scene, *FILE_FRAME)
    report.picture(run.digests == expected)
    said = stage.events("scene-failed", began)
    report.note("it said that it cannot hold it" if said else "the kernel ended it" if not stage.lab.alive(pid) else "it held it")
    count = len(said) + len(stage.events("slave-lost", began))
    report.claim("one event", 1 <= count <= versions_offered(stage), [e["event"] for e in said])
    report.claim("it lives, or was ended by the kernel", stage.lab.alive(pid) or not said)
    stage.sampler.base["master"]["mib"] += 2 * pathlib.Path(scene).stat().st_size / 2**20  # read, and kept
    stage.oracle()


def f10(stage, report):
    """When no slave has memory enough, the frame fails and names the need; a smaller scene can still be rendered."""
    scene = large_file(stage)
    stage.serve()
    pids = [stage.slave(f"small-{i}", node=2 + i, sleep_ms=5, limits={"mem": SMALL_MIB}) for i in range(2)]
    stage.cluster.wait_for_slaves(2)
    began = stage.now()
    render = stage.cluster.start_render(scene, *FILE_FRAME)
    try:
        run = stage.cluster.finish(render)
    except subprocess.TimeoutExpired:
        render.kill()
        render.communicate()
        report.claim("the frame fails", False, f"slaves alive: {[stage.lab.alive(p) for p in pids]}")
        return
    report.claim("the frame fails in one line", run.code == 3 and len(run.stderr.strip().splitlines()) == 1, run.stderr)
    report.claim("it names the need", re.search(r"needs about \d+ MiB", run.stderr), run.stderr)
    report.claim("and the largest slave", re.search(rf"'small-\d', may take {SMALL_MIB} MiB", run.stderr), run.stderr)
    report.claim("slaves live", all(stage.lab.alive(p) for p in pids) and not stage.events("slave-lost", began))
    report.figure("attempts", len(stage.events("scene-failed", began)), 2 * versions_offered(stage), "")
    again = stage.cluster.finish(stage.cluster.start_render("builtin:cornell", *FRAME))
    report.claim("a smaller scene is rendered", again.code == 0, again.stderr)


def f21(stage, report):
    """A slave that reads its scene at a trickle stays, and hardly slows the others."""
    stage.cluster_of(2, options=["--log-level", "debug"])
    stage.animate(MOVING, frames=6)
    stage.finish()
    without = stage.usual_mean(stage.frames.times[1], stage.frames.times[-1])
    version = max(int(e["bytes"]) for e in stage.events("scene-received", log="slave-1")) / 2**20
    relay = subprocess.Popen([*stage.cluster.prefix(5), *peer.tcpfault(
        "proxy", "--listen", "127.0.0.1:7997", "--to", stage.cluster.address, "--rate", 100, "--chunk", 1000, "--dir", "down", "--conn", 2)],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    stage.clean.callback(relay.stdout.close)
    stage.clean.callback(relay.wait)
    stage.clean.callback(relay.terminate)
    relay.stdout.readline()
    stage.cluster.start("trickle", [
        cluster_lib.program("tessera-slave"), "--master", "127.0.0.1:7997", "--keys", stage.cluster.add_key("slave", "trickle"),
        "--name", "trickle", "--threads", "1", "--test-tile-sleep-ms", "40"], node=5)
    stage.cluster.wait_for_slaves(3)
    b = stage.bounds()
    stage.now()
    stage.frames.stop()
    stage.animate(MOVING, frames=10)
    stage.wait_for_frames(10)
    with_it = stage.usual_mean(stage.frames.times[1], stage.frames.times[-1])
    # Its queue is in the oracle's figure of memory, whose bound counts two versions.
    report.figure("a version", version, MOVING_VERSION_MIB, "MiB")
    report.figure("others' frame time", with_it, 1.25 * without + stage.measured_lateness)
    stage.finish()
    report.claim("alive while bytes move", not stage.events("slave-lost"), stage.events("slave-lost"))
    report.note(f"T_det {b.detection:.2f} s")
    wait_until("status", stage.status)
    time.sleep(0.1)
    stage.oracle()


ROWS = {"F09": f09, "F10": f10, "F21": f21}
