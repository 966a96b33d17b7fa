#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Files that ask for too much cost the importer little and are named in one line; it is in its sandbox while it reads.

    bad_files_test.py           TESSERA_BIN names the folder of the programs

Bounds are of memory and of processor time, which other programs on the machine do not change.
"""
import os
import pathlib
import re
import resource
import struct
import subprocess
import sys
import tempfile
import unittest

import bad_files

IMPORTER = os.path.join(os.environ.get("TESSERA_BIN", "build/release/bin"), "tessera-import")
MEMORY_MIB_MAX, SECONDS_MAX = 1024, 5
# Machines differ, most of all in what the first touch of a page costs: a file may also cost this many times what it
# takes to fill that much memory and to read it once.
FILLS_MAX = 4
LIBRARIES_MAX = 60  # of an importer that decodes no picture


class Run:
    """One run of the importer to its end: what it said, and what it cost."""

    def __init__(self, path, environment=None):
        errors = tempfile.TemporaryFile()  # a pipe that nobody reads would stop the importer
        process = subprocess.Popen([IMPORTER, "--", str(path)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=errors, env=environment or {})
        self.bytes, self.head = 0, b""  # warnings stand before the scene
        while part := os.read(process.stdout.fileno(), 1 << 20):
            self.bytes += len(part)
            self.head += part[:max(0, 100_000 - len(self.head))]
        process.stdout.close()
        _, status, usage = os.wait4(process.pid, 0)
        self.code = process.returncode = os.waitstatus_to_exitcode(status)
        errors.seek(0)
        self.errors = errors.read().decode(errors="replace")
        errors.close()
        self.memory_mib = usage.ru_maxrss / 1024
        self.seconds = usage.ru_utime + usage.ru_stime

    def lines(self, path):
        """What a person is told: the refusal, or the warnings, which begin with the folder's name."""
        told = self.errors.encode() if self.code else self.head
        folder = re.escape(str(path.parent).encode())
        return [line.decode(errors="replace") for line in re.findall(folder + rb"/[^\0-\x1f]*", told)]


def seconds_allowed():
    """CPU time that a file may cost on this machine."""
    fill = f"import zlib; zlib.crc32(b'\\1' * ({MEMORY_MIB_MAX} << 20))"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", fill], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return max(SECONDS_MAX, FILLS_MAX * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime))


class BadFiles(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)

    def test_each_costs_little_and_is_named(self):
        allowed = seconds_allowed()
        print(f"allowed: {allowed:.1f} s, {MEMORY_MIB_MAX} MiB")
        for make, words in bad_files.FILES:
            path = make(self.folder)
            with self.subTest(path.name):
                run = Run(path)
                lines = run.lines(path)
                print(f"{path.name:14} {run.seconds:5.2f} s {run.memory_mib:5.0f} MiB  "
                      f"{'; '.join(line.split('/')[-1][:110] for line in lines[:1])}")
                self.assertIn(run.code, (0, 1), run.errors)
                self.assertLess(run.memory_mib, MEMORY_MIB_MAX)
                self.assertLess(run.seconds, allowed)
                if words is None:
                    self.assertEqual((run.code, lines), (0, []))
                else:
                    self.assertTrue(any(words in line for line in lines), lines)

    def test_few_libraries_are_loaded_where_no_picture_is_decoded(self):
        def libraries(path):
            log = Run(path, {"LD_DEBUG": "files"}).errors
            return set(re.findall(r"calling init: (\S*\.so\S*)", log))
        plain = self.folder / "plain.obj"
        plain.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        few = libraries(plain)
        (self.folder / "small.png").write_bytes(bad_files.zero_png(8, 4))
        many = libraries(bad_files.textured_obj(self.folder, "textured", "small.png"))
        print(f"{len(few)} libraries without a picture, {len(many)} with one")
        self.assertGreater(len(few), 1, "the loader's log is not understood")
        self.assertLessEqual(len(few), LIBRARIES_MAX)
        self.assertTrue(any("OpenImageIO" in name for name in many))

    def sandboxed(self, path):
        """The importer's state while it waits for a reader of its output, which is longer than a pipe holds."""
        process = subprocess.Popen([IMPORTER, "--", str(path)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, env={})
        try:
            self.assertTrue(os.read(process.stdout.fileno(), 1), "the file is not read")
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            return {key: int(value) for key, value in re.findall(r"(NoNewPrivs|Seccomp):\s*(\d+)", status)}
        finally:
            process.kill()
            process.stdout.close()
            process.wait()

    def test_the_importer_is_in_its_sandbox(self):
        if not os.path.exists("/proc/sys/kernel/seccomp"):
            self.skipTest("this kernel has no seccomp")
        mesh = self.folder / "long.obj"
        mesh.write_text("".join(f"v {i} {i % 7} {i % 3}\n" for i in range(30_000)) +
                        "".join(f"f {i} {i + 1} {i + 2}\n" for i in range(1, 29_000)))
        sky = self.folder / "sky.hdr"
        sky.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 200 +X 200\n" + struct.pack("4B", 128, 64, 32, 129) * 40_000)
        for path in (mesh, sky):
            with self.subTest(path.name):
                self.assertEqual(self.sandboxed(path), {"NoNewPrivs": 1, "Seccomp": 2})


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
