// render/empty_space/shown_ranges.h: the visible values of a transfer function, and the values in which two
// functions can differ. After an edit only cells with such values need a new test.
#pragma once

#include "core/scene/transfer_function.h"

#include <vector>

namespace tessera {

/// Physical units, both ends included; ends may be infinite.
struct ValueRange {
    double lowest = 0, highest = 0;
    bool meets(const ValueRange& other) const { return lowest <= other.highest && other.lowest <= highest; }
};

class ShownRanges {
  public:
    ShownRanges() = default;
    explicit ShownRanges(const TransferTable& table);

    /// Ranges of values such that TransferTable::emptyOver() is equal for both tables on every range that
    /// meets none of them.
    std::vector<ValueRange> differences(const ShownRanges& other) const;

  private:
    bool shows(double value) const;
    std::vector<double> ends() const; // of shown_, finite ones

    double firstValue_ = 0, entriesPerValue_ = 1;
    std::size_t entries_ = 0;
    std::vector<ValueRange> shown_; // ascending, half an entry beyond the outermost entries that are not 0
    bool tooMany_ = false;          // more ranges: then everything counts as different
};

} // namespace tessera
