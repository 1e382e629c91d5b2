"""Tessera: volumes larger than memory, and pictures of them. Not for diagnosis.

Arrays have axes [z, y, x], as SimpleITK's have; nibabel's are [x, y, z]. What names places or lengths is in the
order x, y, z, in patient space: DICOM's LPS, millimetres.

>>> import tessera
>>> volume = tessera.open("scan/")                        # doctest: +SKIP
>>> tessera.render(volume, preset="bone-1").save("a.png")  # doctest: +SKIP

docs/python.md says more.
"""

import atexit as _atexit

from ._tessera import Cancelled, Error, InputError, OverBudget, __version__, remove_temporary_stores as _remove
from ._lumen import Centreline, Coverage, Line, centreline, coverage
from ._picture import Picture, film, png, render, render_file
from ._scene import Scene, looks, presets, scene_keys, views
from ._volume import Body, Label, LabelMap, Surface, Table, Volume, open, phantom, phases

_atexit.register(_remove)

__all__ = [
    "Body",
    "Cancelled",
    "Centreline",
    "Coverage",
    "Error",
    "InputError",
    "Label",
    "LabelMap",
    "Line",
    "OverBudget",
    "Picture",
    "Scene",
    "Surface",
    "Table",
    "Volume",
    "__version__",
    "centreline",
    "coverage",
    "film",
    "looks",
    "open",
    "phantom",
    "phases",
    "png",
    "presets",
    "render",
    "render_file",
    "scene_keys",
    "views",
]
