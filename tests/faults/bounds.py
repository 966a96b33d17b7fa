"""The symbols of the fault matrix, read from the running system: seconds, unless the name says otherwise.

Nothing here is a constant of a test: heartbeat, limits and measured times come from `tessera-master status --json`
and from `--stats`, so that the bounds hold on slow machines, too.
"""
import math


class Bounds:
    """What a status answer implies. `lateness` is how late this machine woke a sleeping thread meanwhile, at most."""

    def __init__(self, status, build_seconds=0.0):
        self.heartbeat = status["heartbeat_ms"] / 1e3
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
