"""The package's types by mypy: its own, and those that a program of a user sees."""

import os
import shutil
import subprocess
import tempfile
import unittest

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "viewer", "python")
RIGHT = """
from typing import Any
import numpy as np
import tessera
array: "np.ndarray[Any, Any]" = np.zeros((4, 5, 6), np.int16)
volume: tessera.Volume = tessera.open(array, spacing=(1, 1, 1), origin=np.zeros(3), unit="HU")
picture: tessera.Picture = tessera.render(volume, size=(20, 16), engine="native")
png: bytes = tessera.png(picture.srgb())
scene = tessera.Scene(volume, **{"shading.ambient": 0.3})
scene["shading.ambient"] = 0.4
line = tessera.centreline(volume, (0, 0, 0), np.array([1, 2, 3]))
share: float = tessera.coverage(volume, line).share
values: "np.ndarray[Any, Any]" = volume[0, 1:2, ...]
"""
WRONG = """
import tessera
volume = tessera.open("a.zarr", unit=5)
volume.level("0")
volume.unit = "HU"
tessera.png("a.png")
"""


@unittest.skipUnless(shutil.which("mypy"), "without mypy")
class Types(unittest.TestCase):
    def mypy(self, *words):
        with tempfile.TemporaryDirectory() as cache:
            return subprocess.run(["mypy", "--strict", "--cache-dir", cache, *words], capture_output=True, text=True,
                                  cwd=PACKAGE, env={**os.environ, "MYPYPATH": ".", "PYTHONPATH": ""})

    def test_they_agree(self):
        made = self.mypy("tessera")
        self.assertEqual(made.returncode, 0, made.stdout)
        made = self.mypy("-c", RIGHT)
        self.assertEqual(made.returncode, 0, made.stdout)

    def test_what_is_wrong_is_found(self):
        found = self.mypy("-c", WRONG).stdout
        for line in (3, 4, 5, 6):
            self.assertIn(f"<string>:{line}: error", found)


if __name__ == "__main__":
    unittest.main()
