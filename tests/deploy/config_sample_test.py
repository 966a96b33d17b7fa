#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every key of the config sample is read, and every option of the command line is in the sample.

Usage: config_sample_test.py TESSERA_MASTER SAMPLE
"""
import pathlib
import re
import subprocess
import sys
import tempfile

# These options are no settings: they say what to do, where to put it, and where the config file is.
NOT_SETTINGS = {"help", "config", "output", "screenshot", "screenshot-after"}


def run(*words):
    return subprocess.run(words, capture_output=True, text=True, timeout=60)


def main():
    master, sample = sys.argv[1], pathlib.Path(sys.argv[2]).read_text()
    lines = re.findall(r"^#? ?([a-z-]+) = (.*)$", sample, re.MULTILINE)
    options = set()
    for command in ("serve", "render", "view"):
        options |= set(re.findall(r"^\s+(?:-\w,)?--([a-z-]+)", run(master, command, "--help").stdout, re.MULTILINE))
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        for key, value in lines:
            file = pathlib.Path(folder, "one.toml")
            file.write_text(f"{key} = {value}\n")
            # A scene that does not exist ends the run after the options were read.
            also = ["--plain"] if key in ("listen", "connect") else []
            ended = run(master, "render", "none.obj", "-o", "x.png", "--config", str(file), *also)
            if str(file) in ended.stderr or "unknown key" in ended.stderr:
                wrong.append(f"'{key} = {value}': {ended.stderr.strip()}")
    keys = {key for key, _ in lines}
    wrong += [f"option --{name} is not in the sample" for name in sorted(options - keys - NOT_SETTINGS)]
    wrong += [f"key {key} is no option" for key in sorted(keys - options)]
    print("\n".join(wrong) or f"{len(keys)} keys")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
