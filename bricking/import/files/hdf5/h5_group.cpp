// bricking/import/files/hdf5/h5_group.cpp: see h5_group.h.
#include "bricking/import/files/hdf5/h5_group.h"

#include "bricking/import/files/hdf5/h5_tree.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint64_t kLongestName = 4096;

/// Old groups: names in a heap, links in nodes of symbols below a B-tree.
class SymbolTable {
  public:
    SymbolTable(const H5File& file, std::vector<H5Link>& links) : file_(file), links_(links) {}

    void read(std::uint64_t tree, std::uint64_t heap) {
        H5Bytes bytes = file_.block(heap, 8 + 2 * file_.lengthBytes() + file_.addressBytes(), "a local heap");
        requireMark(bytes, "HEAP");
        bytes.requireVersion(bytes.byte(), 0, 0);
        bytes.skip(3);
        namesBytes_ = bytes.length();
        bytes.skip(file_.lengthBytes());
        namesAt_ = bytes.address();
        if (!file_.has(namesAt_, namesBytes_))
            bytes.refuse("names within the file", "some behind its end");
        constexpr int kAnyLevel = -1;
        readNode(tree, kAnyLevel);
    }

  private:
    static void requireMark(H5Bytes& bytes, const char* mark) {
        if (H5Bytes::textOf(bytes.take(4)) != mark)
            bytes.refuse(std::string("the mark ") + mark, "another (damage)");
    }

    void requireNew(std::uint64_t at) {
        checkInterrupted();
        if (!seen_.insert(at).second)
            file_.refuse("nodes of a group once", "one that is met again");
    }

    void readNode(std::uint64_t at, int expected) {
        requireNew(at);
        const char* const what = "a group's B-tree";
        const std::uint64_t head = 8 + 2 * file_.addressBytes();
        H5Bytes bytes = file_.block(at, head, what);
        requireMark(bytes, "TREE");
        const int kind = bytes.byte(), level = bytes.byte();
        constexpr int kMostLevel = 32;
        if (kind != 0 || (expected >= 0 ? level != expected : level > kMostLevel))
            bytes.refuse("levels of symbols one below another",
                         "kind " + std::to_string(kind) + ", level " + std::to_string(level));
        const std::uint64_t entries = bytes.number(2);
        H5Bytes rest = file_.block(at + head, entries * (file_.lengthBytes() + file_.addressBytes()), what);
        for (std::uint64_t n = 0; n < entries; ++n) {
            rest.skip(file_.lengthBytes()); // its first name
            const std::uint64_t child = rest.address();
            if (level > 0)
                readNode(child, level - 1);
            else
                readSymbols(child);
        }
    }

    void readSymbols(std::uint64_t at) {
        requireNew(at);
        const char* const what = "a group's symbols";
        H5Bytes bytes = file_.block(at, 8, what);
        requireMark(bytes, "SNOD");
        bytes.requireVersion(bytes.byte(), 1, 1);
        bytes.skip(1);
        const std::uint64_t symbols = bytes.number(2), each = 24 + 2 * file_.addressBytes();
        H5Bytes rest = file_.block(at + 8, symbols * each, what);
        for (std::uint64_t n = 0; n < symbols; ++n) {
            H5Link link;
            link.name = nameAt(rest.address());
            link.at = rest.address();
            constexpr std::uint64_t kSoft = 2;
            if (rest.number(4) == kSoft)
                link.at = kH5Nowhere;
            rest.skip(20);
            links_.push_back(std::move(link));
        }
    }

    std::string nameAt(std::uint64_t offset) {
        if (offset >= namesBytes_)
            file_.refuse("names within a group's heap", "one behind its end");
        std::vector<std::byte> name(std::min(namesBytes_ - offset, kLongestName));
        file_.readAt(namesAt_ + offset, name);
        if (std::ranges::find(name, std::byte{0}) == name.end())
            file_.refuse("names of links that end", "one that does not");
        return H5Bytes::textOf(name);
    }

    const H5File& file_;
    std::vector<H5Link>& links_;
    std::uint64_t namesAt_ = 0, namesBytes_ = 0;
    std::set<std::uint64_t> seen_;
};

H5Link linkOf(H5Bytes bytes) {
    bytes.requireVersion(bytes.byte(), 1, 1);
    const int flags = bytes.byte();
    constexpr int kHard = 0, kExternal = 64;
    const int kind = (flags & 8) != 0 ? bytes.byte() : kHard;
    bytes.skip((flags & 4) != 0 ? 8 : 0);  // order of creation
    bytes.skip((flags & 16) != 0 ? 1 : 0); // letters: UTF-8 or ASCII
    const std::uint64_t length = bytes.number(std::size_t{1} << (flags & 3));
    if (length > kLongestName)
        bytes.refuse("names of links of 4096 bytes at most", std::to_string(length));
    const auto name = bytes.take(length);
    H5Link link;
    link.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
    link.leadsOut = kind == kExternal;
    if (kind == kHard)
        link.at = bytes.address();
    return link;
}

} // namespace

bool isH5Group(const H5Object& object) {
    return object.has(H5Kind::symbolTable) || object.has(H5Kind::linkInfo) || object.has(H5Kind::link);
}

std::vector<H5Link> linksOf(const H5File& file, const H5Object& group) {
    std::vector<H5Link> links;
    if (auto table = group.find(H5Kind::symbolTable)) {
        const std::uint64_t tree = table->address();
        SymbolTable(file, links).read(tree, table->address());
    }
    for (const H5Message& message : group.messages)
        if (message.kind == static_cast<int>(H5Kind::link) && !message.isShared)
            links.push_back(linkOf(message.bytes));
    if (auto info = group.find(H5Kind::linkInfo)) {
        info->requireVersion(info->byte(), 0, 0);
        info->skip((info->byte() & 1) != 0 ? 8 : 0);
        const std::uint64_t heapAt = info->address(), names = info->address();
        if (heapAt != kH5Nowhere) {
            H5Heap heap(file, heapAt);
            constexpr int kByName = 5;
            eachH5Record(file, names, kByName, {}, [&](H5Bytes& record) {
                record.skip(4); // the name's checksum
                links.push_back(linkOf(heap.object(record)));
            });
        }
    }
    return links;
}

std::optional<H5Object> objectBelow(const H5File& file, const H5Object& group,
                                    const std::vector<std::string>& names) {
    H5Object object = group;
    for (const std::string& name : names) {
        if (!isH5Group(object))
            return std::nullopt;
        const std::vector<H5Link> links = linksOf(file, object);
        const auto link = std::ranges::find_if(
            links, [&](const H5Link& each) { return each.name == name && each.at != kH5Nowhere; });
        if (link == links.end())
            return std::nullopt;
        object = readH5Object(file, link->at);
    }
    return object;
}

} // namespace tessera
