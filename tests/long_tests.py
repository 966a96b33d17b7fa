#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs tests of a build in their long form (TESSERA_LONG=1), one after the other, and goes on past what fails.

    long_tests.py BUILD_FOLDER CTEST_OPTION...        for example build/release -L property

ctest would end each after the limit of its usual form, which it prefers to --timeout; here one that hangs is ended after
four hours. Exit code 0: all held; 1: one did not, or there is none; 77: all were skipped.
"""
import json
import os
import subprocess
import sys
import time

HANG_S = 4 * 3600


def tests_of(folder, options):
    """Returns name, command and properties of the tests that ctest would run."""
    run = subprocess.run(["ctest", "--test-dir", folder, "--show-only=json-v1", *options], stdout=subprocess.PIPE, check=True)
    for test in json.loads(run.stdout)["tests"]:
        properties = {p["name"]: p["value"] for p in test.get("properties", [])}
        yield test["name"], test.get("command"), properties


def run_one(command, properties):
    """Returns the verdict and the output."""
    if not command:
        return "FAILED", "its program is not built"
    environment = os.environ | {"TESSERA_LONG": "1"} | dict(word.split("=", 1) for word in properties.get("ENVIRONMENT", []))
    try:
        run = subprocess.run(command, env=environment, cwd=properties.get("WORKING_DIRECTORY"), timeout=HANG_S,
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    except (subprocess.TimeoutExpired, OSError) as error:
        return "FAILED", str(error)
    is_skipped = run.returncode != 0 and run.returncode == properties.get("SKIP_RETURN_CODE")
    verdict = "skipped" if is_skipped else "held" if run.returncode == 0 else "FAILED"
    return verdict, f"{run.stdout.decode(errors='replace')}exit code {run.returncode}"


def main():
    counts = {"held": 0, "skipped": 0, "FAILED": 0}
    failed = []
    for name, command, properties in tests_of(sys.argv[1], sys.argv[2:]):
        began = time.monotonic()
        verdict, output = run_one(command, properties)
        print(f"{name:36} {verdict:8} {time.monotonic() - began:8.1f} s", flush=True)
        counts[verdict] += 1
        if verdict == "FAILED":
            failed.append(name)
        if verdict != "held":
            print(output, flush=True)
    ran = counts["held"] + counts["FAILED"]
    if not ran:
        print("skipped: every test was" if counts["skipped"] else "FAILED: there is no such test")
        return 77 if counts["skipped"] else 1
    print(f"{counts['held']} of {ran} held, {counts['skipped']} skipped" + (f"; FAILED: {', '.join(failed)}" if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
