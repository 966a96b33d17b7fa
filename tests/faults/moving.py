# SPDX-License-Identifier: Apache-2.0
"""Rows while everything moves: each frame shows another version of its scene, and files are animated."""
import array
import json
import struct
import sys

import scene_noise

FLOATS, INDICES, NOISE = 5126, 5125, "noise.png"  # glTF's numbers of component types


def while_all_moves(row):
    """Returns: the row on a stage whose scenes move."""
    def moved(stage, report):
        stage.moves = True
        row(stage, report)

    moved.__doc__ = row.__doc__.strip().splitlines()[0] + " While everything moves."
    return moved


class Glb:
    """A binary glTF file that is put together from arrays."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "bufferViews": [], "accessors": []}
        self.bytes = b""

    def accessor(self, kind, values, bounds=None):
        """kind: SCALAR, VEC2 or VEC3. values: an array("f"), or an array("I"). Returns: its number."""
        assert sys.byteorder == "little"
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[kind]
        raw = values.tobytes()
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(raw)})
        self.bytes += raw
        self.json["accessors"].append({
            "bufferView": len(self.json["bufferViews"]) - 1, "count": len(values) // width, "type": kind,
            "componentType": FLOATS if values.typecode == "f" else INDICES, **(bounds or {})})
        return len(self.json["accessors"]) - 1

    def animate(self, path, kind, values):
        """The node's `path` takes the values at 0, 1, 2... seconds."""
        width = {"SCALAR": 1, "VEC3": 3}[kind]
        seconds = array.array("f", range(len(values) // width))
        key = self.accessor("SCALAR", seconds, {"min": [seconds[0]], "max": [seconds[-1]]})
        self.json["animations"] = [{
            "samplers": [{"input": key, "output": self.accessor(kind, values)}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}]}]

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as out:
            out.write(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(self.bytes), len(text), 0x4E4F534A) + text +
                      struct.pack("<II", len(self.bytes), 0x004E4942) + self.bytes)
        return path


def waving_scene(path, side):
    """Writes a square of 2 side^2 triangles all of whose corners move. Returns: its path."""
    glb = Glb()
    count = (side + 1) ** 2
    places, waves, triangles = array.array("f"), array.array("f"), array.array("I")
    for y in range(side + 1):
        for x in range(side + 1):
            places.extend((x, y, (x * 7 + y * 13) % 5 / 4))
            waves.extend((0, 0, (x * 11 + y * 3) % 7 / 4))
    for y in range(side):
        for x in range(side):
            at = y * (side + 1) + x
            triangles.extend((at, at + 1, at + side + 1, at + 1, at + side + 2, at + side + 1))
    bounds = {"min": [0, 0, 0], "max": [side, side, 2]}
    assert len(places) == len(waves) == 3 * count
    glb.json["meshes"] = [{"weights": [0], "primitives": [{
        "attributes": {"POSITION": glb.accessor("VEC3", places, bounds)}, "indices": glb.accessor("SCALAR", triangles),
        "targets": [{"POSITION": glb.accessor("VEC3", waves, bounds)}]}]}]
    glb.animate("weights", "SCALAR", array.array("f", (0, 1, 0)))
    return glb.write(path)


def moving_noise(folder, side_px):
    """Writes a moving square with 4 side_px^2 bytes of texels that no codec shrinks. Returns: the file's path."""
    scene_noise.write_picture(folder / NOISE, side_px)
    glb = Glb()
    corners = array.array("f", (0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0))
    glb.json.update(
        images=[{"uri": NOISE}], textures=[{"source": 0}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        meshes=[{"primitives": [{
            "material": 0, "indices": glb.accessor("SCALAR", array.array("I", (0, 1, 2, 0, 2, 3))), "attributes": {
                "POSITION": glb.accessor("VEC3", corners, {"min": [0, 0, 0], "max": [1, 1, 0]}),
                "TEXCOORD_0": glb.accessor("VEC2", array.array("f", (0, 0, 1, 0, 1, 1, 0, 1)))}}]}])
    glb.animate("translation", "VEC3", array.array("f", (0, 0, 0, 0.5, 0.25, 0)))
    return str(glb.write(folder / "moving.glb"))
