# SPDX-License-Identifier: Apache-2.0
"""Reads channels of EXR files and pixels of PNG files without the library that wrote them.

EXR: scan lines, without compression or ZIP (OpenEXR's "File Layout"). PNG: 8 bits, colour with or without alpha."""
import array
import struct
import zlib

HALF, FLOAT = 1, 2  # kinds of numbers in an EXR
KINDS = {0: "I", HALF: "e", FLOAT: "f"}
SIZES = {0: 4, 1: 2, 2: 4}
LINES = {0: 1, 2: 1, 3: 16}  # lines of a block, by compression: none, ZIPS, ZIP


class Exr:
    """channels: name -> (kind, [width * height] numbers, row 0 on top)."""

    def __init__(self, path):
        data = open(path, "rb").read()
        assert data[:4] == b"\x76\x2f\x31\x01", f"{path} is no EXR"
        self.attributes, at = {}, 8
        while data[at] != 0:
            name, at = self.text(data, at)
            _, at = self.text(data, at)
            size = struct.unpack_from("<i", data, at)[0]
            self.attributes[name] = data[at + 4:at + 4 + size]
            at += 4 + size
        left, top, right, bottom = struct.unpack("<4i", self.attributes["dataWindow"])
        self.width, self.height = right - left + 1, bottom - top + 1
        kinds = self.kinds()
        self.channels = {name: (kind, []) for name, kind in kinds}
        compression = self.attributes["compression"][0]
        blocks = -(-self.height // LINES[compression])
        for offset in struct.unpack_from(f"<{blocks}Q", data, at + 1):
            line, size = struct.unpack_from("<2i", data, offset)
            self.add_block(kinds, line - top, LINES[compression], data[offset + 8:offset + 8 + size])

    @staticmethod
    def text(data, at):
        end = data.index(0, at)
        return data[at:end].decode(), end + 1

    def kinds(self):
        data, at, found = self.attributes["channels"], 0, []
        while data[at] != 0:
            name, at = self.text(data, at)
            found.append((name, struct.unpack_from("<i", data, at)[0]))
            at += 16
        return found

    def add_block(self, kinds, line, lines, block):
        lines = min(lines, self.height - line)
        whole = self.width * lines * sum(SIZES[kind] for _, kind in kinds)
        if len(block) < whole:
            block = self.restored(zlib.decompress(block))
        assert len(block) == whole
        at = 0
        for _ in range(lines):
            for name, kind in kinds:
                numbers = struct.unpack_from(f"<{self.width}{KINDS[kind]}", block, at)
                self.channels[name][1].extend(numbers)
                at += self.width * SIZES[kind]

    @staticmethod
    def restored(block):
        """Undoes what ZIP arranges: differences of bytes, the even ones first."""
        bytes_, value = bytearray(block), 0
        for i, difference in enumerate(bytes_):
            value = difference if i == 0 else (value + difference - 128) & 255
            bytes_[i] = value
        half = (len(bytes_) + 1) // 2
        out = bytearray(len(bytes_))
        out[0::2], out[1::2] = bytes_[:half], bytes_[half:]
        return bytes(out)

    def values(self, name):
        return self.channels[name][1]

    def bits(self, name):
        """Returns a channel as bytes, so that NaN and -0 count."""
        kind, numbers = self.channels[name]
        return struct.pack(f"<{len(numbers)}{KINDS[kind]}", *numbers)


class Png:
    """pixels: [width * height] tuples of 8-bit codes."""

    def __init__(self, path):
        data = open(path, "rb").read()
        assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG"
        at, packed = 8, b""
        while at < len(data):
            size, kind = struct.unpack_from(">I4s", data, at)
            if kind == b"IHDR":
                self.width, self.height, depth, colour = struct.unpack_from(">IIBB", data, at + 8)
                assert depth == 8 and colour in (2, 6), f"{path}: {depth} bits, kind {colour}"
                self.channels = 4 if colour == 6 else 3
            elif kind == b"IDAT":
                packed += data[at + 8:at + 8 + size]
            at += 12 + size
        self.pixels = []
        rows, stride = zlib.decompress(packed), self.width * self.channels
        above = bytearray(stride)
        for y in range(self.height):
            start = y * (stride + 1)
            above = self.unfiltered(rows[start], array.array("B", rows[start + 1:start + 1 + stride]), above)
            self.pixels += [tuple(above[i:i + self.channels]) for i in range(0, stride, self.channels)]

    def unfiltered(self, kind, row, above):
        n = self.channels
        for i in range(len(row)):
            left = row[i - n] if i >= n else 0
            corner = above[i - n] if i >= n else 0
            if kind == 4:
                guess = left + above[i] - corner
                near = min((abs(guess - left), 0, left), (abs(guess - above[i]), 1, above[i]), (abs(guess - corner), 2, corner))[2]
            else:
                near = (0, left, above[i], (left + above[i]) // 2)[kind]
            row[i] = (row[i] + near) & 255
        return row
