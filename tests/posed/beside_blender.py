#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares where the vertices of animated glTF files are with Blender's import of them, and with an evaluator in double.

    beside_blender.py [FILE...]

Without files: Fox and AnimatedMorphCube of Khronos's samples, where the checkout has them beside it. Corners of triangles are
compared at up to 12 keys of the first animation, and between these. The size is the diagonal of the box around all of them.

Bar: 1e-5 of the size. Between two keys it holds for what nothing turns: Blender interpolates the four numbers of a rotation
and scales the result, glTF asks for the arc between both, so the difference there is printed and judged by the evaluator
in double alone (tests/support/motion_reference.h).

Needs blender (Debian 12: blender 3.4.1, python3-numpy), and files of one mesh. Exit code 77: it is missing.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))

import blender

SHARED = ROOT.parent / "shared/scenes/gltf"
BIN = pathlib.Path(os.environ.get("TESSERA_BIN", ROOT / "build/release/bin"))
BAR = 1e-5
TIMES = 12

IN_BLENDER = """
frames = []
for seconds in job["seconds"]:
    frame = seconds * scene.render.fps / scene.render.fps_base
    scene.frame_set(math.floor(frame), subframe=frame - math.floor(frame))
    graph = bpy.context.evaluated_depsgraph_get()
    corners = []
    # An armature's bones are drawn as a shape, which is a mesh of no user's.
    shapes = {bone.custom_shape for o in bpy.data.objects if o.pose for bone in o.pose.bones}
    for thing in [o for o in bpy.data.objects if o.type == "MESH" and o not in shapes]:
        there = thing.evaluated_get(graph)
        mesh = there.to_mesh()
        mesh.calc_loop_triangles()
        places = [there.matrix_world @ v.co for v in mesh.vertices]
        for triangle in mesh.loop_triangles:
            corners += [[places[v].x, places[v].z, -places[v].y] for v in triangle.vertices]
        there.to_mesh_clear()
    frames.append(corners)
with open(job["output"], "w") as file: json.dump(frames, file)
"""


def run(command, **more):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **more)
    if done.returncode != 0:
        raise SystemExit(f"beside_blender.py: {command[0]} failed ({done.returncode}): {(done.stderr or done.stdout)[-500:]}")
    return done.stdout


def ours(file, seconds):
    """Returns the corners at each time, and how far they are from the evaluator in double and the size."""
    frames, head = [], None
    for line in run([BIN / "posed_corners", file, *map(repr, seconds)]).splitlines():
        word, *numbers = line.split()
        if word == "reference":
            head = [float(n) for n in numbers]
        elif word == "at":
            frames.append([])
        else:
            frames[-1].append([float(word), *map(float, numbers)])
    return frames, *head


def blenders(file, seconds):
    with tempfile.TemporaryDirectory() as folder:
        output = pathlib.Path(folder) / "corners.json"
        job = {"scene": str(file.resolve()), "seconds": seconds, "output": str(output)}
        command, environment = blender.command(IN_BLENDER, job)
        run(command, env=environment)
        return json.loads(output.read_text())


def worst(frames, others):
    """Returns the largest distance of corners."""
    far = 0.0
    for here, there in zip(frames, others, strict=True):
        if len(here) != len(there):
            raise SystemExit(f"beside_blender.py: {len(here)} corners here, {len(there)} in Blender")
        far = max([far, *(sum((a - b) ** 2 for a, b in zip(p, q)) ** 0.5 for p, q in zip(here, there))])
    return far


def compare(file):
    """Prints the differences. Returns: whether they are below the bar."""
    turns, *keys = run([BIN / "posed_corners", file, "keys"]).splitlines()
    keys = [float(key) for key in keys]
    picked = sorted({keys[i * (len(keys) - 1) // (TIMES - 1)] for i in range(TIMES)})
    between = [(a + b) / 2 for a, b in zip(keys, keys[1:])]
    between = sorted({between[i * (len(between) - 1) // (TIMES - 1)] for i in range(TIMES)}) if between else []
    seconds = picked + between
    frames, off_reference, size = ours(file, seconds)
    others = blenders(file, seconds)
    at_keys = worst(frames[:len(picked)], others[:len(picked)]) / size
    beside = worst(frames[len(picked):], others[len(picked):]) / size
    is_turning = turns.split()[1] == "1"
    print(f"{file.name}: {len(frames[0])} corners, over the size: {off_reference / size:.2g} from the evaluator in double at "
          f"{len(seconds)} times; {at_keys:.2g} from Blender at {len(picked)} keys, {beside:.2g} at {len(between)} times between"
          + (", where rotations are interpolated otherwise" if is_turning else ""))
    return max(off_reference / size, at_keys, 0 if is_turning else beside) <= BAR


def main():
    files = [pathlib.Path(word) for word in sys.argv[1:]]
    if not files:
        known = [SHARED / "Fox.glb", SHARED / "AnimatedMorphCube/AnimatedMorphCube.gltf"]
        files = [file for file in known if file.exists()]
    if not files or not blender.is_there():
        missing = blender.MISSING if files else "no file is here: name some"
        print(f"beside_blender.py: {missing}")
        return 77
    return 0 if all([compare(file) for file in files]) else 1


if __name__ == "__main__":
    sys.exit(main())
