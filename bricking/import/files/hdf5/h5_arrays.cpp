// bricking/import/files/hdf5/h5_arrays.cpp: see h5_arrays.h.
#include "bricking/import/files/hdf5/h5_arrays.h"

#include <algorithm>
#include <bit>
#include <string>

namespace tessera {
namespace {

constexpr std::size_t kSum = 4;
constexpr const char* kFixed = "a fixed array of chunks";
constexpr const char* kGrowing = "an extensible array of chunks";

/// The highest bit of a byte comes first.
bool isBitSet(H5Bytes bytes, std::uint64_t number) {
    bytes.skip(number / 8);
    return (bytes.byte() >> (7 - number % 8) & 1) != 0;
}

std::uint64_t roundedUp(std::uint64_t number, std::uint64_t step) {
    return number / step + (number % step != 0 ? 1 : 0);
}

void requireKind(H5Bytes& bytes, const H5Entries& entries) {
    bytes.requireVersion(bytes.byte(), 0, 0);
    if (bytes.byte() != (entries.areFiltered ? 1 : 0))
        bytes.refuse(entries.areFiltered ? "chunks with filters" : "chunks without filters", "others");
}

} // namespace

void H5Entries::setBytes(std::size_t said, const H5File& file) {
    const std::size_t address = file.addressBytes();
    if (areFiltered ? said < address + 5 || said > address + 12 : said != address)
        file.refuse("entries of a chunk's place", std::to_string(said) + " bytes");
    bytes = said;
}

H5Extent H5Entries::read(H5Bytes& entry) const {
    H5Extent extent;
    extent.at = entry.address();
    extent.bytes = chunkBytes;
    if (areFiltered) {
        extent.bytes = entry.number(bytes - entry.file().addressBytes() - 4);
        extent.mask = static_cast<std::uint32_t>(entry.number(4));
    }
    return extent;
}

H5Extent H5Entries::readAt(H5Bytes all, std::uint64_t number) const {
    all.skip(number * bytes);
    return read(all);
}

H5FixedArray::H5FixedArray(const H5File& file, std::uint64_t at, H5Entries entries)
    : file_(file), blocks_(file), entries_(entries), headerAt_(at) {
    H5Bytes bytes = file.sealed(at, 12 + file.lengthBytes() + file.addressBytes(), "FAHD", kFixed);
    requireKind(bytes, entries_);
    entries_.setBytes(bytes.number(1), file);
    const int pageBits = bytes.byte();
    constexpr int kMostBits = 20;
    if (pageBits < 1 || pageBits > kMostBits)
        bytes.refuse("pages of 2^20 entries at most", "2^" + std::to_string(pageBits));
    perPage_ = std::uint64_t{1} << pageBits;
    count_ = bytes.length();
    dataAt_ = bytes.address();
}

H5Extent H5FixedArray::entry(std::uint64_t number) {
    if (dataAt_ == kH5Nowhere || number >= count_)
        return {};
    const std::uint64_t head = 6 + file_.addressBytes();
    const bool hasPages = count_ > perPage_;
    const std::uint64_t pages = hasPages ? roundedUp(count_, perPage_) : 0, map = roundedUp(pages, 8);
    if (count_ > file_.sizeBytes())
        file_.refuse("entries of chunks within the file", std::to_string(count_) + " of them");
    H5Bytes bytes =
        blocks_.get(dataAt_, head + map + (hasPages ? 0 : count_ * entries_.bytes) + kSum, "FADB", kFixed);
    requireKind(bytes, entries_);
    if (bytes.address() != headerAt_)
        bytes.refuse("entries of this array", "those of another");
    if (!hasPages)
        return entries_.readAt(bytes, number);
    const std::uint64_t page = number / perPage_;
    if (!isBitSet(bytes, page))
        return {};
    const std::uint64_t at = dataAt_ + head + map + kSum + page * (perPage_ * entries_.bytes + kSum),
                        here = std::min(perPage_, count_ - page * perPage_);
    return entries_.readAt(blocks_.get(at, here * entries_.bytes + kSum, "", kFixed), number % perPage_);
}

H5GrowingArray::H5GrowingArray(const H5File& file, std::uint64_t at, H5Entries entries)
    : file_(file), blocks_(file), entries_(entries), headerAt_(at) {
    H5Bytes bytes = file.sealed(at, 16 + 6 * file.lengthBytes() + file.addressBytes(), "EAHD", kGrowing);
    requireKind(bytes, entries_);
    entries_.setBytes(bytes.number(1), file);
    const int mostBits = bytes.byte();
    inIndex_ = bytes.number(1);
    const std::uint64_t leastEntries = bytes.number(1);
    leastPointers_ = bytes.number(1);
    const int pageBits = bytes.byte();
    constexpr int kMostBits = 48, kMostPageBits = 20;
    if (mostBits > kMostBits || pageBits < 1 || pageBits > kMostPageBits ||
        !std::has_single_bit(leastEntries) || !std::has_single_bit(leastPointers_) || leastPointers_ < 2 ||
        mostBits < log2Of(leastEntries) + 1)
        bytes.refuse("blocks of powers of 2", "others");
    perPage_ = std::uint64_t{1} << pageBits;
    offsetBytes_ = static_cast<std::size_t>(mostBits + 7) / 8;
    Level level;
    for (int n = 0; n <= mostBits - log2Of(leastEntries); ++n) {
        level.blocks = std::uint64_t{1} << (n / 2);
        level.entries = leastEntries << ((n + 1) / 2);
        levels_.push_back(level);
        level.firstEntry += level.blocks * level.entries;
        level.firstBlock += level.blocks;
    }
    bytes.skip(6 * file.lengthBytes()); // counts
    indexAt_ = bytes.address();
}

/// A block behind its mark and the place of the header.
H5Bytes H5GrowingArray::headless(std::uint64_t at, std::uint64_t bytes, const char* mark) {
    H5Bytes block = blocks_.get(at, bytes, mark, kGrowing);
    requireKind(block, entries_);
    if (block.address() != headerAt_)
        block.refuse("entries of this array", "those of another");
    return block;
}

/// 0: a block is in one piece.
std::uint64_t H5GrowingArray::pagesOf(const Level& level) const {
    return level.entries > perPage_ ? level.entries / perPage_ : 0;
}

H5Extent H5GrowingArray::ofBlock(std::uint64_t at, const Level& level, std::uint64_t number,
                                 bool isPageThere) {
    if (at == kH5Nowhere)
        return {};
    const std::uint64_t head = 6 + file_.addressBytes() + offsetBytes_;
    if (pagesOf(level) == 0) {
        H5Bytes block = headless(at, head + level.entries * entries_.bytes + kSum, "EADB");
        block.skip(offsetBytes_);
        return entries_.readAt(block, number);
    }
    static_cast<void>(headless(at, head + kSum, "EADB"));
    if (!isPageThere)
        return {};
    const std::uint64_t page = perPage_ * entries_.bytes + kSum;
    return entries_.readAt(blocks_.get(at + head + kSum + number / perPage_ * page, page, "", kGrowing),
                           number % perPage_);
}

H5Extent H5GrowingArray::entry(std::uint64_t number) {
    if (indexAt_ == kH5Nowhere)
        return {};
    const std::size_t address = file_.addressBytes();
    const std::uint64_t head = 6 + address,
                        inIndexLevels = static_cast<std::uint64_t>(2 * log2Of(leastPointers_)),
                        direct = 2 * (leastPointers_ - 1);
    const std::uint64_t others = levels_.size() - std::min<std::uint64_t>(levels_.size(), inIndexLevels);
    H5Bytes index =
        headless(indexAt_, head + inIndex_ * entries_.bytes + (direct + others) * address + kSum, "EAIB");
    if (number < inIndex_)
        return entries_.readAt(index, number);
    index.skip(inIndex_ * entries_.bytes);
    number -= inIndex_;
    const auto n = static_cast<std::size_t>(log2Of(number / levels_.front().entries + 1));
    if (n >= levels_.size())
        index.refuse("entries of chunks up to the most that may be", "one behind them");
    const Level& level = levels_[n];
    number -= level.firstEntry;
    const std::uint64_t block = number / level.entries;
    number %= level.entries;
    if (n < inIndexLevels) {
        index.skip((level.firstBlock + block) * address);
        return ofBlock(index.address(), level, number, true);
    }
    index.skip((direct + n - inIndexLevels) * address);
    const std::uint64_t at = index.address();
    if (at == kH5Nowhere)
        return {};
    const std::uint64_t pages = pagesOf(level), map = level.blocks * roundedUp(pages, 8);
    H5Bytes super = headless(at, head + offsetBytes_ + map + level.blocks * address + kSum, "EASB");
    super.skip(offsetBytes_);
    const bool isThere = pages == 0 || isBitSet(super, block * pages + number / perPage_);
    super.skip(map + block * address);
    return ofBlock(super.address(), level, number, isThere);
}

} // namespace tessera
