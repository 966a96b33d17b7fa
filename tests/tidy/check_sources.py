#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads the sources and checks them against the rules of rules.py; prints file:line: what is wrong.

Usage: check_sources.py ROOT        exit code 1 when anything is found
"""
import pathlib
import re
import sys

import figures
import rules

INCLUDE = re.compile(r'^\s*#\s*include\s+(["<])([^">]+)[">]')
# A full specialisation of a variable template, which is no inline variable by itself.
OWN_VALUE = re.compile(r"^[ ]*template\s*<>\s*(constexpr\b[^;{(=]*(?:=|\{))", re.MULTILINE)
SOURCES = {".h", ".hpp", ".cpp", ".cc"}
TOPS = ["common", "slave", "master", "proto", "deploy", "tests"]
PATH_CHECKED = SOURCES | {".py", ".sh", ".cmake", ".txt", ".json", ".toml", ".md", ".service", ".yaml", ".proto", ""}
MACHINE_PATH = re.compile(r"(?<![\w.}/$*-])/(?:" + "|".join(rules.MACHINE_PATHS) + r")/[A-Za-z.]")


class Findings:
    def __init__(self):
        self.lines = []

    def add(self, path, line, text):
        self.lines.append(f"{path}:{line}: {text}")


def folder_rule(path):
    """Returns the longest folder with a rule that holds `path`; None when none does."""
    folder = path.rpartition("/")[0]
    while folder:
        if folder in rules.ARROWS:
            return folder
        folder = folder.rpartition("/")[0]
    return None


def lies_in(path, places):
    return any(path.startswith(place) if place.endswith("/") else path == place for place in places)


def includes_of(text):
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(2), match.group(1) == '"'


def check_arrows(path, text, found):
    if path.startswith("tests/"):
        return
    owner = folder_rule(path)
    if owner is None:
        found.add(path, 1, "this folder has no line in the table of arrows (tests/tidy/rules.py)")
        return
    for number, name, is_own in includes_of(text):
        if not is_own or "/" not in name or name.split("/")[0] not in TOPS:
            continue
        target = folder_rule(name)
        if name.startswith("tests/"):
            found.add(path, number, f"nothing outside tests/ may include {name}")
        elif target != owner and target not in rules.ARROWS[owner]:
            found.add(path, number, f"{owner} may not include {name}: the arrow {target} -> {owner} does not exist")


def check_confinement(path, text, found):
    for number, name, _ in includes_of(text):
        for library, (patterns, places) in rules.CONFINED.items():
            if path.startswith("tests/") and library != "spdlog":
                continue
            if lies_in(name, patterns) or any(name.startswith(p) for p in patterns):
                if not lies_in(path, places):
                    found.add(path, number, f"{library} ({name}) is confined to {', '.join(places)}")


def check_one_file(sources, found):
    for library, patterns in rules.ONE_FILE_PER_FOLDER.items():
        first_of = {}
        for path, text in sources:
            if path.startswith("tests/"):
                continue
            for number, name, _ in includes_of(text):
                if not any(name.startswith(p) for p in patterns):
                    continue
                folder = path.rpartition("/")[0]
                other = first_of.setdefault(folder, path)
                if other != path:
                    found.add(path, number, f"{library} is already included by {other}: one file per folder")


def check_header(path, text, found):
    lines = text.splitlines()
    opening = 0
    while opening < len(lines) and lines[opening].startswith("//"):
        opening += 1
    if lines and rules.LICENCE_LINE in lines[0]:
        opening -= 1
    if opening < rules.HEADER_COMMENT_LINES_MIN:
        found.add(path, 1, f"a header opens with {rules.HEADER_COMMENT_LINES_MIN} or more lines of // comment: what it is for, threads, invariants")
    has_guard = any(re.match(r"#pragma once\b", line) for line in lines)
    is_toggled = path.endswith("-inl.h") and "HWY_TARGET_TOGGLE" in text
    if not has_guard and not is_toggled and not path.endswith("_text.h"):
        found.add(path, 1, "no #pragma once")
    for match in OWN_VALUE.finditer(text):
        line = text.count("\n", 0, match.start(1)) + 1
        found.add(path, line, "one value of a variable template is defined anew by every file: no inline stands before it")


def check_inl(path, text, found):
    for number, name, _ in includes_of(text):
        if name in rules.C_HEADERS or any(re.match(p, name) for p in rules.INL_MAY_INCLUDE):
            continue
        found.add(path, number, f"-inl.h files include only hwy/, -inl.h, _layout.h and C headers, not {name}")


def check_lanes(path, text, found):
    """Code of several instruction sets stands in their namespaces, under their attributes, apart from plain code."""
    lines = text.splitlines()
    if lies_in(path, rules.WITHOUT_HIGHWAYS_NAMES):
        for number, line in enumerate(lines, 1):
            if "hn::" in line:
                found.add(path, number, "Highway's own names: operators, or the functions of slave/core/simd/real-inl.h")
    if path.endswith("-inl.h"):
        check_lane_namespaces(path, lines, found)
        return
    first = next((number for number, name, _ in includes_of(text) if name.endswith("-inl.h")), None)
    if first is None or path.startswith("tests/") or any(name == "hwy/highway.h" for _, name, _ in includes_of(text)):
        return
    if rules.PLAIN_TEXT not in lines[:first]:
        found.add(path, first, f"an -inl.h without '{rules.PLAIN_TEXT}' before it, or Highway's loop over instruction sets")


def check_lane_namespaces(path, lines, found):
    for number, line in enumerate(lines, 1):
        match = re.match(r"namespace (tessera|tessera::core) \{$", line)
        if not match:
            continue
        inner = re.match(r"namespace (\w+) \{$", lines[number]) if number < len(lines) else None
        kind = inner.group(1) if inner else None
        if kind not in rules.LANE_NAMESPACES:
            found.add(path, number, f"not in {' or '.join(rules.LANE_NAMESPACES)}: one name for several instruction sets")
            continue
        before, after = rules.LANE_NAMESPACES[kind]
        if lines[number - 2] != before:
            found.add(path, number, f"no {before} before it: the attributes of the instruction set")
        if not any(other == after for other in lines[number:]):
            found.add(path, number, f"no {after} behind it")


def blank_text(text):
    """Returns `text` with comments, strings and characters blanked out; line breaks stay."""
    token = re.compile(
        r'R"(?P<tag>[^()\\\s]{0,16})\(.*?\)(?P=tag)"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])\'(?:\\.|[^\'\\\n])+\'',
        re.DOTALL)
    return token.sub(lambda m: re.sub(r"[^\n]", " ", m.group(0)), text)


SCOPE = re.compile(r"\b(namespace|class|struct|union|enum|extern)\b[^;(){}]*$")
GTEST_BODY = re.compile(r"\b(TEST|TEST_F|TEST_P|TYPED_TEST)\s*\([^{}]*\)\s*$")


def opens_function(head):
    """Whether a brace after `head` (the text since the last ; { or }) opens a function's body."""
    head = " ".join(line for line in head.splitlines() if not line.lstrip().startswith("#")).strip()
    if GTEST_BODY.search(head):
        return True
    if not head or head.endswith(("=", ",", "(", "return", "]")) or SCOPE.search(head):
        return False
    return ")" in head


def long_functions(text):
    """Yields (line, lines) of each function, outermost only, that is longer than the limit."""
    clean = blank_text(text)
    stack, head_start, line = [], 0, 1
    for i, c in enumerate(clean):
        if c == "\n":
            line += 1
        elif c == "{":
            head = clean[head_start:i]
            is_inside = any(entry is not None for entry in stack)
            start = line - head.strip().count("\n")
            stack.append(start if not is_inside and opens_function(head) else None)
            head_start = i + 1
        elif c == "}":
            start = stack.pop() if stack else None
            if start is not None and line - start + 1 > rules.FUNCTION_LINES_MAX:
                yield start, line - start + 1
            head_start = i + 1
        elif c == ";":
            head_start = i + 1


def check_lengths(path, text, found):
    count = text.count("\n")
    if count > rules.FILE_LINES_MAX:
        found.add(path, count, f"{count} lines, {rules.FILE_LINES_MAX} are the most: split by meaning")
    for number, line in enumerate(text.split("\n"), 1):
        if line.lstrip().startswith("//") and len(line) > rules.COMMENT_COLUMNS_MAX:
            found.add(path, number, f"a comment of {len(line)} columns, {rules.COMMENT_COLUMNS_MAX} are the most")
    for line, lines in long_functions(text):
        found.add(path, line, f"a function of {lines} lines, {rules.FUNCTION_LINES_MAX} are the most")


def check_machine_paths(path, text, found):
    for number, line in enumerate(text.splitlines(), 1):
        if MACHINE_PATH.search(line):
            found.add(path, number, "a path of one particular machine")


def check_strangers(path, text, found):
    """A folder that is kept free of a notion does not say its word."""
    for word, folders in rules.STRANGERS.items():
        if not lies_in(path, folders):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            if word in line.lower():
                found.add(path, number, f"the word '{word}': {', '.join(folders)} know nothing of it")


def unit_of(path):
    """A header, its source, and what it hides behind a pointer or compiles per instruction set, are one unit."""
    return re.sub(r"(-inl|_impl|_asio|_abi)?\.[a-z]+$", "", path)


def check_circles(sources, found):
    """Units (a header and its source) do not include each other in a circle: no arrow runs back up."""
    arrows = {}
    for path, text in sources:
        if path.startswith("tests/"):
            continue
        for number, name, is_own in includes_of(text):
            if is_own and unit_of(name) != unit_of(path):
                arrows.setdefault(unit_of(path), {}).setdefault(unit_of(name), (path, number))
    below, on_the_way = set(), []

    def descend(unit):
        on_the_way.append(unit)
        for other, (path, number) in sorted(arrows.get(unit, {}).items()):
            if other in on_the_way:
                circle = on_the_way[on_the_way.index(other):] + [other]
                found.add(path, number, "a circle: " + " -> ".join(circle))
            elif other not in below:
                descend(other)
        below.add(on_the_way.pop())

    for unit in sorted(arrows):
        if unit not in below:
            descend(unit)


def check_readme(path, text, found):
    if not path.endswith("README.md"):
        return
    lines = text.splitlines()
    if len(lines) > rules.README_LINES_MAX:
        found.add(path, len(lines), f"{len(lines)} lines: a map has {rules.README_LINES_MAX}; decisions are files of their own")
    for number, line in enumerate(lines, 1):
        if len(line) > rules.README_COLUMNS_MAX and not line.lstrip().startswith(("|", "![")):
            found.add(path, number, f"{len(line)} columns, {rules.README_COLUMNS_MAX} are the most")


def check_still(path, text, found):
    """Unit tests wait for what they test, not for the clock, and leave the system's sockets alone."""
    if not lies_in(path, rules.STILL_TESTS):
        return
    for number, line in enumerate(text.splitlines(), 1):
        for word in rules.STILL_MAY_NOT:
            if word in line:
                found.add(path, number, f"'{word}' in {path.rpartition('/')[0]}: tests/links has sockets, tests/sim has time")


def check_licence(path, text, found):
    """Each source names its licence where tools look for it."""
    if pathlib.PurePosixPath(path).suffix not in SOURCES | {".proto", ".py", ".sh", ".cmake"} and not path.endswith("CMakeLists.txt"):
        return
    lines = text.split("\n", 2)
    line = lines[1] if lines[0].startswith("#!") and len(lines) > 1 else lines[0]
    if line not in ("// " + rules.LICENCE_LINE, "# " + rules.LICENCE_LINE):
        found.add(path, 1, f"the first line is not '{rules.LICENCE_LINE}'")


TIME_LIMIT = re.compile(r"\bTIMEOUT\s+\d")


def check_time_limits(path, text, found):
    """A busy machine breaks a test's own limit: there is one for all, which ends what hangs (tests/CMakeLists.txt)."""
    if not path.startswith("tests/") or not path.endswith("CMakeLists.txt"):
        return
    for number, line in enumerate(text.splitlines(), 1):
        if TIME_LIMIT.search(line):
            found.add(path, number, "a time limit of its own: use tessera_hang_seconds")


def is_kept(path):
    """Whether the file is the project's own text (not built, not hidden by another tool)."""
    parts = path.split("/")
    return not any(part in ("build", "out", "__pycache__") or (part.startswith(".") and part != ".ci") for part in parts)


def read_tree(root):
    files = []
    for top in TOPS + [".ci"]:
        for file in sorted((root / top).rglob("*")):
            path = file.relative_to(root).as_posix()
            if file.is_file() and is_kept(path) and file.suffix in PATH_CHECKED:
                files.append((path, file.read_text(encoding="utf-8", errors="replace")))
    for name in ["CMakeLists.txt", "CMakePresets.json", "README.md", "CONTRIBUTING.md", "CHANGELOG.md"]:
        if (root / name).is_file():
            files.append((name, (root / name).read_text(encoding="utf-8")))
    return files


def check_cmake(files, found):
    """Every folder with something to compile lists it in its own CMakeLists.txt (where the tree is built by CMake)."""
    names = {path for path, _ in files}
    if "CMakeLists.txt" not in names:
        return
    for path in sorted(names):
        folder = path.rpartition("/")[0]
        if path.endswith((".cpp", ".cc")) and f"{folder}/CMakeLists.txt" not in names:
            found.add(path, 1, f"{folder} has no CMakeLists.txt")


def check_tree(root):
    """Returns all findings below `root`, as file:line: text, and the number of sources."""
    found = Findings()
    files = read_tree(pathlib.Path(root))
    sources = [(path, text) for path, text in files if pathlib.PurePosixPath(path).suffix in SOURCES]
    for path, text in sources:
        check_arrows(path, text, found)
        check_confinement(path, text, found)
        check_lengths(path, text, found)
        check_strangers(path, text, found)
        check_still(path, text, found)
        if path.endswith((".h", ".hpp")):
            check_header(path, text, found)
        if path.endswith("-inl.h"):
            check_inl(path, text, found)
        check_lanes(path, text, found)
    check_one_file(sources, found)
    check_circles(sources, found)
    check_cmake(files, found)
    has_licence = (pathlib.Path(root) / "LICENSE").is_file()
    for path, text in files:
        if has_licence:
            check_licence(path, text, found)
        check_time_limits(path, text, found)
        check_readme(path, text, found)
        figures.check_figures(path, text, found)
        if not path.startswith("tests/tidy/"):
            check_machine_paths(path, text, found)
    return found.lines, len(sources)


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    lines, count = check_tree(sys.argv[1])
    for line in lines:
        print(line)
    if count == 0:
        print(f"no sources below {sys.argv[1]}")
        return 1
    print(f"{count} sources, {len(lines)} findings")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
