#!/usr/bin/python3
"""tests/interop/exports/check.py TESSERA FOLDER: volumes that numpy made are exported, and other programs' readers find
the same values at the same places: nibabel, tifffile, VTK and OpenVDB. A reader that is not installed is left out, with
a line; exit 77 (skipped) where none is."""
import json
import math
import os
import subprocess
import sys

tessera, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
try:
    import numpy as np
except ImportError:
    print("skipped: python3-numpy is not installed")
    sys.exit(77)
os.makedirs(folder, exist_ok=True)
os.chdir(folder)
os.environ["XDG_CACHE_HOME"] = os.path.join(os.getcwd(), "cache")

SPACING = (0.7, 0.9, 1.3)
ORIGIN = (-31.5, 12.25, 7.125)
C, S = math.cos(0.2), math.sin(0.2)
AXES = np.array([[C, -S, 0], [S, C, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, C, -S], [0, S, C]])
LOW, HIGH = (3, 5, 2), (40, 33, 51)
BOX = ",".join(f"{low},{high}" for low, high in zip(LOW, HIGH))
SHAPE = (53, 37, 45)  # z, y, x


def volume(dtype):
    rng = np.random.default_rng(7)
    if dtype.startswith("float"):
        return rng.normal(0, 500, SHAPE).astype(dtype)
    limits = np.iinfo(dtype)
    return rng.integers(limits.min, limits.max, SHAPE, dtype=dtype, endpoint=True)


def export(name, dtype, slope, intercept, *more):
    data = volume(dtype)
    data.astype(np.dtype(dtype).newbyteorder("<")).tofile("v.raw")
    with open("v.json", "w", encoding="utf-8") as file:
        json.dump({"data": "v.raw", "type": dtype, "extent": SHAPE[::-1], "spacing": SPACING, "origin": ORIGIN,
                   "direction": AXES.ravel().tolist(), "rescaleSlope": slope, "rescaleIntercept": intercept}, file)
    if os.path.exists(name):
        os.remove(name)
    subprocess.run([tessera, "export", "-q", "v.json", name, "--crop-voxels", BOX, *more], check=True)
    (x0, y0, z0), (x1, y1, z1) = LOW, HIGH
    part = data[z0:z1, y0:y1, x0:x1]
    return part, slope * part.astype(np.float64) + intercept


def centre(i, j, k):
    """LPS, mm, of a voxel of the box."""
    return np.array(ORIGIN) + AXES @ (np.array(SPACING) * (np.array([i, j, k]) + LOW))


def expect(condition, what):
    if not condition:
        print("FAILED:", what)
        sys.exit(1)


def expect_place(place, tolerance, what):
    for index in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (7, 8, 9)):
        expect(np.allclose(place(index), centre(*index), rtol=0, atol=tolerance), f"{what}: place of {index}")


CASES = [("uint8", 1, 0), ("int8", 1, 0), ("int16", 1, -1000), ("uint16", 1, -1024), ("int16", 0.25, 3),
         ("float32", 1, 0), ("uint16", 2, 0)]


def check_nifti():
    import nibabel
    for dtype, slope, intercept in CASES:
        for name, more, tolerance in (("v.nii", (), 1e-5), ("v.nii.gz", (), 1e-5),
                                      ("v.nii", ("--format", "nifti2"), 1e-9)):
            stored, physical = export(name, dtype, slope, intercept, *more)
            image = nibabel.load(name)
            what = f"{name} {dtype} {slope} {more}"
            expect((np.asarray(image.dataobj.get_unscaled()).T == stored).all(), what + ": stored values")
            expect(np.allclose(image.get_fdata().T, physical, rtol=1e-6), what + ": values")
            ras = np.diag([-1, -1, 1, 1])
            for affine in (image.get_sform(), image.get_qform()):
                expect_place(lambda i, a=affine: (ras @ a @ np.array([*i, 1]))[:3], tolerance, what)
            expect(image.header.get_xyzt_units()[0] == "mm", what + ": unit")


def check_tiff():
    import tifffile
    for dtype, slope, intercept in CASES:
        for more in ((), ("--compress",)):
            stored, physical = export("v.tif", dtype, slope, intercept, *more)
            with tifffile.TiffFile("v.tif") as file:
                data, said = file.asarray(), file.imagej_metadata
                tags = file.pages[0].tags
                pixels = [tags[name].value[1] / tags[name].value[0] for name in ("XResolution", "YResolution")]
            what = f"tiff {dtype} {slope} {more}"
            value = data.astype(np.float64) * said.get("c1", 1) + said.get("c0", 0)
            expect(np.allclose(value, physical, rtol=1e-7, atol=0), what + ": values")
            if data.dtype == stored.dtype and slope == 1 and intercept == 0:
                expect((data == stored).all(), what + ": stored values")
            expect(np.allclose([*pixels, said["spacing"]], SPACING, rtol=1e-9), what + ": spacing")
            expect(said["unit"] == "mm" and said["slices"] == len(data), what + ": unit, slices")


def check_vti():
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    for dtype, slope, intercept in CASES:
        for more in ((), ("--compress",)):
            _, physical = export("v.vti", dtype, slope, intercept, *more)
            reader = vtk.vtkXMLImageDataReader()
            reader.SetFileName("v.vti")
            reader.Update()
            image = reader.GetOutput()
            data = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(physical.shape)
            what = f"vti {dtype} {slope} {more}"
            expect((data == physical.astype(data.dtype)).all(), what + ": values")

            def place(index, image=image):
                point = [0.0, 0.0, 0.0]
                image.TransformContinuousIndexToPhysicalPoint(*map(float, index), point)
                return point
            expect_place(place, 1e-9, what)


def check_vdb():
    import pyopenvdb
    for dtype, slope, intercept in CASES:
        for more in ((), ("--compress",)):
            _, physical = export("v.vdb", dtype, slope, intercept, *more)
            grid = pyopenvdb.read("v.vdb", "density")
            data = np.zeros(physical.shape[::-1], np.float32)
            grid.copyToArray(data)
            what = f"vdb {dtype} {slope} {more}"
            expect((data.T == physical.astype(np.float32)).all(), what + ": values")
            expect(grid.background == np.float32(physical.min()), what + ": background")
            expect(grid.activeVoxelCount() == (physical.astype(np.float32) != np.float32(physical.min())).sum(),
                   what + ": active voxels")
            expect_place(grid.transform.indexToWorld, 1e-9, what)
    export("v.vdb", "uint8", 1, 0, "--format", "vdb-half")
    expect(pyopenvdb.read("v.vdb", "density").saveFloatAsHalf, "vdb: halves")


formats = subprocess.run([tessera, "export", "--help"], check=True, capture_output=True, text=True).stdout
checked = 0
for name, package, check in (("nifti", "python3-nibabel", check_nifti), ("tiff", "python3-tifffile", check_tiff),
                             ("vti", "python3-vtk9", check_vti), ("vdb", "python3-openvdb", check_vdb)):
    if name + " (" not in formats:
        print(f"{name}: skipped, this program does not write it")
        continue
    try:
        check()
    except ImportError as error:
        print(f"{name}: skipped, {package} is not installed ({error})")
        continue
    print(f"{name}: read back equal")
    checked += 1
sys.exit(0 if checked else 77)
