# SPDX-License-Identifier: Apache-2.0
"""Rows B, second half: links that are dead one way, for large packets, or one after the other."""
import random
import time

import network
from network import returns_within
from stage import wait_until

LONGER = 600  # bytes of an IP packet: heartbeats are shorter, results and certificates are not


def f13deaf(stage, report):
    """A slave that hears nothing, and is heard, gives up its master and is back when its link is healed."""
    network.cut_row(stage, report, direction="in")


def f13mute(stage, report):
    """A slave that hears, and is not heard, is found by its silence, and is back when its link is healed."""
    network.cut_row(stage, report, direction="out")


def f61(stage, report):
    """A path that loses large packets and passes small ones costs its slave, and no frame."""
    network.cut_row(stage, report, longer=LONGER)


def f65(stage, report):
    """Links that are cut one after the other and healed in reverse lose no frame, whichever slave is left."""
    stage.cluster_of(4)
    names = [f"slave-{i + 1}" for i in range(4)]
    stage.animate(frames=30)
    stage.wait_for_frames(4)
    b = stage.bounds()
    chance = random.Random(report.seed)
    rounds = 1 if stage.is_small else 3
    slowest = 0.0
    for _ in range(rounds):
        chance.shuffle(names)
        began = stage.now()
        for name in names:
            stage.lab.cut(stage.nodes[name])
            time.sleep(b.detection / 2 * chance.uniform(0.8, 1.2))
        wait_until("none is left", lambda: not stage.status()["slaves"])
        healed = stage.now()
        for name in reversed(names):
            stage.lab.heal(stage.nodes[name])
        joined = wait_until("all are back", lambda: [
            e["at"] for e in stage.events("slave-joined", began)][3:] and time.time())
        slowest = max(slowest, joined - healed)
        done = len(stage.frames.lines)
        wait_until("frames go on", lambda: len(stage.frames.lines) > done or stage.animation.poll() is not None)
        report.claim("the application waits for them", stage.animation.poll() in (None, 0))
        stage.cluster.wait_for_slaves(4)
    report.figure("all are back", slowest, returns_within(b) + stage.lateness)
    stage.finish()
    report.claim("no frame failed", not stage.events("frame-failed"))
    stage.oracle(settled_slaves=4)


ROWS = {"F13deaf": f13deaf, "F13mute": f13mute, "F61": f61, "F65": f65}
