# SPDX-License-Identifier: Apache-2.0
"""The symbols of the fault matrix, read from the running system: seconds, unless the name says otherwise.

Nothing here is a constant of a test: heartbeat, limits and measured times come from `tessera-master status --json`
and from `--stats`, so that the bounds hold on slow machines, too.
"""
import math

# The floor of every bound on time: what a machine's scheduler may add to a reaction that comes at once.
#
# A thread that has something to do runs when those before it on its core have had their turn. Linux's scheduler serves
# all of them within its latency: 6 ms * (1 + log2(cores)) for up to 8 cores, 24 ms, with eight ready threads a core and
# less; its successor's turns (3 ms each) are shorter. The longest chain that a row judges by round trips is a refusal:
# the test says something, the master answers, the test reads and says who it is, the master looks and refuses, the test
# reads that and wakes who waits for it; and the master's log may be written between. Eight threads wait for their turn.
SCHEDULER_TURN_S = 0.024
HANDOVERS = 8
SCHEDULING_S = HANDOVERS * SCHEDULER_TURN_S  # 192 ms


class Bounds:
    """The matrix's formulas for the figures of a status answer. What the machine itself may add is allowance()."""

    def __init__(self, status, build_seconds=0.0):
        self.heartbeat = status["heartbeat_ms"] / 1e3
        # Else "at once" could not be told from what only a deadline brings about, which takes some heartbeats or more.
        assert SCHEDULING_S < self.heartbeat, f"a floor of {SCHEDULING_S} s and heartbeats of {self.heartbeat} s"
        self.missed = status["heartbeats_missed_max"]
        self.rtt = status["rtt_seconds_max"]
        self.handshake = status["handshake_ms"] / 1e3
        self.reconnect_max = status["reconnect_max_ms"] / 1e3
        self.tile = status["tile_seconds_p95"]
        self.tile_median = status["tile_seconds_median"]
        self.threads = {s["name"]: s["threads"] for s in status["slaves"]}
        self.held = {s["name"]: s["tiles_in_flight"] for s in status["slaves"]}
        self.build = build_seconds

    @property
    def detection(self):  # T_det
        return (self.missed + 1) * self.heartbeat + self.rtt

    def message(self, size_bytes):  # T_msg; r_min of proto/PROTOCOL.md, "Records"
        return size_bytes / (8 * 1024) + self.detection

    @property
    def scene(self):  # T_scene: two messages each way, the build; small scenes take no time on the wire
        return self.build + 4 * self.rtt

    def redo(self, lost_tiles, lost=()):  # T_redo
        others = sum(n for name, n in self.threads.items() if name not in lost)
        return math.ceil(lost_tiles / max(others, 1)) * self.tile + self.rtt

    @property
    def reissue(self):  # A
        return max(2 * self.tile_median, 2 * self.rtt)

    @property
    def backoff_first(self):  # B(0), with its greatest random factor
        return 0.1 * 1.5


def allowance(late, doubt):
    """Returns what a bound on time grants besides the matrix's formula: the scheduler's turns, how late this machine
    woke a sleeping thread meanwhile (once: such a stall is rare), how long the fault took to be made, and a rounding of
    the log's clock."""
    return SCHEDULING_S + measured_allowance(late, doubt)


def measured_allowance(late, doubt):
    """Returns the allowance of a row about speed, which has no floor."""
    return late + doubt + 0.001
