# SPDX-License-Identifier: Apache-2.0
"""Rows E: the master dies and returns; the application dies, stands still, hurries; others ask for the status."""
import os
import signal
import socket
import struct
import subprocess
import time

import peer
from stage import MOVING, TILES, cluster_lib, wait_until


def f44(stage, report):
    """The master is killed and restarted; four slaves and the application come back, and every frame comes."""
    master = stage.serve()
    stage.slaves(4)
    stage.animate(frames=30)
    stage.wait_for_frames(4)
    b = stage.bounds()
    port = stage.cluster.port
    stage.now()
    stage.kill("master")
    time.sleep(b.detection)
    stage.quiet([f"slave-{i + 1}" for i in range(4)])
    again = stage.cluster.start("master", [
        cluster_lib.program("tessera-master"), "serve", "--listen", f"{stage.cluster.host}:{port}", "--keys",
        str(stage.cluster.keys / "master"), "--log-format", "json"])
    # The new process is measured against the old one at the same work.
    before = {**stage.sampler.base["master"], "mib": stage.sampler.peak["master"]}
    stage.sampler.follow("master", again.pid)
    stage.sampler.base["master"] = before
    stage.sampler.late, born = 0.0, time.time()
    wait_until("all back", lambda: len(stage.events("slave-joined", born)) >= 4)
    back = max(e["at"] for e in stage.events("slave-joined", born))
    report.figure("all back", back - born, 1.5 * b.reconnect_max + b.handshake + b.scene + stage.lateness)
    joined = stage.first_event("application-joined", born)["at"]
    report.figure("the application is back", joined - born, b.reconnect_max + b.handshake + stage.lateness)
    stage.finish()
    for i in range(4):
        report.claim(f"slave-{i + 1}: one event", len(stage.events("master-lost", born - 60, log=f"slave-{i + 1}")) == 1)
    report.claim("another process", again.pid != master.pid)
    stage.oracle(settled_slaves=4)


def f45(stage, report):
    """An application killed with two frames in flight frees the cluster at once."""
    stage.cluster_of(2)
    stage.animate(MOVING, frames=12)
    stage.wait_for_frames(2)
    stage.wait_for_tiles("slave-1")
    b = stage.bounds()
    stage.now()
    stage.animation.kill()
    stage.animation.communicate()
    gone = time.time()  # the process has ended, so its socket is closed by then
    left = stage.first_event("application-left", gone - 1)
    cancelled = wait_until("tiles cancelled", lambda: all(
        s["tiles_in_flight"] == 0 for s in stage.status()["slaves"]) and time.time())
    report.figure("noticed", left["at"] - gone, b.rtt + stage.lateness)
    report.figure("cancel", cancelled - gone, b.rtt + b.tile + 0.2 + stage.lateness)
    stage.quiet(["master", "slave-1", "slave-2"])
    stage.cluster.processes.pop(stage.animation.tessera[0], None)
    stage.frames.stop()
    stage.animate(frames=4)
    stage.finish()
    report.event("application-left", len([e for e in stage.events("application-left") if "goodbye" not in e["reason"]]))
    report.claim("no slave lost", not stage.events("slave-lost"))
    stage.oracle(settled_slaves=2)


def allowed_silence(stage):
    """How long an application may be silent: what the master tells one that comes."""
    comer = peer.Link(stage, 1, stage.cluster.add_key("app", "comer"))
    comer.say(peer.HELLO, peer.hello("comer", role=1))
    _, welcome, _ = comer.hear(peer.WELCOME)
    comer.say(peer.GOODBYE, {1: "enough"})
    comer.close()
    wait_until("without an application", lambda: not stage.status()["has_application"])
    return welcome[4] / 1e3 * (welcome[5] + 1)


def f46(stage, report):
    """An application that stops for a moment goes on; one that stops for longer than the limit is gone, and comes back."""
    stage.cluster_of(2)
    silence = allowed_silence(stage)
    stage.animate(frames=12)
    stage.wait_for_frames(3)
    b = stage.bounds()
    stage.now()
    os.kill(stage.animation.pid, signal.SIGSTOP)
    time.sleep(silence / 2)
    os.kill(stage.animation.pid, signal.SIGCONT)
    stage.finish()
    report.claim("a short stop costs nothing", not stage.events("application-left", 0) or all(
        "goodbye" in e["reason"] for e in stage.events("application-left")))
    stage.frames.stop()
    stage.animate(frames=40)
    stage.wait_for_frames(3)
    began = stage.now()
    os.kill(stage.animation.pid, signal.SIGSTOP)
    left = stage.first_event("application-left", began)
    report.figure("treated as gone", left["at"] - began, silence + b.rtt + stage.lateness)
    time.sleep(0.5)
    stage.quiet(["master", "slave-1", "slave-2"])
    resumed = stage.now()
    os.kill(stage.animation.pid, signal.SIGCONT)
    back = stage.first_event("application-joined", resumed)["at"]
    report.figure("back", back - resumed, b.backoff_first + b.handshake + stage.lateness)
    stage.finish()
    stage.oracle(settled_slaves=2)


DEPTH = 2  # the frames that an application may have in the master (--frames-in-flight)


def too_many(stage, report):
    """An application that does not wait is closed before its frames pile up."""
    rude = peer.Link(stage, 1, stage.cluster.add_key("app", "rude"))
    rude.say(peer.HELLO, peer.hello("rude", role=1))
    rude.hear(peer.WELCOME)
    said = stage.now()
    try:
        for number in range(8):
            rude.say(peer.SUBMIT, {1: number, 2: 1, **peer.SETTINGS})
    except OSError:  # closed in the middle: the reason is in the master's log
        pass
    rude.wait_for_end()
    reason = stage.first_event("application-left", said)["reason"]
    report.claim("who submits without end is closed", "frames submitted at once" in reason, reason)
    rude.close()


def f47(stage, report):
    """The application submits faster than the cluster renders: submit waits, the depth is two frames."""
    stage.cluster_of(1, sleep_ms=30)
    stage.animate(frames=10)
    depths = []
    while len(stage.frames.lines) < 9 and stage.animation.poll() is None:
        depths.append(stage.status()["frames_open"])
        time.sleep(0.05)
    run = stage.finish()
    report.figure("frames submitted and not delivered", max(depths), DEPTH, "")
    report.claim("as many as there may be, most of the time", sorted(depths)[len(depths) // 2] == DEPTH, depths)
    spans = [line["seconds"] for line in run.stats]
    # A frame waits for those before it, and takes its own time: one tile after another on one thread.
    report.figure("latency", max(spans), DEPTH * (TILES + 1) * stage.bounds().tile + stage.lateness)
    stage.frames.stop()
    too_many(stage, report)
    stage.oracle(settled_slaves=1)


MOVING_PLAIN_MB, MOVING_CODED_MB = 0.8, 0.6  # a version of MOVING, on a fast link and on one slower than the codec


def version_mb(stage):
    """Returns the most that a slave was sent for a frame, once the master knows how fast the links are."""
    return max(line["scene_bytes"] / len(stage.nodes) / 1e6 for line in stage.frames.lines[2:])


def f48(stage, report):
    """With scene updates larger than a frame time allows the rate falls; order and content stay right."""
    stage.cluster_of(2, "--relay", "off")  # so that each slave has its bytes from the master
    stage.animate(MOVING, frames=6)
    stage.finish()
    report.figure("a version", version_mb(stage), MOVING_PLAIN_MB, "MB")
    for node in (2, 3):
        stage.lab.shape(node, rate=20000)
    stage.now()
    stage.frames.stop()
    stage.animate(MOVING, frames=6)
    stage.finish()
    report.claim("no slave lost", not stage.events("slave-lost"), stage.events("slave-lost"))
    report.note(f"{1e3 * stage.frames.usual():.0f} ms a frame at 20 Mbit/s")
    report.figure("a version, coded", version_mb(stage), MOVING_CODED_MB, "MB")
    stage.oracle(settled_slaves=2)


ASKERS = 30  # programs at once; an address may have 16 connections in their handshake (64 in all)
RUDE_ASKERS = 24


def leave_twice(asker):
    """The asker says goodbye three times, in one write."""
    asker.send(peer.record(peer.STATUS_REQUEST) + 3 * peer.record(peer.GOODBYE, {1: "enough"}))


def leave_by_reset(asker):
    """The asker asks much, reads nothing, says goodbye and is gone with a reset."""
    asker.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    asker.send(200 * peer.record(peer.STATUS_REQUEST) + peer.record(peer.GOODBYE, {1: "enough"}))


def break_rules_twice(asker):
    """The asker cancels a frame twice, which is not for it to do, and leaves."""
    asker.send(2 * peer.record(peer.CANCEL, {1: 1}) + peer.record(peer.GOODBYE, {1: "enough"}))


def f58(stage, report):
    """Many ask for the status while frames are rendered; some leave twice, by a reset, or break the rules."""
    stage.cluster_of(2)
    stage.animate(frames=24)
    stage.wait_for_frames(3)
    stage.bounds()
    keys = stage.cluster.add_key("app", "asks")
    stage.now()
    programs = [subprocess.Popen(
        [*stage.cluster.prefix(1), cluster_lib.program("tessera-master"), "status", "--connect", stage.cluster.address, "--keys", keys],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for _ in range(ASKERS)]
    came_late = 0
    for i in range(RUDE_ASKERS):
        asker = None
        try:
            asker = peer.Link(stage, 5, keys)
            asker.say(peer.HELLO, peer.hello("asks", role=2))
            asker.hear(peer.WELCOME)
            (leave_twice, leave_by_reset, break_rules_twice)[i % 3](asker)
        except OSError:  # it was closed for its silence, since this machine was busy
            came_late += 1
        if asker is not None:
            asker.close()
    report.claim("most were rude in time", came_late < RUDE_ASKERS / 2, f"{came_late} came late")
    # On a busy machine some programs come too late for their handshake, and say so.
    said = [program.communicate(timeout=60)[1].strip().splitlines() for program in programs]
    codes = [program.returncode for program in programs]
    report.claim("each gets its answer, or one line", all(
        code == 0 or (code == 1 and len(lines) == 1) for code, lines in zip(codes, said)), list(zip(codes, said)))
    report.note(f"{codes.count(0)} of {ASKERS} were answered")
    if not report.claim("the master lives", stage.process("master").poll() is None):
        return
    report.claim("and answers", (stage.status() or {}).get("slaves"))
    stage.finish()
    report.claim("no slave lost", not stage.events("slave-lost"), stage.events("slave-lost"))
    stage.oracle(settled_slaves=2)


ROWS = {"F44": f44, "F45": f45, "F46": f46, "F47": f47, "F48": f48, "F58": f58}
