#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws an interval of a trace (tessera-master --trace FILE.json) as an SVG picture.

Each render thread of a slave has a row, below the frames of the master; below them are rows of its builder and of
scenes on their way to it. A tile has its frame's colour, builds are grey, transfers light grey; in a gap the thread
waits. For a closer look open the trace itself at ui.perfetto.dev.
"""
import argparse
import json
import sys
from xml.sax.saxutils import escape

COLOURS = ["#4c78a8", "#f58518", "#54a24b", "#b279a2", "#e45756", "#72b7b2", "#9d755d", "#eeca3b"]
WIDTH_PX, NAME_PX, ROW_PX, HEAD_PX = 1000, 150, 14, 26
MASTER_PROCESS = 1
BUILD, TRANSFER = "builds", "transfers"  # in the place of a frame
SCENE_COLOURS = {BUILD: "#888", TRANSFER: "#bbb"}


def read(path):
    """Returns spans as (process, row, begin_us, end_us, frame), the names of processes, and the file's other data."""
    with open(path, encoding="utf-8") as file:
        trace = json.load(file)
    spans, names = [], {}
    for event in trace["traceEvents"]:
        if event["ph"] == "X":
            begin = event["ts"]
            of_scene = BUILD if "built_primitives" in event["args"] else TRANSFER
            spans.append((event["pid"], event["tid"], begin, begin + event["dur"], event["args"].get("frame", of_scene)))
        elif event["ph"] == "M" and event["name"] == "process_name":
            names[event["pid"]] = event["args"]["name"]
    return spans, names, trace["otherData"]


def busy_share(spans, begin, end):
    tiles = [s for s in spans if s[0] != MASTER_PROCESS and s[4] not in SCENE_COLOURS]
    rows = {(s[0], s[1]) for s in tiles}
    used = sum(min(s[3], end) - max(s[2], begin) for s in tiles)
    return used / (len(rows) * (end - begin)) if rows else 0.0


def ticks(begin, end):
    """Yields round times in the interval, about ten of them."""
    step = 1.0
    while (end - begin) / step > 12:
        step *= 10 if (end - begin) / step > 120 else (2.5 if str(step)[0] == "2" else 2)
    at = -(-begin // step) * step
    while at <= end:
        yield at
        at += step


def draw(spans, names, other, begin, end):
    spans = [s for s in spans if s[3] > begin and s[2] < end]
    rows = sorted({(s[0], s[1]) for s in spans})
    of_scenes = {(s[0], s[1]): s[4] for s in spans if s[4] in SCENE_COLOURS}
    scale = (WIDTH_PX - NAME_PX - 30) / (end - begin)
    x = lambda t: NAME_PX + (min(max(t, begin), end) - begin) * scale  # noqa: E731
    tops, y, last = {}, HEAD_PX + 4, None
    for row in rows:
        y += 6 if last is not None and row[0] != last else 0
        tops[row], last = y, row[0]
        y += ROW_PX
    height = y + 24
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH_PX} {height}" font-family="sans-serif" '
           'font-size="10">', f'<rect width="{WIDTH_PX}" height="{height}" fill="#fff"/>']
    for at in ticks(begin, end):
        out.append(f'<path d="M{x(at):.1f} {HEAD_PX}V{y}" stroke="#ddd"/>'
                   f'<text x="{x(at):.1f}" y="{HEAD_PX - 6}" text-anchor="middle" fill="#555">{at / 1000:g} ms</text>')
    for process, row in rows:
        top = tops[process, row]
        name = names.get(process, "?")
        label = ("frames" if row == 0 else "") if process == MASTER_PROCESS else f"{name[:18]} : {of_scenes.get((process, row), row)}"
        out.append(f'<text x="{NAME_PX - 6}" y="{top + 10}" text-anchor="end">{escape(label)}</text>')
    for process, row, span_begin, span_end, frame in sorted(spans, key=lambda s: s[:4]):
        left, right = x(span_begin), x(span_end)
        top = tops[process, row]
        colour = SCENE_COLOURS[frame] if frame in SCENE_COLOURS else COLOURS[frame % len(COLOURS)]
        out.append(f'<rect x="{left:.2f}" y="{top + 1}" width="{max(right - left - 0.4, 0.3):.2f}" height="{ROW_PX - 2}" '
                   f'fill="{colour}"/>')
        if process == MASTER_PROCESS and right - left > 40:
            out.append(f'<text x="{left + 4:.1f}" y="{top + 11}" fill="#fff">frame {frame}</text>')
    error = max((float(e) for e in other.get("clock_error_us", {}).values()), default=0.0)
    slaves = len({s[0] for s in spans if s[0] != MASTER_PROCESS})
    out.append(f'<text x="{NAME_PX}" y="{height - 8}" fill="#555">{slaves} slaves, render threads busy '
               f'{100 * busy_share(spans, begin, end):.1f} % of this interval; clocks within {error:.0f} us</text>')
    return "\n".join(out + ["</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trace", help="file written by tessera-master --trace")
    parser.add_argument("-o", "--output", help="SVG file (default: standard output)")
    parser.add_argument("--from", dest="begin", type=float, metavar="MS", help="begin of the interval (default: 0)")
    parser.add_argument("--to", dest="end", type=float, metavar="MS", help="its end (default: that of the trace)")
    options = parser.parse_args()
    try:
        spans, names, other = read(options.trace)
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"trace_svg.py: {options.trace}: {error}; give a file that tessera-master --trace wrote")
    if not spans:
        sys.exit(f"trace_svg.py: {options.trace}: no tile was rendered in it")
    begin = 0.0 if options.begin is None else options.begin * 1000
    end = max(s[3] for s in spans) if options.end is None else options.end * 1000
    if not begin < end:
        sys.exit("trace_svg.py: give --from and --to such that there is something between them")
    picture = draw(spans, names, other, begin, end)
    if options.output:
        with open(options.output, "w", encoding="utf-8") as file:
            file.write(picture)
    else:
        sys.stdout.write(picture)


if __name__ == "__main__":
    main()
