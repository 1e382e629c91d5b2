"""Volumes: tessera.open() and what it returns."""

from __future__ import annotations

import json
import operator
import os
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _tessera
from ._labels import affine_of, image_of, labels_file, unmasked
from ._tessera import InputError
from ._words import Path, Progress, absolute, arguments_of, number, ram_text, refuse_unknown, told, whole_number, words_of

if TYPE_CHECKING:
    from ._words import Array, Numbers


def by_slabs(values: Array, dtype: "np.dtype[Any]", of_slab: Callable[[Array], Array]) -> Array:
    """A function of the values of an array [z, y, x], some slices at a time: so that Ctrl-C need not wait for all."""
    out = np.empty(values.shape, dtype)
    slices = max(1, 2**24 // max(1, values[0].size))
    for first in range(0, len(values), slices):
        out[first : first + slices] = of_slab(values[first : first + slices])
    return out


@dataclass(frozen=True)
class Label:
    """A label of a segmentation; colour: sRGB in [0, 1], None where its file has none."""

    value: int
    name: str
    group: str = ""
    colour: Optional[Tuple[float, float, float]] = None


class LabelMap:
    """A segmentation on a volume's lattice. Labels may overlap: `sets` has the number of a set for every voxel,
    [z, y, x], and `labels_of_sets` the labels of every set."""

    def __init__(self, found: Dict[str, Any], affine: Array) -> None:
        #: 4 x 4: patient space (LPS, mm) from the index (x, y, z) of a voxel, its centre
        self.affine = affine
        self.labels: Tuple[Label, ...] = tuple(Label(**one) for one in found["labels"])
        self.sets: Array = found["sets"]
        self.labels_of_sets: Tuple[Tuple[Label, ...], ...] = tuple(
            tuple(self.labels[n] for n in of_set) for of_set in found["of_sets"]
        )
        self.notes: Tuple[str, ...] = tuple(found["notes"])

    @property
    def overlaps(self) -> bool:
        """True if a voxel has several labels."""
        return any(len(of_set) > 1 for of_set in self.labels_of_sets)

    @property
    def values(self) -> Array:
        """The label of every voxel by its value, 0 for none. Raises InputError where labels overlap."""
        if self.overlaps:
            raise InputError("values: expected labels that do not overlap, found some that do; mask() has each")
        most = max((label.value for label in self.labels), default=0)
        numbers = [of_set[0].value if of_set else 0 for of_set in self.labels_of_sets]
        return by_slabs(self.sets, np.min_scalar_type(most), np.array(numbers, dtype=np.min_scalar_type(most)).__getitem__)

    def mask(self, label: Union[str, int, Label]) -> Array:
        """The voxels of a label, by its name or value: bool [z, y, x]."""
        key = label.value if isinstance(label, Label) else label
        chosen = [one for one in self.labels if key in (one.name, one.value)]
        if not chosen:
            names = ", ".join(one.name for one in self.labels[:20])
            raise InputError(f"label: expected a name or value of {names}, found {label!r}")
        is_in = np.array([any(one in of_set for one in chosen) for of_set in self.labels_of_sets])
        return by_slabs(self.sets, np.dtype(bool), is_in.__getitem__)

    def __repr__(self) -> str:
        z, y, x = self.sets.shape
        return f"<tessera.LabelMap of {len(self.labels)} labels, {z} x {y} x {x} (z, y, x)>"


@dataclass(frozen=True)
class Body:
    """The box of the patient in a CT: corners in patient space, mm; litres of body, and of what is none."""

    low: Tuple[float, float, float]
    high: Tuple[float, float, float]
    litres: float
    litres_left_out: float


@dataclass(frozen=True, eq=False)
class Table:
    """The table under a patient. mask: uint8 [z, y, x] of samples of `level`, 0 shown to 255 hidden; None, and the
    reason in `why`, where it is not sure that something is a table."""

    litres: float
    why: str
    mask: Optional[Array]
    level: Optional[int]


@dataclass(frozen=True, eq=False)
class Surface:
    """The closed surface of a value: points float64 [n, 3] in patient space (LPS), mm; triangles uint32 [m, 3] of their
    numbers, which turn to the left seen from outside. Millilitres that it encloses, and its area."""

    points: Array
    triangles: Array
    volume_ml: float
    area_cm2: float


class Volume:
    """A volume that was opened: its levels of detail, read when they are asked for.

    Axes of arrays are [z, y, x]. Along x, y and z the volume runs towards the patient's left, back and head, as
    nearly as whole axes can; `affine` says exactly how. It is an os.PathLike of its store.
    """

    def __init__(self, opened: _tessera.Volume) -> None:
        self._opened = opened
        self._facts: Dict[str, Any] = opened.facts()
        self._hash: Optional[str] = None
        self._given_unit = ""  # that its source does not say
        self._array: Optional[Tuple[Tuple[int, ...], Array]] = None  # shape and affine of what it was opened from

    @property
    def path(self) -> str:
        """Of its store; a temporary one for an array."""
        return os.fsdecode(self._opened.path)

    def __fspath__(self) -> str:
        return os.fsdecode(self._opened.path)

    @property
    def shape(self) -> Tuple[int, int, int]:
        """Voxels along z, y and x."""
        return self.levels[0]

    @property
    def ndim(self) -> int:
        return 3

    @property
    def size(self) -> int:
        """Number of voxels."""
        z, y, x = self.shape
        return z * y * x

    @property
    def levels(self) -> Tuple[Tuple[int, int, int], ...]:
        """Shapes of the levels of detail, finest first: each has half of the one before along every axis."""
        return tuple((z, y, x) for z, y, x in self._facts["shapes"])

    @property
    def dtype(self) -> "np.dtype[Any]":
        """Of the arrays that reading gives: stored numbers if they are the values, else float32."""
        is_value = self.slope == 1 and self.intercept == 0
        return np.dtype(self._facts["type"]) if is_value else np.dtype(np.float32)

    @property
    def type(self) -> str:
        """Of the stored numbers: "uint8", "int16", "uint16" or "float32"."""
        return str(self._facts["type"])

    @property
    def slope(self) -> float:
        """value = slope * stored number + intercept"""
        return float(self._facts["slope"])

    @property
    def intercept(self) -> float:
        return float(self._facts["intercept"])

    @property
    def unit(self) -> str:
        """Of the values: "HU" for CT, "SUVbw"; "" unknown."""
        return str(self._facts["unit"])

    @property
    def modality(self) -> str:
        """As DICOM has it: "CT", "MR"; "" unknown."""
        return str(self._facts["modality"])

    @property
    def affine(self) -> Array:
        """4 x 4: patient space (LPS, mm) from the index (x, y, z) of a voxel, its centre."""
        return np.array(self._facts["affine"]).reshape(4, 4)

    @property
    def spacing(self) -> Tuple[float, float, float]:
        """Millimetres between voxels along x, y and z."""
        x, y, z = np.linalg.norm(self.affine[:3, :3], axis=0).tolist()
        return x, y, z

    @property
    def origin(self) -> Tuple[float, float, float]:
        """Centre of the first voxel, patient space, mm."""
        x, y, z = self.affine[:3, 3].tolist()
        return x, y, z

    @property
    def direction(self) -> Array:
        """3 x 3: directions of x, y and z in patient space, as columns."""
        return np.asarray(self.affine[:3, :3] / np.array(self.spacing))

    @property
    def range(self) -> Tuple[float, float]:
        """Least and greatest value."""
        low, high = self._facts["range"]
        return min(low, high), max(low, high)

    @property
    def remarks(self) -> Tuple[str, ...]:
        """Irregularities of the source that were accepted."""
        return tuple(self._facts["remarks"])

    @property
    def notes(self) -> Tuple[str, ...]:
        """What opening had to say."""
        return tuple(self._opened.notes)

    @property
    def content_hash(self) -> str:
        """Identity of the content, as manifests of pictures have it."""
        if self._hash is None:
            self._hash = self._opened.content_hash()
        return self._hash

    def histogram(self) -> Tuple[Array, Array]:
        """Counts of all voxels in 64 equal bins, and the 65 values at their edges, as numpy.histogram has them."""
        counts, edges = self._opened.histogram()
        step = -1 if self.slope < 0 else 1  # values ascend
        return np.array(counts, dtype=np.uint64)[::step], np.array(edges)[::step]

    def level(self, level: int, *, stored: bool = False, progress: Progress = None) -> Array:
        """A whole level of detail as an array; 0 is the finest. The array's memory is the caller's.

        stored: numbers as they are stored, not values.
        """
        return self.read(None, level, stored=stored, progress=progress)

    def read(
        self,
        box: Optional[Sequence[Tuple[int, int]]] = None,
        level: int = 0,
        *,
        stored: bool = False,
        progress: Progress = None,
    ) -> Array:
        """A box of a level: ((z0, z1), (y0, y1), (x0, x1)), half open, in samples of that level; None: all of it.

        Values in their unit, or with `stored` numbers as they are stored. Only what the box needs is decoded.
        """
        level = whole_number(level, "level", 0, len(self.levels) - 1)
        if box is None:
            box = [(0, extent) for extent in self.levels[level]]
        try:
            ranges = [(operator.index(low), operator.index(high)) for low, high in box]
            (z0, z1), (y0, y1), (x0, x1) = ranges
        except (TypeError, ValueError):
            raise InputError("box: expected ((z0, z1), (y0, y1), (x0, x1)), found " + repr(box)[:80]) from None
        for axis, (low, high), extent in zip("zyx", ranges, self.levels[level]):
            if not 0 <= low < high <= extent:
                raise InputError(f"box: expected a range within 0 to {extent} along {axis}, found {low} to {high}")
        return self._opened.read(level, (x0, y0, z0), (x1, y1, z1), stored, told(progress))

    def labels(
        self,
        path: Any,
        *,
        same_frame: bool = False,
        level: int = 0,
        ram: Union[str, int, None] = None,
        progress: Progress = None,
    ) -> LabelMap:
        """A segmentation of this volume on its lattice: a file or folder that --labels takes, or an array of bool or
        whole numbers of the volume's shape, imported to the cache.

        level: of detail; coarser ones by majority. same_frame: though the frames of reference differ.
        """
        with labels_file(path, lambda: self) as file:
            found = _tessera.labels(
                self._opened, os.fsencode(file or ""), same_frame, level, ram_text(ram), told(progress)
            )
        affine = self.affine
        affine[:3, 3] += affine[:3, :3] @ np.full(3, (2**level - 1) / 2)  # a coarse voxel's centre is that of all its own
        affine[:3, :3] *= 2**level
        return LabelMap(found, affine)

    def surface(self, value: float, *, level: int = 0, progress: Progress = None) -> Surface:
        """The surface of a value as triangles, as `tessera mesh` finds it. Its arrays are the caller's memory; a coarser
        level has fewer triangles. Empty arrays where the volume has no such value."""
        return Surface(**_tessera.surface(self._opened, number(value, "value"), level, told(progress)))

    def body(self) -> Body:
        """The box of the patient in a CT, without the table. Raises InputError for values without HU, and none."""
        return Body(**_tessera.body(self._opened))

    def table(self) -> Table:
        """The table under the patient in a CT, as pictures leave it out."""
        return Table(**_tessera.table(self._opened))

    def __getitem__(self, index: Any) -> Array:
        """volume[z, y, x] of level 0 by numbers and slices, as arrays have it. Only the box around is decoded."""
        if not isinstance(index, tuple):
            index = (index,)
        for one in index:
            if one is not Ellipsis and (isinstance(one, (bool, np.bool_)) or not hasattr(one, "__index__")):
                if not isinstance(one, slice):
                    raise IndexError(f"index: expected numbers and slices, found {type(one).__name__}")
            elif isinstance(one, np.ndarray) and (one.ndim or one.dtype.kind not in "iu"):
                raise IndexError("index: expected numbers and slices, found an array (numpy.asarray(volume) takes it)")
        dots = [at for at, one in enumerate(index) if one is Ellipsis]
        if len(dots) > 1:
            raise IndexError("index: expected one ellipsis at most, found several")
        if dots:
            index = index[: dots[0]] + (slice(None),) * (4 - len(index)) + index[dots[0] + 1 :]
        if len(index) > 3:
            raise IndexError("a volume has three axes")
        index += (slice(None),) * (3 - len(index))
        box: List[Tuple[int, int]] = []
        rest: List[Any] = []
        for one, extent in zip(index, self.shape):
            if isinstance(one, slice):
                start, stop, step = one.indices(extent)
                places = range(start, stop, step)
                low, high = (min(places), max(places) + 1) if len(places) else (0, 1)
                first = places[0] - low if len(places) else 0
                ends = None if step < 0 else high - low
                box.append((low, high))
                rest.append(slice(first, ends, step) if len(places) else slice(0, 0))
            else:
                at = one.__index__()
                if not -extent <= at < extent:
                    raise IndexError(f"index {at} is out of bounds for {extent} voxels")
                at %= extent
                box.append((at, at + 1))
                rest.append(0)
        values: Array = self.read(box)[tuple(rest)]
        return values

    def __array__(self, dtype: Any = None, copy: Any = None) -> Array:
        if copy is False:
            raise ValueError("a volume is on disk: its array is always a copy")
        values = self.level(0)
        if dtype is None or values.dtype == dtype:
            return values
        return by_slabs(values, np.dtype(dtype), lambda slab: slab)

    def __len__(self) -> int:
        return self.shape[0]

    def __copy__(self) -> "Volume":
        return self  # nothing in it changes, and its temporary store has one owner

    def __deepcopy__(self, memo: Any) -> "Volume":
        return self

    def __reduce__(self) -> Any:
        """Another process opens the same store, which stays as long as this volume does."""
        return _reopened, (self.path, self._given_unit)

    def __repr__(self) -> str:
        z, y, x = self.shape
        mm = " x ".join(f"{length:.4g}" for length in self.spacing)
        low, high = self.range
        unit = f" {self.unit}" if self.unit else ""
        kind = f"{self.modality}, " if self.modality else ""
        return f"<tessera.Volume {kind}{z} x {y} x {x} (z, y, x), {self.type}, {low:g} to {high:g}{unit}, {mm} mm (x, y, z)>"


def _affine_of(spacing: Any, origin: Any, direction: Any, affine: Any) -> Tuple[Array, bool]:
    """The affine of an array, and whether its orientation was given."""

    def numbers(value: Any, shape: Tuple[int, ...], name: str) -> Array:
        try:
            out = np.array(value, dtype=np.float64).reshape(shape)
        except (TypeError, ValueError):
            words = " x ".join(str(n) for n in shape)
            raise InputError(f"{name}: expected {words} numbers, found {str(value)[:80]}") from None
        return out

    if affine is not None:
        if spacing is not None or origin is not None or direction is not None:
            raise InputError("affine: expected no spacing, origin and direction with it, found some")
        return affine_of(affine), True
    whole = np.eye(4)
    axes = np.eye(3) if direction is None else numbers(direction, (3, 3), "direction")
    lengths = np.linalg.norm(axes, axis=0)
    if not np.all(np.abs(lengths - 1) < 1e-3):
        raise InputError(f"direction: expected columns of length 1, found lengths {lengths.tolist()}")
    millimetres = np.ones(3) if spacing is None else numbers(spacing, (3,), "spacing")
    if not np.all(millimetres > 0):
        raise InputError(f"spacing: expected lengths above 0, found {millimetres.tolist()} (`direction` turns axes)")
    whole[:3, :3] = axes * millimetres
    if origin is not None:
        whole[:3, 3] = numbers(origin, (3,), "origin")
    return whole, direction is not None


def _arguments_of_open() -> List[str]:
    own = ["spacing", "origin", "direction", "affine", "unit", "slope", "intercept", "ram", "progress"]
    return own + arguments_of(_tessera.options_of_open())


def open(  # noqa: A001
    source: Any,
    *,
    spacing: Optional[Numbers] = None,
    origin: Optional[Numbers] = None,
    direction: Any = None,
    affine: Any = None,
    unit: str = "",
    slope: float = 1.0,
    intercept: float = 0.0,
    ram: Union[str, int, None] = None,
    progress: Progress = None,
    **options: Any,
) -> Volume:
    """Opens a path, an address, an array, or an image of SimpleITK or nibabel as a volume.

    A path is what the command line takes: a store, a DICOM folder, a file of a volume, a stack of pictures; or an
    address. Source files are imported once, to the cache. `options` are those of the command line that choose
    among them: series, phase, largest, resample_z, allow_missing, spacing, file_level, file_box.

    An array has axes [z, y, x] and real numbers of any layout. Its values are read where they lie, slab by slab,
    to a temporary store (in TMPDIR) that is removed with the volume; the array may change afterwards. NaN and
    infinite values become the lowest value. `spacing` and `origin` are in mm, x, y, z; `direction` has the
    directions of x, y, z as columns, as SimpleITK has it; `affine` takes (x, y, z) indices of voxels to patient
    space (LPS), in place of all three. value = slope * number + intercept, in `unit` ("HU" for CT). An image of SimpleITK or nibabel says its place itself. A path may be given the `unit` that its files do not say.

    ram: budget, such as "512MiB". progress: called with a stage and a share from 0 to 1; it may raise, or return
    False, to stop. Raises InputError for what cannot be opened.
    """
    refuse_unknown(options, _arguments_of_open(), "tessera.open()")
    if isinstance(source, Volume):
        given = dict(options, spacing=spacing, origin=origin, direction=direction, affine=affine)
        given.update(unit=unit or None, slope=None if slope == 1 else slope, intercept=intercept or None)
        for name, value in given.items():
            if value is not None:
                raise InputError(f"{name}: expected for an array or a path, found for a volume that is open")
        return source
    if not isinstance(unit, str) or not (unit.isascii() and unit.isprintable()):
        raise InputError(f"unit: expected text of printable ASCII characters, found {unit!r}")
    if isinstance(source, (str, bytes, os.PathLike)):
        for name, value in (("origin", origin), ("direction", direction), ("affine", affine)):
            if value is not None:
                raise InputError(f"{name}: expected for an array, found for a path, which says it itself")
        if slope != 1.0 or intercept != 0.0:
            raise InputError("slope, intercept: expected for an array, found for a path, which says them itself")
        words = words_of({**options, "spacing": None if spacing is None else tuple(spacing)})
        raw = [os.fsencode(word) for word in words]
        opened = Volume(_tessera.open_path(os.fsencode(source), raw, unit, ram_text(ram), told(progress)))
        opened._given_unit = unit
        return opened
    if options:
        raise InputError(f"{next(iter(options))}: expected for a path, found for an array")
    image = image_of(source)
    if image is not None:
        for name, value in (("spacing", spacing), ("origin", origin), ("direction", direction), ("affine", affine)):
            if value is not None:
                raise InputError(f"{name}: expected for an array, found for an image, which says it itself")
        source, affine = image
    source = unmasked(source, "array")
    if source is None or isinstance(source, (int, float, complex)):
        raise InputError(f"source: expected a path, an array or an image, found {type(source).__name__}")
    array = np.asarray(source)
    whole, oriented = _affine_of(spacing, origin, direction, affine)
    opened = Volume(
        _tessera.open_array(
            array,
            whole.ravel().tolist(),
            oriented,
            unit,
            number(slope, "slope"),
            number(intercept, "intercept"),
            ram_text(ram),
            told(progress),
        )
    )
    opened._array = array.shape, whole
    return opened


def _reopened(path: str, unit: str) -> Volume:
    return open(path, unit=unit)


def phases(source: Union[str, "os.PathLike[str]"], **options: Any) -> List[str]:
    """Labels of the phases (times) of source files, in the order of `phase`, which counts from 1; empty: there is one.

    `options` choose among several volumes, as for `open`: series, largest. Headers alone are read.
    """
    refuse_unknown(options, arguments_of(_tessera.options_of_open()), "tessera.phases()")
    return _tessera.phases(os.fsencode(source), [os.fsencode(word) for word in words_of(options)])


def phantom(
    name: str = "torso",
    size: Sequence[int] = (128, 96, 150),
    *,
    ram: Union[str, int, None] = None,
    progress: Progress = None,
) -> Volume:
    """A volume by a formula, for examples and tests: torso, sphere, marschner-lobb, ramp, checkerboard, ...

    size: voxels along x, y and z. It lies in a temporary store that is removed with it.
    """
    try:
        x, y, z = (whole_number(n, "size", 1, 2**31 - 1) for n in size)
    except InputError:
        raise
    except (TypeError, ValueError):
        raise InputError(f"size: expected voxels along x, y and z, found {str(size)[:80]}") from None
    return Volume(_tessera.open_phantom(str(name), (x, y, z), ram_text(ram), told(progress)))


def as_json(value: Any) -> str:
    """A value of a scene as JSON text: paths and volumes as absolute paths, numbers and arrays of numpy."""

    def other(one: Any) -> Any:
        if hasattr(one, "__fspath__"):
            return absolute(one)
        if hasattr(one, "tolist"):
            return one.tolist()
        raise TypeError(f"{type(one).__name__} has no JSON")

    try:
        return json.dumps(value, default=other, allow_nan=False)
    except (TypeError, ValueError) as problem:
        raise InputError(f"scene: expected values that JSON has, found {problem}") from None
