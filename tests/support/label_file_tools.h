// tests/support/label_file_tools.h: what tests of label files share: reading a layer whole, labels at
// places of the patient, writing files.
#pragma once

#include "bricking/import/labels/label_format.h"
#include "tests/support/folders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <string>
#include <vector>
#include <zlib.h>

namespace tessera::test {

/// A folder of the running test's own, empty.
inline std::filesystem::path labelTestFolder() {
    const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "tessera-label-formats" /
                                         (std::string(test->test_suite_name()) + "." + test->name());
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

inline void writeBytes(const std::filesystem::path& path, const std::string& bytes) {
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::string readBytes(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Values as a file has them.
template <class T> std::string fileBytes(const std::vector<std::uint32_t>& values, bool bigEndian = false) {
    std::string bytes;
    for (const std::uint32_t value : values) {
        const T typed = static_cast<T>(value);
        std::array<char, sizeof(T)> raw;
        std::memcpy(raw.data(), &typed, sizeof(T));
        if (bigEndian)
            std::reverse(raw.begin(), raw.end());
        bytes.append(raw.data(), raw.size());
    }
    return bytes;
}

inline std::string gzipped(const std::string& bytes) {
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
    std::string out(compressBound(bytes.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

/// Opens by the table of formats.
inline LabelFile openLabelFile(const std::filesystem::path& path) {
    const LabelFormat* const format = labelFormatOf(path);
    if (!format) {
        ADD_FAILURE() << path << " is of no format";
        return {};
    }
    return format->open(path, {});
}

/// Reads everything, in uneven portions (1, 2, 3, ... slices).
inline std::vector<std::uint32_t> readLayer(LabelLayer& layer) {
    const glm::ivec3 extent = layer.info().extentVoxels;
    const auto perSlice = static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y);
    std::vector<std::uint32_t> voxels(perSlice * static_cast<std::size_t>(extent.z));
    int z = 0;
    for (int count = 1; z < extent.z; ++count) {
        const int now = std::min(count, extent.z - z);
        layer.readSlices(now, std::span(voxels).subspan(static_cast<std::size_t>(z) * perSlice,
                                                        static_cast<std::size_t>(now) * perSlice));
        z += now;
    }
    return voxels;
}

/// The labelled voxels of a layer by their centres' places in the patient, in hundredths of a millimetre.
using Places = std::map<std::array<long, 3>, std::uint32_t>;
inline Places placesOf(LabelLayer& layer) {
    const std::vector<std::uint32_t> voxels = readLayer(layer);
    const glm::ivec3 extent = layer.info().extentVoxels;
    Places places;
    std::size_t i = 0;
    for (int z = 0; z < extent.z; ++z)
        for (int y = 0; y < extent.y; ++y)
            for (int x = 0; x < extent.x; ++x)
                if (const std::uint32_t label = voxels[i++]; label != 0) {
                    const glm::dvec4 at =
                        layer.info().patientFromVoxel * glm::dvec4(x + 0.5, y + 0.5, z + 0.5, 1);
                    places[{std::lround(100 * at.x), std::lround(100 * at.y), std::lround(100 * at.z)}] =
                        label;
                }
    return places;
}

/// The message of the InputError that opening a file and reading all of it throws; "" if it throws none.
inline std::string refusalOfReading(const std::filesystem::path& path) {
    try {
        LabelFile file = openLabelFile(path);
        for (const auto& layer : file.layers)
            readLayer(*layer);
        return "";
    } catch (const InputError& error) {
        return error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << "not an InputError: " << error.what();
        return error.what();
    }
}

} // namespace tessera::test
