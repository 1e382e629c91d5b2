// bricking/import/files/hdf5/h5_tree.cpp: see h5_tree.h.
#include "bricking/import/files/hdf5/h5_tree.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <set>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint64_t kNodeOverhead = 10; // mark, version, kind, checksum
constexpr const char* kTree = "a B-tree of version 2";
constexpr const char* kHeap = "a fractal heap";

struct Tree {
    std::uint64_t nodeBytes = 0, recordBytes = 0, rootAt = 0, rootRecords = 0;
    int kind = 0;
    std::uint64_t depth = 0;
    // By level, from the leaves: how many records a node and all below it hold at most, in bytes of that
    // number.
    std::size_t countBytes = 0;
    std::vector<std::size_t> allBytes;
};

Tree readTree(const H5File& file, std::uint64_t at) {
    H5Bytes bytes = file.sealed(at, 22 + file.addressBytes() + file.lengthBytes(), "BTHD", kTree);
    Tree tree;
    bytes.requireVersion(bytes.byte(), 0, 0);
    tree.kind = bytes.byte();
    tree.nodeBytes = bytes.number(4);
    tree.recordBytes = bytes.number(2);
    tree.depth = bytes.number(2);
    bytes.skip(2); // when nodes split and merge
    tree.rootAt = bytes.address();
    tree.rootRecords = bytes.number(2);
    constexpr std::uint64_t kMostDepth = 16;
    if (tree.recordBytes < 1 || tree.nodeBytes < kNodeOverhead + tree.recordBytes || tree.depth > kMostDepth)
        bytes.refuse("a depth of 16 at most, and nodes that hold records",
                     std::to_string(tree.depth) + ", " + std::to_string(tree.nodeBytes) + " bytes for " +
                         std::to_string(tree.recordBytes));
    const std::uint64_t leaf = (tree.nodeBytes - kNodeOverhead) / tree.recordBytes;
    tree.countBytes = bytesToHold(leaf);
    double all = static_cast<double>(leaf);
    std::uint64_t exact = leaf;
    tree.allBytes = {0};
    for (std::uint64_t level = 1; level <= tree.depth; ++level) {
        const std::uint64_t pointer = file.addressBytes() + tree.countBytes + tree.allBytes.back();
        if (tree.nodeBytes < kNodeOverhead + pointer)
            bytes.refuse("nodes that hold records", std::to_string(tree.nodeBytes) + " bytes");
        const std::uint64_t most = (tree.nodeBytes - kNodeOverhead - pointer) / (tree.recordBytes + pointer);
        all = (static_cast<double>(most) + 1) * all + static_cast<double>(most);
        exact = (most + 1) * exact + most;
        if (all > 0x1p62)
            bytes.refuse("2^62 records at most", "a depth of " + std::to_string(tree.depth));
        tree.allBytes.push_back(bytesToHold(exact));
    }
    return tree;
}

class TreeWalk {
  public:
    TreeWalk(const H5File& file, const Tree& tree, const H5Compare& compare,
             const std::function<void(H5Bytes&)>& each)
        : file_(file), tree_(tree), compare_(compare), each_(each) {}

    void walk(std::uint64_t at, std::uint64_t records, std::uint64_t level) {
        checkInterrupted();
        if (!seen_.insert(at).second)
            file_.refuse("nodes of a B-tree once", "one that is met again");
        const std::uint64_t pointers = level == 0
                                           ? 0
                                           : (records + 1) * (file_.addressBytes() + tree_.countBytes +
                                                              (level > 1 ? tree_.allBytes[level - 1] : 0));
        const std::uint64_t used = kNodeOverhead + records * tree_.recordBytes + pointers;
        if (records > tree_.nodeBytes / tree_.recordBytes || used > tree_.nodeBytes)
            file_.refuse("as many records of a B-tree as its nodes hold", std::to_string(records));
        H5Bytes node = file_.sealed(at, used, level == 0 ? "BTLF" : "BTIN", kTree);
        node.requireVersion(node.byte(), 0, 0);
        if (const int kind = node.byte(); kind != tree_.kind)
            node.refuse("nodes of kind " + std::to_string(tree_.kind), std::to_string(kind));
        std::vector<int> order(records);
        std::vector<H5Bytes> all;
        for (std::uint64_t n = 0; n < records; ++n) {
            all.push_back(node.part(tree_.recordBytes));
            if (compare_) {
                order[n] = compare_(all.back());
                if (n > 0 && order[n] < order[n - 1])
                    node.refuse("records in order", "others");
            }
        }
        for (std::uint64_t n = 0; n <= records; ++n) {
            if (level > 0) {
                const std::uint64_t child = node.address(), below = node.number(tree_.countBytes);
                if (level > 1)
                    node.skip(tree_.allBytes[level - 1]);
                if ((n == 0 || order[n - 1] <= 0) && (n == records || order[n] >= 0)) {
                    if (below == 0)
                        node.refuse("nodes with records", "one without");
                    walk(child, below, level - 1);
                }
            }
            if (n < records && order[n] == 0)
                each_(all[n]);
        }
    }

  private:
    const H5File& file_;
    const Tree& tree_;
    const H5Compare& compare_;
    const std::function<void(H5Bytes&)>& each_;
    std::set<std::uint64_t> seen_;
};

} // namespace

H5Bytes H5Blocks::get(std::uint64_t at, std::uint64_t bytes, const char* mark, const char* what,
                      const std::function<void(H5Bytes)>& check) {
    const auto held = held_.find(at);
    if (held != held_.end() && held->second.first == bytes)
        return held->second.second;
    H5Bytes read = mark ? file_.sealed(at, bytes, mark, what) : file_.block(at, bytes, what);
    if (check)
        check(read);
    if (heldBytes_ + bytes > H5File::kMostBlock) {
        held_.clear();
        heldBytes_ = 0;
    }
    held_.insert_or_assign(at, std::pair(bytes, read));
    heldBytes_ += bytes;
    return read;
}

void eachH5Record(const H5File& file, std::uint64_t at, int kind, const H5Compare& compare,
                  const std::function<void(H5Bytes& record)>& each) {
    const Tree tree = readTree(file, at);
    if (tree.kind != kind)
        file.refuse("a B-tree of kind " + std::to_string(kind), std::to_string(tree.kind));
    if (tree.rootAt != kH5Nowhere && tree.rootRecords > 0)
        TreeWalk(file, tree, compare, each).walk(tree.rootAt, tree.rootRecords, tree.depth);
}

std::size_t h5RecordBytes(const H5File& file, std::uint64_t at) {
    return readTree(file, at).recordBytes;
}

H5Heap::H5Heap(const H5File& file, std::uint64_t at) : file_(file), blocks_(file), at_(at) {
    const std::size_t address = file.addressBytes(), length = file.lengthBytes();
    H5Bytes bytes = file.sealed(at, 26 + 3 * address + 12 * length, "FRHP", kHeap);
    bytes.requireVersion(bytes.byte(), 0, 0);
    idBytes_ = bytes.number(2);
    if (bytes.number(2) != 0)
        bytes.refuse("no filters", "some");
    isSummed_ = (bytes.byte() & 2) != 0;
    mostObject_ = bytes.number(4);
    bytes.skip(2 * length + 2 * address); // huge objects; free space, and where it is told
    bytes.skip(8 * length);               // counts
    width_ = bytes.number(2);
    firstBytes_ = bytes.length();
    mostDirect_ = bytes.length();
    maxBits_ = static_cast<int>(bytes.number(2));
    bytes.skip(2);
    rootAt_ = bytes.address();
    rootRows_ = bytes.number(2);
    const auto isPower = [](std::uint64_t n) { return std::has_single_bit(n); };
    constexpr int kMostBits = 62;
    if (!isPower(width_) || !isPower(firstBytes_) || !isPower(mostDirect_) || mostDirect_ < firstBytes_ ||
        mostDirect_ > H5File::kMostBlock || maxBits_ < 1 || maxBits_ > kMostBits || rootRows_ > 64)
        bytes.refuse("blocks of powers of 2, up to 16 MiB", "others");
    offsetBytes_ = static_cast<std::size_t>(maxBits_ + 7) / 8;
    lengthBytes_ = std::min(static_cast<std::size_t>(log2Of(mostDirect_) + 7) / 8, bytesToHold(mostObject_));
}

std::uint64_t H5Heap::rowBytes(std::uint64_t row) const {
    return row == 0 ? firstBytes_ : firstBytes_ << (row - 1);
}

H5Heap::Block H5Heap::directOf(std::uint64_t offset) {
    if (rootAt_ == kH5Nowhere)
        file_.refuse("blocks of a heap", "none");
    if (rootRows_ == 0)
        return {rootAt_, 0, firstBytes_};
    const auto directRows = static_cast<std::uint64_t>(log2Of(mostDirect_ / firstBytes_) + 2);
    const std::size_t head = 5 + file_.addressBytes() + offsetBytes_;
    std::uint64_t at = rootAt_, begin = 0, rows = rootRows_;
    constexpr int kMostLevels = 64;
    for (int level = 0; level < kMostLevels; ++level) {
        const std::uint64_t direct = std::min(rows, directRows) * width_,
                            indirect = (rows - std::min(rows, directRows)) * width_;
        H5Bytes block = blocks_.get(at, head + (direct + indirect) * file_.addressBytes() + 4, "FHIB", kHeap);
        block.skip(head - 4);
        std::uint64_t row = 0, first = begin; // of the row
        while (row < rows && offset - first >= width_ * rowBytes(row))
            first += width_ * rowBytes(row++);
        if (row >= rows)
            break;
        const std::uint64_t column = (offset - first) / rowBytes(row);
        block.skip((row * width_ + column) * file_.addressBytes());
        at = block.address();
        begin = first + column * rowBytes(row);
        if (at == kH5Nowhere)
            break;
        if (row < directRows)
            return {at, begin, rowBytes(row)};
        const int lost = log2Of(rowBytes(row)) - log2Of(firstBytes_ * width_);
        rows = static_cast<std::uint64_t>(std::max(lost, 0) + 1);
    }
    file_.refuse("objects of a heap within its blocks", "one elsewhere");
}

H5Bytes H5Heap::object(H5Bytes& id) {
    const std::size_t before = id.left();
    constexpr int kKind = 0x30;
    if ((id.byte() & kKind) != 0)
        id.refuse("objects within the heap's blocks", "a huge or a tiny one");
    const std::uint64_t offset = id.number(offsetBytes_), bytes = id.number(lengthBytes_);
    if (before < idBytes_ || bytes > mostObject_ || offset >> maxBits_ != 0)
        id.refuse("objects of " + std::to_string(mostObject_) + " bytes at most", std::to_string(bytes));
    const Block block = directOf(offset);
    constexpr std::size_t kMark = 4, kSum = 4;
    const std::size_t head = kMark + 1 + file_.addressBytes() + offsetBytes_ + (isSummed_ ? kSum : 0);
    H5Bytes all = blocks_.get(block.at, block.bytes, nullptr, kHeap, [&](H5Bytes read) {
        H5Bytes whole = read;
        if (H5Bytes::textOf(read.take(kMark)) != "FHDB")
            read.refuse("a block of the heap", "another mark (damage)");
        read.requireVersion(read.byte(), 0, 0);
        if (read.address() != at_ || read.number(offsetBytes_) != block.begin)
            read.refuse("a block of this heap", "one of another");
        if (!isSummed_ || !h5ChecksumsCount)
            return;
        const auto bytes = whole.take(block.bytes);
        std::vector<std::byte> summed(bytes.begin(), bytes.end()); // its checksum counts as zero
        std::fill_n(summed.begin() + static_cast<std::ptrdiff_t>(head - kSum), kSum, std::byte{0});
        if (read.number(kSum) != h5Checksum(summed))
            read.refuse("the checksum of a block", "another (damage)");
    });
    if (offset - block.begin < head)
        id.refuse("objects behind the head of a block", "one within it");
    all.skip(offset - block.begin);
    return all.part(bytes);
}

} // namespace tessera
