#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plants the bugs of bugs.py in a copy of the sources and looks whether the property tests find them.

    planted_bugs.py --check                    does each bug still have its place? (ctest -R planted_bugs)
    planted_bugs.py [--build DIR] [--jobs N] [--only NAME ...] [--json FILE] [--table FILE]

All bugs are compiled into one build of the label `property`, side by side with what is right; an environment variable
says which one is alive. So one build serves all. First no bug is alive, and every test has to hold; then each is, and
one test has to fail: the one that is most likely to, else any other. Exit code 0: every bug was found; 1: one was not,
or has lost its place, or a test fails without any.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(HERE))
from bugs import BUGS  # noqa: E402

HEADER = """#pragma once
#include <cstdlib>
namespace tessera::core {
inline const int planted = [] {
  const char* const which = std::getenv("TESSERA_PLANTED");
  return which == nullptr ? 0 : std::atoi(which);
}();
}  // namespace tessera::core
"""


def fail(text):
    sys.exit(f"planted_bugs: {text}")


def places():
    """Returns, by path under the root, the texts with every bug planted."""
    texts = {}
    for number, bug in enumerate(BUGS, 1):
        path = f"slave/core/{bug.file}"
        text = texts.get(path) or (ROOT / path).read_text()
        if text.count(bug.right) != 1:
            fail(f"{bug.name}: its text stands {text.count(bug.right)} times in {path}; plant it anew (bugs.py)")
        is_alive = f"::tessera::core::planted == {number}"
        if bug.right.endswith(";"):
            planted = f"if ({is_alive}) {{ {bug.wrong} }} else {{ {bug.right} }}"
        else:
            planted = f"({is_alive} ? ({bug.wrong}) : ({bug.right}))"
        texts[path] = text.replace(bug.right, planted)
    return texts


def make_copy(folder):
    """Copies what git knows of, with the bugs. Files that are right already are left alone: a second build is short."""
    source = folder / "source"
    names = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True,
                           check=True).stdout.split("\n")
    texts = places()
    wanted = {name: (texts[name].encode() if name in texts else (ROOT / name).read_bytes())
              for name in names if name and (ROOT / name).is_file()}
    wanted["planted.h"] = HEADER.encode()
    for name, content in wanted.items():
        target = source / name
        if target.is_file() and target.read_bytes() == content:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        if (ROOT / name).exists():
            shutil.copymode(ROOT / name, target)
    for target in [path for path in source.rglob("*") if path.is_file()]:
        if str(target.relative_to(source)) not in wanted:
            target.unlink()
    return source


def build(folder, jobs):
    source = make_copy(folder)
    binary = folder / "build"
    # Both arms of a choice are compiled, and a constant in one of them makes warnings that mean nothing.
    flags = f"-include {source / 'planted.h'} -Wno-error"
    subprocess.run(["cmake", "-S", source, "-B", binary, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DTESSERA_TESTS=ON",
                    f"-DCMAKE_CXX_FLAGS={flags}"], check=True, stdout=subprocess.DEVNULL)
    built = subprocess.run(["ninja", "-C", binary, "-j", str(jobs), "tests_property"], capture_output=True, text=True)
    if built.returncode != 0:
        errors = [line for line in built.stdout.splitlines() if "error:" in line]
        fail("what is planted does not compile:\n" + "\n".join(errors[:5]))
    return binary


def failing_test(binary, number, pattern, jobs):
    """Returns the first test of the label, of those that match, that fails; or None. trace_tool is left out, since its
    program is not built here."""
    run = subprocess.run(["ctest", "--test-dir", binary, "-L", "^property$", "-R", pattern, "-E", "trace_tool", "-j", str(jobs),
                          "--stop-on-failure", "--output-on-failure"],
                         env={**os.environ, "TESSERA_PLANTED": str(number)}, capture_output=True, text=True)
    if "No tests were found" in run.stdout + run.stderr:
        fail(f"no test matches '{pattern}'")
    failed = re.search(r"Test +#\d+: (\S+) \.+.*\*\*\*(Failed|Timeout|Exception)", run.stdout)
    case = re.search(r"\[  FAILED  \] (\S+?)[, ]", run.stdout)
    if run.returncode == 0:
        return None
    return f"{failed[1] if failed else 'a test'}{': ' + case[1] if case else ''}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="only whether each bug has its place")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "planted")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--table", type=pathlib.Path)
    options = parser.parse_args()
    names = [bug.name for bug in BUGS]
    if len(set(names)) != len(names):
        fail("two bugs have one name")
    if unknown := set(options.only) - set(names):
        fail(f"no bug is called {', '.join(sorted(unknown))}")
    places()
    if options.check:
        print(f"{len(BUGS)} bugs have their place")
        return 0
    binary = build(options.build.resolve(), options.jobs)
    if not options.only:
        if found := failing_test(binary, 0, ".", options.jobs):
            fail(f"without a bug {found} fails")
    rows = []
    lines = ["| bug | what was done | found by | seconds |", "|---|---|---|---|"]
    print("\n".join(lines), flush=True)
    for number, bug in enumerate(BUGS, 1):
        if options.only and bug.name not in options.only:
            continue
        began = time.monotonic()
        found = failing_test(binary, number, bug.first, options.jobs) or failing_test(binary, number, ".", options.jobs)
        taken = time.monotonic() - began
        rows.append({"bug": bug.name, "what": bug.what, "file": bug.file, "found_by": found, "seconds": round(taken, 1)})
        lines.append(f"| {bug.name} | {bug.what} | {found or '**not found**'} | {taken:.0f} |")
        print(lines[-1], flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")
    if options.table:
        options.table.write_text("# Who finds the planted bugs\n\nBy `tests/property/planted/planted_bugs.py --table FILE`; seconds "
                                 "until the first test failed.\n\n" + "\n".join(lines) + "\n")
    missed = [row["bug"] for row in rows if not row["found_by"]]
    print(f"{len(rows) - len(missed)} of {len(rows)} found" + (f"; not {', '.join(missed)}" if missed else ""))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
