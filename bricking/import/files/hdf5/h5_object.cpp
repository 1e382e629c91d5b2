// bricking/import/files/hdf5/h5_object.cpp: see h5_object.h.
#include "bricking/import/files/hdf5/h5_object.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr const char* kHeader = "an object's header";

class HeaderReader {
  public:
    HeaderReader(const H5File& file, std::uint64_t at) : file_(file) { object_.at = at; }

    H5Object read() {
        std::array<std::byte, 16> head{};
        const std::uint64_t at = object_.at;
        if (!file_.has(at, head.size()))
            file_.refuse("an object's header within the file", "one behind its end");
        file_.readAt(at, head);
        isNew_ = head[0] == std::byte{'O'};
        if (isNew_)
            readNew(at);
        else
            readOld(at);
        while (!parts_.empty()) {
            const auto [part, bytes] = parts_.back();
            parts_.pop_back();
            if (!seen_.insert(part).second)
                file_.refuse("parts of an object's header one after another", "one that points back");
            addPart(bytes);
            H5Bytes messages =
                isNew_ ? file_.sealed(part, bytes, "OCHK", kHeader) : file_.block(part, bytes, kHeader);
            readMessages(messages);
        }
        return std::move(object_);
    }

  private:
    void addPart(std::uint64_t bytes) {
        if (bytes > H5File::kMostBlock || (all_ += bytes) > H5File::kMostBlock)
            file_.refuse("an object's header of 16 MiB at most", "a longer one");
    }

    void readOld(std::uint64_t at) {
        constexpr std::uint64_t kPrefix = 16;
        H5Bytes head = file_.block(at, kPrefix, kHeader);
        head.requireVersion(head.byte(), 1, 1);
        head.skip(7); // how many messages and links there are
        const std::uint64_t bytes = head.number(4);
        addPart(bytes);
        H5Bytes messages = file_.block(at + kPrefix, bytes, kHeader);
        readMessages(messages);
    }

    void readNew(std::uint64_t at) {
        constexpr std::uint64_t kSum = 4, kLongest = 34;
        H5Bytes head = file_.block(at, std::min(kLongest, file_.sizeBytes() - at), kHeader);
        const std::size_t all = head.left();
        head.skip(4);
        head.requireVersion(head.byte(), 2, 2);
        const int flags = head.byte();
        hasOrder_ = (flags & 4) != 0;
        head.skip((flags & 32) != 0 ? 16 : 0); // times
        head.skip((flags & 16) != 0 ? 4 : 0);  // when attributes move
        const std::uint64_t bytes = head.number(std::size_t{1} << (flags & 3));
        const std::uint64_t prefix = all - head.left();
        addPart(bytes);
        H5Bytes messages = file_.sealed(at, prefix + bytes + kSum, "OHDR", kHeader);
        messages.skip(prefix - 4);
        readMessages(messages);
    }

    void readMessages(H5Bytes& bytes) {
        const std::size_t head = isNew_ ? (hasOrder_ ? 6 : 4) : 8;
        while (bytes.left() >= head) { // fewer are a gap
            const int kind = static_cast<int>(bytes.number(isNew_ ? 1 : 2));
            const std::uint64_t size = bytes.number(2);
            const int flags = bytes.byte();
            bytes.skip(isNew_ ? (hasOrder_ ? 2 : 0) : 3);
            H5Message message{kind, (flags & 2) != 0, bytes.part(size)};
            if (kind == static_cast<int>(H5Kind::continuation)) {
                const std::uint64_t part = message.bytes.address();
                parts_.emplace_back(part, message.bytes.length());
            } else if (kind != 0) {
                object_.messages.push_back(std::move(message));
            }
        }
    }

    const H5File& file_;
    H5Object object_;
    bool isNew_ = false, hasOrder_ = false;
    std::uint64_t all_ = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> parts_; // places, bytes
    std::set<std::uint64_t> seen_;
};

} // namespace

bool H5Object::has(H5Kind kind) const {
    return std::ranges::any_of(messages,
                               [&](const H5Message& each) { return each.kind == static_cast<int>(kind); });
}

std::uint64_t placeOfShared(H5Bytes& bytes) {
    const int version = bytes.byte();
    bytes.requireVersion(version, 1, 3);
    const int type = bytes.byte();
    constexpr int kInHeap = 1;
    if (version == 3 && type == kInHeap)
        bytes.refuse("messages of its own", "one of the file's table of shared messages");
    bytes.skip(version == 1 ? 6 : 0);
    return bytes.address();
}

std::optional<H5Bytes> H5Object::find(H5Kind kind) const {
    const auto message = std::ranges::find_if(
        messages, [&](const H5Message& each) { return each.kind == static_cast<int>(kind); });
    if (message == messages.end())
        return std::nullopt;
    H5Bytes bytes = message->bytes;
    if (!message->isShared)
        return bytes;
    const H5Object other = readH5Object(bytes.file(), placeOfShared(bytes));
    for (const H5Message& each : other.messages)
        if (each.kind == static_cast<int>(kind) && !each.isShared)
            return each.bytes;
    bytes.refuse("a message at the place that is said", "none");
}

H5Object readH5Object(const H5File& file, std::uint64_t at) {
    return HeaderReader(file, at).read();
}

} // namespace tessera
