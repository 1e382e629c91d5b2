// viewer/python/parts.h: parts of a volume for Python: labels beside it, the patient's box, the table,
// and surfaces of values.
#pragma once

#include <pybind11/pybind11.h>

namespace tessera::python {

/// Adds labels(), body(), table() and surface().
void addParts(pybind11::module_& module);

} // namespace tessera::python
