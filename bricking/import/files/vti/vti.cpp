// bricking/import/files/vti/vti.cpp: VTK's images in XML (.vti).
#include "bricking/import/files/file_format.h"
#include "bricking/import/vtk/vtk_image.h"

namespace tessera {

FileFormat vtiFormat() {
    return {"VTK images", ".vti",
            [](const std::filesystem::path& file, const SourceOptions&) { return openVtkImage(file); }};
}

} // namespace tessera
