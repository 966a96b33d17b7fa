# SPDX-License-Identifier: Apache-2.0
"""Writes small glTF 2.0 files: one lit dome with coordinates, normals and a material, seen by a camera.

Everything is made here, by Python's standard library, but what only its own encoder can write: packed/*.bin and
*.webp (the dome by the encoders of Draco and meshoptimizer, the picture by oiiotool).
"""
import base64
import json
import math
import pathlib
import struct
import zlib

BYTE, UBYTE, SHORT, USHORT, UINT, FLOAT = 5120, 5121, 5122, 5123, 5125, 5126
FORMATS = {BYTE: "b", UBYTE: "B", SHORT: "h", USHORT: "H", UINT: "I", FLOAT: "f"}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
PACKED = pathlib.Path(__file__).parent / "packed"
SIDE = 8


def png(width, height, texel, depth=8, alpha=False):
    """Returns a PNG; texel(x, y) gives the values."""
    rows = b""
    for y in range(height):
        rows += b"\0" + b"".join(struct.pack(">%d%s" % (4 if alpha else 3, "H" if depth == 16 else "B"), *texel(x, y))
                                 for x in range(width))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", width, height, depth, 6 if alpha else 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def halves(left, right, size=8, depth=8, alpha=False):
    """Returns a picture of two colours, side by side."""
    return png(size, size, lambda x, y: left if x < size // 2 else right, depth, alpha)


def data_uri(data, kind="application/octet-stream"):
    return f"data:{kind};base64," + base64.b64encode(data).decode()


def dome(side=SIDE):
    """Returns positions, normals, coordinates and triangles of a dome over a square, which bulges towards +z."""
    positions, normals, uvs, triangles = [], [], [], []
    for j in range(side + 1):
        for i in range(side + 1):
            x, y = 2 * i / side - 1, 2 * j / side - 1
            positions.append((x, y, 0.5 * (1 - 0.5 * (x * x + y * y))))
            length = math.sqrt(0.25 * (x * x + y * y) + 1)
            normals.append((0.5 * x / length, 0.5 * y / length, 1 / length))
            uvs.append((i / side, 1 - j / side))
    for j in range(side):
        for i in range(side):
            a = j * (side + 1) + i
            triangles += [(a, a + 1, a + side + 2), (a, a + side + 2, a + side + 1)]
    return positions, normals, uvs, triangles


class GltfFile:
    """`doc` is the JSON; what is added to `bytes` ends up in buffer 0."""

    def __init__(self):
        self.bytes, self.files = b"", {}
        self.doc = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
                    "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]},
                              {"translation": [2, 2, 4], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
                    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
                    "extensionsUsed": ["KHR_lights_punctual"],
                    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 683 * 20}]}},
                    "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0,
                                                            "roughnessFactor": 0.5}}],
                    "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}], "images": [], "samplers": [], "textures": []}
        positions, normals, uvs, triangles = dome()
        self.doc["meshes"] = [{"primitives": [{"attributes": {
            "POSITION": self.accessor(positions, FLOAT, "VEC3"), "NORMAL": self.accessor(normals, FLOAT, "VEC3"),
            "TEXCOORD_0": self.accessor(uvs, FLOAT, "VEC2")},
            "indices": self.accessor([i for t in triangles for i in t], USHORT, "SCALAR"), "material": 0}]}]

    # Cases change these parts.
    material = property(lambda self: self.doc["materials"][0])
    pbr = property(lambda self: self.material["pbrMetallicRoughness"])
    primitive = property(lambda self: self.doc["meshes"][0]["primitives"][0])
    attributes = property(lambda self: self.primitive["attributes"])
    node = property(lambda self: self.doc["nodes"][0])
    camera = property(lambda self: self.doc["cameras"][0])
    lamp = property(lambda self: self.doc["extensions"]["KHR_lights_punctual"]["lights"][0])

    def view(self, data, **more):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.doc["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data), **more})
        self.bytes += data
        return len(self.doc["bufferViews"]) - 1

    def accessor(self, values, component, shape, **more):
        rows = values if isinstance(values[0], (tuple, list)) else [(v,) for v in values]
        size = struct.calcsize(FORMATS[component]) * COMPONENTS[shape]
        pad = -size % 4 if component != FLOAT and shape != "SCALAR" else 0  # vertex attributes are aligned
        data = b"".join(struct.pack("<%d%s" % (COMPONENTS[shape], FORMATS[component]), *row) + b"\0" * pad for row in rows)
        entry = {"bufferView": self.view(data, **({"byteStride": size + pad} if pad else {})), "componentType": component,
                 "count": len(rows), "type": shape, **more}
        if shape == "VEC3" and component == FLOAT:
            entry.update(min=[min(r[i] for r in rows) for i in range(3)], max=[max(r[i] for r in rows) for i in range(3)])
        self.doc["accessors"].append(entry)
        return len(self.doc["accessors"]) - 1

    def texture(self, picture, sampler=None, **more):
        """Returns a textureInfo of a picture in a data URI."""
        self.doc["images"].append({"uri": data_uri(picture, "image/png")})
        entry = {"source": len(self.doc["images"]) - 1}
        if sampler is not None:
            self.doc["samplers"].append(sampler)
            entry["sampler"] = len(self.doc["samplers"]) - 1
        self.doc["textures"].append(entry)
        return {"index": len(self.doc["textures"]) - 1, **more}

    def use(self, extension, value, of=None):
        """Puts an extension into the material, or into `of`."""
        if extension not in self.doc["extensionsUsed"]:
            self.doc["extensionsUsed"].append(extension)
        (self.material if of is None else of).setdefault("extensions", {})[extension] = value
        return value

    def json(self):
        doc = {key: value for key, value in self.doc.items() if value not in ([], {})}
        doc["buffers"][0]["byteLength"] = len(self.bytes)
        return doc

    def write(self, path):
        """Writes the file as .gltf with its bytes in the text, or as .glb."""
        for name, data in self.files.items():
            path.parent.joinpath(name).write_bytes(data)
        doc = self.json()
        if path.suffix == ".glb":
            text = json.dumps(doc).encode()
            text += b" " * (-len(text) % 4)
            data = self.bytes + b"\0" * (-len(self.bytes) % 4)
            chunks = struct.pack("<II", len(text), 0x4e4f534a) + text + struct.pack("<II", len(data), 0x004e4942) + data
            path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
        else:
            doc["buffers"][0].setdefault("uri", data_uri(self.bytes))
            path.write_text(json.dumps(doc))
