// tests/support/zarr_label_image.h: labels of a small volume in OME-Zarr.
#pragma once

#include "tests/support/zarr_writer.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace tessera::test {

inline const std::vector<std::size_t> kShape = {7, 11, 13};

inline std::vector<std::uint32_t> zarrLabelValues(std::size_t count, std::uint32_t most = 100) {
    std::vector<std::uint32_t> values(count);
    std::mt19937 random(5);
    for (std::size_t i = 0; i < count; ++i)
        values[i] = i / 40 % 3 == 0 ? 0
                    : random() % 2  ? most
                                    : static_cast<std::uint32_t>(
                                         random() % std::min(std::uint64_t{most} + 1, std::uint64_t{100}));
    return values;
}

/// One label image "STORE/labels/NAME".
inline void writeLabels(const std::filesystem::path& store, WrittenZarr zarr,
                        const std::vector<std::uint32_t>& values, Json scales,
                        const std::string& name = "cells", const Json& about = Json::object()) {
    if (zarr.shape.empty())
        zarr.shape = kShape;
    if (zarr.chunk.empty())
        zarr.chunk = {3, 4, 5};
    Json ome = {{"multiscales", Json::array({scales})}, {"image-label", about}};
    if (zarr.version == 2)
        ome["multiscales"][0]["version"] = "0.4";
    else
        ome["version"] = "0.5";
    writeZarrGroup(store, zarr.version, Json::object());
    writeZarrGroup(store / "labels", zarr.version, {{"labels", Json::array({name})}});
    writeZarrGroup(store / "labels" / name, zarr.version, ome);
    writeZarrArray(store / "labels" / name / "0", zarr, values);
}

} // namespace tessera::test
