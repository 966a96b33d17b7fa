# SPDX-License-Identifier: Apache-2.0
"""Rows A, first half: slaves that die, hang, leave, crash and come back."""
import signal
import time

from stage import MOVING, PATIENCE_S, TILES, time_of, wait_until

# The most tiles that one thread of a slave holds by default, its prefetch and the one in work, for bounds where nobody
# could look at what it held as it was lost.
PREFETCHED = 4


def f01(stage, report):
    """A slave killed in the middle of a tile is noticed at once, and costs no pixel."""
    stage.cluster_of(3)
    stage.animate(frames=10)
    stage.wait_for_frames(4)
    report.values["tiles_lost"] = stage.wait_for_tiles("slave-3")
    b = stage.bounds()
    gone = stage.kill("slave-3")
    lost = stage.first_event("slave-lost", gone - 1)
    report.figure("detection", lost["at"] - gone, b.rtt + stage.lateness)
    stage.finish()
    usual = stage.usual_without("slave-3", gone)
    report.figure("gap", stage.frames.gap_after(gone),
                  usual + b.redo(report.values["tiles_lost"], ["slave-3"]) + b.reissue + stage.lateness)
    report.event("slave-lost", len(stage.events("slave-lost")))
    report.claim("reason=closed", "clos" in lost.get("reason", ""), lost)
    stage.oracle(settled_slaves=2)


def silent_slave(stage, report, name, begin, end, after, must_end=True):
    """A slave that falls silent by begin() and speaks again by end(), as in F02, F13, F15 and F16.

    after(b): how long after end() the slave may take until it is in use again. must_end: it cannot come back before.
    """
    report.values["tiles_lost"] = stage.wait_for_tiles(name)
    b = stage.bounds()
    began = begin()
    lost = stage.first_event("slave-lost", began)
    report.figure("detection", lost["at"] - began, b.detection + stage.lateness)
    stage.wait_for_frames(len(stage.frames.lines) + 2)
    report.figure("gap", stage.frames.gap_after(began), b.detection + stage.usual_without(name, began) + b.redo(
        report.values["tiles_lost"], [name]) + b.reissue + stage.lateness)
    ended = end() if must_end else lost["at"]
    joined = stage.first_event("slave-joined", ended)
    report.figure("back", joined["at"] - ended, after(b) + stage.lateness)
    stage.wait_in_use(name, what="in use again")
    report.event("slave-lost", len(stage.events("slave-lost")))


def f02(stage, report):
    """A slave stopped for less than T_det loses nothing; stopped for longer, it is lost and comes back."""
    stage.cluster_of(3)
    stage.animate(frames=24)
    stage.wait_for_frames(4)
    stage.wait_for_tiles("slave-3")
    b = stage.bounds()
    stage.pause("slave-3")
    time.sleep(b.detection - 2 * b.heartbeat)
    resumed = stage.resume("slave-3")
    time.sleep(2 * b.detection)
    report.claim("a short pause loses nothing", not stage.events("slave-lost"), stage.events("slave-lost"))
    report.claim("and needs no reconnect", len(stage.events("slave-joined")) == 3)
    silent_slave(stage, report, "slave-3", lambda: stage.pause("slave-3"), lambda: stage.resume("slave-3"),
                 lambda b: b.backoff_first + b.handshake + b.scene)
    stage.finish()
    report.claim("no result of the old session", not stage.events("slave-expelled", resumed))
    stage.oracle(settled_slaves=3)


def f03(stage, report):
    """A slave that gets SIGTERM ends its tiles, hands back its queue and says goodbye."""
    stage.cluster_of(3)
    stage.animate(frames=10)
    stage.wait_for_frames(3)
    stage.wait_for_tiles("slave-3")
    b = stage.bounds()
    asked = stage.now()
    code = stage.process("slave-3")
    code.send_signal(signal.SIGTERM)
    left = code.wait(PATIENCE_S)
    report.figure("exit", time.time() - asked, b.tile + b.rtt + 1 + stage.lateness)
    report.claim("exit code 0", left == 0, left)
    run = stage.finish()
    report.claim("nothing is rendered twice", report.values["tiles_rendered_twice"] == 0, [
        line["tiles_rejected"] for line in run.stats])
    report.event("slave-left", len(stage.events("slave-left")))
    report.claim("no slave-lost", not stage.events("slave-lost"))
    stage.oracle(settled_slaves=2)


def f05(stage, report):
    """A slave that crashes in the renderer again and again is held back for a growing time."""
    stage.cluster_of(2)
    stage.animate(frames=90)
    stage.wait_for_frames(4)
    b = stage.bounds()
    stage.now()
    began = time.time()

    def crashes(until, first):
        """Starts the slave again whenever it has crashed, as systemd would."""
        count = 0
        while not until() and count < 20:
            stage.slave("crasher", node=5, sleep_ms=10, options=["--test-abort-at-tile", "2"])
            count += 1
            wait_until("crashed or held back", lambda: stage.process("crasher").poll() is not None or until())
        process = stage.cluster.processes.pop("crasher")
        if process.poll() is None:
            process.kill()
        process.wait()
        report.figure(f"losses until it is held back ({first})", len(stage.events("slave-lost")), 3 if first == 1 else 6, "")

    def held(times):
        return [q for q in stage.status()["quarantined"] if q["name"] == "crasher" and q["times"] >= times]

    crashes(lambda: held(1), 1)
    report.figure("held back", held(1)[0]["seconds"], 25, "s", least=True)
    stage.slave("crasher", node=5, sleep_ms=10)
    refused = stage.first_event("slave-refused", began)
    report.claim("refused with the reason", "held back" in refused["text"], refused["text"])
    joined = stage.first_event("slave-joined", refused["at"])
    quarantined = stage.first_event("slave-quarantined", began)
    report.figure("let in after", joined["at"] - quarantined["at"], 30 - 0.01, least=True)
    report.figure("and no later than", joined["at"] - quarantined["at"], 30 + b.reconnect_max * 1.5 + stage.lateness)
    stage.process("crasher").terminate()
    stage.process("crasher").wait()
    crashes(lambda: held(2), 2)
    report.figure("held back again", held(2)[0]["seconds"], 55, "s", least=True)
    stage.animation.terminate()
    stage.cluster.finish(stage.animation)
    stage.frames.stop()
    done = [f["digest"] for f in stage.frames.lines]
    report.picture(done == stage.expected_digests[:len(done)])
    report.claim("no frame failed", not stage.events("frame-failed"))
    stage.oracle(settled_slaves=2)


def f06(stage, report):
    """All slaves lost: the frame in work is kept, and a new slave ends it."""
    stage.cluster_of(2)
    stage.animate(frames=8)
    stage.wait_for_frames(2)
    stage.wait_for_tiles("slave-1")
    b = stage.bounds()
    gone = stage.now()
    stage.kill("slave-1")
    stage.kill("slave-2")
    none_left = time_of("no slaves in status", lambda: not stage.status()["slaves"])
    report.figure("detection", none_left - gone, b.detection + stage.lateness)
    done = len(stage.frames.lines)
    stage.quiet(["master"])
    report.claim("the application waits", stage.animation.poll() is None and len(stage.frames.lines) <= done + 1)
    born = stage.now()
    stage.slave("slave-9")
    joined = stage.first_event("slave-joined", born)
    stage.wait_for_frames(done + 1)
    # The frame in work has at most all its tiles left.
    report.figure("resumes", stage.frames.times[done] - joined["at"],
                  b.scene + (TILES + 1) * b.tile + b.rtt + stage.lateness)
    stage.finish()
    report.claim("2 events slave-lost", len(stage.events("slave-lost")) == 2)
    report.claim("no frame failed", not stage.events("frame-failed"))
    stage.oracle(settled_slaves=1)


def f07(stage, report):
    """A slave is killed and comes back at once, again and again, within frames of changing scenes."""
    times = 12 if stage.is_small else 100
    stage.cluster_of(2)
    stage.animate(MOVING, frames=3 * times // 2)
    stage.wait_for_frames(2)
    b = stage.bounds()
    slowest = 0.0
    kills = 0
    while kills < times and (kills < 2 or len(stage.frames.lines) < len(stage.expected_digests) - 3):
        stage.kill("slave-2")
        began = stage.now()
        stage.slave("slave-2", node=3)
        joined = stage.first_event("slave-joined", began)
        # The slave must bring more tiles than it holds, or else it is taken for one that crashes (F05).
        stage.wait_in_use("slave-2", tiles=PREFETCHED)
        slowest = max(slowest, joined["at"] - began)
        kills += 1
    report.note(f"{kills} kills")
    report.claim("killed again and again", kills >= 2, kills)
    report.figure("usable after", slowest, b.handshake + b.scene + stage.lateness)
    stage.finish()
    report.claim("as many events slave-lost as kills", len(stage.events("slave-lost")) == kills)
    report.claim("each tile once", stage.status()["tiles_accepted"] == TILES * stage.frames_asked,
                 stage.status()["tiles_accepted"])
    stage.oracle(settled_slaves=2)


ROWS = {"F01": f01, "F02": f02, "F03": f03, "F05": f05, "F06": f06, "F07": f07}
