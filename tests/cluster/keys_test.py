#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Credentials may change while a cluster works (F40, F41), and peers with wrong ones are refused (F39, F40, F42)."""
import pathlib
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import threading
import time
import unittest

import cluster_lib

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "faults"))
import peer  # noqa: E402

SLOW = ["--test-tile-sleep-ms", "20"]
FRAME = ["--size", "256x192", "--tile", "16"]
SCENE = "builtin:waves"
FRAMES = ["--frames", "0:7"]
RELOAD_S = 60  # within this time a revocation holds, as promised
TCPFAULT = pathlib.Path(__file__).parent.parent / "faultlab" / "tcpfault.py"


def context_of(kind, folder):
    """Returns the context of a TLS end that has these credentials and believes anybody."""
    context = ssl.SSLContext(kind)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    if folder:
        certificate = next(c for c in (folder / "node.crt", folder / "ca.crt") if c.exists())
        context.load_cert_chain(certificate, certificate.with_suffix(".key"))
    return context


class Keys(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(self.end_cluster)

    def end_cluster(self):
        self.cluster.__exit__(None if self._outcome.success else AssertionError, None, None)

    def log(self, name):
        path = self.cluster.folder / f"{name}.log"
        return path.read_text(errors="replace") if path.exists() else ""

    def events(self, name, event):
        return [line for line in self.log(name).splitlines() if f" {event}: " in line]

    def keys(self, *words):
        self.cluster.make_keys(words[0], str(self.cluster.keys), *words[1:])

    def folder(self, name):
        return self.cluster.keys / name

    def hang_up(self, *names):
        for name in names:
            self.cluster.processes[name].send_signal(signal.SIGHUP)

    def expected(self):
        return self.cluster.render(SCENE, *FRAME, *FRAMES, "--local", "1", connect=False).digests

    def start_render(self):
        render = self.cluster.start_render(SCENE, *FRAME, *FRAMES)
        cluster_lib.wait_until("a frame is done", lambda: self.cluster.status()["frames_done"] > 0)
        return render

    def dial(self, folder):
        """Connects with these credentials. Returns: the master's certificate, and whether it lets this peer in."""
        with socket.create_connection(("127.0.0.1", self.cluster.port), cluster_lib.PATIENCE_S) as link:
            with context_of(ssl.PROTOCOL_TLS_CLIENT, folder).wrap_socket(link) as tls:
                certificate = ssl.DER_cert_to_PEM_cert(tls.getpeercert(True))
                try:
                    tls.sendall(peer.record(peer.HELLO, peer.hello("dialler", role=2)))
                    self.told = tls.recv(4096)  # the master answers, or says why not, or closes the link
                    return certificate, int.from_bytes(self.told[6:8], "little") == peer.WELCOME
                except TimeoutError:
                    raise
                except OSError:
                    return certificate, False

    def test_renewal_while_rendering_loses_no_frame(self):
        expected = self.expected()
        self.cluster.serve(*cluster_lib.CALM)
        self.cluster.slaves(2, *SLOW)
        render = self.start_render()
        old, _ = self.dial(self.folder("app"))
        for name in ("master", "slave-1", "slave-2", "app"):
            self.keys("renew", name)
        self.hang_up("master", "slave-1", "slave-2")
        for name in ("master", "slave-1", "slave-2"):
            cluster_lib.wait_until(f"{name} reloads", lambda: self.events(name, "credentials-reloaded"))
        run = self.cluster.finish(render)
        self.assertEqual(run.code, 0, run.stderr)
        self.assertEqual(run.digests, expected)
        self.assertEqual(self.events("master", "slave-lost"), [], "open connections live on")
        new, is_in = self.dial(self.folder("app"))
        self.assertTrue(is_in)
        self.assertNotEqual(old, new)
        self.assertEqual(new.split(), (self.folder("master") / "node.crt").read_text().split())
        self.cluster.slave("slave-3")
        self.cluster.wait_for_slaves(3)

    def test_a_revoked_slave_is_thrown_out_in_mid_frame_and_cannot_come_back(self):
        expected = self.expected()
        self.cluster.serve(*cluster_lib.CALM)
        self.cluster.slaves(2, *SLOW)
        stolen = self.cluster.folder / "stolen"
        shutil.copytree(self.folder("slave-2"), stolen)
        render = self.start_render()
        begin = time.monotonic()
        self.keys("revoke", "slave-2")  # no signal is sent: the master looks by itself
        cluster_lib.wait_until("slave-2 is out", lambda: self.cluster.slave_status("slave-2") is None)
        seconds = time.monotonic() - begin
        print(f"a revoked slave was thrown out after {seconds:.1f} s (bound {RELOAD_S} s)")
        if cluster_lib.is_quiet():
            self.assertLess(seconds, RELOAD_S)
        run = self.cluster.finish(render)
        self.assertEqual(run.code, 0, run.stderr)
        self.assertEqual(run.digests, expected)
        self.assertIn("revoked", self.cluster.wait_for_refusal("slave-2"))
        lost = self.events("master", "slave-lost")
        self.assertEqual(len(lost), 1, lost)
        self.assertIn("the certificate of slave 'slave-2' has been revoked", lost[0])
        self.assertFalse(self.dial(stolen)[1], "nor who stole its key")
        self.assertIn("subject=slave 'slave-2'", self.events("master", "handshake-failed")[-1])
        self.keys("renew", "slave-2")
        self.cluster.slave("slave-2", *SLOW)
        self.cluster.wait_for_slaves(2)

    def test_a_reload_that_fails_keeps_the_old_credentials(self):
        self.cluster.serve(*cluster_lib.CALM)
        self.cluster.slaves(1)
        path = self.folder("master") / "node.crt"
        good = path.read_text()
        path.write_text("damaged")
        self.hang_up("master")
        cluster_lib.wait_until("a line", lambda: self.events("master", "credentials-kept"))
        self.assertTrue(self.dial(self.folder("app"))[1])
        path.write_text(good)
        time.sleep(2.5)  # the master looks at the folder several times
        self.assertEqual(len(self.events("master", "credentials-kept")), 1, "said once")
        self.assertIsNotNone(self.cluster.slave_status("slave-1"))

    def test_peers_with_wrong_credentials_are_refused_by_name_and_reason(self):
        self.cluster.serve(*cluster_lib.CALM)
        self.cluster.slaves(1)
        self.cluster.make_keys("init", str(self.cluster.folder / "foreign"))
        self.cluster.make_keys("add", str(self.cluster.folder / "foreign"), "slave", "stranger")
        self.keys("add", "slave", "old", "--days", "-1")
        self.keys("add", "slave", "early", "--test-starts-in-days", "2")
        foreign = self.cluster.folder / "foreign"
        for folder, words in [(self.folder("old"), ["slave 'old'", "has expired"]),
                              (self.folder("early"), ["slave 'early'", "not valid yet"]),
                              (foreign / "stranger", ["slave 'stranger'", "another cluster"]),
                              (foreign, ["'Tessera CA'", "signed by itself"]),
                              (None, ["did not return a certificate"])]:
            before = len(self.events("master", "handshake-failed"))
            self.assertFalse(self.dial(folder)[1], words)
            events = cluster_lib.wait_until("an event", lambda: self.events("master", "handshake-failed")[before:])
            self.assertEqual(len(events), 1, events)
            for word in words:
                self.assertIn(word, events[0])
                if folder:
                    self.assertIn(word.encode(), self.told, "the refused side hears the reason")
        self.assertNotIn("PRIVATE", self.log("master"))
        self.assertIsNotNone(self.cluster.slave_status("slave-1"), "it was not disturbed")

    def test_a_slave_refuses_a_false_master_by_name_and_reason(self):
        self.keys("add", "master", "old", "--days", "-1")
        self.keys("add", "master", "early", "--test-starts-in-days", "2")
        self.keys("add", "master", "lost")
        self.keys("revoke", "lost")
        self.cluster.make_keys("init", str(self.cluster.folder / "foreign"))
        foreign = self.cluster.folder / "foreign"
        self.cluster.make_keys("add", str(foreign), "master", "stranger")
        for i, (folder, words) in enumerate([(self.folder("old"), ["master 'old'", "has expired"]),
                                             (self.folder("early"), ["master 'early'", "not valid yet"]),
                                             (self.folder("lost"), ["master 'lost'", "has been revoked"]),
                                             (self.folder("app"), ["role 'app'"]),
                                             (foreign / "stranger", ["master 'stranger'", "another cluster"]),
                                             (foreign, ["'Tessera CA'", "signed by itself"])]):
            with socket.create_server(("127.0.0.1", 0)) as server:
                self.cluster.port = server.getsockname()[1]
                false_master = threading.Thread(target=self.play_master, args=(server, folder))
                false_master.start()
                name = f"slave-{i}"
                self.cluster.slave(name)
                line = self.cluster.wait_for_refusal(name)
                false_master.join()
            for word in words:
                self.assertIn(word, line)

    @staticmethod
    def play_master(server, folder):
        link, _ = server.accept()
        context = context_of(ssl.PROTOCOL_TLS_SERVER, folder)
        try:
            with context.wrap_socket(link, server_side=True) as tls:
                tls.recv(100)
        except OSError:
            pass  # the slave has refused this master

    def test_slaves_come_by_any_link_that_the_master_listens_on(self):
        second = f"127.0.0.2:{cluster_lib.free_port()}"
        self.cluster.serve("--listen", second)
        self.cluster.slave("slave-1", *SLOW)
        first, self.cluster.host, self.cluster.port = self.cluster.port, *second.split(":")
        self.cluster.slave("slave-2", *SLOW)
        self.cluster.wait_for_slaves(2)  # the status is asked for over the second link
        self.cluster.host, self.cluster.port = "127.0.0.1", first
        render = self.cluster.start_endless(SCENE, *FRAME)
        for name in ("slave-1", "slave-2"):
            cluster_lib.wait_until(f"{name} draws", lambda: self.cluster.slave_status(name)["tiles_done"])
        self.cluster.stop_render(render)

    def test_a_recorded_session_sent_again_is_refused(self):
        self.cluster.serve(*cluster_lib.CALM)
        port = cluster_lib.free_port()
        recorded = self.cluster.folder / "recorded"
        recorded.mkdir()
        self.cluster.start("recorder", [sys.executable, str(TCPFAULT), "record", "--listen", f"127.0.0.1:{port}",
                                        "--to", self.cluster.address, "--out", str(recorded)])
        cluster_lib.wait_until("the recorder listens", lambda: self.listens(port))
        master_port, self.cluster.port = self.cluster.port, port
        self.cluster.slave("slave-1")
        self.cluster.port = master_port
        self.cluster.wait_for_slaves(1)
        self.cluster.processes.pop("slave-1").kill()
        self.cluster.wait_for_slaves(0)
        recordings = [r for r in sorted(recorded.iterdir()) if "up" in r.name and r.stat().st_size > 0]
        self.assertGreaterEqual(len(recordings), 2, list(recorded.iterdir()))
        for recording in recordings:
            before = len(self.events("master", "handshake-failed"))
            subprocess.run([sys.executable, str(TCPFAULT), "send", "--to", self.cluster.address, "--file", str(recording)],
                           stdout=subprocess.DEVNULL, check=True)
            cluster_lib.wait_until("refused", lambda: len(self.events("master", "handshake-failed")) > before)
        self.assertEqual(self.cluster.status()["slaves"], [])
        self.assertEqual(len(self.events("master", "slave-joined")), 1)

    @staticmethod
    def listens(port):
        with socket.socket() as one:
            return one.connect_ex(("127.0.0.1", port)) == 0


if __name__ == "__main__":
    cluster_lib.main()
