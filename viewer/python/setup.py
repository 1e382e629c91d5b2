"""A wheel of the package tessera from this tree, built by CMake: what it loads on demand lies in it. It needs the
libraries of this system (cmake/debian-packages.txt), and fits the version of Python that builds it.

TESSERA_BUILD names a folder that CMake has configured with -DTESSERA_PYTHON_FOLDER=. -DTESSERA_PYTHON_ALONE=ON, such as
build/release; else the wheel has a build of its own in build/wheel."""

import os
import re
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
OWN = os.path.join(ROOT, "build", "wheel")


class BuildByCMake(build_ext):
    def run(self):
        folder = os.environ.get("TESSERA_BUILD")
        if folder:
            folder = os.path.join(ROOT, folder)
        else:
            folder = os.path.join(OWN, "cmake")
            options = {
                "CMAKE_BUILD_TYPE": "Release",
                "TESSERA_WITH_WINDOW": "OFF",
                "TESSERA_PYTHON_FOLDER": ".",
                "TESSERA_PYTHON_ALONE": "ON",
                "Python_EXECUTABLE": sys.executable,
            }
            words = [f"-D{name}={value}" for name, value in options.items()]
            subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", *words], check=True)
        subprocess.run(["cmake", "--build", folder, "--target", "tessera_python"], check=True)
        place = os.path.abspath(self.build_lib)
        subprocess.run(["cmake", "--install", folder, "--component", "python", "--prefix", place], check=True)
        made = os.listdir(os.path.join(place, "tessera")) if os.path.isdir(os.path.join(place, "tessera")) else []
        if self.get_ext_filename("_tessera") not in made or "tessera_importers.so" not in made:
            raise SystemExit(f"{folder}: expected -DTESSERA_PYTHON_FOLDER=. -DTESSERA_PYTHON_ALONE=ON, found others")

    def get_outputs(self):
        return []  # what CMake installed is there


with open(os.path.join(ROOT, "CMakeLists.txt"), encoding="utf-8") as file:
    version = re.search(r"project\(tessera VERSION ([0-9.]+)", file.read()).group(1)
os.makedirs(OWN, exist_ok=True)

setup(
    name="tessera",
    version=version,
    description="Volumes larger than memory, and pictures of them",
    python_requires=">=3.9",
    install_requires=["numpy"],
    packages=["tessera"],
    package_data={"tessera": ["py.typed", "*.pyi"]},
    ext_modules=[Extension("tessera._tessera", sources=[])],
    cmdclass={"build_ext": BuildByCMake},
    options={"build": {"build_base": OWN}, "egg_info": {"egg_base": OWN}},
    zip_safe=False,
)
