// bricking/import/files/metaimage/metaimage.cpp: volumes in MetaImage files (.mha, .mhd).
#include "bricking/import/files/data_files.h"
#include "bricking/import/files/file_format.h"
#include "bricking/import/files/metaimage/meta_header.h"
#include "core/base/error.h"

namespace tessera {
namespace {

std::unique_ptr<SlabSource> openMetaImage(const std::filesystem::path& path, const SourceOptions& options) {
    const MetaHeader header = readMetaHeader(path, options.spacingMm);
    if (!header.saysSpacing && !options.spacingMm)
        throw spacingUnknown(path.string(), "a MetaImage without ElementSpacing");
    if (header.saysSpacing && options.spacingMm)
        throw badFile(path.string(), "a file that does not say its spacing, for --spacing", "one that does");
    checkDataLengths(header.files, path);
    const bool isPacked = header.files.encoding == DataEncoding::gzip;
    return openDataFiles(header.files, path, header.info,
                         std::string("MetaImage (") + (isPacked ? "zlib), " : "raw), ") +
                             name(header.files.type));
}

std::vector<std::filesystem::path> dataFilesOf(const std::filesystem::path& path) {
    try {
        return readMetaHeader(path, {}).files.dataFiles;
    } catch (const Error&) {
        return {};
    }
}

} // namespace

FileFormat metaimageFormat() {
    return {"MetaImage files", ".mha, .mhd", openMetaImage, nullptr, dataFilesOf, true};
}

} // namespace tessera
