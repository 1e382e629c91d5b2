// tests/support/no_vtk_images.cpp: bricking/import/vtk/vtk_image.h for tests that read none. Those that do
// link tessera_vtk_image before this.
#include "bricking/import/vtk/vtk_image.h"

namespace tessera {

std::unique_ptr<SlabSource> openVtkImage(const std::filesystem::path& file) {
    throw Error(file.string() + ": this test links no reader of VTK's images (tessera_vtk_image)");
}

} // namespace tessera
