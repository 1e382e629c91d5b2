"""A wheel of the package tessera from this tree, by scikit-build: CMake builds the module and what it loads on demand,
which lies in the wheel. It needs the libraries of this system (cmake/debian-packages.txt), and fits the version of Python
that builds it. CMAKE_ARGS has more arguments for CMake. All that is made lies in build/."""

import os
import re
import shutil
import sys

from skbuild import setup
from skbuild.constants import CMAKE_BUILD_DIR, CMAKE_INSTALL_DIR, SETUPTOOLS_INSTALL_DIR

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
OBJECTS = os.path.join(ROOT, "build", "wheel-{}.{}".format(*sys.version_info))

with open(os.path.join(ROOT, "CMakeLists.txt"), encoding="utf-8") as file:
    version = re.search(r"project\(tessera VERSION ([0-9.]+)", file.read()).group(1)


def link(name, folder):
    os.makedirs(os.path.dirname(os.path.abspath(name)), exist_ok=True)
    if not os.path.islink(name):
        os.symlink(folder, name)


# ccache knows an object by its place relative to CMake's folder (cmake/setup.sh). So that those of build/release are
# found again, this folder is as deep; scikit-build's is deeper, and has a link.
os.environ.update(CCACHE_BASEDIR=ROOT, CCACHE_NOHASHDIR="1")
os.makedirs(OBJECTS, exist_ok=True)
os.makedirs(os.path.join(ROOT, "build", "skbuild"), exist_ok=True)
os.chdir(os.path.join(ROOT, "build", "skbuild"))
link(CMAKE_BUILD_DIR(), OBJECTS)
link("tessera", os.path.join(ROOT, "viewer", "python", "tessera"))
for installed in (CMAKE_INSTALL_DIR(), SETUPTOOLS_INSTALL_DIR()):  # else a wheel has what an earlier one had
    shutil.rmtree(installed, ignore_errors=True)
# Before another target than `install`, scikit-build makes `all`; with a target named, that one.
os.environ["SKBUILD_BUILD_OPTIONS"] = "tessera_python " + os.environ.get("SKBUILD_BUILD_OPTIONS", "")

setup(
    name="tessera",
    version=version,
    description="Volumes larger than memory, and pictures of them",
    python_requires=">=3.9",
    install_requires=["numpy"],
    packages=["tessera"],
    cmake_source_dir=ROOT,
    cmake_args=[
        "-GNinja",
        "-DCMAKE_BUILD_TYPE=Release",
        "-DTESSERA_WITH_WINDOW=OFF",
        "-DTESSERA_PYTHON_FOLDER=.",
        "-DTESSERA_PYTHON_ALONE=ON",
    ],
    cmake_install_target="install-python",
    zip_safe=False,
)
