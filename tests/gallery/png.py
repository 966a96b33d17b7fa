# SPDX-License-Identifier: Apache-2.0
"""Reads the pixels of 8-bit RGB or RGBA PNG files with the standard library alone."""
import pathlib
import struct
import zlib


def read_png(path):
    """Returns width, height and rows of bytes (RGB), from the top."""
    data = pathlib.Path(path).read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError(f"{path} is no PNG file")
    at, packed, width, height, channels = 8, b"", 0, 0, 3
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", body[:10])
            if depth != 8 or color not in (2, 6):
                raise ValueError(f"{path}: depth {depth}, colour type {color} is not read here")
            channels = 3 if color == 2 else 4
        if kind == b"IDAT":
            packed += body
        at += 12 + size
    rows, before = [], bytes(width * channels)
    raw, stride = zlib.decompress(packed), width * channels + 1
    for y in range(height):
        line = raw[y * stride:(y + 1) * stride]
        before = unfiltered(line[0], bytearray(line[1:]), before, channels)
        rows.append(bytes(before) if channels == 3 else
                    b"".join(before[i:i + 3] for i in range(0, len(before), 4)))
    return width, height, rows


def unfiltered(kind, line, above, channels):
    for i in range(len(line) if kind else 0):
        left = line[i - channels] if i >= channels else 0
        corner = above[i - channels] if i >= channels else 0
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = above[i]
        elif kind == 3:
            guess = (left + above[i]) // 2
        else:
            guess = paeth(left, above[i], corner)
        line[i] = (line[i] + guess) & 255
    return line


def paeth(left, above, corner):
    estimate = left + above - corner
    distances = [(abs(estimate - x), k) for k, x in enumerate((left, above, corner))]
    return (left, above, corner)[min(distances)[1]]


_LINEAR = [x / 255 / 12.92 if x <= 10 else ((x / 255 + 0.055) / 1.055) ** 2.4 for x in range(256)]


def mean_luminance(rows):
    """Returns the mean luminance (Rec. 709) of the light that a display sheds, in [0, 1]."""
    total = count = 0
    for row in rows:
        total += (0.2126 * sum(_LINEAR[x] for x in row[0::3]) +
                  0.7152 * sum(_LINEAR[x] for x in row[1::3]) +
                  0.0722 * sum(_LINEAR[x] for x in row[2::3]))
        count += len(row) // 3
    return total / count
