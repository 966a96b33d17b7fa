# SPDX-License-Identifier: Apache-2.0
"""Generates two glTF scenes: a chart of the optional lobes of surfaces, and a plant whose leaves are cut out
of a picture by its alpha."""
import base64
import json
import math
import pathlib
import random
import struct
import zlib

FLOAT, UINT = 5126, 5125


def png(size, texel):
    """Returns a square RGBA PNG; texel(x, y) gives four values from 0 to 255."""
    rows = b"".join(b"\0" + b"".join(bytes(texel(x, y)) for x in range(size)) for y in range(size))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 6, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def data_uri(data, kind="application/octet-stream"):
    return f"data:{kind};base64," + base64.b64encode(data).decode()


class Gltf:
    def __init__(self):
        self.bytes = b""
        self.doc = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
                    "accessors": [], "bufferViews": []}

    def accessor(self, rows, kind, code):
        data = b"".join(struct.pack("<" + code, *(row if isinstance(row, tuple) else (row,))) for row in rows)
        self.doc["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        self.doc["accessors"].append({"bufferView": len(self.doc["bufferViews"]) - 1, "count": len(rows), "type": kind,
                                      "componentType": UINT if code == "I" else FLOAT})
        if kind == "VEC3":
            self.doc["accessors"][-1].update({name: [pick(row[a] for row in rows) for a in range(3)]
                                              for name, pick in [("min", min), ("max", max)]})
        return len(self.doc["accessors"]) - 1

    def geometry(self, positions, normals, uvs, indices):
        return {"attributes": {"POSITION": self.accessor(positions, "VEC3", "3f"), "NORMAL": self.accessor(normals, "VEC3", "3f"),
                               "TEXCOORD_0": self.accessor(uvs, "VEC2", "2f")}, "indices": self.accessor(indices, "SCALAR", "I")}

    def node(self, geometry, material, **placed):
        self.doc["materials"].append(material)
        self.doc["meshes"].append({"primitives": [{**geometry, "material": len(self.doc["materials"]) - 1}]})
        self.add_node({"mesh": len(self.doc["meshes"]) - 1, **placed})

    def add_node(self, node):
        self.doc["nodes"].append(node)
        self.doc["scenes"][0]["nodes"].append(len(self.doc["nodes"]) - 1)

    def camera(self, eye, pitch, yfov):
        self.doc["cameras"] = [{"type": "perspective", "perspective": {"yfov": yfov, "znear": .1}}]
        self.add_node({"camera": 0, "translation": eye, "rotation": [math.sin(pitch / 2), 0, 0, math.cos(pitch / 2)]})

    def floor(self, size, y):
        s = size
        self.node(self.geometry([(-s, y, -s), (s, y, -s), (s, y, s), (-s, y, s)], [(0, 1, 0)] * 4,
                                [(0, 0), (1, 0), (1, 1), (0, 1)], [0, 2, 1, 0, 3, 2]), surface((.45, .45, .45), .9, 0))

    def write(self, path):
        used = sorted({name for m in self.doc["materials"] for name in m.get("extensions", {})})
        if used:
            self.doc["extensionsUsed"] = used
        self.doc["buffers"] = [{"byteLength": len(self.bytes), "uri": data_uri(self.bytes)}]
        path = pathlib.Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(self.doc))
        return str(path)


def surface(color, roughness, metallic, **extensions):
    made = {"pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "roughnessFactor": roughness, "metallicFactor": metallic}}
    if extensions:
        made["extensions"] = {"KHR_materials_" + name: keys for name, keys in extensions.items()}
    return made


def sphere(around=64):
    rows, positions, uvs, indices = around // 2, [], [], []
    for j in range(rows + 1):
        for i in range(around + 1):
            theta, phi = math.pi * j / rows, 2 * math.pi * i / around
            positions.append((math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi)))
            uvs.append((1 - i / around, j / rows))
    for j in range(rows):
        for i in range(around):
            a = j * (around + 1) + i
            below = a + around + 1
            indices += ([a, a + 1, below + 1] if j > 0 else []) + ([a, below + 1, below] if j < rows - 1 else [])
    return positions, positions, uvs, indices


def lobes(folder):
    """Writes the chart. Left to right, back to front: paint, the same under varnish, metal under varnish, velvet; gold,
    the same brushed one way and the other, a coloured reflection; glass: thin, thin and rough, tinted, tinted rough."""
    red, gold, glass = ((.6, .02, .02), .5, 0), ((.9, .6, .3), .3, 1), {"transmissionFactor": 1}

    def tint(color, ior):
        return {"volume": {"thicknessFactor": 1, "attenuationColor": color, "attenuationDistance": 1}, "ior": {"ior": ior}}
    chart = [
        surface(*red), surface(*red, clearcoat={"clearcoatFactor": 1, "clearcoatRoughnessFactor": .03}),
        surface((.8, .8, .8), .3, 1, clearcoat={"clearcoatFactor": 1}),
        surface((.1, .1, .5), .9, 0, sheen={"sheenColorFactor": [.9, .9, .9], "sheenRoughnessFactor": .4}),
        surface(*gold), surface(*gold, anisotropy={"anisotropyStrength": .8}),
        surface(*gold, anisotropy={"anisotropyStrength": .8, "anisotropyRotation": math.pi / 2}),
        surface((.3, .3, .3), .2, 0, specular={"specularFactor": 1, "specularColorFactor": [1, 6, 12]}),
        surface((.9, .95, 1), 0, 0, transmission=glass), surface((.9, .95, 1), .2, 0, transmission=glass),
        surface((1, 1, 1), 0, 0, transmission=glass, **tint([.2, .8, .4], 1.5)),
        surface((1, 1, 1), .2, 0, transmission=glass, **tint([.9, .5, .1], 1.33))]
    file = Gltf()
    ball = file.geometry(*sphere())
    for k, material in enumerate(chart):
        file.node(ball, material, translation=[(k % 4 - 1.5) * 2.3, 0, (k // 4 - 1) * 2.6])
    file.floor(30, -1)
    file.camera([0, 5.2, 10.5], -.46, .6)
    return file.write(pathlib.Path(folder) / "lobes.gltf")


def leaf(size=128):
    def texel(x, y):
        u, v = 2 * (x + .5) / size - 1, (y + .5) / size
        width = .8 * math.sin(math.pi * v) ** .8 * (1 - .35 * v) * (1 + .06 * math.sin(40 * v))
        vein = abs(u) < .03 or abs((abs(u) * .7 + v * 6) % 1 - .5) < .05
        shade = (150, 185, 95) if vein else (70 + int(40 * v), 130 + int(30 * v), 45)
        return (*shade, 255 if abs(u) < width else 0)
    return png(size, texel)


def plant(folder):
    """Writes the plant. Its leaves are rectangles in the file, with alphaMode MASK, and seen from both sides."""
    rng = random.Random(5)
    file = Gltf()
    file.doc["images"] = [{"uri": data_uri(leaf(), "image/png")}]
    file.doc["textures"] = [{"source": 0}]
    positions, normals, uvs, indices = [], [], [], []
    for stem in range(26):
        turn, lean = 2 * math.pi * stem / 26 + rng.uniform(-.2, .2), rng.uniform(.1, .75)
        for k in range(8):
            along = .08 + .92 * k / 8
            reach = lean * along * along * 1.8
            centre = (reach * math.cos(turn), 2.6 * along - .9 * lean * along * along, reach * math.sin(turn))
            way, size = turn + rng.uniform(-1.3, 1.3), rng.uniform(.28, .45)
            fall = rng.uniform(-.3, .5)
            ahead = (math.cos(way) * math.cos(fall), -math.sin(fall), math.sin(way) * math.cos(fall))
            side = (-math.sin(way), 0, math.cos(way))
            up = (side[1] * ahead[2] - side[2] * ahead[1], side[2] * ahead[0] - side[0] * ahead[2],
                  side[0] * ahead[1] - side[1] * ahead[0])
            first = len(positions)
            for s, t in [(-.5, 1), (.5, 1), (.5, 0), (-.5, 0)]:
                positions.append(tuple(c + size * (s * b + t * a * 1.6) for c, a, b in zip(centre, ahead, side)))
                normals.append(up)
                uvs.append((s + .5, t))
            indices += [first + i for i in (0, 1, 2, 0, 2, 3)]
    green = surface((1, 1, 1), .5, 0)
    green["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    green.update(alphaMode="MASK", doubleSided=True)
    file.node(file.geometry(positions, normals, uvs, indices), green)
    pot, around = ([], [], [], []), 48
    for j, (radius, height) in enumerate([(.32, -.7), (.45, .0), (.5, .0), (.5, .12), (.44, .12), (.42, .05), (0, .05)]):
        for i in range(around + 1):
            phi = 2 * math.pi * i / around
            pot[0].append((radius * math.cos(phi), height, radius * math.sin(phi)))
            pot[1].append((math.cos(phi), 0, math.sin(phi)) if j < 4 else (0, 1, 0))
            pot[2].append((i / around, j / 6))
            if i < around and j < 6:
                a = j * (around + 1) + i
                pot[3].extend(([a, a + around + 1, a + around + 2] if j < 5 else []) + [a, a + around + 2, a + 1])
    file.node(file.geometry(*pot), surface((.5, .18, .09), .7, 0))
    file.floor(20, -.7)
    file.camera([0, 2.1, 6.2], -.2, .6)
    return file.write(pathlib.Path(folder) / "plant.gltf")
