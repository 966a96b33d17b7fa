# SPDX-License-Identifier: Apache-2.0
"""Rows A, third part: slaves that die together, come twice under one name, or lie."""
import time

from network import returns_within
from stage import MOVING, TILES, cluster_lib, wait_until


def f62(stage, report):
    """A slave that sends other pixels than it renders is convicted by an audit, and no frame has one of them."""
    stage.serve("--audit", "100")
    for name in ("slave-1", "slave-2"):
        stage.slave(name, sleep_ms=5)
    stage.slave("liar", node=5, sleep_ms=5, options=["--test-wrong-tile-every", "3"])
    stage.cluster.wait_for_slaves(3)
    stage.animate(frames=10)
    stage.now()
    lost = stage.first_event("slave-lost", time.time() - 60)
    report.claim("the liar is the one", "'liar'" in lost["text"] and "audit" in lost["reason"], lost)
    held = [q for q in stage.status()["quarantined"] if q["name"] == "liar"]
    report.claim("it is held back", len(held) == 1, stage.status()["quarantined"])
    run = stage.finish()
    wrong = sum(digest != right for digest, right in zip(run.digests, stage.expected_digests))
    report.figure("frames with a wrong pixel", wrong, 0, "")
    report.event("slave-lost", len(stage.events("slave-lost")))
    stage.oracle(settled_slaves=2)


def f66(stage, report):
    """A clone with a slave's key is refused while that one lives, disturbs nothing, and comes in when it has died."""
    stage.cluster_of(2)
    stage.animate(frames=40)
    stage.wait_for_frames(4)
    b = stage.bounds()
    began = stage.now()
    clone = stage.cluster.start("clone", [
        cluster_lib.program("tessera-slave"), "--master", stage.cluster.address, "--keys", str(stage.cluster.keys / "slave-1"),
        "--name", "slave-1", "--threads", "1", "--test-tile-sleep-ms", "40", "--log-format", "json"], node=5)
    refused = stage.first_event("slave-refused", began)
    report.claim("it is told why", "in use by slave 'slave-1'" in refused["text"], refused["text"])
    stage.wait_for_frames(len(stage.frames.lines) + 3)
    report.claim("the first one is not lost", not stage.events("slave-lost"), stage.events("slave-lost"))
    report.claim("the clone lives, and waits", clone.poll() is None)
    gone = stage.kill("slave-1")
    joined = stage.first_event("slave-joined", gone)
    report.figure("the clone is in", joined["at"] - gone, returns_within(b) + stage.lateness)
    stage.finish()
    report.event("slave-lost", len(stage.events("slave-lost")))
    stage.oracle(settled_slaves=2)


def f67(stage, report):
    """All slaves killed as a frame ends, while scenes change, and started again: the next frame is whole."""
    names = [f"slave-{i + 1}" for i in range(4)]
    stage.cluster_of(4)
    stage.animate(MOVING, frames=24)
    slowest = 0.0
    for _ in range(2):
        stage.wait_for_frames(len(stage.frames.lines) + 4)
        b = stage.bounds()
        done = len(stage.frames.lines)
        stage.wait_for_frames(done + 1)  # now
        for name in names:
            stage.process(name).kill()
        gone = stage.now()
        for name in names:
            stage.process(name).wait()
        for i, name in enumerate(names):
            stage.slave(name, node=2 + i)
        joined = wait_until("all are back", lambda: [e["at"] for e in stage.events("slave-joined", gone)][3:])[0]
        done = len(stage.frames.lines)
        stage.wait_for_frames(done + 1)
        slowest = max(slowest, stage.frames.times[done] - joined)
        for name in names:
            wait_until("each in use", lambda: (stage.cluster.slave_status(name) or {}).get("tiles_done", 0) > 4
                       or stage.animation.poll() is not None)
    report.figure("the next frame", slowest, b.scene + (TILES + 1) * b.tile + b.rtt + stage.lateness)
    report.event("slave-lost", len(stage.events("slave-lost")), 8)
    stage.finish()
    report.claim("no frame failed", not stage.events("frame-failed"), stage.events("frame-failed")[:1])
    stage.oracle(settled_slaves=4)


ROWS = {"F62": f62, "F66": f66, "F67": f67}
