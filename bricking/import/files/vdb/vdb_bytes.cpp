// bricking/import/files/vdb/vdb_bytes.cpp: see vdb_bytes.h.
#include "bricking/import/files/vdb/vdb_bytes.h"

#include "core/base/error.h"

#include <algorithm>

namespace tessera {

void VdbBytes::refuse(const std::string& expected, const std::string& found) const {
    throw badFile(file_.path().string(), expected, found);
}

void VdbBytes::require(std::uint64_t bytes) const {
    if (at_ > end_ || bytes > end_ - at_)
        refuse("a whole grid of OpenVDB", std::to_string(at_ > end_ ? 0 : end_ - at_) + " bytes where " +
                                              std::to_string(bytes) + " follow (is it truncated?)");
}

void VdbBytes::read(std::span<std::byte> out) {
    require(out.size());
    while (!out.empty()) {
        if (at_ < heldAt_ || at_ >= heldAt_ + held_.size()) {
            held_.resize(std::min<std::uint64_t>(portion_, end_ - at_));
            heldAt_ = at_;
            file_.readAt(at_, held_);
        }
        const std::span<const std::byte> here = std::span(held_).subspan(at_ - heldAt_);
        const std::size_t step = std::min(here.size(), out.size());
        std::copy_n(here.begin(), step, out.begin());
        out = out.subspan(step);
        at_ += step;
    }
}

void VdbBytes::skip(std::uint64_t bytes) {
    require(bytes);
    at_ += bytes;
}

std::string VdbBytes::word() {
    constexpr std::uint32_t kMost = 4096;
    const auto length = number<std::uint32_t>();
    if (length > kMost)
        refuse("words of 4096 bytes at most", std::to_string(length));
    std::string text(length, '\0');
    read(std::as_writable_bytes(std::span(text)));
    return text;
}

} // namespace tessera
