# SPDX-License-Identifier: Apache-2.0
"""Views of results: what stands in the columns and rows of a table. tables.py writes them, plots.py draws some.

A view of `tessera-bench core --json` is computed from its rates, one of `tessera-sim scaling` from its series; of any other
result it is one of its "tables".
"""
import re

import scaling_series
from update_views import update_table

KINDS = {"primary": "camera", "shadow": "shadow", "bounce": "bounce"}
STRUCTURES = {"bvh": "hierarchy", "bvhq": "quality hierarchy", "kd": "kd-tree", "kdq": "quality kd-tree", "instanced": "two levels"}


def number(value):
    """Formats a number with some three digits, as a person writes it."""
    if value == 0 or not abs(value) < float("inf"):
        return f"{value:g}"
    if abs(value) >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}" if abs(value) < 0.01 else f"{value:.{1 if abs(value) >= 10 else 2}f}"


def span(values):
    low, high = number(min(values)), number(max(values))
    return low if low == high else f"{low} to {high}"


def structure_of(name):
    """Returns, for a contender's or a build's name, ("bvh", "16"), ("kd", "8"), ("kdq", "8") or (None, None)."""
    match = re.match(r"(bvh|kd|instanced)(\d+)(q?)\b", name)
    return (match[1] + match[3], match[2]) if match else (None, None)


def best(rows, is_wanted):
    rates = [row["mrays_per_cpu_second"] for row in rows if is_wanted(row["name"])]
    return max(rates) if rates else None


def rays_table(runs, peer):
    """Compares the best mode of each structure with the peer's best, in Mrays per CPU-second, and their answers."""
    scenes = [scene["scene"] for scene in runs[0]["core"]]

    def cells(kind, make):
        out = []
        for scene in scenes:
            lists = [k["rows"] for run in runs for s in run["core"] if s["scene"] == scene for k in s["rays"] if k["kind"] == kind]
            found = [value for value in map(make, lists) if value is not None]
            out.append(span(found) if found else "-")
        return out

    rows = []
    traced = {rays["kind"] for run in runs for scene in run["core"] for rays in scene["rays"]}
    for kind, word in KINDS.items():
        if kind not in traced:
            continue
        for key, structure in STRUCTURES.items():
            def own(lists, key=key):
                return best(lists, lambda name: structure_of(name)[0] == key)

            def ratio(lists, own=own):
                ours, theirs = own(lists), best(lists, lambda name: name.startswith(peer))
                return ours / theirs if ours and theirs else None

            ratios, rates = cells(kind, ratio), cells(kind, own)
            if any(rate != "-" for rate in rates):
                rows.append([f"{word} rays, {structure}"] +
                            [f"{a} ({b})" if a != "-" else b for a, b in zip(ratios, rates)])
        rows.append([f"{word} rays, peer's Mrays"] + cells(kind, lambda lists: best(lists, lambda n: n.startswith(peer))))
        rows.append([f"{word} rays of a million that end elsewhere: ours / peer's"] + [
            " / ".join(elsewhere(runs, scene, kind, name) for name in ("bvh", peer)) for scene in scenes])
    return ["ratio (Mrays per CPU-second)"] + scenes, rows


def elsewhere(runs, scene, kind, prefix):
    """Returns the greatest share, in millionths, of rays whose answer is not the first row's."""
    shares = [1e6 * row["differ"] / max(1, k["rays"]) for run in runs for s in run["core"] if s["scene"] == scene
              for k in s["rays"] if k["kind"] == kind for row in k["rows"] if row["name"].startswith(prefix)]
    return number(max(shares)) if shares else "-"


def modes_table(runs, kind):
    """Shows every way of tracing rays of one kind, in Mrays per CPU-second."""
    scenes, names, rates = [], [], {}
    for run in runs:
        for scene in run["core"]:
            for rays in scene["rays"]:
                if rays["kind"] != kind:
                    continue
                if scene["scene"] not in scenes:
                    scenes.append(scene["scene"])
                for row in rays["rows"]:
                    if row["name"] not in names:
                        names.append(row["name"])
                    rates.setdefault((row["name"], scene["scene"]), []).append(row["mrays_per_cpu_second"])
    rows = [[name] + [span(rates[name, scene]) if (name, scene) in rates else "-" for scene in scenes] for name in names]
    return [f"{KINDS[kind]} rays, Mrays per CPU-second"] + scenes, rows


def builds_table(runs, _):
    """Shows the CPU time of Embree's build of the same quality over ours, and memory of ours over Embree's."""
    scenes = [scene["scene"] for scene in runs[0]["core"]]
    rows = {}
    for run in runs:
        for scene in run["core"]:
            builds = {build["name"]: build for build in scene["builds"]}
            for name, build in builds.items():
                key, _width = structure_of(name)
                peer = builds.get("embree high" if key in ("kdq", "bvhq") else "embree medium")
                if key is None or peer is None:
                    continue
                for what, value in (("time, peer's to ours", peer["cpu_seconds"] / build["cpu_seconds"]),
                                    ("memory, ours to peer's", build["mb"] / peer["mb"])):
                    rows.setdefault(f"{STRUCTURES[key]}, {what}", {}).setdefault(scene["scene"], []).append(value)
    return ["build"] + scenes, [[name] + [span(found[s]) if s in found else "-" for s in scenes] for name, found in rows.items()]


def build_table(runs, _):
    """Shows, of the suite "build", the CPU time of Embree's build of the same quality over ours, on one thread."""
    scenes = [scene["scene"] for scene in runs[0]["build"]]
    rows = {}
    for run in runs:
        for scene in run["build"]:
            builds = {build["name"]: build for build in scene["builds"] if build["threads"] == 1}
            for name, build in builds.items():
                key = structure_of(name.replace(" quality", "q"))[0]
                quality = "high" if key in ("kdq", "bvhq") else "medium"
                if key is None or f"embree {quality}" not in builds:
                    continue
                ratio = builds[f"embree {quality}"]["cpu_seconds"] / build["cpu_seconds"]
                rows.setdefault(f"{STRUCTURES[key]}, to {quality}", {}).setdefault(scene["scene"], []).append(ratio)
    return ["CPU time, Embree's to ours"] + scenes, [[name] + [span(found[s]) if s in found else "-" for s in scenes] for name, found in rows.items()]


def build_threads_table(runs, _):
    """Shows, of the suite "build", the speed of as many threads as there are over that of one, by wall clock.

    The runs may be of different structures."""
    scenes = [scene["scene"] for scene in runs[0]["build"]]
    rows = {}
    for run in runs:
        for scene in run["build"]:
            seconds = {(build["name"], build["threads"]): build["wall_seconds"] for build in scene["builds"]}
            most = max(threads for _name, threads in seconds)
            for name, threads in seconds:
                if threads == most:
                    ratio = seconds[name, 1] / seconds[name, most]
                    rows.setdefault(f"{name}, {most} threads", {}).setdefault(scene["scene"], []).append(ratio)
    return ["speed to one thread's"] + scenes, [[name] + [span(found[s]) if s in found else "-" for s in scenes] for name, found in rows.items()]


def fans_table(runs, kind):
    """Shows fans of each size through the usual hierarchy, as a multiple of the smallest, with Mrays per CPU-second.

    Fans from a light as they are traced are two of 64 where these have little to do."""
    lists = {scene["scene"]: rays["rows"] for scene in runs[0]["core"] for rays in scene["rays"] if rays["kind"] == kind}
    rates = {scene: {int(match[1] or 128): row["mrays_per_cpu_second"] for row in rows if (match := re.match(r"bvh\d+ fan (?:of (\d+)|from light)$", row["name"]))}
             for scene, rows in lists.items()}
    sizes = sorted(next(iter(rates.values())))
    rows = [[f"{size}"] + [f"{number(of[size] / of[sizes[0]])} ({number(of[size])})" for of in rates.values()] for size in sizes]
    return [f"{KINDS[kind]} rays, fan of"] + list(rates), rows


def build_times_table(runs, _):
    """Shows the CPU time of each build of one scene by its number of triangles, in ms, on one thread."""
    parts = runs[0]["build"]
    names = [build["name"] for build in parts[0]["builds"] if build["threads"] == 1]
    times = [{build["name"]: 1e3 * build["cpu_seconds"] for build in part["builds"] if build["threads"] == 1} for part in parts]
    return ["triangles"] + [f"{part['triangles']:,}" for part in parts], [[name] + [number(of[name]) for of in times] for name in names]


def moves_table(runs, _):
    """Shows what a version costs in which one instance moved, in CPU-milliseconds, and rays in edited hierarchies to new ones."""
    columns = ["instances", "triangles of each", "triangles that stand once", "first version, ms", "one moved, ms", "rays, edited to built"]
    scenes = {}
    for run in runs:
        for row in run["moves"]:
            scenes.setdefault((row["instances"], row["triangles"], row["ground_triangles"]), []).append(row)
    rows = []
    for sizes, found in scenes.items():
        milliseconds = [[1e3 * row[key] for row in found] for key in ("first_cpu_seconds", "moved_cpu_seconds")]
        rows.append([f"{size:,}" for size in sizes] + [span(values) for values in milliseconds] +
                    [span([row["edited_to_built"] for row in found])])
    return columns, rows


def deforming_table(runs, _):
    """Shows rates of builds and fits to Embree's, and of rays in what they made to those in what is built as usual."""
    columns = ["scene", "triangles", "usual build, to medium", "fast build, to low", "fit, to refit",
               "rays built fast: camera, shadow, bounces", "rays fitted over 24 frames"]
    made = []
    for place, scene in enumerate(runs[0]["deforming"]):
        same = [run["deforming"][place] for run in runs]
        pairs = (("built", "embree medium"), ("fast", "embree low"), ("fitted", "embree refit"))
        ratios = [span([row["cpu_seconds"][theirs] / row["cpu_seconds"][ours] for row in same if theirs in row["cpu_seconds"]] or [0])
                  for ours, theirs in pairs]
        rays = [", ".join(span([row[f"{way}_to_built"][kind] for row in same]) for kind in KINDS) for way in ("fast", "fitted")]
        made.append([scene["scene"], f"{scene['triangles']:,}"] + ratios + rays)
    return columns, made


def demand_table(runs, _):
    """Shows what the first frame costs by when its objects are built."""
    made = []
    for place, row in enumerate(runs[0]["demand"]):
        same = [run["demand"][place] for run in runs]
        made.append([row["name"]] + [span([scale * r[key] for r in same]) for scale, key in
                                     ((1e3, "cpu_seconds"), (1e3, "wall_seconds"), (1, "mb"))] + [f"{row['built']:,}"])
    return [f"{runs[0]['demand'][0]['objects']} objects", "CPU-ms", "ms", "MB", "primitives built"], made


def beside_table(runs, _):
    """Shows what rendering loses to builds beside it, and how long a build takes where."""
    made = []
    for place, row in enumerate(runs[0]["beside"]):
        same = [run["beside"][place] for run in runs]
        made.append([row["scene"], f"{row['threads']}", span([100 * r["lost_share"] for r in same]) + " %"]
                    + [span([1e3 * r[key] for r in same]) if any(r[key] for r in same) else "-"
                       for key in ("frame_seconds", "alone_seconds", "beside_seconds", "caught_up_seconds")])
    return ["scene", "threads", "render speed lost", "a frame, ms", "a build alone", "beside rendering", "after its frame, begun beside"], made


def trims_table(runs, _):
    """Shows what it costs to ask whether a point is kept: nanoseconds, and pieces and points of them that were looked at."""
    ways = ("cells", "tree", "linear")
    columns = ["loops"] + [f"{way}: ns; pieces, points" for way in ways] + ["cells, bytes a segment", "cells are prepared in ms"]
    rows = {}
    for run in runs:
        for row in run["trims"]:
            rows.setdefault((row["loops"], row["layout"]), []).append(row)
    made = []
    for (loops, layout), found in rows.items():
        cells = [f"{loops:,} {layout}"]
        for way in ways:
            steps = [found[0][way][key] for key in ("pieces", "points")]
            cells.append(f"{span([row[way]['ns'] for row in found])}; {steps[0]:.2f}, {steps[1]:.2f}")
        cells.append(f"{found[0]['cells_bytes_a_segment']:.0f}")
        made.append(cells + [span([1e3 * row["prepare_cpu_seconds"] for row in found])])
    return columns, made


def methods_table(runs, rest):
    """Shows what `tessera-bench patch --methods` has measured of the groups whose names begin with the words of `rest`."""
    found = [suite for run in runs for suite in run["methods"]]
    grazing = found[0]["grazing_rays"]
    columns = ["", "parts", "Mrays/CPU-s", "off by, p99.9, of the diagonal", f"of {found[0]['rays']:,} rays missed, wrong, false",
               f"lost of {grazing:,} that graze", "boxes or steps a ray"]
    made = []
    for number_of_row, row in enumerate(found[0]["rows"]):
        if not row["group"].startswith(rest):
            continue
        same = [suite["rows"][number_of_row] for suite in found]
        lost = ", ".join(f"{row[key]:,}" for key in ("missed", "wrong", "false"))
        made.append([row["name"], f"{row['parts']:,}", span([r["mrays_per_cpu_second"] for r in same]),
                     number(row["off_p999_of_diagonal"]), lost,
                     f"{row['lost_of_grazing']:,}" if "lost_of_grazing" in row else "",
                     f"{row['work_per_ray']:.1f}" if row.get("work_per_ray") else ""])
    return columns, made


def patch_table(runs, scene):
    """Shows what `tessera-bench patch` has measured of a scene: our rates and Embree's, with ours to theirs, beside each error."""
    found = [suite for run in runs for suite in run["patch"] if suite["scene"] == scene]
    kinds = [rays["kind"] for rays in found[0]["rays"]]
    columns = ["", *(f"{KINDS[kind]} rays" for kind in kinds), "off by, p99.9, of the diagonal", f"of {found[0]['judged']:,} rays missed, invented, wrong",
               "MB", "build, CPU-s"]
    made = []
    for i, surface in enumerate(found[0]["surfaces"]):
        cells = [surface["name"]]
        for k in range(len(kinds)):
            same = [suite["rays"][k]["rows"][i] for suite in found]
            ratios = [row["patches_to_these"] for row in same if row["patches_to_these"] is not None]
            cells.append(span([row["mrays_per_cpu_second"] for row in same]) + (f" ({span(ratios)})" if ratios else ""))
        lost = ", ".join(f"{surface[key]:,}" for key in ("missed", "invented", "wrong"))
        made.append(cells + [number(surface["off_p999_of_diagonal"]), lost, number(surface["mb"]), number(surface["build_cpu_seconds"])])
    return columns, made


VIEWS = {"rays": lambda runs, rest: rays_table(runs, f"embree {rest or 'medium'}"), "modes": modes_table, "builds": builds_table, "fans": fans_table}


def table_of(runs, view):
    name, _, rest = view.partition(" ")
    for suite, table in (("moves", moves_table), ("deforming", deforming_table), ("demand", demand_table), ("beside", beside_table), ("trims", trims_table), ("methods", methods_table), ("patch", patch_table), ("build", build_table),
                        ("build-times", build_times_table), ("build-threads", build_threads_table),
                        ("update", update_table)):
        if name == suite and suite.partition("-")[0] in runs[0]:
            return table(runs, rest)
    if name in VIEWS and "core" in runs[0]:
        return VIEWS[name](runs, rest)
    if name == "speeds" and scaling_series.TABLE in runs[0].get("tables", {}):
        return scaling_series.speeds_table(runs[0], rest.split())
    made = runs[0].get("tables", {}).get(view)
    if made is None:
        raise SystemExit(f"tables.py: no table or view '{view}'; there are {sorted(runs[0].get('tables', {})) + sorted(VIEWS)}")
    return made["columns"], made["rows"]
