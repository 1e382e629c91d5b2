// bricking/import/dicom/encapsulated_frames.cpp: see encapsulated_frames.h. Encapsulated data is always
// little endian.
#include "bricking/import/dicom/encapsulated_frames.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <string>

namespace tessera {
namespace {

constexpr std::uint32_t kFragment = 0xE000FFFE,
                        kLastFragment = 0xE0DDFFFE; // group first, as it lies in the file
constexpr std::uint64_t kItemHeaderBytes = 8;
constexpr std::size_t kMostFragments = 1 << 20;

std::uint32_t littleEndian(const std::byte* at) {
    std::uint32_t value = 0;
    for (int i = 4; i-- > 0;)
        value = value << 8 | std::to_integer<std::uint32_t>(at[i]);
    return value;
}

/// All items, the table of offsets first.
std::vector<Fragment> readItems(const InputFile& file, std::uint64_t at) {
    std::vector<Fragment> items;
    const std::string where = file.path().string();
    while (true) {
        std::array<std::byte, kItemHeaderBytes> head;
        if (file.readSome(at, head) < head.size())
            throw badFile(where, "compressed pixels up to an end mark",
                          "the end of the file (is it truncated?)");
        const std::uint32_t tag = littleEndian(head.data()), length = littleEndian(head.data() + 4);
        if (tag == kLastFragment)
            return items;
        if (tag != kFragment)
            throw badFile(where, "an item of compressed pixels at byte " + std::to_string(at),
                          "something else");
        if (length > file.sizeBytes() - at - kItemHeaderBytes)
            throw badFile(where, std::to_string(length) + " bytes of compressed pixels",
                          std::to_string(file.sizeBytes() - at - kItemHeaderBytes) +
                              " bytes (is the file truncated?)");
        if (items.size() == kMostFragments)
            throw badFile(where, "at most 1048576 items of compressed pixels", "more");
        items.push_back({at + kItemHeaderBytes, length});
        at += kItemHeaderBytes + length;
    }
}

/// Frames begin at the table's offsets, each at the beginning of a fragment.
std::vector<std::vector<Fragment>> framesByTable(const InputFile& file, const std::vector<Fragment>& items,
                                                 int frames) {
    std::vector<std::byte> table(items.front().lengthBytes);
    file.readAt(items.front().offsetBytes, table);
    const std::uint64_t origin = items[1].offsetBytes - kItemHeaderBytes;
    std::vector<std::vector<Fragment>> found;
    for (std::size_t i = 1; i < items.size(); ++i) {
        const std::uint64_t start = items[i].offsetBytes - kItemHeaderBytes - origin;
        if (found.size() < static_cast<std::size_t>(frames) &&
            start == littleEndian(&table[4 * found.size()]))
            found.emplace_back();
        if (found.empty())
            break;
        found.back().push_back(items[i]);
    }
    if (found.size() != static_cast<std::size_t>(frames))
        throw badFile(file.path().string(), "a table of offsets that names fragments",
                      "offsets between fragments");
    return found;
}

} // namespace

std::vector<std::vector<Fragment>> framesOf(const InputFile& file, std::uint64_t offsetBytes, int frames) {
    const std::vector<Fragment> items = readItems(file, offsetBytes);
    const std::string where = file.path().string();
    if (items.size() < 2)
        throw badFile(where, "compressed pixels", "no fragment of them");
    if (frames == 1)
        return {{items.begin() + 1, items.end()}};
    if (items.size() - 1 == static_cast<std::size_t>(frames)) {
        std::vector<std::vector<Fragment>> each;
        for (std::size_t i = 1; i < items.size(); ++i)
            each.push_back({items[i]});
        return each;
    }
    if (items.front().lengthBytes / 4 != static_cast<std::uint32_t>(frames) ||
        items.front().lengthBytes % 4 != 0)
        throw badFile(where,
                      "one fragment for each of " + std::to_string(frames) +
                          " frames, or a table of their offsets",
                      std::to_string(items.size() - 1) + " fragments and a table of " +
                          std::to_string(items.front().lengthBytes / 4));
    return framesByTable(file, items, frames);
}

std::vector<std::byte> readFrame(const InputFile& file, const std::vector<Fragment>& fragments) {
    std::size_t bytes = 0;
    for (const Fragment& fragment : fragments)
        bytes += fragment.lengthBytes;
    std::vector<std::byte> stream(bytes);
    std::size_t at = 0;
    for (const Fragment& fragment : fragments) {
        file.readAt(fragment.offsetBytes, std::span(stream).subspan(at, fragment.lengthBytes));
        at += fragment.lengthBytes;
    }
    return stream;
}

} // namespace tessera
