// bricking/import/files/stack/slice_gaps.cpp: see slice_gaps.h.
#include "bricking/import/files/stack/slice_gaps.h"

#include "bricking/import/source/blended_slices.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace tessera {
namespace {

class GapSource final : public RandomSlabSource {
  public:
    GapSource(std::unique_ptr<RandomSlabSource> slices, const std::vector<std::uint64_t>& places)
        : slices_(std::move(slices)), places_(places.begin(), places.end()) {
        takeInfo();
    }

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return slices_->describe(); }
    std::vector<std::string> notes() const override { return slices_->notes(); }
    VoxelTally takeTally() override { return slices_->takeTally(); }
    std::size_t roomBytes() const override { return slices_->roomBytes() + 2 * sliceBytesOf(info_); }

    void readSliceAt(int z, std::span<std::byte> out) override {
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && out.size() == sliceBytesOf(info_));
        const auto next = std::upper_bound(places_.begin(), places_.end(), z);
        const int lower = static_cast<int>(next - places_.begin()) - 1;
        const int from = places_[static_cast<std::size_t>(lower)];
        const auto& below = kept(lower, lower);
        if (from == z) {
            std::copy(below.begin(), below.end(), out.begin());
            return;
        }
        const auto weight = static_cast<float>(z - from) / static_cast<float>(*next - from);
        blendSlices(info_.type, below, kept(lower + 1, lower), weight, out);
    }

  private:
    struct Kept {
        int slice = -1;
        std::vector<std::byte> values;
    };

    void takeInfo() {
        info_ = slices_->info();
        info_.extentVoxels.z = places_.back() + 1;
    }

    /// Slice n of those that there are, kept with one other; `other` is the one not to replace.
    const std::vector<std::byte>& kept(int n, int other) {
        for (const Kept& each : kept_)
            if (each.slice == n)
                return each.values;
        Kept& place = kept_[0].slice == other ? kept_[1] : kept_[0];
        place.slice = -1; // stays so if reading throws
        place.values.resize(sliceBytesOf(info_));
        slices_->readSliceAt(n, place.values);
        place.slice = n;
        takeInfo();
        return place.values;
    }

    std::unique_ptr<RandomSlabSource> slices_;
    std::vector<int> places_;
    VolumeInfo info_;
    std::array<Kept, 2> kept_;
};

} // namespace

std::unique_ptr<RandomSlabSource> fillGaps(std::unique_ptr<RandomSlabSource> slices,
                                           const std::vector<std::uint64_t>& places) {
    return std::make_unique<GapSource>(std::move(slices), places);
}

} // namespace tessera
