#!/usr/bin/env python3
"""Compares the pixels of all PNG and EXR files in two folders, bit by bit: pixels.py NAME FOLDER FOLDER.

Headers are not compared but for size and layout: they say when and by what version a picture was made. For
scripts/same-bits.sh; EXR only as gemtrace writes it (one part, scan lines, compressed by ZIP).
"""

import struct
import sys
import zlib
from pathlib import Path


def png(data):
    """The header, and all rows with their filters undone: how a row was filtered says nothing about its pixels."""
    chunks, at = {}, 8
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind = data[at + 4 : at + 8]
        chunks[kind] = chunks.get(kind, b"") + data[at + 8 : at + 8 + length]
        at += length + 12
    header = chunks[b"IHDR"]
    width, height, depth, colour = struct.unpack_from(">IIBB", header)
    size = {0: 1, 2: 3, 4: 2, 6: 4}[colour] * depth // 8
    raw, rows = zlib.decompress(chunks[b"IDAT"]), []
    above = bytes(width * size)
    for y in range(height):
        start = y * (width * size + 1)
        row = bytearray(raw[start + 1 : start + 1 + width * size])
        unfilter(raw[start], row, above, size)
        rows.append(bytes(row))
        above = row
    return header, rows


def unfilter(kind, row, above, size):
    """Undoes one of PNG's filters in place (PNG specification, section 9)."""
    for i in range(len(row)):
        left, up = (row[i - size] if i >= size else 0), above[i]
        corner = above[i - size] if i >= size else 0
        paeth = min((left, up, corner), key=lambda value: abs(left + up - corner - value))
        row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[kind]) & 255


def exr(data):
    """Channels, compression and window, and the blocks of scan lines, decompressed."""
    header, at = {}, 8
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        (length,) = struct.unpack_from("<i", data, at)
        header[name] = data[at + 4 : at + 4 + length]
        at += 4 + length
    window = header[b"dataWindow"]
    top, bottom = struct.unpack("<iiii", window)[1::2]
    count = -(-(bottom - top + 1) // 16)
    blocks = []
    for offset in struct.unpack_from(f"<{count}q", data, at + 1):
        _, length = struct.unpack_from("<ii", data, offset)
        block = data[offset + 8 : offset + 8 + length]
        try:
            block = zlib.decompress(block)
        except zlib.error:
            pass  # stored as it is, where ZIP would not make it smaller
        blocks.append(block)
    return header[b"channels"] + header[b"compression"] + window, blocks


def difference(a, b):
    """What differs between two files; None if nothing does."""
    read = {".png": png, ".exr": exr}[a.suffix]
    (layout, first), (other, second) = read(a.read_bytes()), read(b.read_bytes())
    if layout != other:
        return "another size or layout"
    differing = sum(x != y for x, y in zip(first, second, strict=True))
    return f"{differing} of {len(first)} groups of rows" if differing else None


def main(name, *folders):
    pictures = [{p.relative_to(f): p for p in Path(f).rglob("*") if p.suffix in (".png", ".exr")} for f in folders]
    a, b = pictures
    if not a or a.keys() != b.keys():
        print(f"DIFFERENT  {name}: other files: {sorted(map(str, a.keys() ^ b.keys())) or 'none at all'}")
        return 1
    found = {path: difference(a[path], b[path]) for path in sorted(a)}
    for path, what in found.items():
        if what:
            print(f"DIFFERENT  {name}: {path}: {what}")
    if any(found.values()):
        return 1
    print(f"same       {name}: {len(found)} file{'s' * (len(found) > 1)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
