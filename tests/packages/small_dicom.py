#!/usr/bin/env python3
"""Writes a small CT as DICOM slices, uncompressed: a bright ball in air. small_dicom.py FOLDER"""
import struct
import sys
from pathlib import Path

EXTENT, SLICES, SPACING = 48, 32, 2.0  # mm


def element(group, number, vr, value):
    if isinstance(value, str):
        value = value.encode() + (b"" if len(value) % 2 == 0 else b"\0" if vr == "UI" else b" ")
    elif isinstance(value, int):
        value = struct.pack("<H", value)
    head = struct.pack("<HH2s", group, number, vr.encode())
    return head + (struct.pack("<HI", 0, len(value)) if vr in ("OB", "OW") else struct.pack("<H", len(value))) + value


def voxels(z):
    """Stored values of a slice: HU and 1024."""
    middle = (EXTENT - 1) / 2
    rows = []
    for y in range(EXTENT):
        for x in range(EXTENT):
            away = ((x - middle) ** 2 + (y - middle) ** 2 + ((z - (SLICES - 1) / 2) * 1.5) ** 2) ** 0.5
            rows.append(1624 if away < EXTENT / 3 else 24)
    return struct.pack(f"<{len(rows)}H", *rows)


def slice_file(z):
    uid, ct, explicit = "1.2.826.0.1.3680043.10.1", "1.2.840.10008.5.1.4.1.1.2", "1.2.840.10008.1.2.1"
    meta = (element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", ct) + element(2, 3, "UI", f"{uid}.3.{z + 1}") +
            element(2, 0x10, "UI", explicit) + element(2, 0x12, "UI", uid))
    body = (element(8, 0x16, "UI", ct) + element(8, 0x18, "UI", f"{uid}.3.{z + 1}") + element(8, 0x60, "CS", "CT") +
            element(0x18, 0x50, "DS", str(SPACING)) + element(0x20, 0xd, "UI", f"{uid}.1") + element(0x20, 0xe, "UI", f"{uid}.2") +
            element(0x20, 0x13, "IS", str(z + 1)) + element(0x20, 0x32, "DS", f"0\\0\\{z * SPACING}") +
            element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") + element(0x20, 0x52, "UI", f"{uid}.4") + element(0x28, 2, "US", 1) +
            element(0x28, 4, "CS", "MONOCHROME2") + element(0x28, 0x10, "US", EXTENT) + element(0x28, 0x11, "US", EXTENT) +
            element(0x28, 0x30, "DS", f"{SPACING}\\{SPACING}") + element(0x28, 0x100, "US", 16) + element(0x28, 0x101, "US", 12) +
            element(0x28, 0x102, "US", 11) + element(0x28, 0x103, "US", 0) + element(0x28, 0x1052, "DS", "-1024") +
            element(0x28, 0x1053, "DS", "1") + element(0x7fe0, 0x10, "OW", voxels(z)))
    length = element(2, 0, "UL", struct.pack("<I", len(meta)))
    return b"\0" * 128 + b"DICM" + length + meta + body


folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
for z in range(SLICES):
    (folder / f"{z + 1:03}.dcm").write_bytes(slice_file(z))
