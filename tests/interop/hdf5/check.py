#!/usr/bin/python3
"""tests/interop/hdf5/check.py TESSERA FOLDER: volumes that h5py writes to HDF5 files, by every type, layout, filter and
version of the format, are those that tessera finds, voxel by voxel. Exit 77 (skipped) where h5py is not installed."""
import os
import subprocess
import sys

tessera, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
try:
    import h5py
    import numpy as np
except ImportError:
    print("skipped: python3-h5py is not installed")
    sys.exit(77)
os.makedirs(folder, exist_ok=True)
os.chdir(folder)
os.environ["XDG_CACHE_HOME"] = os.path.join(os.getcwd(), "cache")

SHAPE, CHUNKS = (11, 13, 17), (4, 5, 6)
FILTERS = [{}, {"compression": "gzip"}, {"shuffle": True}, {"fletcher32": True},
           {"compression": "gzip", "shuffle": True, "fletcher32": True}]
ENDLESS = [None, (None, 13, 17), (11, 13, None), (None, None, 17), (20, 30, 40)]
STORED = {"i1": "i2", "u1": "u1", "i2": "i2", "u2": "u2"}  # others: float32
random = np.random.default_rng(7)


def numbers(dtype):
    if dtype.kind == "f":
        return random.normal(0, 500, SHAPE).astype(dtype)
    limits = np.iinfo(dtype)
    return random.integers(limits.min, limits.max, SHAPE, dtype=dtype.newbyteorder("="), endpoint=True).astype(dtype)


def write(file, dtype):
    file.create_dataset("contiguous", data=numbers(dtype))
    for f, filters in enumerate(FILTERS):
        file.create_dataset(f"single/{f}", data=numbers(dtype), chunks=SHAPE, **filters)
        for e, most in enumerate(ENDLESS):
            made = file.create_dataset(f"chunks {f}/{e}", SHAPE, dtype, chunks=CHUNKS, maxshape=most, fillvalue=3,
                                       **filters)
            made[2:9, 3:, :11] = numbers(dtype)[2:9, 3:, :11]  # the other chunks are missing


def part(dtype, expected, name, *options):
    """Compares an exported part of a.h5 or a.ims with what h5py reads."""
    if os.path.exists("v.nrrd"):
        os.remove("v.nrrd")
    subprocess.run([tessera, "export", "-q", name, "v.nrrd", *options], check=True)
    expected = expected.astype(STORED.get(dtype.lstrip("<>"), "f4"))
    found = nrrd("v.nrrd")
    if found.shape != expected.shape or not (found == expected).all():
        print(f"FAILED: {name} {options}")
        sys.exit(1)


def nrrd(name):
    with open(name, "rb") as file:
        head, data = file.read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().split("\n") if ": " in line)
    types = {"uint8": "u1", "int16": "<i2", "uint16": "<u2", "float": "<f4"}
    sizes = [int(size) for size in fields["sizes"].split()]
    return np.frombuffer(data, types[fields["type"]]).reshape(sizes[::-1])


volumes = 0
for libver in ("earliest", "latest"):
    for dtype in ("i1", "u1", "<i2", ">u2", "<u4", ">i4", "<f2", ">f2", ">f4", "<f4", ">f8", "<i8"):
        with h5py.File("a.h5", "w", libver=libver) as file:
            write(file, np.dtype(dtype))
        with h5py.File("a.h5", "r") as file:
            paths = []
            file.visititems(lambda name, made: paths.append(name) if isinstance(made, h5py.Dataset) else None)
            # Sorted as links of each group are. One type, one file and version: each has other sets checked.
            for number in range(volumes % 5, len(paths), 5) if libver == "latest" else (0, len(paths) - 1):
                path = sorted(paths, key=lambda p: p.split("/"))[number]
                chosen = ["--series", str(number + 1), "--spacing", "1,1,1"]
                part(dtype, file[path][...], "a.h5", *chosen)
                if number < 5:  # a box of it
                    part(dtype, file[path][3:9, 1:12, 5:13], "a.h5", *chosen, "--file-box", "5,13,1,12,3,9")
                volumes += 1
with h5py.File("a.ims", "w", libver=("earliest", "v108")) as file:  # levels of Imaris, padded
    for level, shape in enumerate([(9, 10, 12), (5, 5, 6)]):
        channel = file.create_group(f"DataSet/ResolutionLevel {level}/TimePoint 0/Channel 0")
        for letter, size in zip("ZYX", shape):
            channel.attrs[f"ImageSize{letter}"] = np.frombuffer(str(size).encode(), dtype="S1")
        padded = tuple(-(-n // 4) * 4 for n in shape)
        channel.create_dataset("Data", data=random.integers(0, 60000, padded, "u2"), chunks=(4, 4, 4), compression="gzip")
    image = file.create_group("DataSetInfo/Image")
    for key, text in {"X": "12", "Y": "10", "Z": "9", "Unit": "um", "ExtMin0": "0", "ExtMin1": "0", "ExtMin2": "0",
                      "ExtMax0": "12", "ExtMax1": "10", "ExtMax2": "9"}.items():
        image.attrs[key] = np.frombuffer(text.encode(), dtype="S1")
with h5py.File("a.ims", "r") as file:
    for level, (z, y, x) in enumerate([(9, 10, 12), (5, 5, 6)]):
        data = file[f"DataSet/ResolutionLevel {level}/TimePoint 0/Channel 0/Data"][:z, :y, :x]
        part("u2", data, "a.ims", "--file-level", str(level))
        part("u2", data[1:4, 2:5, 3:6], "a.ims", "--file-level", str(level), "--file-box", "3,6,2,5,1,4")
print(f"{volumes} volumes equal")
