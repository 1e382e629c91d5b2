// tests/support/import_test_tools.h: tools that the import tests share: reading a source whole, patient
// positions, NIfTI and sidecar writers, and the shared test data.
#pragma once

#include "bricking/import/open_source.h"
#include "bricking/import/source/slab_source.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "tests/support/folders.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>
#include <zlib.h>

namespace tessera::test {

inline void writeFile(const std::filesystem::path& path, const std::string& bytes) {
    std::filesystem::remove(path); // some file systems flush a file that is truncated and rewritten
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::string gzip(const std::string& bytes) {
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

template <class T> void put(std::string& bytes, std::size_t at, T value, bool bigEndian = false) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (bigEndian)
        std::reverse(raw, raw + sizeof(T));
    bytes.replace(at, sizeof(T), raw, sizeof(T));
}

/// Values as a file has them.
template <class T> std::string voxelBytes(const std::vector<T>& values, bool bigEndian = false) {
    std::string bytes(values.size() * sizeof(T), '\0');
    for (std::size_t i = 0; i < values.size(); ++i)
        put(bytes, i * sizeof(T), values[i], bigEndian);
    return bytes;
}

/// Reads everything, in uneven portions (1, 2, 3, ... slices), as values of T.
template <class T> std::vector<T> readAll(SlabSource& source) {
    const VolumeInfo info = source.info();
    EXPECT_EQ(bytesPerValue(info.type), sizeof(T));
    const auto perSlice =
        static_cast<std::size_t>(info.extentVoxels.x) * static_cast<std::size_t>(info.extentVoxels.y);
    std::vector<T> values(perSlice * static_cast<std::size_t>(info.extentVoxels.z));
    int z = 0;
    for (int count = 1; z < info.extentVoxels.z; ++count) {
        const int now = std::min(count, info.extentVoxels.z - z);
        const auto part = std::span(values).subspan(static_cast<std::size_t>(z) * perSlice,
                                                    static_cast<std::size_t>(now) * perSlice);
        source.readSlices(now, std::as_writable_bytes(part));
        z += now;
    }
    return values;
}

/// Rows by themselves, in the ways that the source allows, are those of whole slices, and count the same.
/// @param open  the source anew
template <typename Open> void expectRowsOfSlices(const Open& open, RowAccess expected) {
    const std::unique_ptr<SlabSource> slices = open(), rows = open();
    EXPECT_EQ(rows->rowAccess(), expected);
    const glm::ivec3 extent = slices->info().extentVoxels;
    const std::size_t rowBytes = rowBytesOf(slices->info()), sliceBytes = sliceBytesOf(slices->info());
    std::vector<std::byte> whole(sliceBytes * static_cast<std::size_t>(extent.z)), found(whole.size());
    slices->readSlices(extent.z, whole);
    const auto readSome = [&](int z, int first, int count) {
        rows->readRows(z, first, count,
                       std::span(found).subspan(static_cast<std::size_t>(z) * sliceBytes +
                                                    static_cast<std::size_t>(first) * rowBytes,
                                                static_cast<std::size_t>(count) * rowBytes));
    };
    const int unit = rows->rowUnit(), band = 2 * unit;
    if (expected == RowAccess::any)
        for (int first = 0; first < extent.y; first += band)
            for (int z = extent.z; z-- > 0;)
                readSome(z, first, std::min(band, extent.y - first));
    else
        for (int z = 0; z < extent.z; ++z)
            for (int first = 0; first < extent.y; first += band)
                readSome(z, first, std::min(band, extent.y - first));
    EXPECT_TRUE(found == whole);
    EXPECT_EQ(rows->info().nonFiniteVoxels, slices->info().nonFiniteVoxels);
    EXPECT_EQ(rows->info().absentStored, slices->info().absentStored);
    const VoxelTally some = rows->takeTally(), all = slices->takeTally();
    EXPECT_EQ(some.labels.isOther, all.labels.isOther);
    if (!all.labels.isOther) { // else counting ended
        EXPECT_EQ(some.labels.values, all.labels.values);
        EXPECT_EQ(some.labels.edges, all.labels.edges);
        EXPECT_EQ(some.labels.inside, all.labels.inside);
    }
    EXPECT_EQ(some.rounded, all.rounded);
}

inline std::size_t indexOf(const VolumeInfo& info, int x, int y, int z) {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(info.extentVoxels.y) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(info.extentVoxels.x) +
           static_cast<std::size_t>(x);
}

inline glm::dvec3 centreMm(const VolumeInfo& info, int x, int y, int z) {
    return glm::dvec3(info.patientFromVoxel * glm::dvec4(x + 0.5, y + 0.5, z + 0.5, 1));
}

/// The message of the InputError that `action` throws; fails if it throws none or another.
template <class Action> std::string refusal(Action action) {
    try {
        action();
    } catch (const InputError& error) {
        return error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << "not an InputError: " << error.what();
        return "";
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

inline std::string refusalOfOpening(const std::filesystem::path& path, const SourceOptions& options = {}) {
    return refusal([&] { openSource(path, options); });
}

/// A NIfTI-1 file's bytes: header, 4 zero bytes, voxels. srow is the 3x4 sform, row by row (RAS).
struct NiftiImage {
    std::array<std::int64_t, 3> extent = {2, 3, 4};
    std::int16_t datatype = 4;
    std::optional<std::int16_t> bitpix = {}; // by default what the datatype takes
    std::int16_t dim4 = 0;
    std::array<double, 12> srow = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    double slope = 0, intercept = 0;
    std::string voxels;
    bool bigEndian = false;
    int version = 1;
};

inline std::int16_t bitsOfNifti(const NiftiImage& image) {
    switch (image.datatype) {
    case 2:
    case 256:
        return 8;
    case 4:
    case 512:
        return 16;
    case 64:
    case 1024:
    case 1280:
        return 64;
    default:
        return 32;
    }
}

inline std::string niftiBytes(const NiftiImage& image) {
    const std::int16_t bitpix = image.bitpix.value_or(bitsOfNifti(image));
    const bool big = image.bigEndian;
    if (image.version == 1) {
        std::string b(352, '\0');
        put<std::int32_t>(b, 0, 348, big);
        put<std::int16_t>(b, 40, 3, big);
        for (std::size_t i = 0; i < 3; ++i) {
            put(b, 42 + 2 * i, static_cast<std::int16_t>(image.extent[i]), big);
            put(b, 80 + 4 * i, 1.f, big);
        }
        put(b, 70, image.datatype, big);
        put(b, 72, bitpix, big);
        put(b, 48, image.dim4, big);
        put(b, 108, 352.f, big);
        put(b, 112, static_cast<float>(image.slope), big);
        put(b, 116, static_cast<float>(image.intercept), big);
        b[123] = 2;
        put<std::int16_t>(b, 254, 1, big);
        for (std::size_t i = 0; i < 12; ++i)
            put(b, 280 + 4 * i, static_cast<float>(image.srow[i]), big);
        b.replace(344, 3, "n+1");
        return b + image.voxels;
    }
    std::string b(544, '\0');
    put<std::int32_t>(b, 0, 540, big);
    b.replace(4, 8, std::string("n+2\0\r\n\x1a\n", 8));
    put(b, 12, image.datatype, big);
    put(b, 14, bitpix, big);
    put<std::int64_t>(b, 16, 3, big);
    for (std::size_t i = 0; i < 3; ++i) {
        put(b, 24 + 8 * i, image.extent[i], big);
        put(b, 112 + 8 * i, 1.0, big);
    }
    put<std::int64_t>(b, 168, 544, big);
    put(b, 176, image.slope, big);
    put(b, 184, image.intercept, big);
    put<std::int32_t>(b, 348, 1, big);
    for (std::size_t i = 0; i < 12; ++i)
        put(b, 400 + 8 * i, image.srow[i], big);
    put<std::int32_t>(b, 500, 2, big);
    return b + image.voxels;
}

/// A source is read, or refused by an InputError; nothing is allocated on a lie.
inline void expectHarmless(const std::filesystem::path& path, const SourceOptions& options) {
    try {
        const auto source = openSource(path, options);
        ASSERT_LT(source->info().voxelCount(), 1u << 22);
        std::vector<std::byte> out(bytesPerValue(source->info().type) * source->info().voxelCount());
        source->readSlices(source->info().extentVoxels.z, out);
    } catch (const InputError&) {
    }
}

/// Every prefix of a file of int16 is refused, by a message that has `named`.
inline void expectPrefixesRefused(const std::filesystem::path& path, const std::string& whole,
                                  const std::string& named) {
    for (std::size_t n = 0; n < whole.size(); ++n) {
        writeFile(path, whole.substr(0, n));
        const std::string said = refusal([&] { readAll<std::int16_t>(*openSource(path, {})); });
        ASSERT_NE(said.find(named), std::string::npos) << n << ": " << said;
    }
}

/// 600 times some bytes of the header are others, digits most of all.
inline void expectDamageHarmless(const std::filesystem::path& path, const std::string& whole,
                                 std::size_t headerBytes) {
    std::mt19937 random(4711);
    for (int n = 0; n < 600; ++n) {
        std::string bytes = whole;
        for (std::size_t i = 0; i < 1 + random() % 3; ++i)
            bytes[random() % headerBytes] = static_cast<char>(n % 3 ? '0' + random() % 10 : random());
        writeFile(path, bytes);
        expectHarmless(path, {});
    }
}

} // namespace tessera::test
