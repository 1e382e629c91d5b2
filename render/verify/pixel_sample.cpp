// render/verify/pixel_sample.cpp: see pixel_sample.h.
#include "render/verify/pixel_sample.h"

#include "core/base/error.h"
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

namespace tessera {
namespace {

/// Least population of a tile, per pixel of a cluster. A tile as long as t strata is drawn from at most 2t +
/// 4 times. While at most 3/4 of all pixels are taken, its pixels suffice for that.
constexpr int kPixelsPerDraw = 16;

/// The position along the Hilbert curve through a square of `side` tiles (a power of two).
std::uint64_t hilbertPlace(int side, int x, int y) {
    std::uint64_t place = 0;
    for (int s = side / 2; s > 0; s /= 2) {
        const int right = (x & s) != 0, below = (y & s) != 0;
        place += static_cast<std::uint64_t>(s) * static_cast<std::uint64_t>(s) *
                 static_cast<std::uint64_t>((3 * right) ^ below);
        if (!below) {
            if (right) {
                x = side - 1 - x;
                y = side - 1 - y;
            }
            std::swap(x, y);
        }
    }
    return place;
}

/// Pixels to choose from: those of rectangles, without those that were taken. Takes memory for what was
/// taken, not for pixels: pictures may be larger than memory.
class Tile {
  public:
    /// From low up to, not with, high.
    void add(const glm::ivec2& low, const glm::ivec2& high) {
        if (high.x <= low.x || high.y <= low.y)
            return;
        TESSERA_CHECK(isWhole());
        parts_.push_back({low, high.x - low.x, size_});
        all_ = size_ += static_cast<std::size_t>(high.x - low.x) * static_cast<std::size_t>(high.y - low.y);
    }
    /// What is left of another, behind what is left of this.
    void add(const Tile& other) {
        if (!isWhole())
            *this = single();
        const Tile copy = other.isWhole() ? other : other.single();
        for (const Part& part : copy.parts_)
            parts_.push_back({part.low, part.width, part.first + size_});
        all_ = size_ += copy.size_;
    }
    /// Of those that were not taken.
    std::size_t size() const { return size_; }
    glm::ivec2 operator[](std::size_t number) const {
        const auto found = moved_.find(number);
        const std::size_t n = found == moved_.end() ? number : found->second;
        const auto part = std::upper_bound(parts_.begin(), parts_.end(), n,
                                           [](std::size_t of, const Part& p) { return of < p.first; }) -
                          1;
        const auto in = static_cast<int>(n - part->first);
        return part->low + glm::ivec2(in % part->width, in / part->width);
    }
    /// The last one takes its number.
    void take(std::size_t number) {
        --size_;
        const auto last = moved_.find(size_);
        const std::size_t of = last == moved_.end() ? size_ : last->second;
        if (last != moved_.end())
            moved_.erase(last);
        if (number != size_)
            moved_[number] = of;
    }
    void clear() { *this = {}; }

  private:
    bool isWhole() const { return size_ == all_; }
    /// The same, of rectangles of one pixel.
    Tile single() const {
        Tile out;
        for (std::size_t n = 0; n < size_; ++n)
            out.add((*this)[n], (*this)[n] + 1);
        return out;
    }
    struct Part {
        glm::ivec2 low{0};
        int width = 0;
        std::size_t first = 0; // its first pixel's number
    };
    std::vector<Part> parts_;
    std::size_t size_ = 0, all_ = 0;           // all_: with those that were taken
    std::map<std::size_t, std::size_t> moved_; // numbers of pixels that are others'
};

/// Along the curve. Tiles of one picture differ by at most one pixel in width and height.
std::vector<Tile> tilesInARow(const glm::ivec2& size, int side, std::span<const std::uint8_t> frame) {
    const glm::ivec2 count = glm::max(glm::ivec2(1), (size + side / 2) / side);
    int square = 1;
    while (square < std::max(count.x, count.y))
        square *= 2;
    std::vector<std::pair<std::uint64_t, glm::ivec2>> order;
    for (int y = 0; y < count.y; ++y)
        for (int x = 0; x < count.x; ++x)
            order.emplace_back(hilbertPlace(square, x, y), glm::ivec2(x, y));
    std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    const auto edge = [](int i, int parts, int whole) {
        return static_cast<int>(static_cast<std::int64_t>(i) * whole / parts);
    };
    std::vector<Tile> tiles;
    for (const auto& [place, at] : order) {
        Tile& tile = tiles.emplace_back();
        const glm::ivec2 low(edge(at.x, count.x, size.x), edge(at.y, count.y, size.y)),
            high(edge(at.x + 1, count.x, size.x), edge(at.y + 1, count.y, size.y));
        if (frame.empty()) {
            tile.add(low, high);
            continue;
        }
        for (int y = low.y; y < high.y; ++y)
            for (int x = low.x; x < high.x; ++x)
                if (frame[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                          static_cast<std::size_t>(x)])
                    tile.add({x, y}, {x + 1, y + 1});
    }
    return tiles;
}

/// Merges neighbours until each has enough.
std::vector<Tile> merged(std::vector<Tile> tiles, std::size_t enough) {
    std::vector<Tile> out;
    for (Tile& tile : tiles) {
        if (out.empty() || out.back().size() >= enough)
            out.push_back(std::move(tile));
        else
            out.back().add(tile);
    }
    if (out.size() > 1 && out.back().size() < enough) {
        out[out.size() - 2].add(out.back());
        out.pop_back();
    }
    return out;
}

/// Draws the pixels from the tiles.
PixelSample takeRound(std::vector<Tile>& tiles, const SampleDesign& design, int round) {
    PixelSample sample;
    for (const Tile& tile : tiles)
        sample.population += tile.size();
    const auto each = static_cast<std::size_t>(design.perCluster);
    const std::size_t strata =
        std::max<std::size_t>(1, (static_cast<std::size_t>(design.pixels) + each) / (2 * each));
    const std::size_t pixels = 2 * each * strata;
    if (4 * pixels >= 3 * sample.population) {
        sample.all = true;
        sample.chance = 1;
        for (Tile& tile : tiles) {
            for (std::size_t n = 0; n < tile.size(); ++n)
                sample.pixels.push_back({tile[n], sample.clusters++});
            tile.clear();
        }
        return sample;
    }
    sample.chance = static_cast<double>(pixels) / static_cast<double>(sample.population);
    tiles = merged(std::move(tiles), kPixelsPerDraw * each);
    std::vector<std::size_t> ends; // of the tiles, in pixels along the row
    for (const Tile& tile : tiles)
        ends.push_back((ends.empty() ? 0 : ends.back()) + tile.size());
    RandomNumbers random(design.seed, static_cast<std::uint64_t>(round));
    const double length = static_cast<double>(sample.population) / static_cast<double>(strata);
    for (std::size_t stratum = 0; stratum < strata; ++stratum)
        for (int draw = 0; draw < 2; ++draw) {
            const double place = (static_cast<double>(stratum) + random.unit()) * length;
            const auto at = std::upper_bound(ends.begin(), ends.end() - 1, static_cast<std::size_t>(place));
            Tile& tile = tiles[static_cast<std::size_t>(at - ends.begin())];
            TESSERA_CHECK(tile.size() >= each);
            for (std::size_t i = 0; i < each; ++i) {
                const auto chosen = static_cast<std::size_t>(random.below(tile.size()));
                sample.pixels.push_back({tile[chosen], sample.clusters});
                tile.take(chosen);
            }
            ++sample.clusters;
        }
    return sample;
}

} // namespace

PixelSample choosePixels(const glm::ivec2& size, const SampleDesign& design, int round,
                         std::span<const std::uint8_t> frame) {
    TESSERA_CHECK(size.x > 0 && size.y > 0 && design.pixels > 0 && design.perCluster > 0 && design.tile > 0 &&
                  round >= 0);
    TESSERA_CHECK(frame.empty() ||
                  frame.size() == static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
    std::vector<Tile> tiles = tilesInARow(size, design.tile, frame);
    for (int earlier = 0; earlier < round; ++earlier)
        takeRound(tiles, design, earlier);
    return takeRound(tiles, design, round);
}

namespace {

glm::dvec3 luvOf(const glm::dvec4& pixel) {
    const auto inside = [](double c) { return std::isfinite(c) ? std::clamp(c, 0.0, 1.0) : 0.0; };
    return luvFromLinear({inside(pixel.r), inside(pixel.g), inside(pixel.b)});
}

/// Mean over the components of (picture - truth)^2, less the variance of the truth's mean.
double squareWithoutNoise(const glm::dvec4& picture, std::span<const glm::vec4> replicates) {
    double sum = 0;
    const auto count = static_cast<double>(replicates.size());
    for (int c = 0; c < 4; ++c) {
        double mean = 0, squares = 0;
        for (const glm::vec4& r : replicates)
            mean += double{r[c]} / count;
        for (const glm::vec4& r : replicates)
            squares += (r[c] - mean) * (r[c] - mean);
        const double d = picture[c] - mean;
        if (!std::isfinite(d) || !std::isfinite(squares)) {
            sum += 1;
            continue;
        }
        sum += d * d;
        if (replicates.size() > 1)
            sum -= squares / (count * (count - 1));
    }
    return sum / 4;
}

/// The truth by half of the replicates: two groups of two, or every pair of four.
std::vector<glm::dvec4> halvesOf(std::span<const glm::vec4> replicates) {
    const std::size_t groups = replicates.size() % 4 == 0 ? 4 : 2, each = replicates.size() / groups;
    std::vector<glm::dvec4> means(groups, glm::dvec4(0)), halves;
    for (std::size_t i = 0; i < replicates.size(); ++i)
        means[i / each] += glm::dvec4(replicates[i]) / static_cast<double>(each);
    if (groups == 2)
        return means;
    for (std::size_t a = 0; a < groups; ++a)
        for (std::size_t b = a + 1; b < groups; ++b)
            halves.push_back(0.5 * (means[a] + means[b]));
    return halves;
}

} // namespace

std::vector<PixelError> pixelErrors(const PixelPairs& pairs, float alphaAbove) {
    const auto each = static_cast<std::size_t>(pairs.replicates);
    TESSERA_CHECK(pairs.replicates == 1 || (pairs.replicates > 0 && pairs.replicates % 2 == 0));
    TESSERA_CHECK(pairs.picture.size() == pairs.sample.pixels.size() &&
                  pairs.truth.size() == each * pairs.picture.size());
    std::vector<PixelError> errors;
    for (std::size_t i = 0; i < pairs.picture.size(); ++i) {
        const std::span<const glm::vec4> replicates(&pairs.truth[i * each], each);
        const glm::dvec4 picture(pairs.picture[i]);
        glm::dvec4 truth(0);
        for (const glm::vec4& r : replicates)
            truth += glm::dvec4(r) / static_cast<double>(each);
        PixelError& e = errors.emplace_back();
        e.cluster = pairs.sample.pixels[i].cluster;
        e.shown = !(truth.a <= alphaAbove); // what is not finite counts
        e.square = squareWithoutNoise(picture, replicates);
        e.luv = glm::length(luvOf(picture) - luvOf(truth));
        if (each == 1)
            e.luvHalves = {e.luv};
        else
            for (const glm::dvec4& half : halvesOf(replicates))
                e.luvHalves.push_back(glm::length(luvOf(picture) - luvOf(half)));
        for (const double luv : e.luvHalves)
            e.luvNoisier += luv / static_cast<double>(e.luvHalves.size());
    }
    return errors;
}

} // namespace tessera
