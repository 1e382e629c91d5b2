// render/pixels/pixel_sums.cpp: see pixel_sums.h.
#include "render/pixels/pixel_sums.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "core/image/colour.h"
#include "core/image/image.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tessera {

void PixelSums::add(std::size_t pixel, int set, const glm::dvec4& sum, int samples) {
    Pixel& p = pixels_[pixel];
    if (this->samples(pixel) == 0)
        p.sum[0] = glm::vec4(0); // the middle
    if (2 * p.samples[set] < kManySamples) {
        p.sum[set] += glm::vec4(sum);
    } else {
        TESSERA_CHECK(!rests_.empty());
        glm::vec4& rest = rests_[pixel][static_cast<std::size_t>(set)];
        const glm::dvec4 whole = glm::dvec4(p.sum[set]) + (sum + glm::dvec4(rest));
        p.sum[set] = glm::vec4(whole);
        rest = glm::vec4(whole - glm::dvec4(p.sum[set]));
    }
    p.samples[set] = static_cast<std::uint16_t>(p.samples[set] + samples);
}

PixelSums::Kept PixelSums::kept(std::size_t pixel) const {
    const Pixel& p = pixels_[pixel];
    const Rests rests = rests_.empty() ? Rests{} : rests_[pixel];
    return {p.sum[0], p.sum[1], rests[0], rests[1]};
}

void PixelSums::restore(std::size_t pixel, const Kept& kept, int samples) {
    TESSERA_CHECK(samples % 2 == 0 && (samples <= kManySamples || !rests_.empty()));
    const auto ofSet = static_cast<std::uint16_t>(samples / 2);
    pixels_[pixel] = {{kept[0], kept[1]}, {ofSet, ofSet}};
    if (!rests_.empty())
        rests_[pixel] = {kept[2], kept[3]};
}

glm::vec4 PixelSums::mean(std::size_t pixel) const {
    const Pixel& p = pixels_[pixel];
    const int all = samples(pixel);
    return all > 0 ? (p.sum[0] + p.sum[1]) / static_cast<float>(all) : p.sum[0];
}

glm::vec4 PixelSums::offset(std::size_t pixel) const {
    TESSERA_CHECK(hasBothSets(pixel));
    const Pixel& p = pixels_[pixel];
    const auto a = static_cast<float>(p.samples[0]), b = static_cast<float>(p.samples[1]);
    // Sets of unequal size differ by more than the error of the mean.
    return (p.sum[0] / a - p.sum[1] / b) * (std::sqrt(a * b) / (a + b));
}

Image PixelSums::image() const {
    Image image(size_);
    for (std::size_t i = 0; i < pixels_.size(); ++i)
        image.pixels[i] = mean(i);
    return image;
}

Image PixelSums::errors() const {
    Image errors = offsets();
    for (glm::vec4& pixel : errors.pixels)
        pixel = glm::abs(pixel);
    return errors;
}

Image PixelSums::offsets() const {
    Image offsets(size_);
    for (std::size_t i = 0; i < pixels_.size(); ++i)
        if (hasBothSets(i))
            offsets.pixels[i] = offset(i);
    return offsets;
}

namespace {
bool shows(const glm::vec4& mean) {
    return mean.a > 1.0f / 255;
}
/// All pixels: f(mean, offset).
template <typename Visit> void forEachPixelOf(const PixelSums& sums, const Visit& visit) {
    for (std::size_t i = 0; i < sums.count(); ++i)
        visit(sums.mean(i), sums.hasBothSets(i) ? sums.offset(i) : glm::vec4(0));
}

/// The value of a rank in ascending order, of numbers from 0 on, which are ordered as their bits are. Sixteen
/// bits are found at a time.
/// @param each  calls a function with every number
template <typename Each> double valueOfRank(const Each& each, std::uint64_t rank) {
    constexpr int kBits = 16;
    std::uint64_t found = 0;
    for (int shift = 64 - kBits; shift >= 0; shift -= kBits) {
        std::vector<std::uint64_t> counts(std::size_t{1} << kBits, 0);
        const std::uint64_t above = shift + kBits < 64 ? ~std::uint64_t{0} << (shift + kBits) : 0;
        each([&](double value) {
            const auto bits = std::bit_cast<std::uint64_t>(value);
            if ((bits & above) == found)
                ++counts[bits >> shift & (counts.size() - 1)];
        });
        std::uint64_t bin = 0;
        for (; bin + 1 < counts.size() && rank >= counts[bin]; ++bin)
            rank -= counts[bin];
        found |= bin << shift;
    }
    return std::bit_cast<double>(found);
}

} // namespace

double rmsError(const PixelSums& sums) {
    double squares = 0;
    std::size_t shown = 0;
    forEachPixelOf(sums, [&](const glm::vec4& mean, const glm::vec4& off) {
        if (!shows(mean))
            return;
        squares += static_cast<double>(glm::dot(off, off));
        ++shown;
    });
    return shown > 0 ? std::sqrt(squares / (4 * static_cast<double>(shown))) : 0;
}

StandardError standardError(const PixelSums& sums) {
    return standardError([&](const auto& visit) { forEachPixelOf(sums, visit); }, sums.count());
}

StandardError standardError(const PixelOffsets& eachPixel, std::size_t kept) {
    const auto seen = [](const glm::vec4& v) {
        return luvFromLinear(glm::dvec3(glm::clamp(glm::vec3(v), 0.0f, 1.0f)));
    };
    const auto errorOf = [&](const glm::vec4& mean, const glm::vec4& off) {
        return glm::length(seen(mean + off) - seen(mean));
    };
    StandardError e;
    std::vector<double> luv;
    std::size_t shown = 0;
    double squares = 0;
    eachPixel([&](const glm::vec4& mean, const glm::vec4& off) {
        if (!shows(mean))
            return;
        const double error = errorOf(mean, off);
        if (shown++ < kept)
            luv.push_back(error);
        e.luvMean += error;
        squares += static_cast<double>(glm::dot(off, off));
    });
    if (shown == 0)
        return {};
    e.rms = std::sqrt(squares / (4 * static_cast<double>(shown)));
    e.luvMean /= static_cast<double>(shown);
    const auto rank = static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(shown - 1));
    if (shown <= kept) {
        std::nth_element(luv.begin(), luv.begin() + rank, luv.end());
        e.luvP99 = luv[static_cast<std::size_t>(rank)];
        return e;
    }
    luv = {};
    e.luvP99 = valueOfRank(
        [&](const auto& take) {
            eachPixel([&](const glm::vec4& mean, const glm::vec4& off) {
                if (shows(mean))
                    take(errorOf(mean, off));
            });
        },
        static_cast<std::uint64_t>(rank));
    return e;
}

namespace {

std::size_t indexOf(const glm::ivec2& at, const glm::ivec2& size) {
    return static_cast<std::size_t>(at.y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(at.x);
}

template <typename Visit>
void forEachAround(const glm::ivec2& at, const glm::ivec2& size, const Visit& visit) {
    for (int y = std::max(0, at.y - 1); y <= std::min(size.y - 1, at.y + 1); ++y)
        for (int x = std::max(0, at.x - 1); x <= std::min(size.x - 1, at.x + 1); ++x)
            visit(indexOf({x, y}, size));
}

/// Mean variance of one sample over a pixel's neighbours with two sets, all components together.
double varianceOfNeighbours(const PixelSums& sums, const glm::ivec2& at) {
    double variance = 0;
    int count = 0;
    forEachAround(at, sums.size(), [&](std::size_t n) {
        if (n == indexOf(at, sums.size()) || !sums.hasBothSets(n))
            return;
        const glm::vec4 off = sums.offset(n);
        variance += static_cast<double>(glm::dot(off, off)) * sums.samples(n);
        ++count;
    });
    return count > 0 ? variance / count : 0;
}

/// Variance of the mean of a pixel with two sets, all components together. Sets can be equal by chance while
/// the neighbours' differ, so these count too, scaled to the same number of samples.
double varianceOfSets(const PixelSums& sums, const glm::ivec2& at) {
    constexpr double kNeighbours = 0.5; // their part beside the pixel's own
    const std::size_t i = indexOf(at, sums.size());
    const glm::vec4 off = sums.offset(i);
    const double around = varianceOfNeighbours(sums, at) / sums.samples(i);
    return (static_cast<double>(glm::dot(off, off)) + kNeighbours * around) / (1 + kNeighbours);
}

/// The derivative of L* by a component of linear light.
double lightnessSlope(double light) {
    constexpr double linearBelow = 0.008856451679035631; // CIE 1976
    return light > linearBelow ? 116.0 / 3 / std::cbrt(light * light) : 903.2962962962963;
}

/// Variance of a ray through a pixel's centre, all components together: of the 3x3 neighbourhood about a
/// plane through it. Pixels at the picture's edge use the nearest nine; a picture of fewer than three rows or
/// columns repeats its last.
double varianceAround(const PixelSums& sums, const glm::ivec2& at) {
    const glm::ivec2 last = sums.size() - 1;
    const glm::ivec2 middle = glm::clamp(at, glm::ivec2(1), glm::max(glm::ivec2(1), last - 1));
    glm::vec4 c[9];
    for (int k = 0; k < 9; ++k) {
        const glm::ivec2 near = glm::min(middle + glm::ivec2(k % 3 - 1, k / 3 - 1), last);
        c[k] = sums.mean(indexOf(near, sums.size()));
    }
    const glm::vec4 mean = (c[0] + c[1] + c[2] + c[3] + c[4] + c[5] + c[6] + c[7] + c[8]) / 9.0f;
    const glm::vec4 right = (c[2] + c[5] + c[8] - c[0] - c[3] - c[6]) / 6.0f;
    const glm::vec4 down = (c[6] + c[7] + c[8] - c[0] - c[1] - c[2]) / 6.0f;
    float scatter = 0; // about the plane, not as a difference of sums, which would cancel in floats
    for (int k = 0; k < 9; ++k) {
        const glm::vec4 off =
            c[k] - (mean + static_cast<float>(k % 3 - 1) * right + static_cast<float>(k / 3 - 1) * down);
        scatter += glm::dot(off, off);
    }
    return static_cast<double>(scatter) / (9 - 3);
}

float needOf(const PixelSums& sums, const glm::ivec2& at, const PixelTarget& target) {
    const std::size_t i = indexOf(at, sums.size());
    const double variance = sums.hasBothSets(i) ? varianceOfSets(sums, at) : varianceAround(sums, at);
    if (!(variance > 0))
        return 0;
    const double off = std::sqrt(variance / 4); // a component's
    const glm::vec4 mean = sums.mean(i);
    const double light =
        std::clamp(0.2126 * static_cast<double>(mean.r) + 0.7152 * static_cast<double>(mean.g) +
                       0.0722 * static_cast<double>(mean.b),
                   0.0, 1.0);
    return static_cast<float>(
        std::max(off / target.linear, off * lightnessSlope(light + off) / target.lightness));
}

/// @param isStale  by pixel: whether its need is computed
template <typename IsStale>
void setNeeds(const PixelSums& sums, const PixelTarget& target, int threads, std::vector<float>& needs,
              const IsStale& isStale) {
    const glm::ivec2 size = sums.size();
    parallelFor(static_cast<std::size_t>(size.y), threads, [&](std::size_t row) {
        for (int x = 0; x < size.x; ++x) {
            const glm::ivec2 at(x, static_cast<int>(row));
            if (const std::size_t i = indexOf(at, size); isStale(i))
                needs[i] = needOf(sums, at, target);
        }
    });
}

} // namespace

std::vector<float> sampleNeeds(const PixelSums& sums, const PixelTarget& target, int threads) {
    std::vector<float> needs(sums.count());
    setNeeds(sums, target, threads, needs, [](std::size_t) { return true; });
    return needs;
}

void updateNeeds(const PixelSums& sums, const PixelTarget& target, std::span<const std::uint32_t> sampled,
                 int threads, std::vector<float>& needs) {
    constexpr int kReach = 2; // of the nearest nine at the picture's edge
    const glm::ivec2 size = sums.size();
    std::vector<std::uint8_t> stale(needs.size(), 0);
    for (const std::uint32_t pixel : sampled) {
        const auto width = static_cast<std::uint32_t>(size.x);
        const glm::ivec2 at(static_cast<int>(pixel % width), static_cast<int>(pixel / width));
        const glm::ivec2 low = glm::max(at - kReach, glm::ivec2(0)), high = glm::min(at + kReach, size - 1);
        for (int y = low.y; y <= high.y; ++y)
            std::fill_n(stale.begin() + static_cast<std::ptrdiff_t>(indexOf({low.x, y}, size)),
                        high.x - low.x + 1, std::uint8_t{1});
    }
    setNeeds(sums, target, threads, needs, [&](std::size_t i) { return stale[i] != 0; });
}

} // namespace tessera
