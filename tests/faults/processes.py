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


def hang_gap(stage, b, name, began):
    """Returns the longest gap that a slave may cause which returns nothing, however long it takes to find out why."""
    return stage.usual_without(name, began) + b.reissue + b.tile + stage.lateness


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
    report.figure("gap", stage.frames.gap_after(began), hang_gap(stage, b, name, began))
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


def keep_alive(stage, names, options, until, deaths):
    """Starts each of these slaves again as soon as it has died, until the condition holds; counts the deaths."""
    deadline = time.monotonic() + PATIENCE_S
    while not until() and time.monotonic() < deadline:
        for node, name in names.items():
            process = stage.cluster.processes.get(name)
            if process is not None and process.poll() is None:
                continue
            if process is not None:
                deaths[name] = deaths.get(name, 0) + 1
                stage.cluster.processes.pop(name)
            stage.slave(name, node=node, sleep_ms=5, **options)
        time.sleep(0.02)
    assert until(), "it does not come to an end"


def put_away(stage, names):
    for name in names:
        process = stage.cluster.processes.pop(name, None)
        if process is not None:
            process.kill()
            process.wait()


def f05large(stage, report):
    """A slave of 64 threads that dies with its first tile, restarted at once, fails no frame beside two healthy ones."""
    runs = 1 if stage.is_small else 20
    stage.cluster_of(2, sleep_ms=5)
    losses = []
    for run in range(runs):
        name = f"large-{run + 1}"
        deaths = {}
        stage.animate(frames=12)
        keep_alive(stage, {5: name}, {"threads": 64, "options": ["--test-abort-at-tile", "1"]},
                   lambda: stage.animation.poll() is not None, deaths)
        put_away(stage, [name])
        stage.finish()
        losses.append(deaths.get(name, 0))
    report.values["deaths"] = losses
    report.claim("it died in every run", all(count > 0 for count in losses), losses)
    report.claim("no frame failed", not stage.events("frame-failed"), stage.events("frame-failed")[:1])
    stage.oracle(settled_slaves=2)


POISON_FRAME, POISON_TILE = 3, 21


def f05poison(stage, report):
    """A tile that ends every slave fails its frame after three deaths, each of another slave; the others come."""
    poison(stage, report, 1 if stage.is_small else 20)


def f05late(stage, report):
    """The same of a tile that ends them only after it was given to others for its age: at most all that hold it die."""
    poison(stage, report, 1 if stage.is_small else 3, after_ms=1500, deaths_max=4)


def poison(stage, report, runs, after_ms=0, deaths_max=3):
    most = 0
    for run in range(runs):
        stage.serve()
        names = {node: f"slave-{run + 1}-{node}" for node in range(2, 6)}
        options = {"options": ["--test-abort-in-frame", str(POISON_FRAME), "--test-abort-in-tile", str(POISON_TILE),
                               "--test-abort-after-ms", str(after_ms)]}
        for node, name in names.items():
            stage.slave(name, node=node, sleep_ms=5, **options)
        stage.cluster.wait_for_slaves(len(names))
        deaths = {}
        stage.animate(frames=8)
        keep_alive(stage, names, options, lambda: stage.animation.poll() is not None, deaths)
        done = stage.cluster.finish(stage.animation)
        stage.frames.stop()
        most = max(most, sum(deaths.values()))
        report.claim("each death another slave's", all(count == 1 for count in deaths.values()), deaths)
        report.claim("exit code 3", done.code == 3, (done.code, done.stderr[-300:]))
        report.claim("it names tile and slaves", f"tile {POISON_TILE}" in done.stderr and all(
            f"'{name}'" in done.stderr for name in deaths), done.stderr[-300:])
        others = [d for i, d in enumerate(stage.expected_digests) if i != POISON_FRAME]
        report.picture(done.digests == others)
        put_away(stage, list(names.values()))
        stage.process("master").terminate()
        stage.cluster.processes.pop("master").wait()
    report.figure("deaths", most, deaths_max, "")


def f02frozen(stage, report):
    """A slave whose render threads stand still while its links live costs A, is said to have stalled, holds one tile."""
    stage.cluster_of(2)
    stage.slave("slave-3", options=["--test-freeze-at-tile", "64"])
    stage.cluster.wait_for_slaves(3)
    stage.animate(frames=24)
    stalled = stage.first_event("slave-stalled", time.time() - PATIENCE_S)
    b = stage.bounds()
    began = stalled["at"] - 2 * b.tile - b.reissue - 0.5
    held = []

    def is_over():
        one = stage.cluster.slave_status("slave-3") or {}
        held.append((one.get("state"), one.get("tiles_in_flight", 0)))
        return stage.animation.poll() is not None
    wait_until("the animation's end", is_over)
    stage.finish()
    report.figure("gap", stage.frames.gap_after(began), hang_gap(stage, b, "slave-3", began))
    report.claim("status says stalled", any(state == "stalled" for state, _ in held), held[-5:])
    report.figure("tiles outstanding at last", held[-2][1] if len(held) > 1 else held[-1][1], 1, "")
    report.event("slave-stalled", len(stage.events("slave-stalled")))
    report.claim("the slave is not lost", not stage.events("slave-lost"))


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


ROWS = {"F01": f01, "F02": f02, "F02frozen": f02frozen, "F03": f03, "F05": f05,
        "F05large": f05large, "F05poison": f05poison, "F05late": f05late, "F06": f06, "F07": f07}
