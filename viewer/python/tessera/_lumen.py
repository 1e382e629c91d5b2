"""Centre-lines of hollow organs: colon, airways, aorta; and the wall that a flight along one sees."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from . import _tessera
from ._labels import named
from ._tessera import InputError
from ._volume import Volume, open as open_volume
from ._words import Path, Progress, number, told, whole_number

if TYPE_CHECKING:
    from ._words import Array, Numbers


@dataclass(eq=False)
class Line:
    """A line of a centre-line: evenly spaced points, patient space, mm, and their distances to the wall."""

    points: Array
    radii: Array
    length: float
    parent: Optional[int] = None


@dataclass
class Centreline:
    """Centre-lines of a lumen; `path` is what the command line writes, and film() and coverage() take."""

    lines: List[Line]
    path: Dict[str, Any]
    about: str
    notes: List[str] = field(default_factory=list)

    @property
    def points(self) -> Array:
        """float64 [n, 3] of the first line: x, y, z, patient space, mm."""
        return self.lines[0].points

    @property
    def radii(self) -> Array:
        """float64 [n] of the first line: distances to the wall, mm."""
        return self.lines[0].radii

    @property
    def length(self) -> float:
        """Of all lines, mm."""
        return sum(line.length for line in self.lines)

    def save(self, path: Path) -> None:
        """Writes a path file, as `tessera centreline` does."""
        with open(path, "w", encoding="ascii") as file:
            json.dump(self.path, file)
            file.write("\n")

    def __repr__(self) -> str:
        return f"<tessera.Centreline of {len(self.lines)} line{'s' * (len(self.lines) != 1)}, {self.length:.4g} mm>"


@contextlib.contextmanager
def path_file(path: Any) -> Iterator[Optional[str]]:
    """A path as a file: that of a Centreline, of a dict or of points is made, and removed."""
    if path is None or isinstance(path, (str, os.PathLike)):
        yield None if path is None else os.fspath(path)
        return
    whole = path.path if isinstance(path, Centreline) else path
    with tempfile.TemporaryDirectory(prefix="tessera-path-") as folder:
        if isinstance(whole, dict):
            name = os.path.join(folder, "path.json")
            with open(name, "w", encoding="ascii") as file:
                json.dump(whole, file)
        else:
            name = os.path.join(folder, "points.csv")
            _write_points(whole, name)
        with named(name, "path"):
            yield name


def _write_points(points: Any, name: str) -> None:
    """Points in their order, a row each: x, y, z, and a radius where there is one."""
    try:
        rows = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        rows = np.empty(0)
    if rows.ndim != 2 or rows.shape[1] not in (3, 4) or not np.all(np.isfinite(rows)):
        raise InputError(
            "path: expected a Centreline, its dict or file, or points as rows of x, y, z (patient space, mm) and perhaps "
            f"a radius, found {str(points)[:80]}"
        )
    with open(name, "w", encoding="ascii") as file:
        file.write("x,y,z,radius\n" if rows.shape[1] == 4 else "x,y,z\n")
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows.tolist())


def _point(value: Any, name: str) -> Tuple[float, float, float]:
    try:
        x, y, z = (float(one) for one in value)
    except (TypeError, ValueError):
        raise InputError(f"{name}: expected a point (x, y, z), patient space, mm, found {str(value)[:80]}") from None
    if not np.all(np.abs((x, y, z)) <= 1e7):
        raise InputError(f"{name}: expected a point (x, y, z), patient space, mm, found {(x, y, z)}")
    return x, y, z


def centreline(
    volume: Any,
    start: Numbers,
    end: Optional[Numbers] = None,
    *,
    through: Sequence[Numbers] = (),
    threshold: Optional[float] = None,
    may_leak: bool = False,
    tree: bool = False,
    generations: int = 12,
    spacing: float = 1.0,
    progress: Progress = None,
) -> Centreline:
    """Finds the centre-line of a hollow organ.

    start, end, through: points in the lumen, patient space (LPS), mm. Without an end, to the point of the lumen that
    is furthest from the start. tree: all branches beyond the start. threshold: value at which the lumen ends; by
    default from the values around the start. spacing: of the points, mm, at most. Raises InputError naming a point
    that is no place in a lumen.
    """
    if tree and (end is not None or len(through)):
        raise InputError("tree: expected a start alone, the tree's root, found an end or points to pass through")
    if len(through) and end is None:
        raise InputError("through: expected an end as well, found none")
    if may_leak and threshold is None:
        raise InputError("may_leak: expected a threshold with it, which it keeps, found none")
    spacing = number(spacing, "spacing")
    if not 0.05 <= spacing <= 100:
        raise InputError(f"spacing: expected mm from 0.05 to 100, found {spacing}")
    generations = whole_number(generations, "generations", 0, 2**31 - 1)
    opened = open_volume(volume)
    found = _tessera.centreline(
        opened._opened,
        _point(start, "start"),
        None if end is None else _point(end, "end"),
        [_point(point, "through") for point in through],
        None if threshold is None else number(threshold, "threshold"),
        may_leak,
        tree,
        generations,
        spacing,
        told(progress),
    )
    lines = [Line(one["points"], one["radii"], one["length"], one["parent"]) for one in found["lines"]]
    return Centreline(lines, json.loads(found["path"]), found["about"], found["notes"])


@dataclass
class Coverage:
    """The share of a lumen's wall that a flight sees, and the patches that it does not see, largest first."""

    share: float
    wall_mm2: float
    seen_mm2: float
    patches: List[Dict[str, Any]]


def coverage(
    volume: Any,
    path: Any,
    *,
    size: Tuple[int, int] = (640, 480),
    view_angle: Optional[float] = None,
    every: float = 1.0,
    backwards: bool = False,
    both_ways: bool = False,
    farthest: Optional[float] = None,
    smallest: float = 25.0,
    progress: Progress = None,
) -> Coverage:
    """Measures what share of an organ's wall a flight along a centre-line sees.

    path: a Centreline, its dict or its file, made in this volume. size: of the pictures; only its aspect ratio
    matters. every: mm between pictures. farthest: mm from the eye beyond which wall is not seen. smallest: mm2 of
    the smallest unseen patch that is listed.
    """
    try:
        width, height = (whole_number(n, "size", 1, 32768) for n in size)
    except InputError:
        raise
    except (TypeError, ValueError):
        raise InputError(f"size: expected width and height, found {str(size)[:80]}") from None
    for name, value, low, high in (
        ("view_angle", view_angle, 1, 170),
        ("every", every, 0.05, 1000),
        ("farthest", farthest, 0.1, 1e6),
        ("smallest", smallest, 0, 1e9),
    ):
        if value is not None and not low <= number(value, name) <= high:
            raise InputError(f"{name}: expected {low} to {high}, found {value}")
    where = "path"
    if isinstance(path, (str, os.PathLike)):
        where = os.fspath(path)
        try:
            with open(where, encoding="utf-8") as file:
                text = file.read()
        except (OSError, UnicodeDecodeError) as problem:
            raise InputError(f"{where}: expected a path file, found {problem}") from None
    else:
        whole = path.path if isinstance(path, Centreline) else path
        if not isinstance(whole, dict):
            raise InputError(
                f"path: expected a Centreline, its dict or its file, which has the lumen, found {type(whole).__name__}"
            )
        text = json.dumps(whole)
    found = _tessera.coverage(
        open_volume(volume)._opened,
        text,
        where,
        width / height,
        0.0 if view_angle is None else float(view_angle),
        float(every),
        backwards,
        both_ways,
        0.0 if farthest is None else float(farthest),
        float(smallest),
        told(progress),
    )
    return Coverage(**found)
