// viewer/python/module.cpp: tessera._tessera, the part of Python's package tessera that is compiled. The
// package's own files (tessera/*.py) give it its form.
#include "viewer/python/call.h"
#include "viewer/python/lumen.h"
#include "viewer/python/parts.h"
#include "viewer/python/picture.h"
#include "viewer/python/volume.h"

PYBIND11_MODULE(_tessera, module) {
    module.attr("__version__") = TESSERA_VERSION;
    tessera::python::addErrors(module);
    tessera::python::addVolumes(module);
    tessera::python::addScenes(module);
    tessera::python::addPictures(module);
    tessera::python::addLumen(module);
    tessera::python::addParts(module);
}
