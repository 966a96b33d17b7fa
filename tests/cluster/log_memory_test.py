#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The status of a master tells what its log suppressed, by name, and the last lines that it wrote."""
import socket
import subprocess
import unittest

import cluster_lib

STRANGERS = 80  # within one interval of the log (10 s), of which 20 lines are written
LINES_MAX, EVENTS_KEPT = 20, 100


class LogMemory(unittest.TestCase):
    def test_suppressed_lines_are_counted_and_the_last_events_kept(self):
        with cluster_lib.Cluster() as cluster:
            cluster.serve()
            self.assertEqual(cluster.status()["lines_suppressed"], {})
            for _ in range(STRANGERS):
                with socket.create_connection(("127.0.0.1", cluster.port), cluster_lib.PATIENCE_S) as link:
                    link.sendall(b"GET / HTTP/1.1\r\n\r\n")
                    while link.recv(4096):
                        pass
            log = cluster.folder / "master.log"

            def all_known():
                written = log.read_text().count(" handshake-failed: a peer")
                suppressed = cluster.status()["lines_suppressed"].get("handshake-failed", 0)
                return written + suppressed >= STRANGERS and (written, suppressed)
            written, suppressed = cluster_lib.wait_until("each line is written or counted", all_known)
            self.assertEqual(written + suppressed, STRANGERS)
            self.assertGreaterEqual(written, LINES_MAX)
            self.assertGreater(suppressed, 0, "this machine took more than an interval for each twenty of them")
            status = cluster.status()
            events = status["events"]
            self.assertLessEqual(len(events), EVENTS_KEPT)
            self.assertEqual(sum(e["line"].startswith("handshake-failed: a peer") for e in events), written)
            self.assertTrue(events[0]["line"].startswith("listening: "), events[0])
            ages = [e["seconds_ago"] for e in events]
            self.assertEqual(ages, sorted(ages, reverse=True), "the oldest first")
            self.assertEqual({e["level"] for e in events}, {"info", "warn"})
            table = subprocess.run([cluster_lib.program("tessera-master"), "status", "--events", "--connect", cluster.address,
                                    "--keys", str(cluster.keys / "app")], capture_output=True, text=True, check=True,
                                   timeout=cluster_lib.PATIENCE_S).stdout
            print(table[:400])
            self.assertIn(f"lines of the log that were only counted: handshake-failed {suppressed}", table)
            self.assertIn("http request", table)

    def test_slaves_that_leave_in_order_say_nothing_of_a_link(self):
        with cluster_lib.Cluster() as cluster:
            cluster.serve()
            cluster.slaves(2)
            for number in (1, 2):
                cluster.end(f"slave-{number}")
            cluster.wait_for_slaves(0)
            status = cluster.status()
            self.assertEqual(status["alone_reason"], "")
            self.assertTrue(status["events"][-1]["line"].startswith("slave-left: "), status["events"][-3:])



if __name__ == "__main__":
    cluster_lib.main()
