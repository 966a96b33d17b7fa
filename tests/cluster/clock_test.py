#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A master whose clock is wrong for a while loses its slaves for that while, and not for good.

    clock_test.py [--whole]    --whole: the clock is wrong for 40 s, instead of 8

The clock is libfaketime's, read from a file at each call; steady clocks stay as they are.
"""
import glob
import re
import signal
import sys
import time
import unittest

import cluster_lib

SLAVES = 4
WRONG_S = 40 if "--whole" in sys.argv else 8
RECONNECT_MAX_MS = 5000  # limits.h
LIBRARIES = glob.glob("/usr/lib/*/faketime/libfaketime.so.1")


class Clock(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(lambda: self.cluster.__exit__(None if self._outcome.success else AssertionError, None, None))
        self.offset = self.cluster.folder / "clock"
        self.set_clock("+0")
        prefix = self.cluster.prefix
        self.cluster.prefix = lambda node: ["env", f"LD_PRELOAD={LIBRARIES[0]}", f"FAKETIME_TIMESTAMP_FILE={self.offset}",
                                            "FAKETIME_NO_CACHE=1", "FAKETIME_DONT_FAKE_MONOTONIC=1", "DONT_FAKE_MONOTONIC=1"]
        self.master = self.cluster.serve()
        self.cluster.prefix = prefix
        self.cluster.slaves(SLAVES)

    def set_clock(self, offset):
        self.offset.write_text(offset + "\n")

    def reset_links(self):
        """The master stands still for longer than it takes to be called dead: its slaves come anew."""
        self.master.send_signal(signal.SIGSTOP)
        time.sleep(2)
        self.master.send_signal(signal.SIGCONT)

    def log(self, name):
        return (self.cluster.folder / f"{name}.log").read_text(errors="replace")

    def sessions(self):
        return sum(self.log(f"slave-{i + 1}").count("master-joined") for i in range(SLAVES))

    def wait_for_new_sessions(self, before):
        began = time.monotonic()
        cluster_lib.wait_until("all have a new session", lambda: self.sessions() >= before + SLAVES)
        self.cluster.wait_for_slaves(SLAVES)
        return time.monotonic() - began

    def check_processes(self):
        for i in range(SLAVES):
            self.assertIsNone(self.cluster.processes[f"slave-{i + 1}"].poll(), "it must not leave that to a service manager")

    def test_an_hour_is_no_matter(self):
        before = self.sessions()
        self.set_clock("-1h")
        self.reset_links()
        took = self.wait_for_new_sessions(before)
        self.check_processes()
        self.assertNotIn("handshake-failed", self.log("master"))
        print(f"an hour behind: {SLAVES} of {SLAVES} slaves were back after {took:.1f} s, while the clock was wrong")

    def test_three_days_cost_what_they_last(self):
        before = self.sessions()
        self.set_clock("-3d")
        self.reset_links()
        for i in range(SLAVES):
            cluster_lib.wait_until("it is told why", lambda: "not valid yet by the clock" in self.log(f"slave-{i + 1}"))
        time.sleep(WRONG_S)
        self.check_processes()
        self.assertEqual(self.sessions(), before)
        self.set_clock("+0")
        took = self.wait_for_new_sessions(before)
        self.check_processes()
        pauses = [int(p) for i in range(SLAVES) for p in re.findall(r"pause_ms=(\d+)", self.log(f"slave-{i + 1}"))]
        self.assertLessEqual(max(pauses), RECONNECT_MAX_MS)
        print(f"three days behind for {WRONG_S} s: {SLAVES} of {SLAVES} slaves were back {took:.1f} s after the right clock")


if __name__ == "__main__":
    if not LIBRARIES:
        print("skipped: libfaketime is not installed (deploy/install-dependencies.sh --with test)")
        sys.exit(77)
    sys.argv = [word for word in sys.argv if word != "--whole"]
    sys.exit(unittest.main(verbosity=1))
