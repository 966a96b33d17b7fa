#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sends damaged scene files through the real tessera-import: no crash, no hang, no memory above its limit.

    damaged_files.py FILE... [--count N] [--seed S] [--seconds T] [--memory-mb M] [--show K]

Each of N files is one of FILE with one to four faults: flipped bits, cut ends, numbers exchanged or replaced (in text,
and in the text of binary glTF), pieces taken out or doubled, lines exchanged, references (#12) bent. FILE's folder is copied once, for what FILE names beside
it. A run takes long, and is for people, not for CI. TESSERA_BIN names the folder of the programs.

Exit code 1, and the damaged file kept, when the importer dies of a signal, takes longer than T seconds or more memory
than its limit, or ends without a line.
"""
import argparse
import concurrent.futures
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time

REFERENCE = re.compile(rb"#\d+")
NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
STRANGE = [b"-1", b"0", b"1e39", b"4294967295", b"4294967296", b"18446744073709551616", b"1e999", b"1e300", b"nan", b"null", b"\"x\"", b"[]",
           b"{}", b"2147483647", b"0.5", b"-0", b"65536", b"1e-39", b"true"]


def exchange_number(data, rng):
    """Replaces a number of the text by another of it, or by a strange one."""
    end = len(data)
    if data[:4] == b"glTF" and len(data) >= 20:  # the text of the JSON chunk; its length stays
        end = min(end, 20 + int.from_bytes(data[12:16], "little"))
    found = [m for m in NUMBER.finditer(bytes(data[:end])) if m.end() - m.start() < 30]
    if not found:
        return data
    at = rng.choice(found)
    new = rng.choice(STRANGE) if rng.random() < 0.6 else rng.choice(found).group()
    if data[:4] == b"glTF":
        room = at.end() - at.start()
        new = new[:room].ljust(room)
    return data[:at.start()] + new + data[at.end():]


def exchange_lines(data, rng):
    lines = data.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def bend_reference(data, rng):
    """Lets a reference name what another one does, so that types differ and circles come about."""
    found = list(REFERENCE.finditer(data))
    if not found:
        return exchange_number(data, rng)
    at = rng.choice(found)
    return data[:at.start()] + rng.choice(found).group() + data[at.end():]


def damage(data, rng):
    for _ in range(rng.randint(1, 4)):
        kind, at = rng.randrange(10), rng.randrange(max(len(data), 1))
        if not data:
            return b"x"
        if kind == 0:
            data = data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1:]
        elif kind == 1:
            data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1:]
        elif kind == 2 and rng.random() < 0.3:
            data = data[:at]
        elif kind == 3:
            data = data[:at] + data[at + rng.randrange(1, 64):]
        elif kind == 4:
            data = data[:at] + data[at:at + rng.randrange(1, 64)] + data[at:]
        elif kind == 5:
            data = data[:at] + rng.choice([b"\xff\xff\xff\xff", b"\0\0\0\0", b"\xff\xff\xff\x7f", b"\0\0\xc0\x7f"]) + data[at + 4:]
        elif kind == 6:
            data = exchange_lines(data, rng)
        elif kind == 7:
            data = bend_reference(data, rng)
        else:
            data = exchange_number(data, rng)
    return data


class Trial:
    def __init__(self, number, options):
        rng = random.Random(f"{options.seed} {number}")
        source = options.files[number % len(options.files)]
        self.path = options.copies[source.parent] / f"{number}{source.suffix}"
        self.path.write_bytes(damage(source.read_bytes(), rng))
        begin = time.monotonic()
        run = subprocess.Popen([options.program, "--memory-mb", str(options.memory_mb), "--cpu-seconds",
                                str(options.cpu_seconds), self.path], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)
        with concurrent.futures.ThreadPoolExecutor(2) as readers:
            out = readers.submit(lambda: sum(len(part) for part in iter(lambda: run.stdout.read(1 << 20), b"")))
            error = readers.submit(run.stderr.read)
            while True:
                pid, status, usage = os.wait4(run.pid, os.WNOHANG)
                if pid or time.monotonic() - begin > options.seconds:
                    break
                time.sleep(0.01)
            self.is_hanging = not pid
            if self.is_hanging:
                os.kill(run.pid, 9)
                _, status, usage = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
            self.bytes, text = out.result(), error.result()
        self.seconds, self.cpu = time.monotonic() - begin, usage.ru_utime + usage.ru_stime
        self.memory_mb = usage.ru_maxrss / 1024
        self.code, self.line = run.returncode, text.decode(errors="replace").strip()
        self.wrong = self.verdict(options)
        if not self.wrong:
            self.path.unlink()

    def verdict(self, options):
        if self.is_hanging:
            return f"hangs: ended after {self.seconds:.1f} s"
        if self.code < 0:
            return f"ended by signal {-self.code}"
        if self.memory_mb > options.memory_mb:
            return f"took {self.memory_mb:.0f} MiB"
        if self.code == 0:
            return None if self.bytes > 0 else "ended well without a scene"
        # Libraries may print lines of their own; the master looks at that of the importer.
        own = [line for line in self.line.split("\n") if line.startswith("tessera-import: ")]
        return None if len(own) == 1 and str(self.path) in own[0] else f"says {self.line!r}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", type=pathlib.Path, nargs="+")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--cpu-seconds", type=int, default=300, help="the importer's own limit")
    parser.add_argument("--memory-mb", type=int, default=1024)
    parser.add_argument("--show", type=int, default=10, help="so many lines of refusals")
    options = parser.parse_args()
    options.program = pathlib.Path(os.environ["TESSERA_BIN"]) / "tessera-import"
    options.files = [file.resolve() for file in options.files]
    folder = pathlib.Path(tempfile.mkdtemp(prefix="damaged-"))
    # Folders of one name lie apart; dict.fromkeys() keeps the order of the command line.
    options.copies = {parent: folder / str(i) / parent.name for i, parent in enumerate(dict.fromkeys(f.parent for f in options.files))}
    for parent, copy in options.copies.items():
        shutil.copytree(parent, copy)
    print(f"seed {options.seed}, {options.count} files of {len(options.files)}")
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        trials = list(pool.map(lambda number: Trial(number, options), range(options.count)))
    wrong = [trial for trial in trials if trial.wrong]
    shown = {}
    for trial in trials:
        if trial.code == 1:
            shown.setdefault(re.sub(r"[\d.]+", "#", trial.line.split(": ", 2)[-1]), trial.line)
    for line in list(shown.values())[:options.show]:
        print(line.replace(str(folder) + "/", "").removeprefix("tessera-import: "))
    for trial in wrong:
        print(f"WRONG {trial.path}: {trial.wrong}")
    print(f"{len(trials)} files: {sum(t.code == 0 for t in trials)} scenes, {sum(t.code == 1 for t in trials)} refused by one line "
          f"({len(shown)} kinds), {len(wrong)} wrong; longest {max(t.seconds for t in trials):.1f} s "
          f"({max(t.cpu for t in trials):.1f} s of CPU), most memory {max(t.memory_mb for t in trials):.0f} MiB "
          f"of {options.memory_mb}")
    if not wrong:
        shutil.rmtree(folder)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
