# SPDX-License-Identifier: Apache-2.0
"""Makes a scene of one textured square: as many bytes as wanted that no codec shrinks, and nothing to build."""
import random
import struct
import zlib


def write_picture(path, side):
    """Writes a PNG of noise, side by side texels."""
    noise = random.Random(7)
    rows = b"".join(b"\0" + noise.randbytes(4 * side) for _ in range(side))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def write_scene(folder, side_px):
    """Writes the scene, with 4 side_px^2 bytes of texels. Returns: the file's path."""
    write_picture(folder / "noise.png", side_px)
    (folder / "scene.mtl").write_text("newmtl paper\nKd 1 1 1\nmap_Kd noise.png\n")
    (folder / "scene.obj").write_text("mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                      "usemtl paper\nf 1/1 2/2 3/3 4/4\n")
    return str(folder / "scene.obj")
