"""A wheel of scikit-build, unpacked elsewhere: it imports a file and writes pictures by what lies in it."""

import glob
import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
import zipfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TOOLS = [name for name in ("skbuild", "pip", "wheel") if not importlib.util.find_spec(name)]

USE = """
import sys
sys.path.insert(0, {site!r})
import numpy, tessera
assert tessera.__file__.startswith({site!r}), tessera.__file__
values = numpy.arange(6 * 5 * 4, dtype=numpy.int16).reshape(6, 5, 4)
with open("scan.nrrd", "wb") as file:
    file.write(b"NRRD0005\\ntype: int16\\ndimension: 3\\nspace: LPS\\nsizes: 4 5 6\\n"
               b"space directions: (1,0,0) (0,1,0) (0,0,1)\\nspace origin: (0,0,0)\\nendian: little\\nencoding: raw\\n\\n" + values.tobytes())
volume = tessera.open("scan.nrrd")
assert numpy.array_equal(volume.level(0), values)
picture = tessera.render(volume, size=(16, 12), engine="native", title="A scan")
for name in ["scan.png", "scan.exr", "scan.pdf"]:
    picture.save(name)
loaded = {{line.split()[-1] for line in open("/proc/self/maps") if "/tessera" in line}}
for part in ["importers", "pictures", "annotations"]:
    assert {site!r} + "/tessera/tessera_" + part + ".so" in loaded, (part, loaded)
assert not [path for path in loaded if not path.startswith({site!r}) and path.endswith(".so")], loaded
"""


@unittest.skipIf(TOOLS, "without python3-" + ", python3-".join(TOOLS))
class Wheel(unittest.TestCase):
    def test_it_holds_all_that_it_loads(self):
        with tempfile.TemporaryDirectory() as folder:
            made = subprocess.run(
                [sys.executable, "-m", "pip", "wheel", "--no-build-isolation", "--no-deps", "--no-index", "-v", "-w", folder,
                 os.path.join(ROOT, "viewer", "python")],
                capture_output=True, text=True, env={**os.environ, "PYTHONPATH": ""})
            self.assertEqual(made.returncode, 0, made.stdout[-4000:] + made.stderr[-4000:])
            (wheel,) = glob.glob(os.path.join(folder, "*.whl"))
            version = "cp{}{}".format(*sys.version_info)
            self.assertIn(f"-{version}-{version}-linux_", wheel)
            with zipfile.ZipFile(wheel) as archive:
                self.assertIn(b"Generator: skbuild", archive.read(next(n for n in archive.namelist() if n.endswith("/WHEEL"))))
                self.assertIn("tessera/py.typed", archive.namelist())
                self.assertEqual(len(archive.namelist()), len(set(archive.namelist())))
                archive.extractall(os.path.join(folder, "site"))
            use = USE.format(site=os.path.join(folder, "site"))
            used = subprocess.run([sys.executable, "-I", "-c", use], capture_output=True, text=True, cwd=folder,
                                  env={**os.environ, "XDG_CACHE_HOME": folder})
            self.assertEqual(used.returncode, 0, used.stderr)


if __name__ == "__main__":
    unittest.main()
