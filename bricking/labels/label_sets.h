// bricking/labels/label_sets.h: LabelSets: sets of numbers, each kept once and known by a number of its own.
#pragma once

#include "core/base/budget.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace tessera {

class LabelSets {
  public:
    static constexpr std::size_t kMost = std::size_t{1} << 20; // sets
    static constexpr std::size_t kStepBytes = std::size_t{1} << 20;

    /// Set 0 is empty. Charges ram in steps of kStepBytes as sets come, the first one at once.
    /// @param where  the file, for messages
    LabelSets(MemoryBudget& ram, std::string where);

    std::size_t size() const { return first_.size() - 1; }
    /// Its numbers, ascending.
    std::span<const std::uint32_t> of(std::uint32_t set) const {
        return std::span(numbers_).subspan(first_[set], first_[set + 1] - first_[set]);
    }
    /// The number of a set, which is kept where it is new. Throws InputError for more than kMost sets, or
    /// where ram cannot hold them.
    /// @param numbers  ascending, none twice
    std::uint32_t numberOf(std::span<const std::uint32_t> numbers);
    /// Of the set with one more number, and of the numbers of two sets together.
    std::uint32_t with(std::uint32_t set, std::uint32_t number);
    std::uint32_t together(std::uint32_t a, std::uint32_t b);

  private:
    void pay();

    MemoryBudget& ram_;
    std::string where_;
    std::vector<Charge> paid_;
    std::vector<std::size_t> first_; // into numbers_, and one more
    std::vector<std::uint32_t> numbers_;
    std::unordered_multimap<std::uint64_t, std::uint32_t> byHash_;
    std::unordered_map<std::uint64_t, std::uint32_t> with_, together_; // by two numbers
    std::vector<std::uint32_t> scratch_;
};

} // namespace tessera
