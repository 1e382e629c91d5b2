// render/labels/outline_band.cpp: see outline_band.h.
#include "render/labels/outline_band.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera {
namespace {

/// How far the middle of the nearest place outside lies beyond the border: 1/2 where that goes along the
/// raster, nearly 0 elsewhere, where some place is always near it. With this the width's error, over all
/// directions, is 0 in the mean.
constexpr double kOff = 0.3;

} // namespace

int OutlineBand::reach(double width) {
    return static_cast<int>(std::ceil(width + kOff + 0.5));
}

const std::vector<float>& OutlineBand::of(const std::vector<std::uint8_t>& inside, const glm::ivec2& size,
                                          const glm::ivec2& first, const glm::ivec2& count, double width) {
    const int far = reach(width); // no distance beyond it is asked for
    TESSERA_CHECK(far < 180);     // its square, twice, in 16 bits
    if (width != width_) {
        width_ = width;
        shareOf_.resize(static_cast<std::size_t>(2 * far * far) + 1);
        for (std::size_t i = 0; i < shareOf_.size(); ++i)
            shareOf_[i] = static_cast<float>(
                std::clamp(width + kOff + 0.5 - std::sqrt(static_cast<double>(i)), 0.0, 1.0));
    }
    const auto farSquared = static_cast<std::uint16_t>(far * far);
    const auto wide = static_cast<std::size_t>(size.x);
    alongRow_.assign(inside.size(), farSquared);
    for (int y = 0; y < size.y; ++y) {
        const std::uint8_t* const in = inside.data() + static_cast<std::size_t>(y) * wide;
        std::uint16_t* const out = alongRow_.data() + static_cast<std::size_t>(y) * wide;
        int away = far;
        for (int x = 0; x < size.x; ++x) {
            away = in[x] ? std::min(away + 1, far) : 0;
            out[x] = static_cast<std::uint16_t>(away * away);
        }
        away = far;
        for (int x = size.x - 1; x >= 0; --x) {
            away = in[x] ? std::min(away + 1, far) : 0;
            out[x] = std::min(out[x], static_cast<std::uint16_t>(away * away));
        }
    }
    const auto across = static_cast<std::size_t>(count.x);
    band_.assign(across * static_cast<std::size_t>(count.y), 0.0f);
    nearest_.resize(across);
    for (int y = 0; y < count.y; ++y) {
        const int middle = first.y + y;
        std::fill(nearest_.begin(), nearest_.end(), std::uint16_t{0xFFFF});
        for (int row = std::max(middle - far, 0); row <= std::min(middle + far, size.y - 1); ++row) {
            const auto down = static_cast<std::uint16_t>((row - middle) * (row - middle));
            const std::uint16_t* const from =
                alongRow_.data() + static_cast<std::size_t>(row) * wide + first.x;
            for (std::size_t x = 0; x < across; ++x)
                nearest_[x] = std::min(nearest_[x], static_cast<std::uint16_t>(from[x] + down));
        }
        float* const out = band_.data() + static_cast<std::size_t>(y) * across;
        const std::uint8_t* const in = inside.data() + static_cast<std::size_t>(middle) * wide + first.x;
        for (std::size_t x = 0; x < across; ++x)
            out[x] = in[x] ? shareOf_[nearest_[x]] : 0.0f;
    }
    return band_;
}

} // namespace tessera
