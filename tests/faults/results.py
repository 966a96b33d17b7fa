# SPDX-License-Identifier: Apache-2.0
"""Rows C, first half: slaves that send wrong results."""
import time

import peer
from stage import wait_until


def fake_in_frame(stage, report, frames=12):
    """Starts two honest slaves, an animation, and a slave by hand that gets a lease. Returns: it, and the lease.

    The lease comes last, so that it can be answered at once: a while later the others have rendered its tile, too, and
    what comes for a frame that is over is dropped unread."""
    stage.cluster_of(2)
    fake = peer.HandSlave(stage, "fake")
    stage.clean.callback(fake.close)
    stage.animate(frames=frames)
    stage.wait_for_tiles("slave-1")
    stage.bounds()
    stage.now()
    fake.build()
    return fake, fake.lease()


def expelled(stage, report, fake, sent, event="slave-lost"):
    """The liar is closed within a round trip, once; its tiles are rendered by others; the picture is the same."""
    ended = fake.tile.wait_for_end()
    report.figure("detection", ended - sent, stage.bounds_before.rtt + stage.lateness)
    report.claim("both connections closed", fake.scene.wait_for_end() > 0)
    stage.finish()
    report.event(event, len(stage.events(event)))


def quarantined(stage, report, name, since):
    held = [q for q in stage.status().get("quarantined", []) if q["name"] == name]
    report.claim("quarantined, shown in status", len(held) == 1, stage.status().get("quarantined"))
    if held:
        report.figure("held back", held[0]["seconds"] + time.time() - since, 30, "s", least=True)
    try:
        again = peer.HandSlave(stage, name)
        again.close()
        report.claim("refused while quarantined", False, "it was let in")
    except (AssertionError, OSError):
        report.claim("refused while quarantined", True)


def f25(stage, report):
    """A slave that sends a result of a wrong size is expelled and quarantined."""
    fake, lease = fake_in_frame(stage, report)
    fields, pixels = fake.answer(lease, pixel=(9, 9, 9))
    sent = time.time()
    fake.tile.say(peer.RESULT, fields, pixels[:-4])
    expelled(stage, report, fake, sent)
    quarantined(stage, report, "fake", sent)
    stage.oracle(settled_slaves=2)


def f26(stage, report):
    """A tile with NaN pixels is rendered once more on another slave, counted, and reported with tile and slave."""
    fake, lease = fake_in_frame(stage, report)
    sent = time.time()
    fake.say_result(lease, pixel=(float("nan"), 0, 0))
    event = stage.first_event("faulty-pixels", sent)
    report.claim("names tile and slave", "tile" in event and "fake" in event.get("slave", ""), event)
    report.claim("counted by the master", stage.verdicts("faulty") == 1, stage.verdicts("faulty"))
    fake.close()
    run = stage.finish()
    report.claim("counted in --stats", sum(line.get("tiles_faulty", 0) for line in run.stats) == 1,
                 [line.get("tiles_faulty") for line in run.stats])
    stage.oracle()


def f27(stage, report):
    """A slave that sends a result for a tile never asked for is expelled and quarantined."""
    fake, lease = fake_in_frame(stage, report)
    sent = time.time()
    fake.say_result(lease, pixel=(9, 9, 9), tile=(lease.get(2, 0) + 7) % 48, attempt=9)
    expelled(stage, report, fake, sent)
    report.claim("counted by the master", stage.verdicts("not_leased") == 1, stage.verdicts("not_leased"))
    report.claim("and who was expelled", stage.metric("tessera_expulsions_total") == 1)
    quarantined(stage, report, "fake", sent)
    stage.oracle(settled_slaves=2)


def f28(stage, report):
    """The same result sent again and again is dropped and counted, then a violation."""
    fake, lease = fake_in_frame(stage, report, frames=16)
    fake.say_result(lease, pixel=(0.5, 0.5, 0.5))
    fields, pixels = fake.answer(lease)
    fake.tile.say(peer.RESULT, fields, pixels)
    time.sleep(0.3)
    report.claim("one is forgiven", fake.tile.ended_at is None)
    count, sent = 0, time.time()
    while fake.tile.ended_at is None and count < 5000:
        try:
            fake.tile.say(peer.RESULT, fields, pixels)
        except OSError:
            break
        count += 1
        time.sleep(0.002)
    fake.tile.wait_for_end()
    repeated = stage.verdicts("repeated")
    report.note(f"closed after {count} more")
    # Some results were on their way as the master closed.
    report.claim("each counted by the master until it closed", 2 <= repeated <= count + 1, f"{repeated} of {count + 1}")
    report.claim("and who was expelled", stage.metric("tessera_expulsions_total") == 1)
    stage.animation.terminate()
    stage.cluster.finish(stage.animation)
    stage.frames.stop()
    quarantined(stage, report, "fake", sent)
    stage.oracle()


def f29(stage, report):
    """A result of a frame that has ended is dropped and counted; one of a frame never begun is a violation."""
    fake, lease = fake_in_frame(stage, report, frames=12)
    wait_until("its frame is over without it", lambda: len(stage.frames.lines) > lease.get(1, 0) + 1)
    fake.say_result(lease, pixel=(9, 9, 9))
    time.sleep(0.5)
    report.claim("a late result is no violation", fake.tile.ended_at is None)
    report.claim("counted by the master", stage.verdicts("frame_ended") == 1, stage.verdicts("frame_ended"))
    late = lease
    sent = time.time()
    fake.say_result(late, pixel=(9, 9, 9), frame=late.get(1, 0) + 100000)
    expelled(stage, report, fake, sent)
    stage.oracle(settled_slaves=2)


ROWS = {"F25": f25, "F26": f26, "F27": f27, "F28": f28, "F29": f29}
