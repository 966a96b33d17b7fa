# SPDX-License-Identifier: Apache-2.0
"""Views of `tessera-bench update --json` and `update.py --json`: tables and the plot, for views.py and plots.py."""
import chart
from chart import Logarithmic, Panel, Style

ALLOWED_MS = {"light": 5, "material": 5, "one object moved": 10}  # beyond a round trip and the tile


def number(value):
    return f"{value:,.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def about(triangles):
    """The power of ten that a scene was asked to have: sheets of whole quads have about so many triangles."""
    return f"10^{len(str(round(triangles * 1.1))) - 1}"


def edits_of(scene):
    return {edit["name"]: edit for edit in scene["edits"]}


def over_sizes(scenes, cell):
    columns = [about(scene["triangles"]) + " triangles" for scene in scenes]
    names = [edit["name"] for edit in scenes[0]["edits"]]
    return ["changed"] + columns, [[name] + [cell(scene, edits_of(scene)[name]) for scene in scenes] for name in names]


def times_table(scenes):
    """Milliseconds to the first right pixel and to the whole frame, and the first edit of a kind."""
    def cell(_, edit):
        first, frame, begin = (1e3 * edit[key] for key in ("first_pixel_seconds", "frame_seconds", "first_of_kind_seconds"))
        return f"{number(first)}, {number(frame)} ({number(begin)})"
    return over_sizes(scenes, cell)


def bars_table(scenes):
    """Milliseconds beyond a round trip and the rendering of the tile, and what is allowed of them."""
    columns, rows = over_sizes(scenes, lambda _, edit: number(1e3 * edit["beyond_seconds"]))
    rows = [[*row, f"{ALLOWED_MS[row[0]]}"] for row in rows if row[0] in ALLOWED_MS]
    every = [edits_of(scene)["all vertices"] for scene in scenes]
    rows.append(["all vertices: the same, in builds of the scene sent whole"] +
                [f"{edit['beyond_seconds'] / scene['build_seconds']:.2f}" for scene, edit in zip(scenes, every)] + ["1.2, and the transfer"])
    return columns + ["allowed"], rows


def costs_table(scenes):
    """What travels, what is built, CPU time to the first pixel, and frames per second where each frame has an edit."""
    def cell(_, edit):
        cpu = " + ".join(number(1e3 * edit[f"{who}_cpu_seconds"]) for who in ("master", "slave"))
        return f"{number(1e-3 * edit['scene_bytes'])} kB; {edit['built_primitives']:,}; {cpu}; {number(edit['frames_per_second'])}"
    return over_sizes(scenes, cell)


def objects_table(scenes):
    """Per kind of edit: bytes, and the slave's CPU-milliseconds to the end of the first tile: all, a camera's, the edit's own."""
    columns = ["changed"] + [f"{scene['objects']:,} objects, {about(scene['triangles'])} triangles" for scene in scenes]

    def cell(edit):
        whole, still = (1e3 * edit[key] for key in ("slave_cpu_seconds", "slave_cpu_still_seconds"))
        return f"{number(1e-3 * edit['scene_bytes'])} kB; {whole:.2f} - {still:.2f} = {whole - still:.2f}"
    edits = [edits_of(scene) for scene in scenes]
    names = [edit["name"] for edit in scenes[0]["edits"] if all(edit["name"] in others for others in edits)]
    return columns, [[name] + [cell(others[name]) for others in edits] for name in names]


def links_table(scenes, rest):
    """Of scenes of one size: over each link, with each number of slaves."""
    chosen = [scene for scene in scenes if about(scene["triangles"]) == rest]
    names = [edit["name"] for edit in chosen[0]["edits"]]
    columns = ["changed"] + [f"{scene['slaves']} at {scene['link']}" for scene in chosen]

    def cell(edit):
        return (f"{number(1e3 * edit['first_pixel_seconds'])}, {number(1e3 * edit['frame_seconds'])}; "
                f"{number(1e-3 * edit['scene_bytes'])} kB; {number(edit['frames_per_second'])}")
    return columns, [[name] + [cell(edits_of(scene)[name]) for scene in chosen] for name in names]


def pictures_table(scenes):
    """How many pictures were compared with those of scenes sent whole, and how many differ."""
    edits = [edit for scene in scenes for edit in scene["edits"]]
    return (["pictures compared", "not the same bits"],
            [[f"{sum(edit['pictures'] for edit in edits):,}", sum(edit["pictures_wrong"] for edit in edits)]])


def update_table(runs, rest):
    scenes = [scene for run in runs for scene in run["update"]]
    name, _, more = rest.partition(" ")
    if name == "links":
        return links_table(scenes, more)
    return {"times": times_table, "bars": bars_table, "costs": costs_table, "objects": objects_table, "pictures": pictures_table}[name](scenes)


def update_plot(runs, _):
    """Time to the first right pixel over the size of the scene, a line for each kind of edit."""
    scenes = [scene for run in runs for scene in run["update"]]
    lines = [[(scene["triangles"], 1e3 * edits_of(scene)[edit["name"]]["first_pixel_seconds"]) for scene in scenes]
             for edit in scenes[0]["edits"]]
    whole = [(scene["triangles"], 1e3 * scene["first_frame_seconds"]) for scene in scenes]
    panel = Panel((76, 46, 500, 330), Logarithmic("triangles", [scene["triangles"] for scene in scenes]),
                  Logarithmic("ms to the first right pixel", [y for points in [*lines, whole] for _, y in points]))
    entries = []
    for i, (name, points) in enumerate([*zip((edit["name"] for edit in scenes[0]["edits"]), lines), ("the scene sent whole", whole)]):
        style = Style(chart.COLOURS[i], chart.MARKS[i % len(chart.MARKS)], "" if points is not whole else "6 3")
        panel.draw(points, style)
        entries.append((name, style))
    title = "From an edit to the first right pixel"
    return title, chart.picture(780, 440, title, panel.parts + chart.legend(594, 60, entries))
