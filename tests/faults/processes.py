"""Rows A: slaves and processes that die, hang, leave, crawl, come back."""
import signal
import time

from stage import STILL, wait_until


def f01(stage, report):
    """SIGKILL in the middle of a tile."""
    stage.cluster_of(3)
    stage.animate(frames=10)
    stage.wait_for_frames(3)
    report.values["tiles_lost"] = stage.wait_for_tiles("slave-3")
    b = stage.bounds()
    gone = stage.kill("slave-3")
    lost = stage.first_event("slave-lost", gone - 1)
    report.figure("detection", lost["at"] - gone, b.rtt + stage.lateness)
    stage.finish()
    usual = stage.frames.usual(since=gone + 1)
    report.figure("gap", stage.frames.gap_after(gone),
                  usual + b.redo(report.values["tiles_lost"], ["slave-3"]) + b.reissue + stage.lateness)
    report.event("slave-lost", len(stage.events("slave-lost")))
    report.claim("reason=closed", "clos" in lost.get("reason", ""), lost)
    stage.oracle(settled_slaves=2)


ROWS = {"F01": f01}
