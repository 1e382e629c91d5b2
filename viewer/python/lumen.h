// viewer/python/lumen.h: centre-lines of hollow organs, and the wall that a flight sees, for Python.
#pragma once

#include <pybind11/pybind11.h>

namespace tessera::python {

/// Adds centreline() and coverage().
void addLumen(pybind11::module_& module);

} // namespace tessera::python
