// render/pixels/noise_filter.cpp: see noise_filter.h.
#include "render/pixels/noise_filter.h"

#include "core/base/interrupt.h"
#include "core/base/threads.h"
#include "render/contract/ray_state.h" // rayCount

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tessera {
namespace {

constexpr int kReach = 6; // of the window around a pixel
constexpr int kPatch = 3; // of the patches that are compared
constexpr int kRows = 16; // of a band
/// Standard deviations of noise that a difference may have: fewer keep more detail, and more noise.
constexpr float kDamping = 0.5f;
constexpr int kVariance = 2; // reach of the mean of squares that stands for the variance of a pixel
constexpr int kPad = kReach + kPatch;

/// A channel of the rows of a band, and of those around it that are compared; beyond the picture its border.
class Rows {
  public:
    Rows(int width, int pad) : stride_(width + 2 * pad), pad_(pad), values_(size(width, pad)) {}
    static std::size_t size(int width, int pad) {
        return static_cast<std::size_t>(width + 2 * pad) * static_cast<std::size_t>(kRows + 2 * pad);
    }
    float* row(int y) { return values_.data() + (y + pad_) * stride_ + pad_; }
    const float* row(int y) const { return values_.data() + (y + pad_) * stride_ + pad_; }

  private:
    std::ptrdiff_t stride_;
    std::ptrdiff_t pad_;
    std::vector<float> values_;
};

/// What a thread needs of a band.
struct Band {
    explicit Band(int width)
        : width(width), half{channels(width, 3), channels(width, 3)},
          variance(channels(width, 3)), distance{Rows(width, kPatch), Rows(width, kPatch)},
          along{Rows(width, kPatch), Rows(width, kPatch)}, sum{channels(width, 4), channels(width, 4)} {}
    static std::vector<Rows> channels(int width, std::size_t count) {
        return std::vector<Rows>(count, Rows(width, kPad));
    }
    int width;
    std::array<std::vector<Rows>, 2> half;
    std::vector<Rows> variance;
    std::array<Rows, 2> distance, along;
    std::array<std::vector<Rows>, 2> sum; // of colours by weights, and of weights
};

/// Nothing is known of the noise of pixels without both sets: they count as exact.
glm::vec4 offsetOf(const PixelSums& sums, std::size_t pixel) {
    return sums.hasBothSets(pixel) ? sums.offset(pixel) : glm::vec4(0);
}

void read(const PixelSums& sums, int first, Band& band) {
    const glm::ivec2 size = sums.size();
    const auto at = [&](int x, int y) {
        return static_cast<std::size_t>(std::clamp(y, 0, size.y - 1)) * static_cast<std::size_t>(size.x) +
               static_cast<std::size_t>(std::clamp(x, 0, size.x - 1));
    };
    for (int y = -kPad; y < kRows + kPad; ++y)
        for (int x = -kPad; x < band.width + kPad; ++x) {
            const std::size_t pixel = at(x, first + y);
            const glm::vec4 mean = sums.mean(pixel), offset = offsetOf(sums, pixel);
            for (int c = 0; c < 3; ++c) {
                band.half[0][static_cast<std::size_t>(c)].row(y)[x] = mean[c] + offset[c];
                band.half[1][static_cast<std::size_t>(c)].row(y)[x] = mean[c] - offset[c];
            }
        }
    // Of a half: twice that of the mean, whose offset has its square.
    for (int y = -kPad; y < kRows + kPad; ++y)
        for (int x = -kPad; x < band.width + kPad; ++x) {
            glm::vec3 squares(0);
            for (int dy = -kVariance; dy <= kVariance; ++dy)
                for (int dx = -kVariance; dx <= kVariance; ++dx) {
                    const glm::vec3 offset(offsetOf(sums, at(x + dx, first + y + dy)));
                    squares += offset * offset;
                }
            for (int c = 0; c < 3; ++c)
                band.variance[static_cast<std::size_t>(c)].row(y)[x] =
                    squares[c] * (2.0f / ((2 * kVariance + 1) * (2 * kVariance + 1)));
        }
}

/// Squared distances of pixels to those at an offset, in units of their noise, of each half.
void compare(Band& band, int dx, int dy) {
    for (int y = -kPatch; y < kRows + kPatch; ++y)
        for (std::size_t h = 0; h < 2; ++h) {
            float* const out = band.distance[h].row(y);
            std::fill(out - kPatch, out + band.width + kPatch, 0.0f);
            for (std::size_t c = 0; c < 3; ++c) {
                const float* const a = band.half[h][c].row(y);
                const float* const b = band.half[h][c].row(y + dy) + dx;
                const float* const va = band.variance[c].row(y);
                const float* const vb = band.variance[c].row(y + dy) + dx;
                for (int x = -kPatch; x < band.width + kPatch; ++x) {
                    const float d = a[x] - b[x];
                    out[x] += (d * d - (va[x] + std::min(va[x], vb[x]))) /
                              (1e-10f + kDamping * kDamping * (va[x] + vb[x]));
                }
            }
        }
}

/// Means over patches, and from them weights.
void weigh(Band& band, int rows, int dx, int dy, int first, const glm::ivec2& size) {
    constexpr int kEdge = 2 * kPatch + 1;
    constexpr float kShare = 1.0f / (3 * kEdge * kEdge);
    for (std::size_t h = 0; h < 2; ++h)
        for (int y = -kPatch; y < kRows + kPatch; ++y) {
            const float* const d = band.distance[h].row(y);
            float* const out = band.along[h].row(y);
            for (int x = 0; x < band.width; ++x) {
                float sum = 0;
                for (int n = -kPatch; n <= kPatch; ++n)
                    sum += d[x + n];
                out[x] = sum;
            }
        }
    const int from = std::max(0, -dx), to = std::min(size.x, size.x - dx);
    for (int y = 0; y < rows; ++y) {
        if (first + y + dy < 0 || first + y + dy >= size.y)
            continue;
        for (int x = from; x < to; ++x) {
            for (std::size_t h = 0; h < 2; ++h) {
                float sum = 0;
                for (int n = -kPatch; n <= kPatch; ++n)
                    sum += band.along[h].row(y + n)[x];
                const float weight = std::exp(-std::max(0.0f, sum * kShare));
                std::vector<Rows>& all = band.sum[1 - h];
                for (std::size_t c = 0; c < 3; ++c)
                    all[c].row(y)[x] += weight * band.half[1 - h][c].row(y + dy)[x + dx];
                all[3].row(y)[x] += weight;
            }
        }
    }
}

} // namespace

Image withoutNoise(const PixelSums& sums, int threads) {
    const glm::ivec2 size = sums.size();
    Image out(size);
    const auto bands = static_cast<std::size_t>((size.y + kRows - 1) / kRows);
    parallelFor(bands, threads, [&](std::size_t number) {
        checkInterrupted();
        const int first = static_cast<int>(number) * kRows, rows = std::min(kRows, size.y - first);
        Band band(size.x);
        read(sums, first, band);
        for (int dy = -kReach; dy <= kReach; ++dy)
            for (int dx = -kReach; dx <= kReach; ++dx) {
                compare(band, dx, dy);
                weigh(band, rows, dx, dy, first, size);
            }
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < size.x; ++x) {
                const std::size_t pixel =
                    static_cast<std::size_t>(first + y) * static_cast<std::size_t>(size.x) +
                    static_cast<std::size_t>(x);
                glm::vec4 mean = sums.mean(pixel);
                if (sums.hasBothSets(pixel))
                    for (std::size_t c = 0; c < 3; ++c) {
                        float both = 0;
                        for (std::size_t h = 0; h < 2; ++h)
                            both += 0.5f * band.sum[h][c].row(y)[x] / band.sum[h][3].row(y)[x];
                        mean[static_cast<int>(c)] = both;
                    }
                out.pixels[pixel] = mean;
            }
    });
    return out;
}

std::size_t noiseFilterBytes(const glm::ivec2& size, int threads) {
    const auto used = static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
    return rayCount(size) * sizeof(glm::vec4) +
           used * sizeof(float) *
               ((3 * 2 + 3 + 4 * 2) * Rows::size(size.x, kPad) + 4 * Rows::size(size.x, kPatch));
}

} // namespace tessera
