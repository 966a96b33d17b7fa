# SPDX-License-Identifier: Apache-2.0
"""Plots of results: which figures of a result a picture shows, and how. tables.py writes the pictures, chart.py draws them.

    frames      frames per second over slaves, and how busy they are (a result with a table "series")
    speed-up    the same, as speed-up over slaves, both logarithmic
    error       RMSE over CPU-seconds, a panel for each scene (`tessera-bench gi --json`)
    patch       error over the time of a camera ray, a panel for each scene (`tessera-bench patch --json`)
    update      time from an edit to the first right pixel over triangles (`tessera-bench update --json`)
    embree VIEW rates to Embree's of a table, bars grouped by scene; of several files the last is the newest
"""
import re

import chart
import scaling_series
from chart import Groups, Linear, Logarithmic, Panel, Style
from update_views import update_plot
from views import table_of

# A series that differs from another in the link or the tiles alone has its colour, and a line of its own.
KIN = re.compile(r"(?P<kin>.*\d+p) (?P<way>.*)")
DASHES = ("", "2 3", "8 4")
# Series of `tessera-bench gi` that vary a number, as lines, then those that vary a setting, as marks alone.
NUMBERED = {"vpls": "igi without a bound", "vpls, raw": "igi, bound compensated, not filtered", "passes": "igi, bound compensated",
            "path": "path"}
VARIED = {"interleave": "igi, interleaved", "clamp": "igi, bound", "samples": "igi, samples"}
# A cell of a table that is a ratio, or the range that several runs span, and perhaps a rate.
RATIO = re.compile(r"(?P<low>\d[\d.]*)( to (?P<high>\d[\d.]*))?(?P<rate> \([^()]*\))?")


def styles_of(names):
    colours, dashes, styles = {}, {}, {}
    for name in names:
        match = KIN.fullmatch(name)
        kin, way = (match["kin"], match["way"]) if match else (name, "")
        colour = colours.setdefault(kin, len(colours) % len(chart.COLOURS))
        dash = dashes.setdefault(way, len(dashes) % len(DASHES))
        styles[name] = Style(chart.COLOURS[colour], chart.MARKS[colour % len(chart.MARKS)], DASHES[dash])
    return styles


def over_slaves(run, column, label, title, make_axis):
    """`column` of each series over slaves, and below it the utilisation of the slaves."""
    series = scaling_series.series_of(run)
    rows_of_all = [row for rows in series.values() for row in rows]
    slaves = [row["slaves"] for row in rows_of_all]
    x_axes = [make_axis("", slaves), make_axis("number of slaves", slaves)]
    upper = Panel((72, 46, 500, 320), x_axes[0], make_axis(label, [row[column] for row in rows_of_all]))
    lower = Panel((72, 404, 500, 130), x_axes[1], Linear("slaves busy, %", [100], 4))
    entries = []
    if column == "speed_up":
        linear = Style(chart.FRAME)
        upper.draw([(min(slaves), min(slaves)), (max(slaves), max(slaves))], linear)
        entries.append(("linear", linear))
    for name, style in styles_of(series).items():
        upper.draw([(row["slaves"], row[column]) for row in series[name]], style)
        lower.draw([(row["slaves"], 100 * row["utilisation"]) for row in series[name]], style)
        entries.append((name, style))
    width = 636 + 7 * max(len(words) for words, _ in entries)
    return title, chart.picture(width, 588, title, upper.parts + lower.parts + chart.legend(590, 60, entries))


def frames_plot(runs, _):
    return over_slaves(runs[0], "frames_per_s", "frames per second", "Frames per second over slaves", Linear)


def speed_up_plot(runs, _):
    return over_slaves(runs[0], "speed_up", "speed-up over one slave", "Speed-up over slaves", Logarithmic)


def error_plot(runs, _):
    """Lower left is better; a line shows what more of something brings."""
    scenes = [scene for scene in runs[0]["gi"] if "error" in scene]
    entries, parts = {}, []
    for i, scene in enumerate(scenes):
        rows = scene["error"]["rows"]
        panel = Panel((76 + 430 * i, 70, 340, 300), Logarithmic("CPU-seconds a picture", [row["cpu_seconds"] for row in rows]),
                      Logarithmic("RMSE of radiance", [row["rmse"] for row in rows]), scene["scene"])
        for k, (series, words) in enumerate({**NUMBERED, **VARIED}.items()):
            own = [row for row in rows if row["series"] == series]
            if not own:
                continue
            style = Style(chart.COLOURS[k], chart.MARKS[k % len(chart.MARKS)], is_line=series in NUMBERED)
            settings = [row["setting"] for row in own]
            words += f": {settings[0].split()[0]} to {settings[-1]}" if style.is_line else f": {'; '.join(settings)}"
            panel.draw([(row["cpu_seconds"], row["rmse"]) for row in own], style)
            entries.setdefault(words, style)
        parts += panel.parts
    title = "Error over time: " + ", ".join(scene["scene"] for scene in scenes)
    return title, chart.picture(430 * max(2, len(scenes)), 520, title, parts + chart.legend(76, 438, entries.items(), 2, 400))


def patch_plot(runs, _):
    """Lower left is better; a line shows what finer squares bring."""
    scenes, parts = runs[-1]["patch"], []
    series = {"patches as they are": lambda name: name == "patches",
              "Embree: N x N squares of two triangles a patch": lambda name: name.replace(" x ", "").isdigit(),
              "Embree: its subdivision surfaces, N x N": lambda name: name.endswith("subdivision")}
    styles = {words: Style(chart.COLOURS[k], chart.MARKS[k], is_line=k > 0) for k, words in enumerate(series)}
    for i, scene in enumerate(scenes):
        camera = next(rays["rows"] for rays in scene["rays"] if rays["kind"] == "primary")
        points = {row["name"]: (1e3 / row["mrays_per_cpu_second"], surface["off_p999_of_diagonal"])
                  for row, surface in zip(camera, scene["surfaces"])}
        panel = Panel((86 + 430 * i, 70, 330, 300), Logarithmic("CPU-nanoseconds a camera ray", [x for x, _ in points.values()]),
                      Logarithmic("distance from the surface, p99.9, of the diagonal", [y for _, y in points.values()]),
                      f"{scene['scene']}, {scene['patches']:,} patches", 60)
        for words, is_of in series.items():
            panel.draw([point for name, point in points.items() if is_of(name)], styles[words])
        parts += panel.parts
    title = "Error over time of surfaces: " + ", ".join(scene["scene"] for scene in scenes)
    return title, chart.picture(430 * max(2, len(scenes)), 470, title, parts + chart.legend(86, 428, styles.items(), 2, 400))


def ratios_of(run, view):
    """(columns, {row: {column: (low, high)}}) of the rows of ratios: a cell at least has a rate beside it, none two ratios."""
    columns, rows = table_of([run], view)
    found = {}
    for name, *cells in rows:
        matches = {column: RATIO.fullmatch(str(cell)) for column, cell in zip(columns[1:], cells) if cell != "-"}
        if all(matches.values()) and any(match["rate"] for match in matches.values()):
            found[name] = {column: (float(match["low"]), float(match["high"] or match["low"])) for column, match in matches.items()}
    return columns[1:], found


def embree_plot(runs, view):
    """A bar for each row and run of a group; older runs are paler."""
    made = [ratios_of(run, view) for run in runs]
    columns = list(dict.fromkeys(column for names, _ in made for column in names))
    names = list(dict.fromkeys(name for _, rows in made for name in rows))
    bars = []
    for i, name in enumerate(names):
        for run, (_, rows) in zip(runs, made):
            style = Style(chart.COLOURS[i % len(chart.COLOURS)], is_line=False, opacity=1 if run is runs[-1] else 0.45)
            bars += [(name, run["run"], rows[name], style)] if name in rows else []
    highs = [high for _, _, cells, _ in bars for _, high in cells.values()]
    panel = Panel((72, 46, 680, 300), Groups("", columns), Linear("rate to the rate of Embree's best mode", [*highs, 1], 10))
    for place, (_, _, cells, style) in enumerate(bars):
        for column, (low, high) in cells.items():
            panel.bar(columns.index(column), place, len(bars), low, high, style)
    panel.level(1, "Embree")
    entries = [(f"{name}: {run['commit']}, {run['date'][:10]}" if len(runs) > 1 else name, style) for name, run, _, style in bars]
    title = "Rate to Embree's, by scene"
    return title, chart.picture(850, 382 + 19 * ((len(entries) + 1) // 2), title,
                                panel.parts + panel.labels + chart.legend(72, 390, entries, 2, 390))


PLOTS = {"frames": frames_plot, "speed-up": speed_up_plot, "error": error_plot, "embree": embree_plot, "patch": patch_plot, "update": update_plot}


def plot_of(runs, view):
    """(title, SVG text) of a view."""
    name, _, rest = view.partition(" ")
    if name not in PLOTS:
        raise SystemExit(f"tables.py: no plot '{view}'; there are {', '.join(sorted(PLOTS))}")
    return PLOTS[name](runs, rest)
