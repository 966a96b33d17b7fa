#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Programs, plug-ins and the session library have what makes memory errors end them, and units let a daemon do little.

Usage: hardening_test.py BUILD_FOLDER FOLDER_OF_UNITS

The commands that compile the product's sources are read: all of them have the flags, the ray core's too. Programs are read with readelf, and hardening-check of Debian's devscripts is
asked about them. Units are judged by systemd-analyze. What is not installed is skipped, saying so, with exit code 77.
So is a build with sanitizers, which take the place of stack protector and fortified functions.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys

EXPOSURE_MAX = 1.1
BUILD, UNITS = (pathlib.Path(word) for word in sys.argv[1:3])
BIN = BUILD / "bin"
FLAGS = ["-fstack-protector-strong", "-fstack-clash-protection", "-fcf-protection=full", "-D_FORTIFY_SOURCE=3"]
# A function of ours in each, which may be called through a pointer.
PROGRAMS = {"tessera-master": "main", "tessera-slave": "main", "tessera-import": "main", "tessera-keys": "main"}
LIBRARIES = {"tessera_image_oiio.so": "tessera_begin_image", "tessera_import_cad.so": "tessera_read_cad_1",
             "libtessera.so": "_ZN7tessera7Session4openERKNS_14SessionOptionsE"}

wrong, skipped = [], []


def claim(is_true, what):
    if not is_true:
        wrong.append(what)


def output_of(*words):
    result = subprocess.run(words, capture_output=True, text=True, check=False)
    return result.stdout + result.stderr


def look_at_file(path, is_program):
    name = path.name
    headers = output_of("readelf", "--wide", "--file-header", "--program-headers", "--dynamic", str(path))
    symbols = output_of("readelf", "--wide", "--dyn-syms", str(path))
    claim(re.search(r"Type:\s+DYN", headers), f"{name} is not position independent")
    if is_program:
        claim(re.search(r"\(FLAGS_1\).*\bPIE\b", headers), f"{name} is not linked as PIE")
    claim("GNU_RELRO" in headers, f"{name}: relocations stay writable")
    claim(re.search(r"\(FLAGS(_1)?\).*\b(NOW|BIND_NOW)\b", headers), f"{name}: symbols are bound late")
    claim(re.search(r"GNU_STACK\s.*\sRW\s", headers), f"{name}: the stack is executable")
    claim("(RPATH)" not in headers, f"{name} has an RPATH")
    claim("__stack_chk_fail" in symbols, f"{name}: no function has a stack protector")
    claim(re.search(r"__(memcpy|memmove|memset|snprintf|vsnprintf|read|recv|strcpy|fprintf|printf)_chk", symbols)
          or name == "tessera_import_cad.so", f"{name}: no function is fortified")
    # The first instruction of a function that may be called through a pointer says so (x86 alone).
    if "X86-64" in headers:
        function = (PROGRAMS | LIBRARIES)[name]
        code = output_of("objdump", "-d", f"--disassemble={function}", str(path))
        claim("endbr64" in code, f"{name}: no control flow protection in {function}")


def look_at_commands():
    """Each object of the product is compiled with all flags; tests have none."""
    objects = 0
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        words = entry["command"].split()
        made = pathlib.Path(entry["directory"], words[words.index("-o") + 1]).relative_to(BUILD).as_posix()
        if made.startswith("tests/"):
            continue
        if any(word.startswith("-fsanitize=") for word in words):
            return skipped.append("commands: this build has a sanitizer")
        objects += 1
        missing = [flag for flag in FLAGS if flag not in words]
        # The last word counts.
        weakened = [word for word in words if word.startswith(("-fno-stack", "-fcf-protection=none", "-D_FORTIFY_SOURCE=0"))]
        claim(not missing, f"{made} is compiled without {' '.join(missing)}")
        claim(not weakened, f"{made} is compiled with {' '.join(weakened)}")
    claim(objects > 300, f"{objects} objects of the product in compile_commands.json")
    return print(f"{objects} objects of the product have the flags")


def look_at_files():
    if not shutil.which("readelf") or not shutil.which("objdump"):
        return skipped.append("programs: binutils is not installed")
    for name in list(PROGRAMS) + list(LIBRARIES):
        path = BIN / name
        if not path.exists():
            claim(name not in PROGRAMS, f"{path} is not built")
            print(f"not looked at: {name}, which is not built")
        elif "__asan_init" in output_of("readelf", "--wide", "--dyn-syms", str(path)) or "__tsan_init" in output_of(
                "readelf", "--wide", "--dyn-syms", str(path)):
            skipped.append(f"{name}: has a sanitizer")
        else:
            look_at_file(path, name in PROGRAMS)
    return None


def ask_hardening_check():
    if not shutil.which("hardening-check"):
        return skipped.append("hardening-check is not installed (package devscripts)")
    for name in PROGRAMS:
        # Control flow is looked at above: a note of it in the file wants one in each file of the C library, too, which
        # Debian 12 does not have.
        result = subprocess.run(["hardening-check", "--nocfprotection", str(BIN / name)], capture_output=True, text=True,
                                check=False)
        claim(result.returncode == 0, f"hardening-check: {result.stdout}")
    return None


def look_at_units():
    units = sorted(UNITS.glob("*.service"))
    claim(len(units) == 2, f"{len(units)} units in {UNITS}")
    for unit in units:
        claim("\nLimitCORE=0\n" in unit.read_text(), f"{unit.name} leaves core files")
    if not shutil.which("systemd-analyze"):
        return skipped.append("units: systemd-analyze is not installed")
    for unit in units:
        text = output_of("systemd-analyze", "security", "--offline=true", "--no-pager", str(unit))
        exposure = re.search(r"Overall exposure level for \S+: ([0-9.]+)", text)
        if not exposure:
            skipped.append(f"{unit.name}: this systemd-analyze judges no file")
            continue
        print(f"{unit.name}: exposure {exposure[1]}")
        claim(float(exposure[1]) <= EXPOSURE_MAX, f"{unit.name}: exposure {exposure[1]} is above {EXPOSURE_MAX}")
    return None


look_at_commands()
look_at_files()
ask_hardening_check()
look_at_units()
for line in skipped:
    print("skipped:", line)
for line in wrong:
    print("WRONG:", line)
sys.exit(1 if wrong else 77 if skipped else 0)
