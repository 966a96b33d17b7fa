#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lists the tests that a ctest run skipped, with the reason, from its JUnit file.

Usage: list_skipped.py JUNIT.xml TESTS.json [--require LABEL,LABEL]
TESTS.json is what 'ctest --show-only=json-v1' prints: the JUnit file of CMake 3.25 has no labels.
Exit code 1 when a skipped test carries one of the required labels, or when no test carries one.
"""
import argparse
import json
import re
import sys
import xml.etree.ElementTree as ET

GTEST_SKIP = re.compile(r"^\[  SKIPPED \] (\S+) \(", re.MULTILINE)
GTEST_REASON = re.compile(r"^\S+:\d+: Skipped\n(.*)$", re.MULTILINE)
SAID = re.compile(r"^skipped: (.*)$", re.MULTILINE | re.IGNORECASE)


def read_labels(path):
    """Returns the set of labels of each test, by its name."""
    labels = {}
    with open(path, encoding="utf-8") as file:
        for test in json.load(file)["tests"]:
            values = [p["value"] for p in test.get("properties", []) if p["name"] == "LABELS"]
            labels[test["name"]] = set(values[0]) if values else set()
    return labels


def skips_of(case):
    """Returns (name, reason) pairs of one ctest test: of itself, or of single tests in a gtest binary."""
    name = case.get("name", "?")
    output = case.findtext("system-out") or ""
    if case.find("skipped") is not None:
        said = SAID.search(output)
        lines = [line for line in output.splitlines() if line.strip()]
        last = lines[-1].strip() if lines else "exit code 77"
        return [(name, said.group(1) if said else last)]
    reasons = GTEST_REASON.findall(output)
    names = GTEST_SKIP.findall(output)
    return [(f"{name}: {one}", reasons[i].strip() if i < len(reasons) else "no reason given")
            for i, one in enumerate(dict.fromkeys(names))]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("junit")
    parser.add_argument("tests")
    parser.add_argument("--require", default="")
    args = parser.parse_args()
    required = {word for word in args.require.split(",") if word}
    labels_of = read_labels(args.tests)
    cases = list(ET.parse(args.junit).getroot().iter("testcase"))
    broken = 0
    seen = set()
    skipped = []
    for case in cases:
        labels = labels_of.get(case.get("name"), set())
        seen |= labels
        for name, reason in skips_of(case):
            wanted = sorted(labels & required)
            broken += bool(wanted)
            mark = f"  REQUIRED by --require {','.join(wanted)}" if wanted else ""
            skipped.append(f"  {name}: {reason}{mark}")
    print(f"skipped: {len(skipped)}" if skipped else "skipped: none")
    for line in skipped:
        print(line)
    for label in sorted(required - seen):
        print(f"  no test has the label '{label}', which --require names")
        broken += 1
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
