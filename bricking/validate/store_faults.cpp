// bricking/validate/store_faults.cpp: see store_faults.h.
#include "bricking/validate/store_faults.h"

#include <algorithm>
#include <tuple>

namespace tessera {

void StoreFaults::add(const std::string& part, const std::string& text) {
    const std::lock_guard lock(mutex_);
    ++parts_[part].faults;
    if (lines_.size() < kMostLines)
        lines_.push_back({text, part});
}

void StoreFaults::mend(const std::string& part) {
    const std::lock_guard lock(mutex_);
    parts_[part].isMended = true;
}

void StoreFaults::leave(const std::string& part, const std::string& why) {
    const std::lock_guard lock(mutex_);
    parts_[part].why = why;
}

bool StoreFaults::has(const std::string& part) const {
    const std::lock_guard lock(mutex_);
    const auto at = parts_.find(part);
    return at != parts_.end() && at->second.faults > 0;
}

std::uint64_t StoreFaults::count() const {
    const std::lock_guard lock(mutex_);
    std::uint64_t faults = 0;
    for (const auto& [name, part] : parts_)
        faults += part.faults;
    return faults;
}

std::uint64_t StoreFaults::mended() const {
    const std::lock_guard lock(mutex_);
    std::uint64_t faults = 0;
    for (const auto& [name, part] : parts_)
        faults += part.isMended ? part.faults : 0;
    return faults;
}

std::size_t StoreFaults::listed() const {
    const std::lock_guard lock(mutex_);
    return lines_.size();
}

void StoreFaults::sortFrom(std::size_t first) {
    const std::lock_guard lock(mutex_);
    std::sort(
        lines_.begin() + static_cast<std::ptrdiff_t>(first), lines_.end(),
        [](const Line& a, const Line& b) { return std::tie(a.part, a.text) < std::tie(b.part, b.text); });
}

std::vector<std::string> StoreFaults::lines() const {
    std::vector<std::string> texts;
    for (const Line& line : lines_) {
        const Part& part = parts_.at(line.part);
        texts.push_back(line.text + (part.isMended      ? " -- made again"
                                     : part.why.empty() ? ""
                                                        : " -- stays: " + part.why));
    }
    return texts;
}

} // namespace tessera
