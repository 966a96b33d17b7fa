# SPDX-License-Identifier: Apache-2.0
"""Runs a script inside Blender, where it is installed (Debian 12: blender 3.4.1, python3-numpy)."""
import json
import os
import shutil
import subprocess

MISSING = "blender, or its numpy, is not installed (Debian: blender python3-numpy)"

# Blender's importer for glTF uses a name that newer versions of numpy lack.
_START = """
import json, math, sys
import numpy
if not hasattr(numpy, "bool"): numpy.bool = bool
import bpy
job = json.loads(sys.argv[sys.argv.index("--") + 1])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=job["scene"])
scene = bpy.context.scene
"""


def _environment():
    # Debian's Blender takes its modules from beside the python3 that it finds first, which has to be Debian's.
    return os.environ | {"PATH": "/usr/bin:/bin"}


def is_there():
    has_numpy = ["/usr/bin/python3", "-c", "import numpy"]
    return shutil.which("blender") is not None and subprocess.run(
        has_numpy, env=_environment(), stderr=subprocess.DEVNULL, check=False).returncode == 0


def command(script, job):
    """Returns the command, and the environment to run it in, of a script that finds `scene`, which is imported from
    job["scene"], and `job`. Files have +y up, Blender has +z: (x, y, z) is (x, -z, y) there."""
    return ([shutil.which("blender"), "-b", "-noaudio", "--python-exit-code", "1", "--python-expr", _START + script, "--",
             json.dumps(job)], _environment())
