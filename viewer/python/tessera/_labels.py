"""Labels as arrays on a volume's lattice, for what takes files of labels."""

from __future__ import annotations

import contextlib
import os
import tempfile
from typing import Any, Iterator, Optional

import numpy as np

from ._tessera import InputError
from ._words import absolute

_MOST = 65535


def _header(volume: Any, kind: str) -> bytes:
    columns = ["(" + ",".join(repr(float(number)) for number in column) + ")" for column in volume.affine[:3].T]
    z, y, x = volume.shape
    text = (
        f"NRRD0005\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\nsizes: {x} {y} {z}\nendian: little\n"
        f"space directions: {' '.join(columns[:3])}\nspace origin: {columns[3]}\nencoding: raw\n\n"
    )
    return text.encode()


@contextlib.contextmanager
def labels_file(labels: Any, volume: Any) -> Iterator[Optional[str]]:
    """A path that --labels takes: paths as they are, of an array [z, y, x] of the volume's shape a file that goes with
    the block. volume(): the Volume; called for arrays alone."""
    if labels is None or isinstance(labels, (str, bytes, os.PathLike)):
        yield None if labels is None else absolute(labels)
        return
    array, scan = np.asarray(labels), volume()
    if array.shape != scan.shape or array.dtype.kind not in "bui":
        raise InputError(
            f"labels: expected a file, a folder, or bool or whole numbers [z, y, x] of the volume's shape"
            f" {list(scan.shape)}, found {array.dtype} {list(array.shape)}"
        )
    if array.min() < 0 or array.max() > _MOST:
        raise InputError(f"labels: expected values from 0 to {_MOST}, found {array.min()} to {array.max()}")
    small = array.max() < 256
    with tempfile.TemporaryDirectory(prefix="tessera-labels-") as folder:
        name = os.path.join(folder, "labels.nrrd")
        with open(name, "wb") as file:
            file.write(_header(scan, "uint8" if small else "uint16"))
            for plane in array:  # one at a time in memory
                file.write(plane.astype("<u1" if small else "<u2", order="C").tobytes())
        yield name
