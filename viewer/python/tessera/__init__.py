"""Tessera: volumes larger than memory, and pictures of them. Not for diagnosis.

Arrays have axes [z, y, x], as SimpleITK's have; nibabel's are [x, y, z]. What names places or lengths is in the
order x, y, z, in patient space: DICOM's LPS, millimetres.

>>> import tessera
>>> volume = tessera.open("scan/")                        # doctest: +SKIP
>>> tessera.render(volume, preset="bone-1").save("a.png")  # doctest: +SKIP

docs/python.md says more.
"""

from ._tessera import Cancelled, Error, InputError, __version__
from ._lumen import Centreline, Coverage, Line, centreline, coverage
from ._picture import Picture, film, render
from ._scene import Scene, looks, presets, scene_keys, views
from ._volume import Volume, open, phantom

__all__ = [
    "Cancelled",
    "Centreline",
    "Coverage",
    "Error",
    "InputError",
    "Line",
    "Picture",
    "Scene",
    "Volume",
    "__version__",
    "centreline",
    "coverage",
    "film",
    "looks",
    "open",
    "phantom",
    "presets",
    "render",
    "scene_keys",
    "views",
]
