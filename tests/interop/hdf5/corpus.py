#!/usr/bin/python3
"""tests/interop/hdf5/corpus.py FOLDER: the small HDF5 files of tests/fuzz/corpus/hdf5, by h5py. Voxel (z, y, x) of every
set has the value 100 z + 10 y + x, and 1000 n more at n along an axis before z; chunks that are missing have the fill
value 7."""
import ctypes
import os
import sys

import h5py
import numpy as np

folder = sys.argv[1]
os.makedirs(folder, exist_ok=True)
SHAPE = (5, 6, 7)
FILTERS = {"compression": "gzip", "shuffle": True, "fletcher32": True}


def values(shape, dtype="<u2"):
    axes = np.indices(shape)
    steps = [1000 ** (len(shape) - 3 - n) if n < len(shape) - 3 else (100, 10, 1)[n - len(shape) + 3]
             for n in range(len(shape))]
    return sum(step * axis for step, axis in zip(steps, axes)).astype(dtype)


def new(name, libver="earliest", **more):
    return h5py.File(os.path.join(folder, name), "w", libver=libver, **more)


def laid_out(file, name, layout, data):
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    if layout == "compact":
        plist.set_layout(h5py.h5d.COMPACT)
    else:
        plist.set_chunk((2, 3, 4))
        plist.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    made = h5py.h5d.create(file.id, name.encode(), h5py.h5t.py_create(data.dtype), h5py.h5s.create_simple(data.shape),
                           plist)
    made.write(h5py.h5s.ALL, h5py.h5s.ALL, data)


def letters(group, **said):
    for name, text in said.items():
        group.attrs[name] = np.frombuffer(text.encode(), dtype="S1")


ENDLESS = {"one": (None, 6, 7), "last": (5, 6, None), "two": (None, None, 7)}
for libver in ("earliest", "latest"):
    with new(f"contiguous_{libver}.h5", libver) as file:
        file.create_dataset("little", data=values(SHAPE, "<i2"))
        file.create_dataset("group/big", data=values(SHAPE, ">f4"))
        file["same"] = file["little"]  # one set, two links
    with new(f"compact_{libver}.h5", libver) as file:
        laid_out(file, "compact", "compact", values(SHAPE, ">u2"))
    with new(f"chunks_{libver}.h5", libver) as file:
        file.create_dataset("plain", data=values(SHAPE), chunks=(2, 3, 4))
        file.create_dataset("packed", data=values(SHAPE, "<f2"), chunks=(3, 4, 3), **FILTERS)
    with new(f"single_{libver}.h5", libver) as file:
        file.create_dataset("plain", data=values(SHAPE), chunks=SHAPE)
        file.create_dataset("packed", data=values(SHAPE, "<i4"), chunks=SHAPE, compression="gzip")
    with new(f"missing_{libver}.h5", libver) as file:
        made = file.create_dataset("missing", SHAPE, "<u2", chunks=(2, 3, 4), fillvalue=7)
        made[2:4, 3:6, 0:4] = values(SHAPE)[2:4, 3:6, 0:4]
        file.create_dataset("never", SHAPE, "<u2", fillvalue=7)
    with new(f"many_{libver}.h5", libver) as file:  # trees of two levels
        file.create_dataset("many", data=values((30, 6, 7)), chunks=(6, 1, 2), maxshape=(None, None, 7))
    for name, most in ENDLESS.items():
        with new(f"endless_{name}_{libver}.h5", libver) as file:
            file.create_dataset("plain", data=values(SHAPE), chunks=(1, 2, 3), maxshape=most)
            file.create_dataset("packed", data=values(SHAPE), chunks=(2, 3, 4), maxshape=most, **FILTERS)
with new("implicit_latest.h5", "latest") as file:
    laid_out(file, "implicit", "early", values(SHAPE))
with new("pages_latest.h5", "latest") as file:  # a fixed array in pages, most of them not there
    made = file.create_dataset("pages", (30, 6, 7), "<u1", chunks=(1, 1, 1), fillvalue=7)
    made[29, 5, 6] = 2900 + 50 + 6 & 255
with new("ordered_latest.h5", "latest", track_order=True) as file:
    file.create_dataset("ordered", data=values(SHAPE), track_order=True).attrs["element_size_um"] = np.array([1.0, 1, 1])
with new("fletcher_earliest.h5") as file:
    file.create_dataset("summed", data=values(SHAPE), chunks=SHAPE, fletcher32=True)
with new("partial_latest.h5", "latest") as file:  # chunks beyond an end of the set are not filtered
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_chunk((2, 3, 4))
    plist.set_deflate(6)
    opened = next(line.split()[-1] for line in open("/proc/self/maps", encoding="utf-8") if "libhdf5_serial.so" in line)
    ctypes.CDLL(opened).H5Pset_chunk_opts(ctypes.c_int64(plist.id), ctypes.c_uint(2))
    made = h5py.h5d.create(file.id, b"partial", h5py.h5t.STD_U16LE, h5py.h5s.create_simple(SHAPE), plist)
    made.write(h5py.h5s.ALL, h5py.h5s.ALL, values(SHAPE))
with new("dense_latest.h5", "latest") as file:  # links and attributes in heaps
    for n in range(30):
        file.create_group(f"group {n}")
    made = file["group 17"].create_dataset("dense", data=values(SHAPE))
    for n in range(20):
        made.attrs[f"attribute {n}"] = n
    made.attrs["element_size_um"] = np.array([3000.0, 2000.0, 500.0])
with new("spacing_earliest.h5", userblock_size=512) as file:
    file.create_dataset("data", data=values(SHAPE)).attrs["element_size_um"] = np.array([3000, 2000, 500], "f4")
with new("axes_latest.h5", "latest") as file:
    file.create_dataset("channels", data=values((2, *SHAPE)), chunks=(2, 2, 3, 4), compression="gzip")
    file.create_dataset("behind", data=values(SHAPE).reshape(*SHAPE, 1))
with new("itk.h5") as file:
    image = file.create_group("ITKImage/0")
    image["Dimension"] = np.array(SHAPE[::-1], "u8")
    image["Spacing"] = np.array([0.5, 2.0, 3.0])
    image["Origin"] = np.array([-10.0, 20.0, 30.0])
    image["Directions"] = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    image.create_dataset("VoxelData", data=values(SHAPE, "<i2"))
with new("refused_tensors.h5") as file:
    image = file.create_group("ITKImage/0")
    image["Spacing"] = np.ones(3)
    image["Origin"] = np.zeros(3)
    image["Directions"] = np.eye(3)
    image.create_dataset("VoxelData", data=np.zeros((1, *SHAPE[1:], 6), "<i2"))
with new("imaris.ims", ("earliest", "v108")) as file:
    for channel in range(2):
        made = file.create_group(f"DataSet/ResolutionLevel 0/TimePoint 0/Channel {channel}")
        letters(made, ImageSizeX="7", ImageSizeY="6", ImageSizeZ="5")
        made.create_dataset("Data", data=1000 * channel + values((6, 8, 8)), chunks=(3, 4, 4), compression="gzip")
        letters(file.create_group(f"DataSetInfo/Channel {channel}"), Name="DAPI" if channel == 0 else "GFP")
    letters(file.create_group("DataSetInfo/Image"), X="7", Y="6", Z="5", Unit="um", ExtMin0="-1000", ExtMin1="0",
            ExtMin2="500", ExtMax0="2500", ExtMax1="12000", ExtMax2="15500")
with new("levels.ims", ("earliest", "v108")) as file:  # a level n is 10000 n more
    for level, size in enumerate([(5, 6, 7), (3, 3, 4), (2, 2, 2)]):
        made = file.create_group(f"DataSet/ResolutionLevel {level}/TimePoint 0/Channel 0")
        letters(made, **{f"ImageSize{axis}": str(n) for axis, n in zip("ZYX", size)})
        padded = tuple(-(-n // 2) * 2 for n in size)
        made.create_dataset("Data", data=10000 * level + values(padded), chunks=(2, 2, 2), compression="gzip")
    letters(file.create_group("DataSetInfo/Image"), X="7", Y="6", Z="5", Unit="um", ExtMin0="-1000", ExtMin1="0",
            ExtMin2="500", ExtMax0="2500", ExtMax1="12000", ExtMax2="15500")
with new("times.ims", ("earliest", "v108")) as file:  # a channel n is 1000 n more, a time n 10000 n
    for time in range(3):
        for channel in range(2):
            made = file.create_group(f"DataSet/ResolutionLevel 0/TimePoint {time}/Channel {channel}")
            letters(made, ImageSizeX="7", ImageSizeY="6", ImageSizeZ="5")
            data = 10000 * time + 1000 * channel + values((6, 6, 8))
            made.create_dataset("Data", data=data, chunks=(3, 6, 4), compression="gzip")
    letters(file.create_group("DataSetInfo/Image"), X="7", Y="6", Z="5", Unit="um", ExtMin0="-1000", ExtMin1="0",
            ExtMin2="500", ExtMax0="2500", ExtMax1="12000", ExtMax2="15500")
# What is refused.
with new("refused_lzf.h5") as file:
    file.create_dataset("lzf", data=values(SHAPE), chunks=True, compression="lzf")
with new("refused_scaleoffset.h5") as file:
    file.create_dataset("scaled", data=values(SHAPE), chunks=True, scaleoffset=0)
with new("refused_virtual.h5", "latest") as file:
    layout = h5py.VirtualLayout(SHAPE, "<u2")
    layout[:] = h5py.VirtualSource("contiguous_latest.h5", "little", SHAPE)
    file.create_virtual_dataset("virtual", layout)
with new("refused_external.h5") as file:
    file.create_dataset("external", SHAPE, "<u2", external=[("voxels.raw", 0, h5py.h5f.UNLIMITED)])
with new("refused_links.h5") as file:
    file["link"] = h5py.ExternalLink("contiguous_latest.h5", "/little")
    file["loop"] = h5py.SoftLink("/loop")
with new("refused_types.h5") as file:
    file.create_dataset("colours", data=np.zeros((*SHAPE, 3), "u1"))
    file.create_dataset("mask", data=np.zeros(SHAPE, "?"))
    file.create_dataset("pairs", data=np.zeros(SHAPE, [("a", "i2"), ("b", "i2")]))
    file.create_dataset("flat", data=np.zeros((5, 6)))
