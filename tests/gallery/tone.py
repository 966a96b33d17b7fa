#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the tone curves on the scenes that the gallery generates or that are built in.

    tone.py [--bin FOLDER] [--size WxH]

Each is rendered once as it is (PFM) and once by each curve (PNG), at the exposure that it gets by itself and at three
stops more, and printed as a Markdown table:
    clipped   per cent of pixels with a channel at 255, or at 0 where there is light
    hue       mean turn of the hue in degrees (OKLab: Ottosson, "A perceptual color space for image processing", 2020),
              weighted by chroma, of pixels that are coloured (chroma above 0.03) before the curve and after it
    chroma    what is left of the mean chroma of these
"""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import chart  # noqa: E402
import gltf_scenes  # noqa: E402
from png import _LINEAR, read_png  # noqa: E402
from run import ROOT, read_pfm  # noqa: E402

STOPS = [0, 3]
CURVES = ["linear", "filmic", "aces", "agx"]


def oklab(r, g, b):
    cones = [(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b), (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b),
             (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b)]
    x, y, z = (max(c, 0) ** (1 / 3) for c in cones)
    return (0.2104542553 * x + 0.7936177850 * y - 0.0040720468 * z, 1.9779984951 * x - 2.4285922050 * y + 0.4505937099 * z,
            0.0259040371 * x + 0.7827717662 * y - 0.8086757660 * z)


def measure(linear, png):
    """Compares exposed light, rows of (r, g, b), with the PNG. Returns: shares and angles as the table has them."""
    clipped = count = 0
    turned = weights = before_sum = after_sum = 0.0
    width, height, rows = read_png(png)
    for y in range(height):
        for x in range(width):
            light, code = linear[y][x], rows[y][3 * x:3 * x + 3]
            count += 1
            clipped += any(c == 255 or (c == 0 and v > 1e-4) for c, v in zip(code, light))
            _, a, b = oklab(*light)
            _, p, q = oklab(*(_LINEAR[c] for c in code))
            chroma, shown = math.hypot(a, b), math.hypot(p, q)
            if chroma < 0.03 or shown < 0.03:
                continue
            angle = abs((math.degrees(math.atan2(q, p) - math.atan2(b, a)) + 180) % 360 - 180)
            turned += chroma * angle
            weights += chroma
            before_sum += chroma
            after_sum += shown
    return clipped / count, turned / max(weights, 1e-9), after_sum / max(before_sum, 1e-9)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--size", default="240x180")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scenes = [chart.write(folder), gltf_scenes.lobes(folder), gltf_scenes.plant(folder), "builtin:cornell", "builtin:room",
                  "builtin:evening"]
        sums = {(stops, curve): [0.0, 0.0, 0.0] for stops in STOPS for curve in CURVES}
        for scene in scenes:
            base = [given.bin / "tessera-master", "render", scene, "--quiet", "--size", given.size]
            for kind in ["pfm", "exr"]:
                subprocess.run([*base, "-o", folder / f"a.{kind}"], check=True)
            said = subprocess.run(["iinfo", "-v", folder / "a.exr"], check=True, capture_output=True, text=True).stdout
            ev = float(said.split("tessera:exposure:")[1].split()[0].strip('"'))
            width, height, values = read_pfm(folder / "a.pfm")
            for stops, curve in sums:
                gain = 2 ** (ev + stops)
                linear = [[tuple(gain * v for v in values[3 * (y * width + x):3 * (y * width + x) + 3]) for x in range(width)]
                          for y in reversed(range(height))]
                subprocess.run([*base, "--exposure", str(ev + stops), "--tone", curve, "-o", folder / "a.png"], check=True)
                for k, value in enumerate(measure(linear, folder / "a.png")):
                    sums[stops, curve][k] += value / len(scenes)
    print("| stops above | curve | clipped, % | hue, degrees | chroma kept |\n|---|---|---|---|---|")
    for (stops, curve), (clipped, hue, chroma) in sums.items():
        print(f"| {stops} | {curve} | {100 * clipped:.1f} | {hue:.1f} | {chroma:.2f} |")


if __name__ == "__main__":
    main()
