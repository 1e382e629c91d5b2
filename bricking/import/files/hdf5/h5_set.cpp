// bricking/import/files/hdf5/h5_set.cpp: see h5_set.h.
#include "bricking/import/files/hdf5/h5_set.h"

#include "bricking/import/files/header_words.h" // shownWord

#include <algorithm>
#include <array>
#include <utility>

namespace tessera {
namespace {

void readChunkedLayout(H5Bytes& bytes, int version, H5Layout& layout) {
    layout.kind = H5Layout::Kind::chunked;
    const int flags = version == 4 ? bytes.byte() : 0;
    const std::uint64_t axes = bytes.number(1);
    if (version == 3)
        layout.at = bytes.address();
    const std::size_t each = version == 4 ? bytes.number(1) : 4;
    if (axes < 2 || axes > kMostH5Axes + 1 || each < 1 || each > 8)
        bytes.refuse("chunks of 1 to 32 axes",
                     std::to_string(axes) + ", of " + std::to_string(each) + " bytes");
    for (std::uint64_t axis = 0; axis < axes; ++axis)
        layout.chunk.push_back(bytes.number(each));
    if (version == 3)
        return;
    layout.skipsPartial = (flags & 1) != 0;
    const int index = bytes.byte();
    constexpr std::array<std::uint64_t, 6> kParameters = {0, 0, 0, 1, 5, 6}; // bytes, which the index has too
    if (index < 1 || index > 5)
        bytes.refuse("chunks found in one of five ways", "way " + std::to_string(index));
    layout.index = static_cast<H5Index>(index);
    if (layout.index == H5Index::single && (flags & 2) != 0) {
        layout.singleBytes = bytes.length();
        layout.singleMask = static_cast<std::uint32_t>(bytes.number(4));
    }
    bytes.skip(kParameters[static_cast<std::size_t>(index)]);
    layout.at = bytes.address();
}

H5Layout readLayout(H5Bytes& bytes, const std::string& name) {
    const int version = bytes.byte();
    bytes.requireVersion(version, 3, 4);
    H5Layout layout;
    switch (bytes.byte()) {
    case 0:
        layout.kind = H5Layout::Kind::compact;
        layout.compact = bytes.part(bytes.number(2));
        return layout;
    case 1:
        layout.at = bytes.address();
        return layout;
    case 2:
        readChunkedLayout(bytes, version, layout);
        return layout;
    case 3:
        bytes.file().refuse("numbers of " + name + " in itself",
                            "a virtual set, whose numbers are in others");
    default:
        bytes.refuse("numbers that are compact, contiguous or in chunks", "another layout");
    }
}

std::string filterName(const H5Filter& filter) {
    struct Known {
        int number;
        const char* name;
    };
    constexpr std::array kNames = {Known{4, "szip"},           Known{5, "nbit"},      Known{6, "scaleoffset"},
                                   Known{32000, "lzf"},        Known{32001, "blosc"}, Known{32004, "lz4"},
                                   Known{32008, "bitshuffle"}, Known{32015, "zstd"}};
    for (const Known& known : kNames)
        if (known.number == filter.number)
            return known.name;
    return "filter " + std::to_string(filter.number) +
           (filter.name.empty() ? "" : " " + shownWord(filter.name));
}

std::vector<H5Filter> readFilters(H5Bytes& bytes, const std::string& name) {
    const int version = bytes.byte();
    bytes.requireVersion(version, 1, 2);
    const int count = bytes.byte();
    bytes.skip(version == 1 ? 6 : 0);
    std::vector<H5Filter> filters;
    constexpr int kOwnName = 256;
    for (int n = 0; n < count; ++n) {
        H5Filter filter;
        filter.number = static_cast<int>(bytes.number(2));
        const std::uint64_t letters = version == 1 || filter.number >= kOwnName ? bytes.number(2) : 0;
        bytes.skip(2); // whether writing may go on without it
        const std::uint64_t values = bytes.number(2);
        filter.name = H5Bytes::textOf(bytes.take(version == 1 ? (letters + 7) / 8 * 8 : letters));
        for (std::uint64_t value = 0; value < values; ++value)
            filter.values.push_back(static_cast<std::uint32_t>(bytes.number(4)));
        bytes.skip(version == 1 && values % 2 == 1 ? 4 : 0);
        const int first = kH5Deflate, last = kH5Fletcher;
        if (filter.number < first || filter.number > last)
            bytes.file().refuse("chunks of " + name + " packed by deflate, shuffle and fletcher32 alone",
                                filterName(filter));
        filters.push_back(std::move(filter));
    }
    if (std::ranges::count(filters, kH5Deflate, &H5Filter::number) > 1)
        bytes.refuse("deflate once", "deflate again");
    return filters;
}

/// Empty: none is said.
std::vector<std::byte> readFill(const H5Object& object) {
    auto bytes = object.find(H5Kind::fill);
    if (bytes) {
        const int version = bytes->byte();
        bytes->requireVersion(version, 1, 3);
        const int flags = version == 3 ? bytes->byte() : 0;
        bytes->skip(version == 3 ? 0 : 2);
        const bool isSaid = version == 3 ? (flags & 32) != 0 : bytes->byte() != 0 || version == 1;
        if (!isSaid)
            return {};
    } else if (bytes = object.find(H5Kind::oldFill); !bytes) {
        return {};
    }
    const auto fill = bytes->take(bytes->number(4));
    return {fill.begin(), fill.end()};
}

} // namespace

H5Set readH5Set(const H5Object& object, const std::string& name) {
    const auto required = [&](H5Kind kind, const char* what) {
        auto bytes = object.find(kind);
        if (!bytes)
            object.messages.front().bytes.refuse(std::string("the ") + what + " of " + name, "none");
        return *std::move(bytes);
    };
    H5Set set;
    set.name = name;
    H5Bytes space = required(H5Kind::space, "extents"), type = required(H5Kind::type, "type");
    set.space = readH5Space(space);
    set.type = readH5Type(type);
    H5Bytes layout = required(H5Kind::layout, "layout");
    const H5File& file = layout.file();
    if (object.has(H5Kind::externalFiles))
        file.refuse("numbers of " + name + " in this file", "some in other files");
    set.layout = readLayout(layout, name);
    if (auto filters = object.find(H5Kind::filters))
        set.filters = readFilters(*filters, name);
    const std::size_t each = set.type.bytes;
    set.fill = readFill(object);
    if (set.fill.empty())
        set.fill.resize(each);
    if (set.fill.size() != each)
        file.refuse("a fill value of " + std::to_string(each) + " bytes for " + name,
                    std::to_string(set.fill.size()));
    if (set.layout.kind != H5Layout::Kind::chunked) {
        const std::uint64_t bytes = set.space.count() * each;
        const bool isCompact = set.layout.kind == H5Layout::Kind::compact;
        if (isCompact ? set.layout.compact->left() < bytes
                      : set.layout.at != kH5Nowhere && !file.has(set.layout.at, bytes))
            file.refuse(std::to_string(bytes) + " bytes of " + name + " within the file",
                        "fewer (is it truncated?)");
        return set;
    }
    std::vector<std::uint64_t>& chunk = set.layout.chunk;
    const std::size_t axes = set.space.extents.size();
    if (chunk.size() != axes + 1 || chunk.back() != each)
        file.refuse("chunks of " + std::to_string(axes) + " axes and " + std::to_string(each) +
                        " bytes a number, as " + name + " has",
                    "others");
    chunk.pop_back();
    set.chunkBytes = each;
    constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;
    for (const std::uint64_t side : chunk) {
        if (side < 1 || side > kMostBytes / set.chunkBytes)
            file.refuse("chunks of 1 byte to 1 GiB in " + name, side < 1 ? "empty ones" : "larger ones");
        set.chunkBytes *= side;
    }
    return set;
}

} // namespace tessera
