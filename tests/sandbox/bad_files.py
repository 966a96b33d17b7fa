# SPDX-License-Identifier: Apache-2.0
"""Files that ask an importer for more than they hold: small to store, without bound to read.

Each maker takes a folder and returns the file to import. FILES has what the importer says of it.
"""

import base64
import json
import struct
import zlib

SIDE = 16384  # pixels of a side, the most that a texture may have
TRIANGLE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
CORNERS = b"".join(struct.pack("<3f", *corner) for corner in TRIANGLE)


def data_uri(kind, content):
    return f"data:{kind};base64," + base64.b64encode(content).decode()


def gltf_of(nodes, roots, **more):
    """A glTF file's JSON with one triangle as mesh 0."""
    return {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}], "nodes": nodes,
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, **more.pop("primitive", {})}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
            "bufferViews": [{"buffer": 0, "byteLength": len(CORNERS)}],
            "buffers": [{"byteLength": len(CORNERS), "uri": data_uri("application/octet-stream", CORNERS)}], **more}


def write_json(folder, name, content):
    path = folder / name
    path.write_text(json.dumps(content))
    return path


def zero_png(bits, side=SIDE):
    """A grey picture of zeros, side x side, compressed as far as zlib does."""
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    packer = zlib.compressobj(9)
    row = bytes(1 + side * bits // 8)
    packed = b"".join(packer.compress(row) for _ in range(side)) + packer.flush()
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, bits, 0, 0, 0, 0)) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


def glb_with_a_huge_chunk(folder):
    text = json.dumps(gltf_of([{"mesh": 0}], [0])).encode()
    path = folder / "chunk.glb"
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 20 + len(text)) + struct.pack("<I4s", 0xfffffff0, b"JSON") + text)
    return path


def doubling_levels(folder):
    nodes = [{"children": [i + 1, i + 1]} for i in range(40)] + [{"mesh": 0}]
    return write_json(folder, "levels.gltf", gltf_of(nodes, [0]))


def doubling_levels_of_pairs(folder):
    """Each level has two nodes, and each of them both of the next."""
    nodes = [{"children": [2 * (i // 2) + 2, 2 * (i // 2) + 3]} for i in range(80)] + [{"mesh": 0}, {"mesh": 0}]
    return write_json(folder, "pairs.gltf", gltf_of(nodes, [0, 1]))


def textured_gltf(folder, name, uri):
    return write_json(folder, name, gltf_of(
        [{"mesh": 0}], [0], primitive={"material": 0}, images=[{"uri": uri}], textures=[{"source": 0}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]))


def textured_obj(folder, name, picture):
    (folder / f"{name}.mtl").write_text(f"newmtl m\nKd 1 1 1\nmap_Kd {picture}\n")
    path = folder / f"{name}.obj"
    path.write_text(f"mtllib {name}.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n")
    return path


def picture_as_file(bits):
    def make(folder):
        (folder / f"zeros{bits}.png").write_bytes(zero_png(bits))
        return textured_obj(folder, f"file{bits}", f"zeros{bits}.png")
    return make


def picture_beside_gltf(bits):
    def make(folder):
        (folder / f"beside{bits}.png").write_bytes(zero_png(bits))
        return textured_gltf(folder, f"beside{bits}.gltf", f"beside{bits}.png")
    return make


def picture_as_data(bits):
    return lambda folder: textured_gltf(folder, f"data{bits}.gltf", data_uri("image/png", zero_png(bits)))


def sparse(folder, name, head):
    with open(folder / name, "wb") as file:
        file.write(head)
        file.truncate(8 << 30)


def sparse_texture(folder):
    sparse(folder, "sparse.png", b"")
    return textured_obj(folder, "sparse", "sparse.png")


def sparse_texture_with_a_head(folder):
    sparse(folder, "headed.png", zero_png(8)[:64])
    return textured_gltf(folder, "headed.gltf", "headed.png")


def sparse_buffer(folder):
    sparse(folder, "sparse.bin", b"")
    content = gltf_of([{"mesh": 0}], [0])
    content["buffers"] = [{"byteLength": 36, "uri": "sparse.bin"}]
    return write_json(folder, "buffer.gltf", content)


def sparse_scene(folder):
    sparse(folder, "long.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    return folder / "long.obj"


def many_nodes(folder):
    count = 1_200_000
    path = folder / "nodes.gltf"
    rest = json.dumps(gltf_of([], []))
    nodes = ",".join(['{"mesh":0}'] * count)
    roots = ",".join(map(str, range(count)))
    path.write_text(rest.replace('"nodes": []}], "nodes": []', f'"nodes":[{roots}]}}],"nodes":[{nodes}]'))
    return path


def equal_triangles(folder):
    path = folder / "equal.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * 1_500_000)
    return path


def nested_brackets(folder):
    path = folder / "nested.gltf"
    path.write_text('{"asset":{"version":"2.0"},"extras":' + "[" * 200_000)
    return path


def closed_nested_brackets(folder):
    path = folder / "closed.gltf"
    path.write_text('{"extras":' + "[" * 200_000 + "]" * 200_000 + "," + json.dumps(gltf_of([{"mesh": 0}], [0]))[1:])
    return path


def accessor_of_nothing(folder):
    """Numbers that no buffer holds are zero; so many of them take 3.6 GB."""
    content = gltf_of([{"mesh": 0}], [0])
    content["accessors"] = [{"componentType": 5126, "count": 300_000_000, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]}]
    return write_json(folder, "nothing.gltf", content)


def equal_faces_of_their_own_corners(folder):
    """The same, where each triangle has corners of its own; in binary STL."""
    path = folder / "equal.stl"
    facet = bytes(12) + CORNERS + bytes(2)
    path.write_bytes(bytes(80) + struct.pack("<I", 1_500_000) + facet * 1_500_000)
    return path


def many_pictures(folder):
    """Forty pictures of 4096 x 4096 zeros, each of which would pass alone: 2.5 GiB from 600 KiB."""
    count = 40
    picture = zero_png(8, 4096)
    for i in range(count):
        (folder / f"many{i}.png").write_bytes(picture)
    (folder / "many.mtl").write_text("".join(f"newmtl m{i}\nKd 1 1 1\nmap_Kd many{i}.png\n" for i in range(count)))
    path = folder / "many.obj"
    path.write_text("mtllib many.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n" +
                    "".join(f"usemtl m{i}\nf 1/1 2/1 3/1\n" for i in range(count)))
    return path


# What is made, and words of the one line that says why, or None where the file is read without one.
FILES = [
    (glb_with_a_huge_chunk, "has a chunk of 4294967280 bytes beyond its end"),
    (doubling_levels, "a child of two nodes"), (doubling_levels_of_pairs, "a child of two nodes"),
    (picture_as_file(8), "would decode to 1024 MiB from 254 KiB"), (picture_as_file(16), "would decode to 2048 MiB from 509 KiB"),
    (picture_beside_gltf(8), "would decode to 1024 MiB"), (picture_beside_gltf(16), "would decode to 2048 MiB"),
    (picture_as_data(8), "would decode to 1024 MiB"), (picture_as_data(16), "would decode to 2048 MiB"),
    (many_pictures, "more than 200 times their files"),
    (sparse_texture, "is larger than 1024 MiB"), (sparse_texture_with_a_head, "larger than 1024 MiB"),
    (sparse_buffer, "larger than 4096 MiB"), (sparse_scene, "does not begin as an OBJ file does"),
    (many_nodes, "more than 1048576 instances"),
    (equal_triangles, "1499984 triangles lie where 16 others do"),
    (equal_faces_of_their_own_corners, "1499984 triangles lie where 16 others do"),
    (nested_brackets, "unexpected end of input"), (closed_nested_brackets, None),
    (accessor_of_nothing, "too much for an accessor without a bufferView"),
]
