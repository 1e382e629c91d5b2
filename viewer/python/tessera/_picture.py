"""Pictures: tessera.render() and what it returns."""

from __future__ import annotations

import json
import os
import struct
import zlib
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Tuple

import numpy as np

from . import _tessera
from ._scene import Scene
from ._tessera import InputError
from ._volume import Volume, as_json, open as open_volume
from ._words import Path, Progress, words_of

if TYPE_CHECKING:
    from ._words import Array

_ELSEWHERE = {
    "output": "Picture.save() writes files",
    "json": "Picture.manifest has it",
    "explain": "Picture.manifest has it",
    "first": "draw a smaller picture first",
    "ranks": "the command line draws by several processes",
    "tiles": "the command line draws in tiles",
    "keep_state": "the command line keeps samples",
    "path": "tessera.film() draws along a path",
    "turn": "tessera.film() draws turntables",
    "frames": "tessera.film() draws films",
    "fps": "tessera.film() draws films",
    "speed": "tessera.film() draws films",
    "seconds": "tessera.film() draws films",
    "unfold": "the command line unfolds walls",
    "may_leak": "the command line unfolds walls",
    "help": "docs/python.md has it",
    "version": "tessera.__version__ has it",
    "quiet": "nothing is printed",
    "verbose": "nothing is printed",
}


def png(pixels: Array) -> bytes:
    """A PNG file in memory of uint8 [y, x, 3] or [y, x, 4], sRGB: for sheets of several pictures."""
    pixels = np.asarray(pixels)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or 0 in pixels.shape:
        raise InputError(f"pixels: expected uint8 [y, x, 3] or [y, x, 4], found {pixels.dtype} {list(pixels.shape)}")
    height, width, channels = pixels.shape

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = np.zeros((height, 1 + width * channels), dtype=np.uint8)  # a 0 first: no filter
    rows[:, 1:] = pixels.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"sRGB", b"\0")
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 4))
        + chunk(b"IEND", b"")
    )


class Picture:
    """A picture in memory, with what its file would hold.

    It is a numpy array for numpy: float32 [y, x, 4], linear light (Rec. 709 primaries), premultiplied by its alpha,
    the top row first, without its background.
    """

    def __init__(self, drawn: _tessera.Picture) -> None:
        self._drawn = drawn
        self._manifest: Optional[Dict[str, Any]] = None

    @property
    def pixels(self) -> Array:
        """float32 [y, x, 4]: linear, premultiplied red, green and blue, and alpha; without a copy."""
        return self._drawn.pixels

    def __array__(self, dtype: Any = None, copy: Any = None) -> Array:
        return self.pixels if dtype is None else self.pixels.astype(dtype)

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
        """uint8 [y, x, 3] on the background, as an 8-bit file has it; [y, x, 4] where that is transparent."""
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

    def save(self, path: Path) -> None:
        """Writes .png (8 bits), .tif (16 bits) or .exr (float, with its layers), with the manifest."""
        self._drawn.save(os.fspath(path))

    def to_png(self) -> bytes:
        """A PNG file in memory, without the manifest."""
        return png(self.srgb())

    def _repr_png_(self) -> bytes:
        return self.to_png()

    def __repr__(self) -> str:
        width, height = self.size
        return f"<tessera.Picture {width} x {height}, {self.manifest['engine']}>"


def _split(options: Mapping[str, Any]) -> Tuple[Dict[str, Any], List[str]]:
    """Options of the command line, and keys of the scene as words."""
    plain: Dict[str, Any] = {}
    words: List[str] = []
    for name, value in options.items():
        if name in _ELSEWHERE:
            raise InputError(f"{name}: expected an option of a picture, found {name}: {_ELSEWHERE[name]}")
        if "." in name or "[" in name:
            words.append(f"--set={name}={as_json(value)}")
        else:
            plain[name] = value
    return plain, words


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
        return os.path.abspath(os.fspath(source)) if "://" not in os.fspath(source) else os.fspath(source), None, kept
    copy = Scene(scene)
    copy["volumes[0].path"] = source
    return "scene", copy, kept


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
    A list repeats an option, a tuple is one value, True is a flag. Options win over the scene.

    progress: called with a stage and a share from 0 to 1 on this thread; it may raise, or return False, to stop.
    Ctrl-C stops within a second. Raises InputError naming the option, the key or the file; Error for what fails
    outside.
    """
    keys = options.pop("set", None) or {}
    plain, words = _split(options)
    name, whole, kept = _named(source, scene)
    words = words_of(plain) + words + [f"--set={key}={as_json(value)}" for key, value in keys.items()]
    kept.append(plain)
    return Picture(_tessera.render(name, whole._scene_of if whole is not None else None, words, progress))


def film(
    source: Any,
    output: Any,
    *,
    path: Any = None,
    turn: Optional[float] = None,
    progress: Progress = None,
    **options: Any,
) -> List[str]:
    """Draws a film along a path or of a turntable: a folder of frames, or .mp4, .mov, .mkv.

    path: a path file, or a Centreline. turn: degrees of a turntable. Other options as for render(), and frames, fps,
    speed, seconds. Frames that are there stay. Returns notes and warnings.
    """
    from ._lumen import path_file

    keys = options.pop("set", None) or {}
    films = {name: options.pop(name, None) for name in ("frames", "fps", "speed", "seconds")}
    plain, words = _split(options)
    name, whole, _kept = _named(source, None)
    with path_file(path) as file:
        words = words_of({**plain, **films, "path": file, "turn": turn}) + words
        words += [f"--set={key}={as_json(value)}" for key, value in keys.items()]
        scene = whole._scene_of if whole is not None else None
        return _tessera.film(name, scene, os.path.abspath(os.fspath(output)), words, progress)
