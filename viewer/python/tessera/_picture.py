"""Pictures: tessera.render() and what it returns."""

from __future__ import annotations

import json
import os
import struct
import zlib
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, Optional, Tuple, Union

import numpy as np

from . import _tessera
from ._labels import labels_file
from ._scene import Scene
from ._tessera import InputError
from ._volume import Volume, as_json, open as open_volume
from ._words import Path, Progress, absolute, arguments_of, ram_text, refuse_unknown, told, words_of

if TYPE_CHECKING:
    from ._words import Array

# Options of the command line that neither a picture in memory nor a file has a use for.
_NOT_HERE = {
    "output": "Picture.save() and tessera.render_file() write files",
    "json": "Picture.manifest has it",
    "explain": "Picture.manifest has it",
    "ranks": "the command line draws by several processes",
    "help": "docs/python.md has it",
    "version": "tessera.__version__ has it",
    "quiet": "nothing is printed",
    "verbose": "nothing is printed",
}
# Those of files alone.
_OF_FILES = (
    "path turn frames fps speed seconds unfold may_leak straighten angle angles curved direction sections across"
    " tiles keep_state first panel columns gap fit_each panel_letters"
).split()


def png(pixels: Array) -> bytes:
    """A PNG file in memory of uint8 [y, x, 3] or [y, x, 4], sRGB: for sheets of several pictures."""
    pixels = np.asarray(pixels)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or 0 in pixels.shape:
        raise InputError(f"pixels: expected uint8 [y, x, 3] or [y, x, 4], found {pixels.dtype} {list(pixels.shape)}")
    height, width, channels = pixels.shape

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    def packed() -> Iterator[bytes]:
        """Some rows at a time: so that Ctrl-C need not wait for all."""
        packer = zlib.compressobj(4)
        at_once = max(1, 2**22 // (width * channels))
        for first in range(0, height, at_once):
            some = pixels[first : first + at_once]
            rows = np.zeros((len(some), 1 + width * channels), dtype=np.uint8)  # a 0 first: no filter
            rows[:, 1:] = some.reshape(len(some), -1)
            yield packer.compress(rows.tobytes())
        yield packer.flush()

    head = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"sRGB", b"\0")
        + chunk(b"IDAT", b"".join(packed()))
        + chunk(b"IEND", b"")
    )


class Picture:
    """A picture in memory, with what its file would hold.

    It is a numpy array for numpy: float32 [y, x, 4], linear light (Rec. 709 primaries), premultiplied by its alpha,
    the top row first, without its background and its annotations.
    """

    def __init__(self, drawn: _tessera.Picture) -> None:
        self._drawn = drawn
        self._manifest: Optional[Dict[str, Any]] = None

    @property
    def pixels(self) -> Array:
        """float32 [y, x, 4]: linear, premultiplied red, green and blue, and alpha; without a copy."""
        return self._drawn.pixels

    def __array__(self, dtype: Any = None, copy: Any = None) -> Array:
        if copy is False and dtype is not None and np.dtype(dtype) != np.float32:
            raise ValueError("pixels are float32: another type is a copy")
        return self.pixels.astype(dtype or np.float32, copy=bool(copy))

    @property
    def shape(self) -> Tuple[int, int]:
        """Height and width."""
        height, width, _ = self.pixels.shape
        return height, width

    @property
    def size(self) -> Tuple[int, int]:
        """Width and height."""
        return self.shape[1], self.shape[0]

    @property
    def background(self) -> Optional[Tuple[float, float, float]]:
        """Linear light that srgb() and files have behind the picture; None: transparent."""
        return self._drawn.background

    def srgb(self) -> Array:
        """uint8 [y, x, 3] on the background, with its annotations, as an 8-bit file has it; [y, x, 4] where it is
        transparent."""
        return self._drawn.srgb()

    @property
    def layers(self) -> Dict[str, Array]:
        """The layers that were asked for: albedo and normal [y, x, 3], depth [y, x] (mm), error [y, x, 4]."""
        return self._drawn.layers

    @property
    def manifest(self) -> Dict[str, Any]:
        """Everything that the picture was made from: scene, levels, engine, budgets, errors. No paths."""
        if self._manifest is None:
            self._manifest = json.loads(self._drawn.manifest)
        return self._manifest

    @property
    def errors(self) -> Any:
        """The manifest's "errors": estimated and measured errors."""
        return self.manifest["errors"]

    @property
    def scene(self) -> Dict[str, Any]:
        """The manifest's "scene", with the camera's position; volumes are named by their content."""
        scene: Dict[str, Any] = self.manifest["scene"]
        return scene

    @property
    def notes(self) -> List[str]:
        """Notes and warnings, as the command line prints them."""
        return self._drawn.notes

    def save(self, path: Path, *, ram: Union[str, int, None] = None) -> None:
        """Writes .png (8 bits), .tif (16 bits), .exr (float, with its layers), .pdf or .svg, with its annotations and
        its manifest."""
        self._drawn.save(os.fsencode(path), ram_text(ram))

    def __reduce__(self) -> Any:
        raise TypeError("a picture has no pickle: its pixels, srgb() and to_png() have one")

    def __copy__(self) -> "Picture":
        return self  # nothing in it changes

    def __deepcopy__(self, memo: Any) -> "Picture":
        return self

    def to_png(self) -> bytes:
        """A PNG file in memory, without the manifest."""
        return png(self.srgb())

    def _repr_png_(self) -> bytes:
        return self.to_png()

    def __repr__(self) -> str:
        width, height = self.size
        return f"<tessera.Picture {width} x {height}, {self.manifest['engine']}>"


def _split(options: Mapping[str, Any], is_file: bool = False) -> List[bytes]:
    """Options of the command line, and behind them keys of the scene, as words."""
    known = arguments_of(_tessera.options_of_render())
    own = [name for name in known if name not in _NOT_HERE and (is_file or name not in _OF_FILES)]
    keys = dict(options.get("set") or {})
    plain: Dict[str, Any] = {}
    for name, value in options.items():
        if name in _NOT_HERE:
            raise InputError(f"{name}: expected an option of pictures, found one that is not here: {_NOT_HERE[name]}")
        if name in _OF_FILES and not is_file:
            raise InputError(f"{name}: expected an option of a picture in memory, found one of tessera.render_file()")
        if "." in name or "[" in name:
            keys[name] = value
        elif name != "set":
            refuse_unknown([name], own + ["scene", "progress"], f"tessera.render{'_file' if is_file else ''}()")
            plain[name] = value
    words = words_of(plain) + [f"--set={key}={as_json(value)}" for key, value in keys.items()]
    return [os.fsencode(word) for word in words]


def _named(source: Any, scene: Any) -> Tuple[str, Optional[Scene], List[Any]]:
    """A path and no scene, or a name and a scene; and what must live as long."""
    kept: List[Any] = [source]
    if isinstance(source, Scene) or isinstance(source, Mapping):
        if scene is not None:
            raise InputError("scene: expected a volume before it, found a scene")
        return "scene", source if isinstance(source, Scene) else Scene(source), kept
    if not isinstance(source, (str, os.PathLike)):
        source = open_volume(source)
        kept.append(source)
    if scene is None:
        return absolute(source), None, kept
    copy = Scene(scene)
    copy["volumes[0].path"] = source
    return "scene", copy, kept


def _volume_of(kept: List[Any], scene: Optional[Scene]) -> Volume:
    """The volume of a picture's source."""
    source = kept[-1]
    if isinstance(source, (Scene, Mapping)) and scene is not None:
        source = scene["volumes[0].path"]
    return source if isinstance(source, Volume) else open_volume(source)


def render(
    source: Any,
    *,
    scene: Any = None,
    progress: Progress = None,
    **options: Any,
) -> Picture:
    """Draws a picture.

    source: a Scene, a mapping of its keys, a Volume, an array (as tessera.open() takes it), or a path: a scene
    file, a store, or files that are imported to the cache. scene: how a volume is drawn; its first volume is then
    `source`.

    `options` are those of `tessera render`, with _ for -: size=(640, 480), view="left" or (30, 10), preset="bone-1",
    mode="mip", window=(40, 400), slice="axial", isosurface=["300:ivory"], mesh=[...], light="studio", engine="native",
    max_error=1, samples=4, verify="full", layers="all", ram="512MiB", gpu_memory=..., crop=(x0, x1, y0, y1, z0, z1),
    set={"shading.ambient": 0.3}, and so on. A name with a point is a key of the scene: **{"shading.ambient": 0.3}.
    labels: a file, a folder, an image of SimpleITK or nibabel, a LabelMap, (array, affine), or an array of
    the volume's shape.
    A list repeats an option, a tuple is one value, True is a flag. Options win over the scene.

    progress: called with a stage and a share from 0 to 1 on this thread; it may raise, or return False, to stop. True
    writes a line on stderr.
    Ctrl-C stops within a second. Raises InputError naming the option, the key or the file; Error for what fails
    outside.
    """
    name, whole, kept = _named(source, scene)
    if isinstance(kept[-1], Volume) and kept[-1]._given_unit:
        options.setdefault("unit", kept[-1]._given_unit)
    drawn = whole._scene_of if whole is not None else None
    with labels_file(options.pop("labels", None), lambda: _volume_of(kept, whole)) as labels:
        words = _split({**options, "labels": labels})
        return Picture(_tessera.render(os.fsencode(name), drawn, words, told(progress)))


def render_file(
    source: Any,
    output: Path,
    *,
    scene: Any = None,
    progress: Progress = None,
    **options: Any,
) -> List[str]:
    """Writes what `tessera render` writes: a picture, with panel= a figure of several, with path= or turn= a film, and
    with path= and unfold=, straighten=, curved= or sections= a picture of a line.

    source, scene and options as for render(). path: a path file, a Centreline or its dict, or points as
    rows of x, y, z (patient space, mm) and perhaps a radius. Frames that are there stay. Returns notes and warnings.
    """
    from ._lumen import path_file

    name, whole, kept = _named(source, scene)
    if isinstance(kept[-1], Volume) and kept[-1]._given_unit:
        options.setdefault("unit", kept[-1]._given_unit)
    drawn = whole._scene_of if whole is not None else None
    with path_file(options.pop("path", None)) as file, labels_file(
        options.pop("labels", None), lambda: _volume_of(kept, whole)
    ) as labels:
        words = _split({**options, "path": file, "labels": labels}, is_file=True)
        return _tessera.render_file(os.fsencode(name), drawn, os.fsencode(absolute(output)), words, told(progress))


def film(
    source: Any,
    output: Path,
    *,
    path: Any = None,
    turn: Optional[float] = None,
    scene: Any = None,
    progress: Progress = None,
    **options: Any,
) -> List[str]:
    """Draws a film along a path, of a turntable or over phases (phase="all"): a folder of frames, or .mp4, .mov, .mkv.

    turn: degrees of a turntable; the rest as for render_file().
    """
    if path is None and turn is None and options.get("phase") != "all":
        raise InputError('film: expected path, turn or phase="all", found none')
    return render_file(source, output, scene=scene, progress=progress, path=path, turn=turn, **options)
