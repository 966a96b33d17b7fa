#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the CSV of `tessera-sim scaling` as SVG: speed over slaves, and utilisation below it.

    tessera-sim scaling thesis > thesis.csv && tests/sim/plot_scaling.py thesis.csv -o thesis.svg
    tests/sim/plot_scaling.py large.csv -o large.svg --log --column speed_up --without "tiles of 32"
"""

import argparse
import csv
import math

COLOURS = ["#1b6ca8", "#c8553d", "#3a7d44", "#8a4f9e", "#b8860b", "#4a4a4a", "#008b8b", "#a0522d"]
WIDTH, LEFT, RIGHT, TOP = 760, 64, 210, 30
UPPER, LOWER, GAP, BOTTOM = 300, 130, 44, 44


def nice_ticks(top):
    step = 10 ** math.floor(math.log10(top))
    for factor in (0.2, 0.5, 1, 2):
        if top / (step * factor) <= 6:
            step *= factor
            break
    return [i * step for i in range(int(top / step + 1e-9) + 1)]


class Panel:
    """One diagram: maps values to places, draws its frame, grid and lines."""

    def __init__(self, top, height, x_range, y_max, is_log, label):
        self.top, self.height, self.x_range, self.y_max = top, height, x_range, y_max
        self.is_log, self.label = is_log, label
        self.parts = []

    def x(self, value):
        low, high = self.x_range
        share = (math.log(value / low) / math.log(high / low) if self.is_log else value / high)
        return LEFT + share * (WIDTH - LEFT - RIGHT)

    def y(self, value):
        low = 1.0
        if self.is_log and self.y_max > 1.5:
            share = math.log(max(value, low) / low) / math.log(self.y_max / low)
        else:
            share = value / self.y_max
        return self.top + self.height * (1 - share)

    def grid(self, x_ticks, y_ticks):
        right = WIDTH - RIGHT
        for value in y_ticks:
            y = self.y(value)
            self.parts.append(f'<line x1="{LEFT}" y1="{y:.1f}" x2="{right}" y2="{y:.1f}" class="grid"/>')
            self.parts.append(f'<text x="{LEFT - 8}" y="{y + 4:.1f}" class="end">{value:g}</text>')
        for value in x_ticks:
            x = self.x(value)
            self.parts.append(f'<line x1="{x:.1f}" y1="{self.top}" x2="{x:.1f}" '
                              f'y2="{self.top + self.height}" class="grid"/>')
            self.parts.append(f'<text x="{x:.1f}" y="{self.top + self.height + 17}" '
                              f'class="middle">{value:g}</text>')
        self.parts.append(f'<text x="{LEFT}" y="{self.top - 9}">{self.label}</text>')

    def line(self, points, colour):
        path = " ".join(f"{self.x(x):.1f},{self.y(y):.1f}" for x, y in points)
        self.parts.append(f'<polyline points="{path}" stroke="{colour}" class="line"/>')
        for x, y in points:
            self.parts.append(f'<circle cx="{self.x(x):.1f}" cy="{self.y(y):.1f}" r="2.6" fill="{colour}"/>')


def read_series(path, without):
    series = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if not without or without not in row["series"]:
                series.setdefault(row["series"], []).append(row)
    return series


def draw(series, column, is_log):
    slaves = sorted({int(row["slaves"]) for rows in series.values() for row in rows})
    top = max(float(row[column]) for rows in series.values() for row in rows)
    x_range = (slaves[0], slaves[-1])
    upper = Panel(TOP, UPPER, x_range, max(top, slaves[-1]) if is_log else 1.06 * top, is_log,
                  column.replace("_", " "))
    lower = Panel(TOP + UPPER + GAP, LOWER, x_range, 1.0, is_log, "utilisation of the slaves")
    y_ticks = [10 ** i for i in range(int(math.log10(upper.y_max)) + 1)] if is_log else nice_ticks(top)
    upper.grid(slaves, y_ticks)
    lower.grid(slaves, [0, 0.25, 0.5, 0.75, 1])
    legend = []
    for i, (name, rows) in enumerate(series.items()):
        colour = COLOURS[i % len(COLOURS)]
        upper.line([(int(row["slaves"]), float(row[column])) for row in rows], colour)
        lower.line([(int(row["slaves"]), float(row["utilisation"])) for row in rows], colour)
        y = TOP + 14 + 20 * i
        x = WIDTH - RIGHT + 14
        legend.append(f'<line x1="{x}" y1="{y - 4}" x2="{x + 18}" y2="{y - 4}" stroke="{colour}" class="line"/>'
                      f'<text x="{x + 24}" y="{y}">{name}</text>')
    height = TOP + UPPER + GAP + LOWER + BOTTOM
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}">',
        "<style>text{font:12px sans-serif;fill:#222}.end{text-anchor:end}.middle{text-anchor:middle}"
        ".grid{stroke:#ddd}.line{fill:none;stroke-width:2}</style>",
        f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
        *upper.parts, *lower.parts, *legend,
        f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{height - 10}" class="middle">slaves</text>', "</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("csv")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--column", default="frames_per_s", help="of the upper diagram")
    parser.add_argument("--log", action="store_true", help="both axes of the upper diagram")
    parser.add_argument("--without", help="series whose names hold this are left out")
    arguments = parser.parse_args()
    with open(arguments.output, "w", encoding="utf-8") as file:
        file.write(draw(read_series(arguments.csv, arguments.without), arguments.column, arguments.log))


if __name__ == "__main__":
    main()
