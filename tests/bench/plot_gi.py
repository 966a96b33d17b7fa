#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error over time of `tessera-bench gi --json FILE`, as an SVG: plot_gi.py FILE OUT.svg

One panel a scene, both axes logarithmic; a line a series of settings. Lower left is better.
"""
import json
import math
import sys

COLOURS = {"vpls": "#1b6ca8", "vpls, raw": "#16a3a3", "passes": "#c0392b", "path": "#555555", "interleave": "#27ae60", "clamp": "#8e44ad", "samples": "#d68910"}
WIDTH, HEIGHT, MARGIN = 460, 360, 56


def panel(scene, left):
    rows = scene["error"]["rows"]
    xs, ys = [math.log10(r["cpu_seconds"]) for r in rows], [math.log10(r["rmse"]) for r in rows]
    low_x, high_x, low_y, high_y = math.floor(min(xs)), math.ceil(max(xs)), math.floor(min(ys)), math.ceil(max(ys))

    def place(row):
        x = (math.log10(row["cpu_seconds"]) - low_x) / (high_x - low_x)
        y = (math.log10(row["rmse"]) - low_y) / (high_y - low_y)
        return left + MARGIN + x * (WIDTH - 2 * MARGIN), HEIGHT - MARGIN - y * (HEIGHT - 2 * MARGIN)

    out = [f'<text x="{left + WIDTH / 2}" y="24" text-anchor="middle" font-weight="bold">{scene["scene"]}</text>']
    for k in range(low_x, high_x + 1):
        x = left + MARGIN + (k - low_x) / (high_x - low_x) * (WIDTH - 2 * MARGIN)
        out.append(f'<line x1="{x:.1f}" y1="{MARGIN}" x2="{x:.1f}" y2="{HEIGHT - MARGIN}" stroke="#ddd"/>')
        out.append(f'<text x="{x:.1f}" y="{HEIGHT - MARGIN + 16}" text-anchor="middle">{10.0 ** k:g} s</text>')
    for k in range(low_y, high_y + 1):
        y = HEIGHT - MARGIN - (k - low_y) / (high_y - low_y) * (HEIGHT - 2 * MARGIN)
        out.append(f'<line x1="{left + MARGIN}" y1="{y:.1f}" x2="{left + WIDTH - MARGIN}" y2="{y:.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{left + MARGIN - 4}" y="{y + 4:.1f}" text-anchor="end">{10.0 ** k:g}</text>')
    for series, colour in COLOURS.items():
        points = [place(r) for r in rows if r["series"] == series]
        if series in ("vpls", "vpls, raw", "passes", "path"):
            out.append(f'<polyline fill="none" stroke="{colour}" stroke-width="1.6" points="'
                       + " ".join(f"{x:.1f},{y:.1f}" for x, y in points) + '"/>')
        out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in points]
    return out


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        scenes = [scene for scene in json.load(file)["gi"] if "error" in scene]
    width = WIDTH * max(2, len(scenes))
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{HEIGHT + 24}" font-family="sans-serif" font-size="11">',
           '<rect width="100%" height="100%" fill="white"/>']
    for i, scene in enumerate(scenes):
        out += panel(scene, i * WIDTH)
    for i, (series, colour) in enumerate(COLOURS.items()):
        x = 60 + 130 * i
        out.append(f'<circle cx="{x}" cy="{HEIGHT + 8}" r="4" fill="{colour}"/><text x="{x + 8}" y="{HEIGHT + 12}">{series}</text>')
    out.append(f'<text x="{width / 2}" y="{HEIGHT - 18}" text-anchor="middle">CPU-seconds against RMSE</text></svg>')
    with open(sys.argv[2], "w") as file:
        file.write("\n".join(out) + "\n")


if __name__ == "__main__":
    main()
