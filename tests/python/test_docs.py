"""docs/python.md and the notebooks beside it: every example runs."""

import contextlib
import io
import json
import os
import re
import shutil
import tempfile
import unittest

import tessera

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE = os.path.join(ROOT, "docs", "python.md")
NOTEBOOKS = os.path.join(ROOT, "docs", "notebooks")


class Examples(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)
        with_torso = tessera.phantom("torso", (64, 48, 75))  # as the page says
        shutil.copytree(with_torso.path, "torso.zarr")

    def run_code(self, code, name, namespace):
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(code, name, "exec"), namespace)

    def test_every_example_of_the_page_runs(self):
        with open(PAGE, encoding="utf-8") as file:
            page = file.read()
        blocks = list(re.finditer(r"^```python\n(.*?)^```$", page, re.M | re.S))
        self.assertGreaterEqual(len(blocks), 30)
        for block in blocks:
            line = page[: block.start(1)].count("\n")
            with self.subTest(line=line + 1):
                self.run_code("\n" * line + block.group(1), PAGE, {"__name__": "example"})

    def test_every_notebook_runs(self):
        names = sorted(name for name in os.listdir(NOTEBOOKS) if name.endswith(".ipynb"))
        self.assertEqual(len(names), 3)
        for name in names:
            path = os.path.join(NOTEBOOKS, name)
            self.assertLess(os.path.getsize(path), 60 << 10, name)
            with open(path, encoding="utf-8") as file:
                notebook = json.load(file)
            self.assertEqual(notebook["nbformat"], 4)
            namespace = {"__name__": "notebook"}
            for n, cell in enumerate(notebook["cells"]):
                if cell["cell_type"] == "code":
                    with self.subTest(notebook=name, cell=n):
                        self.run_code("".join(cell["source"]), f"{name} cell {n}", namespace)


if __name__ == "__main__":
    unittest.main()
