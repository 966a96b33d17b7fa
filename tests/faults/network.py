# SPDX-License-Identifier: Apache-2.0
"""Rows B: links that are cut, reset, slow, lossy, unsteady."""
import random
import time

import processes
import stage as stages
import watch
from stage import MOVING, wait_until


def returns_within(b):
    """Returns: seconds until a slave whose link is whole again is back, since its pause has grown meanwhile."""
    return 1.5 * b.reconnect_max + b.handshake + b.scene


def cut_row(stage, report, port=None, scene=None, **what):
    """The link of slave-3, or one of its connections, is silent until it is healed. what: as for stage.cut()."""
    stage.cluster_of(3)
    stage.animate(scene, frames=20)
    stage.wait_for_frames(4)
    ports = [stage.cluster.slave_status("slave-3")[port]] if port else []
    began = []

    def begin():
        began.append(stage.cut("slave-3", ports, **what))
        return began[0]

    processes.silent_slave(stage, report, "slave-3", begin, lambda: stage.heal("slave-3"),
                           returns_within, must_end=not port)
    b = stage.bounds()
    noticed = stage.first_event("master-lost", began[0], log="slave-3")
    # Where its acknowledgements are lost, the end of the link waits in the master's kernel for a retransmission, and what
    # the slave goes by is again its own silence.
    within = b.detection * (2 if what.get("direction") == "out" else 1)
    report.figure("the slave notices", noticed["at"] - began[0], within + stage.lateness)
    stage.finish()
    stage.oracle(settled_slaves=3)


def f13(stage, report):
    """A slave whose link is cut without FIN is found by its silence, and is back when the link is healed."""
    cut_row(stage, report)


def f14(stage, report):
    """A slave whose connections are both reset is noticed at once and comes back."""
    stage.cluster_of(3)
    stage.animate(frames=12)
    stage.wait_for_frames(4)
    report.values["tiles_lost"] = stage.wait_for_tiles("slave-3")
    b = stage.bounds()
    began = stage.reset("slave-3")
    lost = stage.first_event("slave-lost", began)
    report.figure("detection", lost["at"] - began, b.rtt + stage.lateness)
    stage.first_event("slave-joined", lost["at"])
    stage.finish()
    report.figure("gap", stage.frames.gap_after(began), stage.usual_without("slave-3", began) + b.rtt + b.redo(
        report.values["tiles_lost"], ["slave-3"]) + b.reissue + stage.lateness)
    report.event("slave-lost", len(stage.events("slave-lost")))
    stage.oracle(settled_slaves=3)


def f15(stage, report):
    """A scene connection that is silent beside a live tile connection, while scenes change, is found by its silence."""
    cut_row(stage, report, "scene_port", MOVING)


def f16(stage, report):
    """A tile connection that is silent beside a live scene connection is found by its silence."""
    cut_row(stage, report, "tile_port", MOVING)


def steady_frame_time(stage, report, what, frames=14, scene=None, size=stages.FRAME):
    """Returns the median time of a frame once rates are learnt (after 3 frames)."""
    stage.animate(scene, frames=frames, size=size)
    stage.wait_for_frames(frames)
    usual = stage.frames.usual(since=stage.frames.times[3])
    stage.finish()
    report.note(f"{what}: {1e3 * usual:.0f} ms a frame")
    return usual


def delayed(stage, report, **shape):
    stage.cluster_of(3)
    before = steady_frame_time(stage, report, "at 0 ms")
    stage.now()
    for name in ("slave-1", "slave-2", "slave-3"):
        stage.lab.shape(stage.nodes[name], **shape)
    wait_until("a round trip learnt", lambda: stage.bounds().rtt > 2e-3 * shape["delay"])
    after = steady_frame_time(stage, report, f"at {shape['delay']} ms each way")
    b = stage.bounds()
    report.note(f"round trip {1e3 * b.rtt:.0f} ms")
    report.claim("M * H > 2 * RTT", b.missed * b.heartbeat > 2 * b.rtt)
    report.figure("throughput", 100 * before / after, 95, "%", least=True)
    report.claim("no false death", not stage.events("slave-lost"), stage.events("slave-lost"))
    stage.oracle(settled_slaves=3)


def f17(stage, report):
    """50 ms of delay each way on every link hardly lower the throughput."""
    delayed(stage, report, delay=50)


def far(stage, report):
    """A slave 300 ms of delay away each way: the heartbeat is raised, and it is not taken for dead."""
    stage.serve()
    stage.slave("near", node=2)
    began = stage.now()
    stage.lab.shape(5, delay=300)
    stage.slave("far", node=5)
    stage.cluster.wait_for_slaves(2)
    report.event("heartbeat-raised", len(stage.events("heartbeat-raised", began)))
    stage.animate(frames=8)
    stage.finish()
    b = stage.bounds()
    report.claim("M * H > 2 * RTT", b.missed * b.heartbeat > 2 * 0.6, b.heartbeat)
    report.claim("no false death", not stage.events("slave-lost"), stage.events("slave-lost"))


def f20(stage, report):
    """A delay of 20 +- 20 ms with reordering hardly lowers the throughput."""
    delayed(stage, report, delay=20, jitter=20, reorder=True)


# Results of these tiles are more than the slow link carries at the rate of the slave's thread.
LARGE = ["--size", "256x192", "--tile", "32"]


def f18(stage, report):
    """One slave of four behind 1 Mbit/s hardly slows frames and is not taken for dead."""
    stage.serve()
    stage.slaves(3)
    without = steady_frame_time(stage, report, "without it", size=LARGE)
    stage.slave("slave-4", node=5)
    stage.lab.shape(5, rate=1000)
    stage.cluster.wait_for_slaves(4)
    stage.now()
    with_it = steady_frame_time(stage, report, "with it", size=LARGE)
    report.figure("frame time", with_it, 1.25 * without)
    report.claim("not declared dead", not stage.events("slave-lost"), stage.events("slave-lost"))
    report.note(f"its share: {stage.cluster.slave_status('slave-4')['tiles_done']} tiles")
    stage.oracle(settled_slaves=4)


def f19(stage, report):
    """1 % packet loss on all links loses no slave; frames stay right, also with 5 %."""
    stage.cluster_of(3)
    without = steady_frame_time(stage, report, "no loss")
    for loss in (1, 5):
        for node in (1, *stage.nodes.values()):
            stage.lab.shape(node, loss=loss)
        stage.now()
        usual = steady_frame_time(stage, report, f"{loss} % loss")
        if loss == 1:
            report.figure("frame time at 1 %", usual, 1.5 * without)
            report.claim("no false death at 1 %", not stage.events("slave-lost"), stage.events("slave-lost"))
    report.note(f"{len(stage.events('slave-lost'))} slaves lost at 5 %")
    stage.mend()
    stage.cluster.wait_for_slaves(3)
    stage.oracle(settled_slaves=3)


def f22(stage, report):
    """With a link that flaps every T_det / 2, then every 2 T_det, frames go on and reconnects are spaced."""
    stage.cluster_of(3, "--relay", "off")  # what slaves pass on hides what is sent anew
    scene, seconds = MOVING, 60
    stage.animate(scene, frames=240)
    stage.wait_for_frames(3)
    b = stage.bounds()
    stage.now()
    chance = random.Random(report.seed)
    for period in (b.detection / 2, 2 * b.detection):
        until = time.monotonic() + seconds
        while time.monotonic() < until and len(stage.frames.lines) < 230:
            stage.cut("slave-3")
            time.sleep(period * chance.uniform(0.9, 1.1))
            stage.heal("slave-3")
            time.sleep(period * chance.uniform(0.9, 1.1))
    lost = stage.events("slave-lost")
    report.note(f"{len(lost)} losses")
    joins = [e["at"] for e in stage.events("slave-joined")][3:]
    pauses = [int(e["pause_ms"]) for e in stage.events("master-lost", log="slave-3")]
    report.claim("pauses grow to Bmax, k is kept", len(pauses) < 8 or max(pauses) > 1e3 * b.reconnect_max / 2, pauses)
    report.claim("reconnects are spaced", all(later - earlier >= 0.05 for earlier, later in zip(joins, joins[1:])), joins)
    report.figure("gap", stage.frames.gap_after(0), b.detection + 2 * stage.frames.usual() + b.redo(
        processes.PREFETCHED, ["slave-3"]) + b.reissue + stage.lateness)
    stage.animation.terminate()
    stage.cluster.finish(stage.animation)
    stage.frames.stop()
    count = len(stage.frames.lines)
    report.picture([f["digest"] for f in stage.frames.lines] == stage.expected_digests[:count])
    report.note(f"{count} frames")
    wait_until("back", lambda: len(stage.status()["slaves"]) == 3)
    # Each frame is another version, sent to three; a slave that comes back gets the two in work anew, and no more.
    version = max(line["scene_bytes"] for line in stage.frames.lines[1:3]) / 3 / 2**20  # the first has all of it
    sent = stage.metric("tessera_scene_bytes_sent_total") / 2**20
    report.figure("scenes sent", sent, version * (3 * (count + 3) + 2 * (len(lost) + 1)), "MiB")
    stage.oracle(settled_slaves=3)


ROWS = {"F13": f13, "F14": f14, "F15": f15, "F16": f16, "F17": f17, "F17far": far, "F18": f18, "F19": f19, "F20": f20, "F22": f22}
