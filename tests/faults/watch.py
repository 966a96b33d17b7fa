# SPDX-License-Identifier: Apache-2.0
"""Measures while a row runs: processes by /proc, the machine's own lateness, log events, frames as they come."""
import datetime
import json
import os
import pathlib
import threading
import time

TICKS = os.sysconf("SC_CLK_TCK")
PAGE_MIB = os.sysconf("SC_PAGESIZE") / 2**20


def resident_mib(pid):
    try:
        return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * PAGE_MIB
    except (OSError, IndexError):
        return 0.0


def descriptors(pid):
    try:
        return len(os.listdir(f"/proc/{pid}/fd"))
    except OSError:
        return 0


def threads(pid):
    try:
        return len(os.listdir(f"/proc/{pid}/task"))
    except OSError:
        return 0


def cpu_seconds(pid):
    try:
        fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / TICKS
    except (OSError, IndexError):
        return 0.0


class Sampler:
    """The greatest memory of the processes that it follows, and how late a sleeping thread woke since mark()."""

    STEP = 0.01

    def __init__(self):
        self.pids, self.peak, self.base, self.late = {}, {}, {}, 0.0
        self.over = threading.Event()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def follow(self, name, pid):
        self.base[name] = {"mib": resident_mib(pid), "fds": descriptors(pid), "threads": threads(pid)}
        self.peak[name] = self.base[name]["mib"]
        self.pids[name] = pid

    def mark(self):
        """Measures lateness anew from now on, and memory against the greatest of the time without a fault."""
        self.late = 0.0
        for name, peak in self.peak.items():
            self.base[name]["mib"] = peak

    def _run(self):
        rounds = 0
        while not self.over.is_set():
            before = time.monotonic()
            time.sleep(self.STEP)
            self.late = max(self.late, time.monotonic() - before - self.STEP)
            rounds += 1
            if rounds % 5 == 0:
                for name, pid in list(self.pids.items()):
                    self.peak[name] = max(self.peak[name], resident_mib(pid))

    def stop(self):
        self.over.set()
        self.thread.join()


def cpu_share(pids, seconds):
    """Returns the greatest share of one core that any of the processes uses in the next `seconds`."""
    before = {pid: cpu_seconds(pid) for pid in pids}
    began = time.monotonic()
    time.sleep(seconds)
    passed = time.monotonic() - began
    return max((cpu_seconds(pid) - before[pid]) / passed for pid in pids)


def events(log, since=0.0):
    """Returns the lines of a JSON log after `since` (seconds of the epoch), each with its time as "at"."""
    found = []
    for line in pathlib.Path(log).read_text(errors="replace").splitlines():
        try:
            event = json.loads(line)
            at = datetime.datetime.strptime(event["time"], "%Y-%m-%dT%H:%M:%S.%f%z").timestamp()
        except (ValueError, KeyError, TypeError):
            continue
        if at >= since - 0.001:  # the log rounds to milliseconds
            found.append({**event, "at": at})
    return found


class Frames:
    """Watches when each line of a --stats file comes, to some milliseconds."""

    def __init__(self, path):
        self.path, self.times, self.lines = pathlib.Path(path), [], []
        self.over = threading.Event()
        self.rest = ""
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self):
        offset = 0
        while True:
            is_last = self.over.is_set()
            if self.path.exists():
                with open(self.path, encoding="utf-8") as file:
                    file.seek(offset)
                    text = file.read()
                    offset = file.tell()
                now = time.time()
                whole = (self.rest + text).split("\n")
                self.rest = whole.pop()
                for line in whole:
                    self.times.append(now)
                    self.lines.append(json.loads(line))
            if is_last:
                return
            time.sleep(0.003)

    def stop(self):
        self.over.set()
        self.thread.join()

    def gap_after(self, instant):
        """Returns the longest time without a frame that touches what comes after `instant`."""
        gaps = [b - a for a, b in zip(self.times, self.times[1:]) if b > instant]
        return max(gaps, default=0.0)

    def share_rendering(self, since=0.0, until=float("inf")):
        """Returns the median share of the slaves' time that went into tiles, by their own clocks, over the frames that
        ended within the interval; None where none did."""
        shares = sorted(line["utilisation"] for t, line in zip(self.times, self.lines) if since <= t <= until)
        return shares[len(shares) // 2] if shares else None

    def usual(self, since=0.0, until=float("inf")):
        """Returns the median time between frames that came within the interval."""
        times = [t for t in self.times if since <= t <= until]
        gaps = sorted(b - a for a, b in zip(times, times[1:]))
        return gaps[len(gaps) // 2] if gaps else 0.0
