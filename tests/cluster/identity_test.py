#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Who a node is rests on its certificate alone, and on a folder that nobody else may write; the relay's door is no wider
than it must be; and whose certificate ends soon hears of it."""
import os
import re
import shutil
import socket
import subprocess
import unittest

import cluster_lib


class Identity(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(lambda: self.cluster.__exit__(None if self._outcome.success else AssertionError, None, None))

    def log(self, name):
        path = self.cluster.folder / f"{name}.log"
        return path.read_text(errors="replace") if path.exists() else ""

    def events(self, name, event):
        return [line for line in self.log(name).splitlines() if f" {event}: " in line]

    def wait_for_event(self, name, event):
        return cluster_lib.wait_until(f"{name} says {event}", lambda: self.events(name, event))[0]

    def start_slave(self, log, keys, *options):
        return self.cluster.start(log, [cluster_lib.program("tessera-slave"), "--master", self.cluster.address, "--keys",
                                        self.cluster.add_key("slave", keys), "--threads", "1", *options])

    def names(self):
        return sorted(slave["name"] for slave in (self.cluster.status() or {"slaves": []})["slaves"])

    def test_with_keys_a_slave_is_called_as_its_certificate(self):
        self.cluster.serve()
        self.start_slave("impostor", "bert", "--name", "anna")
        self.cluster.wait_for_slaves(1)
        self.assertIn("'bert'", self.wait_for_event("impostor", "name-unused"))
        self.start_slave("owner", "anna", "--name", "anna")
        self.cluster.wait_for_slaves(2)
        self.assertEqual(self.names(), ["anna", "bert"], "nobody has the name of another")
        self.assertEqual(self.events("owner", "name-unused"), [])

    def test_two_with_one_certificate_take_turns(self):
        self.cluster.serve()
        self.start_slave("first", "anna")
        self.cluster.wait_for_slaves(1)
        self.start_slave("second", "anna")
        self.assertIn("'anna'", self.wait_for_event("second", "master-refuses"))
        self.cluster.end("first")
        self.wait_for_event("second", "master-joined")
        self.assertEqual(self.names(), ["anna"])

    @staticmethod
    def answers(host, port):
        with socket.socket() as one:
            return one.connect_ex((host, port)) == 0

    def door_of(self, name):
        host, port = re.search(r"address=([\d.]+):(\d+)", self.wait_for_event(name, "relay-listening")).groups()
        return host, int(port)

    def test_the_relay_s_door_is_where_the_master_is_reached(self):
        self.cluster.serve()
        self.start_slave("usual", "usual")
        self.start_slave("told", "told", "--relay-listen", "127.0.0.3")
        self.start_slave("closed", "closed", "--relay-listen", "off")
        self.cluster.wait_for_slaves(3)
        host, port = self.door_of("usual")
        self.assertEqual(host, "127.0.0.1")
        self.assertTrue(self.answers(host, port))
        self.assertFalse(self.answers("127.0.0.2", port), "no other address of this machine")
        host, port = self.door_of("told")
        self.assertEqual(host, "127.0.0.3")
        self.assertTrue(self.answers(host, port))
        self.assertEqual(self.events("closed", "relay-listening"), [])
        self.assertTrue(self.events("closed", "relay-off"))
        self.cluster.render("builtin:cornell", "--size", "64x64")

    def test_without_keys_the_relay_s_door_stays_on_loopback(self):
        run = subprocess.run([cluster_lib.program("tessera-slave"), "--master", "127.0.0.1:1", "--plain", "--relay-listen",
                              "0.0.0.0"], capture_output=True, text=True, timeout=cluster_lib.PATIENCE_S)
        self.assertEqual(run.returncode, 2)
        self.assertIn("--relay-listen 0.0.0.0 is not loopback", run.stderr)

    def test_keys_in_a_folder_that_others_may_write_are_refused(self):
        self.cluster.serve()
        folder = self.cluster.add_key("slave", "open")
        os.chmod(folder, 0o777)
        slave = self.start_slave("open", "open")
        self.assertEqual(slave.wait(cluster_lib.PATIENCE_S), 1)
        del self.cluster.processes["open"]
        self.assertIn(f"chmod go-w {os.path.realpath(folder)}", self.log("open"))

    def test_a_day_before_the_end_everybody_is_told(self):
        keys = self.cluster.folder / "short"
        self.cluster.make_keys("init", str(keys))
        for role, name in (("master", "master"), ("slave", "s1"), ("app", "app")):
            self.cluster.make_keys("add", str(keys), role, name, "--days", "1")
        self.cluster.make_keys("add", str(keys), "slave", "s2", "--days", "3")
        self.cluster.keys = keys
        self.cluster.serve()
        self.start_slave("s1", "s1")
        self.start_slave("s2", "s2")
        self.cluster.wait_for_slaves(2)
        for name, whose in (("master", "master 'master'"), ("s1", "slave 's1'")):
            line = self.wait_for_event(name, "certificate-expires")
            self.assertIn(whose, line)
            self.assertRegex(line, r"ends in 2[34] h \d+ min")
            self.assertEqual(len(self.events(name, "certificate-expires")), 1, "once an hour")
        self.assertEqual(self.events("s2", "certificate-expires"), [])
        run = self.cluster.render("builtin:cornell", "--size", "64x64")
        self.assertIn("certificate of app 'app' ends in", run.stderr)

    def test_certificates_renew_themselves_where_the_owner_lays_the_authority_s_key(self):
        folder = self.cluster.folder
        keys = folder / "aged"
        self.cluster.make_keys("init", str(keys))
        for role, name in (("master", "master"), ("slave", "s1"), ("slave", "young")):
            age = "0" if name == "young" else "-300"
            self.cluster.make_keys("add", str(keys), role, name, "--test-starts-in-days", age)
            shutil.copytree(keys / name, folder / f"at-{name}")  # as on their machines
        for name, age in (("app", "-300"), ("new-app", "0")):
            self.cluster.make_keys("add", str(keys), "app", name, "--test-starts-in-days", age)
            shutil.copytree(keys / name, folder / f"at-{name}")
        self.cluster.keys = keys
        old = {name: (folder / f"at-{name}" / "node.key").read_text() for name in ("master", "s1", "young", "app", "new-app")}
        self.cluster.serve("--issue-from", str(keys), keys=folder / "at-master")
        for name in ("s1", "young"):
            self.start_slave_at(name, folder / f"at-{name}")
        self.cluster.wait_for_slaves(2)
        for name in ("master", "s1"):
            self.wait_for_event(name, "certificate-renewed")
            self.wait_for_event(name, "credentials-reloaded")
            self.assertNotEqual((folder / f"at-{name}" / "node.key").read_text(), old[name])
        self.assertEqual((folder / "at-young" / "node.key").read_text(), old["young"])
        self.assertEqual((keys / "s1" / "node.key").read_text(), old["s1"], "no private key travels")
        self.assertEqual(self.events("s1", "master-lost"), [], "open connections live on")
        for name in ("app", "new-app"):
            self.run_at(name, "render", "builtin:cornell", "--size", "320x240", "--aa", "8", "--output", str(folder / f"{name}.png"))
        self.run_at("app", "status")
        cluster_lib.wait_until("the application has its own", lambda: "app 'app'" in self.log("master"))
        self.assertNotEqual((folder / "at-app" / "node.key").read_text(), old["app"])
        self.assertEqual((folder / "at-new-app" / "node.key").read_text(), old["new-app"])
        self.assertEqual((keys / "app" / "node.key").read_text(), old["app"], "no private key travels")
        self.assertEqual(len(self.events("master", "certificate-issued")), 2, "one for s1, one for app")
        listed = subprocess.run([cluster_lib.program("tessera-keys"), "list", str(keys)], capture_output=True, text=True).stdout
        self.assertNotIn("renew it", listed)
        self.cluster.processes.pop("s1").kill()
        self.start_slave_at("again", folder / "at-s1")
        self.wait_for_event("again", "master-joined")
        self.cluster.make_keys("revoke", str(keys), "s1")
        shutil.copy(keys / "crl.pem", folder / "at-master")
        self.wait_for_event("again", "master-refuses")

    def run_at(self, name, *arguments):
        run = subprocess.run([cluster_lib.program("tessera-master"), *arguments, "--connect", self.cluster.address, "--keys",
                              str(self.cluster.folder / f"at-{name}")], capture_output=True, text=True,
                             timeout=cluster_lib.PATIENCE_S)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run

    def start_slave_at(self, log, folder):
        return self.cluster.start(log, [cluster_lib.program("tessera-slave"), "--master", self.cluster.address, "--keys",
                                        str(folder), "--threads", "1"])

    def test_a_master_without_the_authority_s_key_makes_no_certificates(self):
        self.cluster.serve()
        self.cluster.make_keys("add", str(self.cluster.keys), "slave", "aged", "--test-starts-in-days", "-300")
        self.start_slave("aged", "aged")
        self.cluster.wait_for_slaves(1)
        self.cluster.render("builtin:cornell", "--size", "64x64")
        for log, event in (("aged", "certificate-renewed"), ("master", "certificate-issued"), ("master", "slave-lost")):
            self.assertEqual(self.events(log, event), [])


if __name__ == "__main__":
    cluster_lib.main()
