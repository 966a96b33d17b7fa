#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tests/nightly.sh over a small tree whose parts hold, fail and are skipped: it goes on past what fails, and its table and
exit code say which was which, and why."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop())  # of the whole tree

SKIPPED_ROW = "echo 'skipped: this machine has no namespaces'; exit 77"
PROGRAMS = {
    "tests/faults.sh": SKIPPED_ROW,
    "build/release/bin/session_link_storm_test": 'echo "$TESSERA_LINK_STORM visits"',
    "build/release/bin/tessera-sim": "echo 'seed 17 FAILED'; echo 'a last word'; exit 3",
    "build/release/bin/wire_codec_test": "echo '30 tests passed'",
    "tests/sim/planted_bugs.py": "echo 'one was not found'; exit 1",
    "tests/property/planted/planted_bugs.py": "echo 'all were found'",
    "tests/run.sh": "exit 1",  # without a word
}


# As CMake writes it: a limit for the usual form, in seconds.
LONG_TESTS = """
add_test(good "/bin/sh" "-c" "sleep 2; test $TESSERA_LONG = 1 && test $WORD = given")
set_tests_properties(good PROPERTIES TIMEOUT 1 LABELS property ENVIRONMENT "WORD=given")
add_test(cad_damaged_files "/bin/sh" "-c" "exit 77")
set_tests_properties(cad_damaged_files PROPERTIES SKIP_RETURN_CODE 77)
"""


class Nightly(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.root = pathlib.Path(scratch.name)
        for name, body in PROGRAMS.items():
            self.write(name, f"#!/bin/bash\n{body}\n")
        for name in ("nightly.sh", "long_tests.py"):
            shutil.copy(SOURCE / "tests" / name, self.root / "tests" / name)
        self.write("build/release/CTestTestfile.cmake", LONG_TESTS)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    def run_script(self, *options):
        return subprocess.run([self.root / "tests" / "nightly.sh", *options], capture_output=True, text=True)

    def night(self, parts):
        """Returns the exit code and, by part, the verdict and the words of its line."""
        done = self.run_script("--no-build", "--only", parts)
        table = done.stdout.partition("== the night\n")[2]
        lines = re.findall(r"^(\S+) +(held|skipped|FAILED) +\d+ s  (.*)$", table, re.M)
        self.assertEqual(len(lines), len(table.splitlines()), done.stdout + done.stderr)
        return done.returncode, {part: (verdict, words) for part, verdict, words in lines}

    def test_what_holds(self):
        code, table = self.night("links")
        self.assertEqual((code, table), (0, {"links": ("held", "1000 visits")}))

    def test_it_goes_on_past_what_fails(self):
        code, table = self.night("links,sim,run,versions")
        self.assertEqual(code, 1)
        self.assertEqual(table["links"][0], "held")
        self.assertEqual(table["sim"], ("FAILED", "seed 17 FAILED"))
        self.assertEqual(table["run"], ("FAILED", "it said nothing"))
        self.assertEqual(table["versions"][0], "skipped")

    def test_a_skip_says_why_and_fails_nothing(self):
        code, table = self.night("faults,versions")
        skipped = ("skipped", "skipped: this machine has no namespaces")
        self.assertEqual((code, table), (0, {"faults": skipped, "versions": skipped}))

    def test_a_part_of_two_commands_runs_both_and_names_what_failed(self):
        code, table = self.night("planted")
        self.assertEqual((code, table), (1, {"planted": ("FAILED", "FAILED: tests/sim/planted_bugs.py: exit code 1")}))
        self.assertIn("all were found", (self.root / "build/nightly/planted.log").read_text())

    def test_a_failure_outweighs_a_skip(self):
        self.write("build/release/bin/wire_codec_test", "#!/bin/bash\nexit 1\n")
        code, table = self.night("versions")
        self.assertEqual((code, table["versions"]), (1, ("FAILED", "FAILED: build/release/bin/wire_codec_test: exit code 1")))

    def test_long_tests_have_their_own_limit(self):
        code, table = self.night("property,cad")
        self.assertEqual((code, table), (0, {"property": ("held", "1 of 1 held, 0 skipped"),
                                             "cad": ("skipped", "skipped: every test was")}))

    def test_long_tests_that_fail_or_are_not_there(self):
        self.write("build/release/CTestTestfile.cmake", LONG_TESTS.replace("= given", "= other").replace("cad_", "no_"))
        code, table = self.night("property,cad")
        self.assertEqual((code, table), (1, {"property": ("FAILED", "0 of 1 held, 0 skipped; FAILED: good"),
                                             "cad": ("FAILED", "FAILED: there is no such test")}))

    def test_wrong_usage(self):
        for options in (["--only", "nothing"], ["--no-such-option"], ["--only"]):
            self.assertEqual(self.run_script(*options).returncode, 2, options)
        parts = [line.split()[0] for line in self.run_script("--list").stdout.splitlines()]
        for system in (".github/workflows/nightly.yml", ".gitlab-ci.yml"):
            listed = re.search(r"part: \[(.*)\]", (SOURCE / system).read_text(), re.I).group(1)
            self.assertEqual(listed.split(", "), parts, f"{system} runs other parts")


if __name__ == "__main__":
    unittest.main()
