// viewer/python/parts.h: parts of a volume for Python: labels beside it, the patient's box, and the table.
#pragma once

#include <pybind11/pybind11.h>

namespace tessera::python {

/// Adds labels(), body() and table().
void addParts(pybind11::module_& module);

} // namespace tessera::python
