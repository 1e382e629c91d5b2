// bricking/export/export_formats.cpp: the table of formats of volume_writer.h.
#include "bricking/export/volume_writer.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cctype>

namespace tessera {

const std::vector<ExportFormat>& exportFormats() {
    static const std::vector<ExportFormat> formats = {
#if TESSERA_WITH_IMPORT
        {"nrrd", {".nrrd"}, "3D Slicer, ITK", writeNrrd, true},
        {"nifti", {".nii", ".nii.gz"}, "NIfTI-1", writeNifti, true},
        {"nifti2", {}, "positions as doubles", writeNifti2, true},
        {"vti", {".vti"}, "VTK, ParaView", writeVti, true},
        {"tiff", {".tif", ".tiff"}, "ImageJ", writeTiff, true},
#endif
#if TESSERA_WITH_VDB
        {"vdb", {".vdb"}, "OpenVDB: Blender, Houdini", writeVdb, true},
        {"vdb-half", {}, "its values as halves", writeHalfVdb, true},
#endif
        {"ome-zarr", {".zarr"}, "a store, with its levels", writeOmeZarr, true, true},
    };
    return formats;
}

const ExportFormat& exportFormatOf(const std::string& name, const std::filesystem::path& out) {
    std::vector<std::string> names;
    std::string endings;
    for (const ExportFormat& format : exportFormats()) {
        names.push_back(format.name);
        for (const std::string& ending : format.endings)
            endings += (endings.empty() ? "" : ", ") + ending;
    }
    if (!name.empty())
        return exportFormats()[indexOfName(name, names, "--format")];
    std::string file = (out.filename().empty() ? out.parent_path() : out).filename().string();
    std::transform(file.begin(), file.end(), file.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const ExportFormat* found = nullptr;
    std::size_t longest = 0;
    for (const ExportFormat& format : exportFormats())
        for (const std::string& ending : format.endings)
            if (file.ends_with(ending) && ending.size() > longest)
                found = &format, longest = ending.size();
    if (!found)
        throw badFile(out.string(), "a name ending in " + endings + ", or --format",
                      "\"" + out.extension().string() + "\"");
    return *found;
}

} // namespace tessera
