"""A wheel of the package tessera from this tree: what it loads on demand lies in it. It needs the libraries of this
system (cmake/debian-packages.txt), and fits the version of Python that builds it."""

import os
import re
import sys

from skbuild import setup

HERE = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(HERE, "..", "..", "CMakeLists.txt"), encoding="utf-8") as file:
    version = re.search(r"project\(tessera VERSION ([0-9.]+)", file.read()).group(1)

setup(
    name="tessera",
    version=version,
    description="Volumes larger than memory, and pictures of them",
    license="see LICENSE",
    python_requires=">=3.9",
    install_requires=["numpy"],
    packages=["tessera"],
    package_data={"tessera": ["py.typed", "*.pyi"]},
    cmake_source_dir=os.path.join("..", ".."),
    cmake_install_target="install-python",
    cmake_args=[
        "-DCMAKE_BUILD_TYPE=Release",
        "-DTESSERA_WITH_WINDOW=OFF",
        "-DTESSERA_WITH_TESTS=OFF",
        "-DTESSERA_PYTHON_FOLDER=.",
        "-DTESSERA_PYTHON_ALONE=ON",
        f"-DPython_EXECUTABLE={sys.executable}",
    ],
)
