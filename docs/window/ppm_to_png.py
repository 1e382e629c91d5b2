#!/usr/bin/env python3
"""ppm_to_png.py IN.ppm OUT.png [BITS]: a binary PPM as a PNG, with BITS (8) a colour: fewer make a smaller file."""
import struct
import sys
import zlib

with open(sys.argv[1], "rb") as file:
    magic, size, most, pixels = file.read().split(b"\n", 3)
width, height = map(int, size.split())
kept = 256 - (1 << (8 - int(sys.argv[3]) if len(sys.argv) > 3 else 0))
pixels = pixels.translate(bytes(value & kept for value in range(256)))
rows = b"".join(b"\0" + pixels[3 * width * y:3 * width * (y + 1)] for y in range(height))


def part(name, body):
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))


with open(sys.argv[2], "wb") as file:
    file.write(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
               part(b"IDAT", zlib.compress(rows, 9)) + part(b"IEND", b""))
print("wrote", sys.argv[2])
