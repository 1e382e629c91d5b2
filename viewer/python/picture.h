// viewer/python/picture.h: scenes and pictures for Python: a scene with the checks of its keys, and what
// `tessera render` draws, as numbers in memory.
#pragma once

#include <pybind11/pybind11.h>

namespace tessera::python {

namespace py = pybind11;

/// Adds Scene, and the keys, presets and names of scenes.
void addScenes(py::module_& module);
/// Adds Picture and render().
void addPictures(py::module_& module);

} // namespace tessera::python
