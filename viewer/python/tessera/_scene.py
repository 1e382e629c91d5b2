"""Scenes: everything that a picture depends on, as a mapping whose values are checked when they are set."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, MutableMapping, Sequence
from typing import TYPE_CHECKING, Any, Dict, Iterator, List

from . import _tessera
from ._tessera import InputError
from ._volume import Volume, as_json
from ._words import Path, absolute

if TYPE_CHECKING:
    _Mapping = MutableMapping[str, Any]
    _Sequence = Sequence[Any]
else:
    _Mapping, _Sequence = MutableMapping, Sequence


def presets() -> List[str]:
    """Names of presets: transfer functions with their light."""
    return _tessera.presets()


def looks() -> List[str]:
    """Names of presets of light, for `light`."""
    return _tessera.looks()


def views() -> List[str]:
    """Names of sides, for `view`."""
    return _tessera.views()


def scene_keys() -> Dict[str, str]:
    """All keys of scenes, and a sentence about each."""
    return {row["key"]: row["about"] for row in _tessera.scene_keys()}


def _part(scene: "Scene", path: str, value: Any) -> Any:
    if isinstance(value, dict):
        return _Object(scene, path)
    return _List(scene, path) if isinstance(value, list) else value


class _Object(_Mapping):
    """An object in a scene. What is set in it is set in the scene."""

    _scene: "Scene"
    _path: str

    def __init__(self, scene: "Scene", path: str) -> None:
        self._scene, self._path = scene, path

    def _below(self, key: str) -> str:
        return f"{self._path}.{key}" if self._path else key

    def _value(self) -> Dict[str, Any]:
        value: Dict[str, Any] = self._scene._at(self._path)
        return value

    def __getitem__(self, key: str) -> Any:
        return self._scene[self._below(key)]

    def __setitem__(self, key: str, value: Any) -> None:
        self._scene[self._below(key)] = value

    def __delitem__(self, key: str) -> None:
        del self._scene[self._below(key)]

    def __iter__(self) -> Iterator[str]:
        return iter(self._value())

    def __len__(self) -> int:
        return len(self._value())

    def __repr__(self) -> str:
        return repr(self._value())


class _List(_Sequence):
    """A list in a scene. An item that is set is set in the scene; one more may be set behind the last."""

    def __init__(self, scene: "Scene", path: str) -> None:
        self._scene, self._path = scene, path

    def __getitem__(self, at: Any) -> Any:
        if isinstance(at, slice):
            return self._scene._at(self._path)[at]
        n = range(len(self))[at]
        return self._scene[f"{self._path}[{n}]"]

    def __setitem__(self, at: int, value: Any) -> None:
        self._scene[f"{self._path}[{at if at >= 0 else len(self) + at}]"] = value

    def append(self, value: Any) -> None:
        self[len(self)] = value

    def __len__(self) -> int:
        return len(self._scene._at(self._path))

    def __eq__(self, other: Any) -> bool:
        return isinstance(other, (list, tuple, _List)) and list(self._scene._at(self._path)) == list(other)

    def __repr__(self) -> str:
        return repr(self._scene._at(self._path))


class Scene(_Object):
    """A scene, as docs/scene.schema.json has it: a mapping, whose values are checked when they are set.

    Scene("scan.nii") is the default scene of a volume; of a path, a volume that was opened, a scene file, JSON text
    or a mapping. Keys may be paths: scene["shading.ambient"] = 0.3 and scene["shading"]["ambient"] = 0.3 are the
    same, as is Scene(volume, **{"shading.ambient": 0.3}). A key that a file would leave out raises KeyError.
    """

    _path = ""

    @property
    def _scene(self) -> "Scene":  # type: ignore[override]
        return self  # no circle, so that volumes go with the scene at once

    def __init__(self, source: Any = None, /, **keys: Any) -> None:
        self._volumes: List[Volume] = []  # whose stores must stay
        if source is None:
            self._scene_of = _tessera.Scene.of("volume")
        elif isinstance(source, Scene):
            self._scene_of = source._scene_of.copy()
            self._volumes = list(source._volumes)
        elif isinstance(source, Mapping):
            self._scene_of = _tessera.Scene.of("volume")
            keys = {**source, **keys}
        elif isinstance(source, str) and source.lstrip().startswith("{"):
            self._scene_of = _tessera.Scene.parse(source, os.getcwd(), "scene")
        elif not isinstance(source, (str, bytes, os.PathLike)):
            raise InputError(f"scene: expected a path, a volume, JSON text or a mapping, found {type(source).__name__}")
        else:
            if isinstance(source, Volume):
                self._volumes.append(source)
            self._scene_of = _tessera.Scene.of(os.fsencode(absolute(source)))
        for key, value in keys.items():
            self[key] = value

    def _keep(self, value: Any) -> None:
        """Volumes in a value stay as long as the scene."""
        if isinstance(value, Volume):
            self._volumes.append(value)
        elif isinstance(value, Mapping):
            for one in value.values():
                self._keep(one)
        elif isinstance(value, (list, tuple)):
            for one in value:
                self._keep(one)

    def _at(self, path: str) -> Any:
        value = json.loads(self._scene_of.json())
        for step in path.replace("[", ".[").split(".") if path else []:
            try:
                value = value[int(step[1:-1])] if step.startswith("[") else value[step]
            except (KeyError, IndexError, TypeError, ValueError):
                raise KeyError(path) from None
        return value

    def __getitem__(self, key: str) -> Any:
        return _part(self, key, self._at(key))

    def __setitem__(self, key: str, value: Any) -> None:
        if isinstance(value, (_Object, _List)):
            value = value._scene._at(value._path)
        self._scene_of.set(key, as_json(value))
        self._keep(value)

    def __delitem__(self, key: str) -> None:
        self._at(key)
        whole = json.loads(self._scene_of.json())
        *above, last = key.replace("[", ".[").split(".")
        value = whole
        for step in above:
            value = value[int(step[1:-1])] if step.startswith("[") else value[step]
        del value[int(last[1:-1]) if last.startswith("[") else last]
        self._scene_of = _tessera.Scene.parse(json.dumps(whole), os.getcwd(), "scene")

    def to_json(self, indent: Any = None) -> str:
        """As JSON text, which Scene() and the command line read."""
        text = self._scene_of.json()
        return text if indent is None else json.dumps(json.loads(text), indent=indent)

    def to_dict(self) -> Dict[str, Any]:
        """A copy as plain dicts and lists."""
        whole: Dict[str, Any] = json.loads(self._scene_of.json())
        return whole

    def save(self, path: Path) -> None:
        """Writes a scene file."""
        with open(path, "w", encoding="ascii") as file:
            file.write(self.to_json(indent=1) + "\n")

    def __reduce__(self) -> Any:
        return Scene, (self.to_json(),)

    def copy(self) -> "Scene":
        return Scene(self)

    def __copy__(self) -> "Scene":
        return Scene(self)

    def __deepcopy__(self, memo: Any) -> "Scene":
        return Scene(self)

    def __repr__(self) -> str:
        return f"tessera.Scene({self.to_json()})"
