// core/base/budget.cpp: see budget.h.
#include "core/base/budget.h"

#include "core/base/budget_error.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace tessera {

MemoryBudget::MemoryBudget(std::string name, std::string option, std::size_t limitBytes)
    : name_(std::move(name)), option_(std::move(option)), limitBytes_(limitBytes) {}

Charge MemoryBudget::charge(std::size_t bytes, std::string_view what) {
    if (auto held = tryCharge(bytes))
        return std::move(*held);
    throw OverBudget(name_ + ": " + std::string(what) + " needs " + formatBytes(bytes) + ", but only " +
                     formatBytes(freeBytes()) + " of the budget of " + formatBytes(limitBytes_) +
                     " are free; raise " + option_);
}

std::optional<Charge> MemoryBudget::tryCharge(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (bytes > limitBytes_ - usedBytes_)
        return std::nullopt;
    usedBytes_ += bytes;
    peakBytes_ = std::max(peakBytes_, usedBytes_);
    return Charge(this, bytes);
}

std::size_t MemoryBudget::usedBytes() const {
    const std::lock_guard lock(mutex_);
    return usedBytes_;
}

std::size_t MemoryBudget::freeBytes() const {
    const std::lock_guard lock(mutex_);
    return limitBytes_ - usedBytes_;
}

std::size_t MemoryBudget::peakBytes() const {
    const std::lock_guard lock(mutex_);
    return peakBytes_;
}

void MemoryBudget::release(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    TESSERA_CHECK(bytes <= usedBytes_);
    usedBytes_ -= bytes;
}

Charge::Charge(Charge&& other) noexcept
    : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}

Charge& Charge::operator=(Charge&& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(bytes_, other.bytes_);
    return *this;
}

Charge::~Charge() {
    if (budget_)
        budget_->release(bytes_);
}

std::size_t parseBytes(std::string_view text, std::string_view option) {
    const std::string copy(text);
    const auto refuse = [&] {
        return InputError(std::string(option) + ": expected a size such as 512MiB or 2GiB, found '" + copy +
                          "'");
    };
    char* end = nullptr;
    const double number = std::strtod(copy.c_str(), &end);
    std::string unit(end);
    std::erase(unit, ' ');
    double scale = 0;
    if (unit.empty() || unit == "B")
        scale = 1;
    if (unit == "KiB" || unit == "K")
        scale = 1024.0;
    if (unit == "MiB" || unit == "M")
        scale = 1024.0 * 1024;
    if (unit == "GiB" || unit == "G")
        scale = 1024.0 * 1024 * 1024;
    if (unit == "TiB" || unit == "T")
        scale = 1024.0 * 1024 * 1024 * 1024;
    const double bytes = number * scale;
    if (end == copy.c_str() || !(bytes >= 1) || !(bytes < 0x1p62))
        throw refuse();
    return static_cast<std::size_t>(bytes);
}

std::string formatBytes(std::size_t bytes) {
    static constexpr std::array units = {"B", "KiB", "MiB", "GiB", "TiB"};
    double number = static_cast<double>(bytes);
    std::size_t unit = 0;
    while (number >= 1024 && unit + 1 < units.size()) {
        number /= 1024;
        ++unit;
    }
    char text[48];
    const bool whole = number == std::floor(number) || number >= 100;
    const double shown = whole ? std::ceil(number) : std::ceil(number * 100) / 100;
    std::snprintf(text, sizeof text, whole ? "%.0f %s" : "%.2f %s", shown, units[unit]);
    return text;
}

} // namespace tessera
