"""Labels as arrays on a volume's lattice, for what takes files of labels."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from typing import TYPE_CHECKING, Any, Iterator, Optional, Sequence, Tuple

import numpy as np

from ._tessera import Error, InputError
from ._words import absolute

if TYPE_CHECKING:
    from ._words import Array

_MOST = 65535


def image_of(source: Any) -> Optional[Tuple[Any, Array]]:
    """Numbers [z, y, x] and affine (LPS) of an image of SimpleITK or nibabel; None for anything else."""
    if hasattr(source, "dataobj") and hasattr(source, "affine"):  # nibabel: [x, y, z], RAS
        numbers = np.asanyarray(source.dataobj)
        return numbers.T, np.diag([-1.0, -1.0, 1.0, 1.0]) @ np.asarray(source.affine, dtype=np.float64)
    if all(hasattr(source, name) for name in ("GetSpacing", "GetOrigin", "GetDirection")) and "SimpleITK" in sys.modules:
        if len(source.GetSpacing()) != 3:
            raise InputError(f"image: expected three axes, found {len(source.GetSpacing())}")
        whole = np.eye(4)
        whole[:3, :3] = np.reshape(source.GetDirection(), (3, 3)) * source.GetSpacing()
        whole[:3, 3] = source.GetOrigin()
        return sys.modules["SimpleITK"].GetArrayViewFromImage(source), whole
    return None


def affine_of(value: Any) -> Array:
    """4 x 4 numbers, the last row 0, 0, 0, 1."""
    try:
        whole = np.array(value, dtype=np.float64).reshape(4, 4)
    except (TypeError, ValueError):
        raise InputError(f"affine: expected 4 x 4 numbers, found {str(value)[:80]}") from None
    if list(whole[3]) != [0, 0, 0, 1]:
        raise InputError(f"affine: expected a last row of 0, 0, 0, 1, found {whole[3].tolist()}")
    return whole


def unmasked(array: Any, name: str) -> Any:
    """The array, of which nothing is masked."""
    if isinstance(array, np.ma.MaskedArray):
        if bool(np.any(array.mask)):
            raise InputError(f"{name}: expected an array without masked values (numpy.ma.filled gives it), found some")
        return array.data
    return array


@contextlib.contextmanager
def named(name: str, word: str) -> Iterator[str]:
    """A file of its own, which messages call by a word."""
    try:
        yield name
    except (InputError, Error) as problem:
        raise type(problem)(str(problem).replace(name, word)) from None


def _segments(labels: Sequence[Any]) -> str:
    """Names and colours as 3D Slicer has them."""
    text = ""
    for n, label in enumerate(labels):
        name = " ".join(label.name.split())
        text += f"Segment{n}_ID:=s{n}\nSegment{n}_Name:={name}\nSegment{n}_LabelValue:={label.value}\nSegment{n}_Layer:=0\n"
        if label.colour is not None:
            text += f"Segment{n}_Color:={' '.join(repr(float(one)) for one in label.colour)}\n"
    return text


def _header(shape: Tuple[int, ...], affine: Array, kind: str, labels: Sequence[Any]) -> bytes:
    columns = ["(" + ",".join(repr(float(number)) for number in column) + ")" for column in affine[:3].T]
    z, y, x = shape
    text = (
        f"NRRD0005\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\nsizes: {x} {y} {z}\nendian: little\n"
        f"space directions: {' '.join(columns[:3])}\nspace origin: {columns[3]}\nencoding: raw\n{_segments(labels)}\n"
    )
    return text.encode()


def _placed(labels: Any, scan: Any) -> Tuple[Any, Array]:
    """Labels [z, y, x] and their affine."""
    image = image_of(labels)
    if image is not None:
        return image
    if isinstance(labels, tuple) and len(labels) == 2 and np.shape(labels[1]) == (4, 4):
        return labels[0], affine_of(labels[1])
    if hasattr(labels, "labels_of_sets"):  # a LabelMap
        return labels.values, labels.affine
    shape, affine = scan._array or (scan.shape, scan.affine)
    is_turned = not np.allclose(affine, scan.affine, rtol=0, atol=1e-6)
    try:
        own = np.shape(labels)
    except ValueError:
        raise InputError("labels: expected rows of one length, or (array, affine) with 4 x 4 numbers, found others") from None
    if own == shape == scan.shape and is_turned:
        raise InputError(
            "labels: expected (array, affine), because the volume's voxels are in another order than those of the array that"
            " it was opened from: with that array's affine, or with volume.affine for the order of numpy.asarray(volume)"
        )
    if own == scan.shape:
        return labels, scan.affine
    if own == shape:
        return labels, affine
    raise InputError(
        f"labels: expected a file, a folder, an image, (array, affine), or bool or whole numbers [z, y, x] of the volume's"
        f" shape {list(scan.shape)}, found {np.asarray(labels).dtype} {list(own)}"
    )


@contextlib.contextmanager
def labels_file(labels: Any, volume: Any) -> Iterator[Optional[str]]:
    """A path that --labels takes: paths as they are; else a file that goes with the block: of an image of SimpleITK or
    nibabel, of a LabelMap, of (array, affine), or of an array [z, y, x] of the volume's shape.
    volume(): the Volume; called for what is no path."""
    if labels is None or isinstance(labels, (str, bytes, os.PathLike)):
        yield None if labels is None else absolute(labels)
        return
    placed, affine = _placed(labels, volume())
    array = np.asarray(unmasked(placed, "labels"))
    if array.dtype.kind == "f" and image_of(labels) is not None and np.all(array == np.round(array)):
        array = array.astype(np.int64)  # numbers of a scaled image
    if array.ndim != 3 or array.dtype.kind not in "bui" or not array.size:
        raise InputError(f"labels: expected bool or whole numbers [z, y, x], found {array.dtype} {list(array.shape)}")
    if array.min() < 0 or array.max() > _MOST:
        raise InputError(f"labels: expected values from 0 to {_MOST}, found {array.min()} to {array.max()}")
    small = array.max() < 256
    with tempfile.TemporaryDirectory(prefix="tessera-labels-") as folder:
        name = os.path.join(folder, "labels.nrrd")
        with open(name, "wb") as file:
            file.write(_header(array.shape, affine, "uint8" if small else "uint16", getattr(labels, "labels", ())))
            for plane in array:  # one at a time in memory
                file.write(plane.astype("<u1" if small else "<u2", order="C").tobytes())
        with named(name, "labels"):
            yield name
