#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares `path` with Blender Cycles on one glTF file under one sky: CPU time at equal noise, and the mean.

    cycles.py SCENE.gltf SKY.hdr [--camera "EX,EY,EZ LX,LY,LZ UX,UY,UZ FOV"] [--size WxH] [--samples N] [--bounces N]
              [--program FILE] [--repeats N] [--json FILE] [--keep DIR]

Each renderer makes pictures of N and of 2 N samples a pixel, on one thread. What the second takes longer, by N, is the
CPU time of a sample: start, loading and building are left out. Two seeds at N samples give the variance: half of the
mean squared difference, of linear luminance. CPU time at equal noise goes with the product of both.

Cycles is asked for what `path` does: no clamping, no denoiser, no adaptive sampling, all caustics, as many bounces, a
box filter. The sky is turned so that both see it in the same place; the two means are printed, and tell whether that
holds.

Needs blender (Debian 12: blender 3.4.1, python3-numpy). Exit code 77: it is missing.
"""
import argparse
import array
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

import blender
import result_file

ROOT = pathlib.Path(__file__).resolve().parents[2]

# What runs inside Blender. Column 0 of a sky is a quarter further on there.
IN_BLENDER = """
import mathutils
world = bpy.data.worlds.new("sky"); scene.world = world; world.use_nodes = True
nodes, links = world.node_tree.nodes, world.node_tree.links
picture = nodes.new("ShaderNodeTexEnvironment"); picture.image = bpy.data.images.load(job["sky"])
turn, place = nodes.new("ShaderNodeMapping"), nodes.new("ShaderNodeTexCoord")
turn.inputs["Rotation"].default_value = (0, 0, -math.pi / 2)
links.new(place.outputs["Generated"], turn.inputs["Vector"]); links.new(turn.outputs["Vector"], picture.inputs["Vector"])
links.new(picture.outputs["Color"], nodes["Background"].inputs["Color"])
eye, target, up = (mathutils.Vector((v[0], -v[2], v[1])) for v in (job["eye"], job["target"], job["up"]))
back = (eye - target).normalized(); right = up.cross(back).normalized(); above = back.cross(right)
lens = bpy.data.cameras.new("camera"); lens.sensor_fit = "VERTICAL"; lens.angle = math.radians(job["fov"])
lens.clip_start, lens.clip_end = 1e-4, 1e6
camera = bpy.data.objects.new("camera", lens); scene.collection.objects.link(camera); scene.camera = camera
camera.matrix_world = mathutils.Matrix((
    (right.x, above.x, back.x, eye.x), (right.y, above.y, back.y, eye.y), (right.z, above.z, back.z, eye.z), (0, 0, 0, 1)))
render, cycles = scene.render, scene.cycles
render.engine = "CYCLES"; cycles.device = "CPU"; render.threads_mode = "FIXED"; render.threads = 1
render.resolution_x, render.resolution_y, render.resolution_percentage = job["width"], job["height"], 100
cycles.samples, cycles.seed = job["samples"], job["seed"]
cycles.use_adaptive_sampling = cycles.use_denoising = False
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
cycles.caustics_reflective = cycles.caustics_refractive = True
cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = job["bounces"]
cycles.transparent_max_bounces = 64
cycles.light_sampling_threshold = 0
cycles.pixel_filter_type = "BOX"
render.image_settings.file_format = "OPEN_EXR"; render.image_settings.color_depth = "32"
render.filepath = job["output"]
bpy.ops.render.render(write_still=True)
values = numpy.array(bpy.data.images.load(render.filepath).pixels, dtype=numpy.float32).reshape(-1, 4)[:, :3]
with open(job["output"][:-4] + ".pfm", "wb") as file:
    file.write(b"PF\\n%d %d\\n-1.0\\n" % (job["width"], job["height"]) + values.tobytes())
"""


def cpu_seconds_of(command, **more):
    """Runs a command and returns its CPU time; what it says last is shown where it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **more)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise SystemExit(f"cycles.py: {command[0]} failed ({done.returncode}): {(done.stderr or done.stdout)[-500:]}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def luminances(picture):
    """Returns the linear luminance of each pixel of a PFM."""
    data = picture.read_bytes()
    head = data.split(b"\n", 3)
    values = array.array("f", head[3])
    if float(head[2]) > 0:
        values.byteswap()
    return [0.2126 * values[i] + 0.7152 * values[i + 1] + 0.0722 * values[i + 2] for i in range(0, len(values), 3)]


class Cycles:
    name = "cycles"

    def __init__(self, options):
        self.options = options

    def render(self, samples, seed, output):
        o = self.options
        eye, target, up, fov = o.view
        job = {"scene": str(o.scene.resolve()), "sky": str(o.sky.resolve()), "eye": eye, "target": target, "up": up,
               "fov": fov, "width": o.width, "height": o.height, "samples": samples, "seed": seed, "bounces": o.bounces,
               "output": str(output.with_suffix(".exr"))}
        command, environment = blender.command(IN_BLENDER, job)
        return cpu_seconds_of(command, env=environment)


class Path:
    name = "path"

    def __init__(self, options):
        self.options = options

    def render(self, samples, seed, output):
        o = self.options
        return cpu_seconds_of([o.program, "render", o.scene, "--renderer", "path", "--environment", o.sky, "--light", "scene",
                               "--camera", o.camera, "--size", f"{o.width}x{o.height}", "--aa", samples, "--bounces",
                               o.bounces, "--seed", seed, "--threads", 1, "--exposure", 0, "-o", output])


def measured(renderer, options, folder):
    """Returns the CPU time of a sample a pixel, in microseconds, the variance of a sample, and the mean."""
    pictures, few, many = [], [], []
    for repeat in range(options.repeats):
        for seed in (1, 2):
            picture = folder / f"{renderer.name}-{seed}.pfm"
            few.append(renderer.render(options.samples, seed, picture))
            if repeat == 0:
                pictures.append(luminances(picture))
        many.append(renderer.render(2 * options.samples, 3, folder / f"{renderer.name}-3.pfm"))
    pixels = options.width * options.height
    seconds = (statistics.median(many) - statistics.median(few)) / options.samples
    if seconds <= 0:
        raise SystemExit("cycles.py: more samples took no longer: give more --samples, or a larger --size")
    squares = sum((a - b) ** 2 for a, b in zip(*pictures))
    return {"name": renderer.name, "microseconds_a_sample": 1e6 * seconds / pixels,
            "variance_of_a_sample": squares / 2 / pixels * options.samples,
            "mean": statistics.fmean(pictures[0] + pictures[1])}


def vector(text):
    return [float(number) for number in text.split(",")]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("sky", type=pathlib.Path)
    parser.add_argument("--camera", default="0.45,0.55,1.1 0,0.33,0 0,1,0 35")
    parser.add_argument("--size", default="320x400")
    parser.add_argument("--samples", type=int, default=32, help="a pixel; twice as many are rendered, too")
    parser.add_argument("--bounces", type=int, default=4)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/bin/tessera-master")
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for the pictures")
    options = parser.parse_args()
    options.width, options.height = (int(side) for side in options.size.split("x"))
    *places, fov = options.camera.split()
    options.view = [*map(vector, places), float(fov)]
    if 2 * options.samples > 256:
        parser.error("--samples: at most 128, for twice as many are rendered, too")
    return options


def main():
    options = arguments()
    if not blender.is_there():
        print(f"cycles.py: {blender.MISSING}")
        return 77
    with tempfile.TemporaryDirectory() as made:
        folder = options.keep or pathlib.Path(made)
        folder.mkdir(parents=True, exist_ok=True)
        ours, theirs = (measured(kind(options), options, folder) for kind in (Path, Cycles))
    for row in (ours, theirs):
        row["cost_at_equal_noise"] = row["microseconds_a_sample"] * row["variance_of_a_sample"]
        print(f"{row['name']:8} {row['microseconds_a_sample']:8.2f} CPU-us a sample, variance of a sample "
              f"{row['variance_of_a_sample']:.5f}, mean {row['mean']:.5f}")
    ratio = ours["cost_at_equal_noise"] / theirs["cost_at_equal_noise"]
    apart = ours["mean"] / theirs["mean"] - 1
    print(f"CPU time at equal noise, path to cycles: {ratio:.3f}; means {100 * apart:+.2f} % apart")
    if options.json:
        version = subprocess.run(["blender", "--version"], capture_output=True, text=True, check=True).stdout.split("\n")[0]
        rows = [[row["name"], f"{row['microseconds_a_sample']:.2f}", f"{row['variance_of_a_sample']:.4g}", f"{row['mean']:.4f}"]
                for row in (ours, theirs)]
        rows.append(["path to cycles", f"{ours['microseconds_a_sample'] / theirs['microseconds_a_sample']:.3f}",
                     f"{ours['variance_of_a_sample'] / theirs['variance_of_a_sample']:.3f}", f"{1 + apart:.4f}"])
        rows.append(["CPU time at equal noise, path to cycles", f"{ratio:.3f}", "", ""])
        columns = [f"{options.scene.name} under {options.sky.name}, {version}", "CPU-us a sample", "variance of a sample", "mean"]
        result_file.write(options.json, options.program, {"noise": (columns, rows)})
    return 0


if __name__ == "__main__":
    sys.exit(main())
