// bricking/import/files/vgi/vgi.cpp: volumes of Volume Graphics: a header (.vgi) and raw voxels (.vol).
#include "bricking/import/files/data_files.h"
#include "bricking/import/files/file_format.h"
#include "bricking/import/files/vgi/vgi_header.h"
#include "core/base/error.h"

namespace tessera {
namespace {

std::unique_ptr<SlabSource> openVgi(const std::filesystem::path& path, const SourceOptions& options) {
    const VgiHeader header = readVgiHeader(path, options.spacingMm);
    if (!header.saysSpacing && !options.spacingMm)
        throw spacingUnknown(path.string(), "a volume without a resolution in a unit");
    if (header.saysSpacing && options.spacingMm)
        throw badFile(path.string(), "a file that does not say its spacing, for --spacing", "one that does");
    checkDataLengths(header.files, path);
    return openDataFiles(header.files, path, header.info,
                         std::string("Volume Graphics volume, ") + name(header.files.type));
}

std::vector<std::filesystem::path> dataFilesOf(const std::filesystem::path& path) {
    try {
        return readVgiHeader(path, {}).files.dataFiles;
    } catch (const Error&) {
        return {};
    }
}

} // namespace

FileFormat vgiFormat() {
    return {"Volume Graphics volumes", ".vgi", openVgi, nullptr, dataFilesOf, true};
}

} // namespace tessera
