// tests/support/stack_writers.h: stacks of pictures for tests: TIFF files written byte by byte, and any by
// OpenImageIO.
#pragma once

#include "tests/support/import_test_tools.h"

#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

namespace tessera::test {

inline const SourceOptions kCubes{.spacingMm = glm::dvec3(1)};

/// Of slice z: no two slices, rows or columns are alike.
template <class T> std::vector<T> sliceValues(int width, int height, int z) {
    std::vector<T> values;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            values.push_back(static_cast<T>(z * 1013 + y * 131 + x * 17 + (x * y) % 7 - 40));
    return values;
}
template <class T> std::vector<T> stackValues(int width, int height, int slices) {
    std::vector<T> all;
    for (int z = 0; z < slices; ++z)
        for (const T value : sliceValues<T>(width, height, z))
            all.push_back(value);
    return all;
}

template <class T> OIIO::TypeDesc typeOfPixels() {
    if constexpr (std::is_same_v<T, std::int8_t>)
        return OIIO::TypeDesc::INT8; // OpenImageIO has plain char for it
    else
        return OIIO::BaseTypeFromC<T>::value;
}

struct OiioSpec {
    int width = 37, height = 45;
    const char* compression = "none";
    int tile = 0, rowsPerStrip = 0, channels = 1, x = 0, y = 0;
    std::map<std::string, std::string> texts = {};
};

/// Pages of one file; the n-th has slice first + n.
template <class T>
void writeByOiio(const std::filesystem::path& path, const OiioSpec& from, int pages = 1, int first = 0) {
    OIIO::ImageSpec spec(from.width, from.height, from.channels, typeOfPixels<T>());
    spec.attribute("compression", from.compression);
    if (from.rowsPerStrip > 0)
        spec.attribute("tiff:RowsPerStrip", from.rowsPerStrip);
    spec.tile_width = spec.tile_height = from.tile;
    spec.x = from.x, spec.y = from.y;
    for (const auto& [key, value] : from.texts)
        spec.attribute(key, value);
    const auto out = OIIO::ImageOutput::create(path.string());
    ASSERT_TRUE(out);
    const std::vector<OIIO::ImageSpec> specs(static_cast<std::size_t>(pages), spec);
    ASSERT_TRUE(pages == 1 ? out->open(path.string(), spec) : out->open(path.string(), pages, specs.data()))
        << out->geterror();
    for (int page = 0; page < pages; ++page) {
        if (page > 0) {
            ASSERT_TRUE(out->open(path.string(), spec, OIIO::ImageOutput::AppendSubimage)) << out->geterror();
        }
        const std::vector<T> values = sliceValues<T>(from.width * from.channels, from.height, first + page);
        ASSERT_TRUE(out->write_image(typeOfPixels<T>(), values.data())) << out->geterror();
    }
    ASSERT_TRUE(out->close());
}

/// A TIFF file, byte by byte: pages without compression, `rows` in a strip.
struct OwnTiff {
    bool big = false, isLong = false; // order of bytes, BigTIFF
    int width = 5, height = 6, rows = 4, pages = 3;
    std::uint32_t bits = 16, format = 1;
    std::string pixels = {}; // of all pages
    std::string description = {};
    std::uint32_t perX = 0, perY = 0, unit = 1; // resolution
    std::map<int, std::uint32_t> other = {};    // fields in place of these, or besides
    std::vector<std::uint16_t> palette = {};

    std::string bytes() const {
        std::string file = big ? "MM" : "II";
        append(file, isLong ? 43 : 42, 2);
        if (isLong)
            append(file, 8, 2), append(file, 0, 2);
        const std::size_t pointer = isLong ? 8 : 4;
        append(file, 0, pointer);
        std::size_t nextAt = file.size() - pointer;
        const auto pageBytes = pixels.size() / static_cast<std::size_t>(pages);
        const std::size_t stripBytes =
            pageBytes / static_cast<std::size_t>(height) * static_cast<std::size_t>(rows);
        for (std::size_t page = 0; page < static_cast<std::size_t>(pages); ++page) {
            std::vector<std::uint64_t> offsets, lengths;
            for (std::size_t at = 0; at < pageBytes; at += stripBytes) {
                const std::size_t length = std::min(stripBytes, pageBytes - at);
                offsets.push_back(file.size());
                lengths.push_back(length);
                file += pixels.substr(page * pageBytes + at, length);
            }
            const std::size_t offsetsAt = file.size();
            for (const std::uint64_t offset : offsets)
                append(file, offset, 4);
            const std::size_t lengthsAt = file.size();
            for (const std::uint64_t length : lengths)
                append(file, length, 4);
            const std::size_t textAt = file.size();
            file += description + std::string(1, '\0');
            const std::size_t ratiosAt = file.size();
            for (const std::uint32_t number : {perX, 1u, perY, 1u})
                append(file, number, 4);
            const std::size_t paletteAt = file.size();
            for (const std::uint16_t number : palette)
                append(file, number, 2);
            struct Field {
                int type;
                std::uint64_t count, value;
            };
            std::map<int, Field> fields = {
                {256, {4, 1, static_cast<std::uint64_t>(width)}},
                {257, {4, 1, static_cast<std::uint64_t>(height)}},
                {258, {3, 1, bits}},
                {259, {3, 1, 1}},
                {262, {3, 1, 1}},
                {273, {4, offsets.size(), offsets.size() == 1 ? offsets[0] : offsetsAt}},
                {277, {3, 1, 1}},
                {278, {4, 1, static_cast<std::uint64_t>(rows)}},
                {279, {4, lengths.size(), lengths.size() == 1 ? lengths[0] : lengthsAt}},
                {339, {3, 1, format}}};
            if (isLong && offsets.size() == 2) { // eight bytes fit in place
                const auto both = [&](const std::vector<std::uint64_t>& two) {
                    return big ? two[0] << 32 | two[1] : two[1] << 32 | two[0];
                };
                fields[273].value = both(offsets);
                fields[279].value = both(lengths);
            }
            if (perX > 0) {
                const auto ratio = [&](std::uint64_t number, std::size_t at) -> std::uint64_t {
                    return !isLong ? at : big ? number << 32 | 1 : std::uint64_t{1} << 32 | number;
                };
                fields[282] = {5, 1, ratio(perX, ratiosAt)};
                fields[283] = {5, 1, ratio(perY, ratiosAt + 8)};
                fields[296] = {3, 1, unit};
            }
            if (!palette.empty())
                fields[320] = {3, palette.size(), paletteAt};
            if (!description.empty())
                fields[270] = {2, description.size() + 1, textAt};
            for (const auto& [tag, value] : other)
                fields[tag] = {4, 1, value};
            std::string next;
            append(next, file.size(), pointer);
            file.replace(nextAt, pointer, next);
            append(file, fields.size(), isLong ? 8 : 2);
            for (const auto& [tag, field] : fields) {
                append(file, static_cast<std::uint64_t>(tag), 2);
                append(file, static_cast<std::uint64_t>(field.type), 2);
                append(file, field.count, pointer);
                const bool isPointer = field.count * (field.type == 3   ? 2u
                                                      : field.type == 2 ? 1u
                                                                        : 4u) >
                                       pointer;
                const std::size_t size = isPointer || field.count > 1 || field.type == 5 ? pointer
                                         : field.type == 3                               ? 2
                                                                                         : 4;
                append(file, field.value, size);
                file += std::string(pointer - size, '\0');
            }
            nextAt = file.size();
            append(file, 0, pointer);
        }
        return file;
    }

  private:
    void append(std::string& to, std::uint64_t value, std::size_t count) const {
        for (std::size_t i = 0; i < count; ++i)
            to += static_cast<char>(value >> 8 * (big ? count - 1 - i : i));
    }
};

inline OwnTiff ownTiff() {
    OwnTiff tiff;
    tiff.pixels = voxelBytes(stackValues<std::uint16_t>(5, 6, 3));
    return tiff;
}

} // namespace tessera::test
