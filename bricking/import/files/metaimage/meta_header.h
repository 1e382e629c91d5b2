// bricking/import/files/metaimage/meta_header.h: the header of a MetaImage file, with its data behind it
// (.mha) or in files of their own (.mhd). Private to the MetaImage reader.
#pragma once

#include "bricking/import/files/data_files.h"
#include "core/base/volume.h"

#include <filesystem>
#include <optional>
#include <string>

namespace tessera {

struct MetaHeader {
    DataFiles files;
    VolumeInfo info;               // in the file's order of axes; patient space is LPS, as ITK reads it
    bool saysSpacing = true;       // "ElementSpacing" or "ElementSize"
    std::uint64_t packedBytes = 0; // CompressedDataSize; 0 unknown
};

/// Reads the header alone. Throws InputError naming the file for a header that is no MetaImage's of three
/// dimensions and one channel, is damaged or ends early, lacks a required field, or contradicts itself.
/// Unknown fields are passed over.
/// @param spacingMm  where the file does not say it
MetaHeader readMetaHeader(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacingMm);

} // namespace tessera
