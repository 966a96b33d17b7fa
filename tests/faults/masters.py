# SPDX-License-Identifier: Apache-2.0
"""Rows E, second half: a master whose own port, clock, descriptors or processor fail it, and uploads that break off."""
import glob
import hashlib
import os
import resource
import struct
import subprocess
import time

import application
import peer
import watch
from network import returns_within
from stage import FRAME, MEMORY_SLACK_MIB, PATIENCE_S, STILL, cluster_lib, wait_until


def dead_one_way(stage, report, direction, words):
    """What the master sends, or what it should get, is lost beyond its own machine. The application is on it."""
    stage.cluster_of(3)
    b = stage.bounds()
    errors = stage.cluster.folder / "told.txt"
    with open(errors, "w", encoding="utf-8") as file:
        render = subprocess.Popen([
            *stage.cluster.prefix(1), cluster_lib.program("tessera-master"), "render", *STILL, *FRAME, "--frames", "0:9999",
            "--renderer", "direct", "--aa", "1", "--light", "scene", "--exposure", "0", "--connect", stage.cluster.address,
            "--keys", str(stage.cluster.keys / "app"), "-o", str(stage.cluster.folder / "told-%04d.pfm")],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=file)
    stage.cluster.processes["told"] = render
    wait_until("frames", lambda: stage.status()["frames_done"] > 2)
    began = stage.cut("master", direction=direction)
    event = stage.first_event("nobody-heard", began)
    # The last slave was silent from the cut on, or noticed that it heard nothing, by then.
    report.figure("found out", event["at"] - began, b.detection + b.heartbeat + b.rtt + stage.lateness)
    report.claim("the event says which way", words in event["text"] and "3 slaves" in event["text"], event["text"])
    report.claim("status says it", words in stage.status()["alone_reason"], stage.status()["alone_reason"])
    wait_until("the application is told", lambda: words in errors.read_text())
    report.claim("and not that no slave is there", "no slave is there" not in errors.read_text())
    healed = stage.heal("master")
    wait_until("all are back", lambda: len(stage.events("slave-joined", healed)) >= 3)
    back = max(e["at"] for e in stage.events("slave-joined", healed))
    report.figure("all are back", back - healed, returns_within(b) + stage.lateness)
    report.claim("nothing is said any more", stage.status()["alone_reason"] == "")
    stage.cluster.wait_for_frames(2, render)
    stage.cluster.processes.pop("told").terminate()
    render.wait(PATIENCE_S)
    report.event("nobody-heard", len(stage.events("nobody-heard")))


def f59(stage, report):
    """A master whose port sends nothing says so to its application, and goes on when it is healed."""
    dead_one_way(stage, report, "out", "nothing that this master sends arrives")


def f59deaf(stage, report):
    """A master whose port gets nothing says so to its application, and goes on when it is healed."""
    dead_one_way(stage, report, "in", "nothing reaches this master")


CHUNK_BYTES, CHUNKS, SENT = 64 * 1024, 4096, 400


def begin_upload(stage, name):
    """An application at node 5 announces a block and sends a tenth of it. Returns: its link."""
    uploader = peer.Link(stage, 5, stage.cluster.add_key("app", name))
    uploader.say(peer.HELLO, peer.hello(name, role=1))
    uploader.hear(peer.WELCOME)
    chunk = b"\x5a" * CHUNK_BYTES
    digests = hashlib.sha256(chunk).digest() * CHUNKS
    size = struct.pack("<Q", CHUNKS * CHUNK_BYTES)
    block = hashlib.sha256(LIST_TAG + size + digests).digest()
    uploader.say(peer.ANNOUNCE, {1: 1, 2: 1}, block + size)
    uploader.hear(peer.NEED)
    uploader.say(peer.CHUNK_LIST, {1: 1, 2: 0, 3: CHUNKS}, digests)
    uploader.hear(peer.CHUNK_NEED)
    for i in range(SENT):
        uploader.say(peer.CHUNK, {1: 1, 2: 0, 3: i * CHUNK_BYTES}, chunk)
    return uploader


LIST_TAG = b"TSSL"  # before the digests of a block of several chunks (common/scene/block_chunks.cpp)


def f60(stage, report):
    """What an upload held that was killed is freed at once; one that was cut off, after an application's silence."""
    stage.cluster_of(2)
    silence = application.allowed_silence(stage)
    b = stage.bounds()
    sent_mib = SENT * CHUNK_BYTES / 2**20
    pid = stage.pid("master")
    begin_upload(stage, "warm").close()  # what every first upload costs
    wait_until("it has gone", lambda: not stage.status()["has_application"])
    for how, within in (("killed", b.rtt), ("cut off", silence + b.rtt)):
        base = watch.resident_mib(pid)
        name = f"upload-{how.replace(' ', '-')}"
        uploader = begin_upload(stage, name)
        wait_until("the master holds it", lambda: watch.resident_mib(pid) > base + 0.9 * sent_mib)
        began = stage.now()
        if how == "killed":
            uploader.close()
        else:
            stage.lab.cut(5)
        left = stage.first_event("application-left", began)
        report.figure(f"{how}: noticed", left["at"] - began, within + b.heartbeat + stage.lateness)
        wait_until("memory is given back", lambda: watch.resident_mib(pid) < base + sent_mib / 2)
        report.figure(f"{how}: memory left", watch.resident_mib(pid) - base, MEMORY_SLACK_MIB, "MiB")
        stage.lab.heal(5)
        if how == "cut off":
            uploader.close()
    stage.animate(frames=4)
    stage.finish()
    report.event("application-left", len([e for e in stage.events("application-left") if "upload-" in e["text"]]), 2)


LIBRARIES = glob.glob("/usr/lib/*/faketime/libfaketime.so.1")


def f63(stage, report):
    """The clock of the master and of a slave jumps an hour back and two forward: no slave is lost, no frame late."""
    assert LIBRARIES, "libfaketime is not installed (deploy/install-dependencies.sh --with test)"
    clock = stage.cluster.folder / "clock"
    clock.write_text("+0\n")
    prefix = stage.cluster.prefix
    stage.cluster.prefix = lambda node: [
        *prefix(node), "env", f"LD_PRELOAD={LIBRARIES[0]}", f"FAKETIME_TIMESTAMP_FILE={clock}", "FAKETIME_NO_CACHE=1",
        "FAKETIME_DONT_FAKE_MONOTONIC=1", "DONT_FAKE_MONOTONIC=1"]
    stage.serve()
    stage.slave("slave-1")
    stage.cluster.prefix = prefix
    stage.slave("slave-2")
    stage.cluster.wait_for_slaves(2)
    stage.animate(frames=24)
    stage.wait_for_frames(6)
    usual = max(b - a for a, b in zip(stage.frames.times[1:], stage.frames.times[2:]))
    b = stage.bounds()
    began = stage.now()
    for offset in ("-1h", "+1h", "+0"):
        clock.write_text(offset + "\n")
        stage.wait_for_frames(len(stage.frames.lines) + 3)
    report.figure("gap", stage.frames.gap_after(began), usual + b.reissue + b.tile + stage.lateness)
    stage.finish()
    report.claim("no slave lost", not stage.events("slave-lost"), stage.events("slave-lost"))
    report.claim("no application lost", all("goodbye" in e["reason"] for e in stage.events("application-left")))
    stage.oracle(settled_slaves=2)


def f64(stage, report):
    """A master without descriptors tells a new slave so, answers status, and renders on; lifted, it lets the slave in."""
    stage.cluster_of(4)  # the least limit is 20 (common/base/descriptors.cpp), and a quarter of it is kept
    stage.animate(frames=60)
    stage.wait_for_frames(3)
    b = stage.bounds()
    pid = stage.pid("master")
    limits = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    time.sleep(2)  # until the connections that asked for the status are put away
    taken = {int(fd) for fd in os.listdir(f"/proc/{pid}/fd")}
    free = next(fd for fd in range(len(taken) + 1) if fd not in taken)
    # A quarter of the limit is kept: the next descriptor is the first of those.
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (free * 4 // 3, limits[1]))
    began = stage.now()
    stage.slave("late", node=5)
    event = stage.first_event("out-of-descriptors", began)
    report.figure("said after", event["at"] - began, b.handshake + stage.lateness)
    wait_until("the slave is told", lambda: any("no connections left" in e["text"] for e in stage.events("master-not-there", log="late")))
    report.claim("status is answered", len((stage.status() or {"slaves": []})["slaves"]) == 4)
    stage.wait_for_frames(len(stage.frames.lines) + 2)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, limits)
    lifted = stage.now()
    joined = stage.first_event("slave-joined", lifted)
    report.figure("in", joined["at"] - lifted, returns_within(b) + stage.lateness)
    stage.finish()
    report.event("out-of-descriptors", len(stage.events("out-of-descriptors")))
    report.claim("no slave lost", not stage.events("slave-lost"), stage.events("slave-lost"))
    stage.oracle(settled_slaves=5)


def f68(stage, report):
    """A master that stands still for less than T_det loses nobody; for longer, all come back, the application stays."""
    stage.cluster_of(3)
    stage.animate(frames=30)
    stage.wait_for_frames(4)
    b = stage.bounds()
    stage.pause("master")
    time.sleep(b.detection - 2 * b.heartbeat)
    stage.resume("master")
    stage.wait_for_frames(len(stage.frames.lines) + 2)
    report.claim("a short stop loses nobody", not stage.events("slave-lost"), stage.events("slave-lost"))
    stage.pause("master")
    time.sleep(2 * b.detection)
    noticed = [stage.events("master-lost", log=f"slave-{i + 1}") for i in range(3)]
    report.claim("each slave has noticed", all(len(events) == 1 for events in noticed), noticed)
    stage.sampler.late = 0.0
    resumed = stage.resume("master")
    wait_until("all are back", lambda: len(stage.events("slave-joined", resumed)) >= 3)
    back = max(e["at"] for e in stage.events("slave-joined", resumed))
    report.figure("all are back", back - resumed, returns_within(b) + stage.lateness)
    stage.finish()
    report.event("slave-lost", len(stage.events("slave-lost")), 3)
    report.claim("the application stays", all("goodbye" in e["reason"] for e in stage.events("application-left")))
    stage.oracle(settled_slaves=3)


ROWS = {"F59": f59, "F59deaf": f59deaf, "F60": f60, "F63": f63, "F64": f64, "F68": f68}
