# SPDX-License-Identifier: Apache-2.0
"""Finds measured speed in the prose of documents, where it grows old. It stands between the marks of
tests/bench/tables.py, which writes it from results. Limits, sizes and errors are no speed."""
import re

MARKS_BEGIN, MARKS_END = ("<!-- results: ", "<!-- plot: "), ("<!-- end of results -->", "<!-- end of plot -->")
NUMBER = r"\d[\d.,]*"
SPEED = re.compile(
    rf"""{NUMBER}\s*(?:M?rays/s|Mrays|million\s+rays\s+a\s+second|rays\s+a\s+second|frames/s|frames\s+a\s+second|tiles/s
          |CPU-s\b|CPU[ -]seconds?|s\s+a\s+frame|cycles\b|times\s+as\s+(?:fast|long)|times\s+(?:faster|slower))
      |{NUMBER}\s*%\s+(?:faster|slower|fewer|longer|dearer|cheaper|of\s+(?:the|its|all)\s+(?:time|instructions|steps|rate)
          |(?:more|less)\s+(?:time|instructions|to\s+build))
      |\bx\s+\d\.\d
      |{NUMBER}\s+(?:of|to)\s+Embree
      |{NUMBER}\s*[µun]s\s+(?:a|per|for\s+each|for\s+every)\s""",
    re.X)
# Folders whose tables are measurements unless most of their cells are words.
MEASURED = re.compile(r"(^|/)decisions/|^tests/bench/[^/]*\.md$|^tests/sim/(scaling|lab)\.md$|^tests/faults/figures\.md$")
NUMERIC_CELL = re.compile(r"^[-+*~]*\d")


def paragraphs(text):
    """Yields (number of the first line, lines) of each paragraph outside of marks and of code."""
    lines, first, is_marked, is_code = [], 0, False, False
    for number, line in enumerate(text.splitlines() + [""], 1):
        if line.startswith(MARKS_BEGIN):
            is_marked = True
        if line.lstrip().startswith("```"):
            is_code = not is_code
        is_out = is_marked or is_code or (not lines and line.startswith("    ")) or not line.strip()
        if line.startswith(MARKS_END):
            is_marked = False
        if not is_out:
            first = first if lines else number
            lines.append(line)
        elif lines:
            yield first, lines
            lines = []


def check_figures(path, text, found):
    if not path.endswith(".md"):
        return
    for first, lines in paragraphs(text):
        if lines[0].lstrip().startswith("|"):
            cells = [cell.strip() for line in lines[2:] for cell in line.strip().strip("|").split("|")[1:]]
            numeric = sum(bool(NUMERIC_CELL.match(cell)) for cell in cells)
            if MEASURED.search(path) and 2 * numeric > len(cells):
                found.add(path, first, "a measured table outside of marks: put it into tests/bench/results")
            continue
        match = SPEED.search("\n".join(lines))
        if match:
            line = first + "\n".join(lines)[:match.start()].count("\n")
            words = " ".join(match[0].split())
            found.add(path, line, f"'{words}' is measured: let tests/bench/tables.py write it, or say it in words")
