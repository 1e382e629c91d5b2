// bricking/labels/label_sets.cpp: see label_sets.h.
#include "bricking/labels/label_sets.h"

#include "core/base/error.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kNodeBytes = 48; // of an entry of a hash table, with its share of the buckets

std::uint64_t hashOf(std::span<const std::uint32_t> numbers) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const std::uint32_t number : numbers) {
        hash = (hash ^ number) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
    }
    return hash;
}

std::uint64_t keyOf(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{a} << 32 | b;
}

} // namespace

LabelSets::LabelSets(MemoryBudget& ram, std::string where) : ram_(ram), where_(std::move(where)), first_{0} {
    numberOf({});
}

void LabelSets::pay() {
    // Twice, because a vector that grows holds old and new at once.
    const std::size_t needed =
        2 * (first_.capacity() * sizeof(std::size_t) + numbers_.capacity() * sizeof(std::uint32_t)) +
        kNodeBytes * (byHash_.size() + with_.size() + together_.size());
    while (paid_.size() * kStepBytes < needed)
        paid_.push_back(ram_.charge(kStepBytes, "the sets of labels of a file"));
}

std::uint32_t LabelSets::numberOf(std::span<const std::uint32_t> numbers) {
    const std::uint64_t hash = hashOf(numbers);
    const auto [begin, end] = byHash_.equal_range(hash);
    for (auto it = begin; it != end; ++it)
        if (std::ranges::equal(of(it->second), numbers))
            return it->second;
    if (size() == kMost)
        throw badFile(where_, "at most " + std::to_string(kMost) + " sets of labels that share voxels",
                      "more");
    const auto number = static_cast<std::uint32_t>(size());
    numbers_.insert(numbers_.end(), numbers.begin(), numbers.end());
    first_.push_back(numbers_.size());
    byHash_.emplace(hash, number);
    pay();
    return number;
}

std::uint32_t LabelSets::with(std::uint32_t set, std::uint32_t number) {
    const std::uint64_t key = keyOf(set, number);
    if (const auto known = with_.find(key); known != with_.end())
        return known->second;
    const auto before = of(set);
    scratch_.assign(before.begin(), before.end());
    if (const auto at = std::ranges::lower_bound(scratch_, number); at == scratch_.end() || *at != number)
        scratch_.insert(at, number);
    const std::uint32_t result = numberOf(scratch_);
    with_.emplace(key, result);
    return result;
}

std::uint32_t LabelSets::together(std::uint32_t a, std::uint32_t b) {
    if (a == b || b == 0)
        return a;
    if (a == 0)
        return b;
    const std::uint64_t key = keyOf(std::min(a, b), std::max(a, b));
    if (const auto known = together_.find(key); known != together_.end())
        return known->second;
    scratch_.clear();
    std::ranges::set_union(of(a), of(b), std::back_inserter(scratch_));
    const std::uint32_t result = numberOf(scratch_);
    together_.emplace(key, result);
    return result;
}

} // namespace tessera
