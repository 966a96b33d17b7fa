#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tessera-keys says what it made, until when it is valid, and what to do next; and what it says can be done.

Usage: keys_tool_test.py FOLDER_OF_PROGRAMS
"""
import datetime
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop())
PROGRAM_OF_ROLE = {"master": "tessera-master", "slave": "tessera-slave", "app": "tessera-master"}


def days_from_now(days):
    return str(datetime.datetime.now(datetime.timezone.utc).date() + datetime.timedelta(days))


class KeysTool(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="tessera keys ")  # the path has a blank, as people's paths do
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name, "cluster")

    def say(self, command, *words):
        run = subprocess.run([BIN / "tessera-keys", command, self.folder, *words], capture_output=True, text=True)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        print(run.stdout, end="")
        return run.stdout

    def expect_day(self, text, before, days):
        """Expects the day on which so many days end that began by now; `before` is that day if they began yesterday."""
        self.assertIn(re.search(r"good until (\d{4}-\d\d-\d\d)\b", text).group(1), (before, days_from_now(days)))

    def commands_in(self, text):
        return [shlex.split(words) for words in re.findall(r"(tessera-\w+ [^,;\n]+)", text)]

    def test_init_says_what_it_made_and_leads_on_to_add(self):
        before = days_from_now(3650)
        text = self.say("init")
        self.assertIn(str(self.folder), text)
        self.expect_day(text, before, 3650)
        self.assertTrue((self.folder / "ca.key").exists())
        (command,) = [words for words in self.commands_in(text) if words[1] == "add"]
        self.assertEqual(command[2:], [str(self.folder), "master", "NAME"], "a blank in a path is quoted")
        for role in PROGRAM_OF_ROLE:
            self.assertIn(role, text)
            self.say("add", role, f"one-{role}")

    def test_add_says_until_when_and_how_that_role_is_started(self):
        self.say("init")
        for role, program in PROGRAM_OF_ROLE.items():
            before = days_from_now(90)
            text = self.say("add", role, f"my-{role}", "--days", "90")
            self.expect_day(text, before, 90)
            self.assertIn(f"{role} 'my-{role}'", text)
            commands = self.commands_in(text)
            self.assertEqual([words[0] for words in commands], [program, "tessera-keys"])
            options = {word for word in commands[0] if word.startswith("--")}
            command = [word for word in commands[0][1:2] if not word.startswith("-")]
            shown = subprocess.run([BIN / program, *command, "--help"], capture_output=True, text=True).stdout
            for option in options:
                self.assertIn(option, shown)
            self.assertEqual(commands[1][1:], ["renew", str(self.folder), f"my-{role}"])

    def test_renew_and_revoke_say_what_to_copy(self):
        self.say("init")
        self.say("add", "slave", "s1")
        before = days_from_now(365)
        text = self.say("renew", "s1")
        self.expect_day(text, before, 365)
        for word in ("slave 's1'", "node.key", "node.crt", "SIGHUP"):
            self.assertIn(word, text)
        text = self.say("revoke", "s1")
        for word in ("'s1'", "crl.pem", str(self.folder)):
            self.assertIn(word, text)
        self.assertTrue((self.folder / "s1" / "crl.pem").exists())
        (command,) = self.commands_in(text)
        self.assertEqual(command[1:], ["renew", str(self.folder), "s1"])
        self.say(command[1], *command[3:])

    def test_a_node_does_not_outlive_its_authority(self):
        before = days_from_now(3650)
        self.say("init")
        self.expect_day(self.say("add", "slave", "s1", "--days", "3650"), before, 3650)
        self.assertIn("expired since " + days_from_now(-1), self.say("add", "slave", "old", "--days", "-1"))

    def test_list_shows_names_roles_and_last_days(self):
        self.say("init")
        self.say("add", "slave", "s1", "--days", "90")
        self.say("add", "app", "old", "--days", "-1")
        self.say("add", "master", "short", "--days", "1")
        self.say("add", "slave", "lost")
        self.say("revoke", "lost")
        rows = [re.split(r"\s{2,}", line) for line in self.say("list").splitlines()]
        ca, *nodes = rows[1:]
        self.assertEqual(ca[0], "the authority")
        self.assertEqual([row[:2] for row in nodes], [["lost", "slave"], ["old", "app"], ["s1", "slave"], ["short", "master"]])
        good = subprocess.run(["openssl", "x509", "-enddate", "-noout", "-dateopt", "iso_8601", "-in", self.folder / "s1" / "node.crt"],
                              capture_output=True, text=True, check=True).stdout
        self.assertEqual(nodes[2][2:], [re.search(r"\d{4}-\d\d-\d\d", good).group()])
        self.assertEqual([row[3:] for row in nodes],
                         [["revoked"], ["has ended: renew it"], [], ["renew it now: it ends within a day"]])

    def test_what_is_written_in_a_terminal_is_clean(self):
        self.say("init")
        run = subprocess.run([BIN / "tessera-keys", "add", self.folder, "slave", "a\x1b[2J\x9b"], capture_output=True)
        self.assertEqual(run.returncode, 2)
        self.assertNotIn(b"\x1b", run.stderr)
        self.assertIn(b"a?[2J", run.stderr)

    def test_what_failed_says_nothing_of_the_kind(self):
        run = subprocess.run([BIN / "tessera-keys", "add", self.folder, "slave", "x"], capture_output=True, text=True)
        self.assertEqual((run.returncode, run.stdout), (1, ""))
        self.assertEqual(len(run.stderr.splitlines()), 1)


if __name__ == "__main__":
    unittest.main(verbosity=1)
