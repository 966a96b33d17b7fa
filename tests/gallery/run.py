#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders every scene that is at hand as a person would, and makes a page to look at.

    run.py [--out FOLDER] [--bin FOLDER] [--size WxH] [--quick] [SCENES ...]

SCENES are files, folders that are searched, and builtin:NAME. Without any: every built-in scene, the
generated charts (metals, skins and glass; lobes of glTF; leaves cut out by alpha), and the folder
`shared/scenes` beside the checkout, where it is there. Each is rendered with no option but its size.
FOLDER/index.html shows pictures with their commands, times and messages, FOLDER/gallery.json has the
same as data.

Asserted of each picture: its mean luminance lies in [0.05, 0.9], at least 3 % of its pixels show a
surface, no pixel is NaN or infinite. Of each file that is not read: the program says why.
"""
import argparse
import html
import json
import pathlib
import re
import struct
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import chart  # noqa: E402
import gltf_scenes  # noqa: E402
from png import mean_luminance, read_png  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared" / "scenes"
# Suffixes of files that belong to a scene file and are none themselves.
PARTS = {".mtl", ".bin", ".jpg", ".jpeg", ".png", ".txt", ".md", ".hdr", ".exr", ".pfm", ".json",
         ".gz", ".tga", ".ktx2", ".webp", ".xml"}
LUMINANCE = (0.05, 0.9)
SURFACE_SHARE_MIN = 0.03
TIME_LIMIT_S = 600


def builtin_names(program):
    text = subprocess.run([program, "render", "builtin:?", "-o", "x.png"], capture_output=True,
                          text=True).stderr
    listed = re.search(r"there are ([a-z, ]+)", text)
    return ["builtin:" + name.strip() for name in listed.group(1).split(",")] if listed else []


def generated(folder):
    return [chart.write(folder / "chart"), gltf_scenes.lobes(folder / "chart"), gltf_scenes.plant(folder / "chart")]


def found(arguments, program, out):
    if not arguments:
        files = generated(out) + builtin_names(program)
        return files + (found([str(SHARED)], program, out) if SHARED.is_dir() else [])
    scenes = []
    for argument in arguments:
        path = pathlib.Path(argument)
        if path.is_dir():
            scenes += sorted(str(p) for p in path.rglob("*")
                             if p.is_file() and p.suffix.lower() not in PARTS)
        else:
            scenes.append(argument)
    return scenes


def read_pfm(path):
    data = path.read_bytes()
    head = re.match(rb"PF\n(\d+) (\d+)\n-1.0\n", data)
    width, height = int(head.group(1)), int(head.group(2))
    return width, height, struct.unpack(f"<{3 * width * height}f", data[head.end():])


def run(command):
    began = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT_S)
        return done.returncode, done.stderr.strip(), time.monotonic() - began
    except subprocess.TimeoutExpired:
        return -1, f"took more than {TIME_LIMIT_S} s", TIME_LIMIT_S


def surface_share(program, scene, size, folder):
    """Returns the share of the pixels that show a surface, from distances, where a miss is 0, and why there is none."""
    path = folder / "distance.pfm"
    code, words, _ = run([program, "render", scene, "-o", str(path), "--size", size, "--renderer",
                      "primary", "--quiet"])
    if code != 0:
        return 0.0, f"distances: ended with {code}: {(words.splitlines() or ['without a word'])[-1]}"
    _, _, values = read_pfm(path)
    path.unlink()
    share = sum(1 for x in values[::3] if x > 0) / (len(values) // 3)
    return share, None if share >= SURFACE_SHARE_MIN else f"{100 * share:.1f} % of the pixels show a surface"


def check(entry, folder, program, size):
    faults = []
    _, _, values = read_pfm(folder / entry["linear"])
    if not all(abs(x) < float("inf") for x in values):
        faults.append("a pixel is NaN or infinite")
    _, _, rows = read_png(folder / entry["picture"])
    entry["luminance"] = mean_luminance(rows)
    if not LUMINANCE[0] <= entry["luminance"] <= LUMINANCE[1]:
        faults.append(f"mean luminance {entry['luminance']:.3f}")
    entry["surface_share"], fault = surface_share(program, entry["scene"], size, folder)
    if fault:
        faults.append(fault)
    return faults


def render(program, scene, number, size, folder, options):
    name = re.sub(r"[^A-Za-z0-9]+", "-", pathlib.Path(scene).name).strip("-")
    picture, linear = f"{number:03}-{name}.png", f"{number:03}-{name}.pfm"
    command = [program, "render", scene, "-o", str(folder / picture), "--size", size] + options
    code, words, seconds = run(command)
    shown = " ".join(["tessera-master", "render", pathlib.Path(scene).name] + command[5:] +
                     ["-o", picture])
    entry = {"scene": scene, "command": shown, "seconds": round(seconds, 2), "messages": words,
             "code": code, "faults": []}
    if code == 0:
        entry |= {"picture": picture, "linear": linear}
        run([program, "render", scene, "-o", str(folder / linear), "--size", size, "--quiet"] +
            options)
        entry["faults"] = check(entry, folder, program, size)
        (folder / linear).unlink()
    elif code not in (1, 2) or not words:  # 1 is failure and 2 wrong usage, both told in words
        entry["faults"] = [f"ended with {code}"]
    return entry


def page(entries):
    parts = ["<!doctype html><meta charset=utf-8><title>Gallery</title><style>",
             "body{font:14px sans-serif;background:#ddd}figure{display:inline-block;width:420px;",
             "vertical-align:top;margin:8px;background:#fff;padding:8px}img{width:100%}",
             "pre{white-space:pre-wrap;font-size:11px}.bad{color:#b00}</style>"]
    for e in entries:
        image = f'<img src="{e["picture"]}" alt="">' if "picture" in e else ""
        faults = "".join(f'<div class=bad>{html.escape(f)}</div>' for f in e["faults"])
        parts.append(f'<figure>{image}<figcaption><b>{html.escape(pathlib.Path(e["scene"]).name)}'
                     f'</b>, {e["seconds"]} s, luminance {e.get("luminance", 0):.3f}{faults}'
                     f'<pre>{html.escape(e["command"])}\n{html.escape(e["messages"])}</pre>'
                     f'</figcaption></figure>')
    return "\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "gallery")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build" / "release" / "bin")
    parser.add_argument("--size", default="400x300")
    parser.add_argument("--quick", action="store_true", help="built-in scenes and the chart alone")
    parser.add_argument("scenes", nargs="*")
    given = parser.parse_args()
    folder, program = given.out, str(given.bin / "tessera-master")
    folder.mkdir(parents=True, exist_ok=True)
    scenes = found(given.scenes, program, folder)
    if given.quick:
        scenes = generated(folder) + builtin_names(program)
    entries = []
    for number, scene in enumerate(scenes):
        entries.append(render(program, scene, number, given.size, folder, []))
        e = entries[-1]
        state = "; ".join(e["faults"]) or (f"luminance {e['luminance']:.3f}" if e["code"] == 0
                                           else "not read: " + e["messages"].splitlines()[-1])
        print(f"{number + 1} of {len(scenes)}: {scene}: {state}", flush=True)
    (folder / "gallery.json").write_text(json.dumps(entries, indent=1))
    (folder / "index.html").write_text(page(entries))
    bad = [e["scene"] for e in entries if e["faults"]]
    print(f"{len(entries) - len(bad)} passed, {len(bad)} failed; {folder / 'index.html'}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
