// render/pixels/area_picture.cpp: see area_picture.h.
#include "render/pixels/area_picture.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/pixels/pixel_places.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera {
namespace {

/// Automatic samples: rounds after the first. Each spends at most half of the remaining rays, or all if few
/// are left, so that most rays follow the results of earlier rounds. Small structures are found from rays
/// that hit them, one pixel further in each round.
constexpr int kRounds = 12;
constexpr std::size_t kLittle = 32;

/// Samples of a pixel after another round. Two sets of four: fewer are hardly better than its centre, and
/// estimate their error poorly.
int nextSamples(int samples) {
    return samples < 8 ? 8 : 2 * samples;
}

/// The number of a pixel's samples in a set.
int partOf(int samples, int set) {
    return set == 0 ? (samples + 1) / 2 : samples / 2;
}

} // namespace

AreaPicture::AreaPicture(const Rays& picture, const PixelSampling& sampling, int threads,
                         const PixelGoal& goal, Overlooked overlooked, std::optional<double> phasedStep,
                         std::size_t others, const std::optional<AreaOfPicture>& part)
    : picture_(picture), sampling_(sampling), goal_(goal), overlooked_(std::move(overlooked)),
      threads_(threads), places_(sampling.seed, sampling.filter),
      from_(part ? part->tile.from : glm::ivec2(0)), mostRays_(mostRays(part ? part->most : picture.size())),
      sums_(part ? part->tile.size : picture.size(), sampling.samples), others_(others, sums_),
      phasedStep_(phasedStep) {
    TESSERA_CHECK(picture.places.empty() && sampling.samples != 1);
    TESSERA_CHECK(!part || !decides());
    TESSERA_CHECK(!phasedStep || decides());
    beginRound();
}

void AreaPicture::goOn(const PixelGoal& goal) {
    TESSERA_CHECK(decides() && !drawing_ && taken_ > 0);
    goal_ = goal;
    ofOverlooked_ = 0;
    round_ = 0; // which the middles were
    first_ = 0;
    pixels_.clear();
    upTo_.clear();
    needs_.clear();
}

void AreaPicture::goOnFrom(int samples, const std::function<void(std::span<PixelSums*>)>& sums) {
    TESSERA_CHECK(!decides() && taken_ == 0 && samples >= 2 && samples <= sampling_.samples);
    std::vector<PixelSums*> all = {&sums_};
    for (PixelSums& other : others_)
        all.push_back(&other);
    sums(all);
    for (round_ = 0; (firstSamples() << round_) < samples;)
        ++round_;
    taken_ = sums_.count() * static_cast<std::size_t>(samples);
    beginRound();
}

int AreaPicture::wholeSamples() const {
    const int samples = firstSamples() << std::max(0, round_);
    return !decides() && samples >= 2 && taken_ == sums_.count() * static_cast<std::size_t>(samples) ? samples
                                                                                                     : 0;
}

std::vector<const PixelSums*> AreaPicture::allSums() const {
    std::vector<const PixelSums*> all = {&sums_};
    for (const PixelSums& other : others_)
        all.push_back(&other);
    return all;
}

/// Each round doubles the samples of a pixel, so that a complete picture comes soon. Paths are slow: the
/// first round has one of them.
int AreaPicture::samplesAfter(int round) const {
    return std::min(firstSamples() << round, sampling_.samples);
}

int AreaPicture::rounds() const {
    if (decides())
        return 1 + kRounds;
    int rounds = 1;
    while (samplesAfter(rounds - 1) < sampling_.samples)
        ++rounds;
    return rounds;
}

std::optional<int> AreaPicture::samplesOfAll() const {
    if (decides() || drawing_ || pixels_.empty() || first_ < pixels_.size())
        return std::nullopt;
    return samplesAfter(round_);
}

/// On the picture.
glm::ivec2 AreaPicture::pixelAt(std::uint32_t number) const {
    const auto width = static_cast<std::uint32_t>(sums_.size().x);
    return from_ + glm::ivec2(static_cast<int>(number % width), static_cast<int>(number / width));
}

void AreaPicture::take(std::uint32_t pixel, int upTo) {
    pixels_.push_back(pixel);
    upTo_.push_back(static_cast<std::uint16_t>(upTo - 1));
}

/// The error that is asked for is reached. Two samples a pixel tell too little of it.
bool AreaPicture::isQuiet() {
    constexpr int kSamplesBefore = 8;
    const int samples = decides() || round_ <= 0 ? 0 : samplesAfter(round_ - 1);
    const bool asked = sampling_.noise > 0 && samples >= kSamplesBefore;
    if (samples < 2 || !(asked || picture_.paths))
        return false;
    noise_ = rmsError(sums_);
    return asked && *noise_ <= sampling_.noise;
}

void AreaPicture::beginRound() {
    if (++round_; isQuiet())
        round_ = rounds();
    first_ = 0;
    if (!needs_.empty() && round_ < rounds())
        updateNeeds(sums_, goal_.target, pixels_, threads_, needs_);
    pixels_.clear();
    upTo_.clear();
    if (round_ == rounds())
        return;
    if (decides()) {
        if (round_ == 0)
            return; // the middles
        return takeOverlooked() ? void(--round_) : chooseNeedy();
    }
    const int upTo = samplesAfter(round_);
    forEachPixel(sums_.size(), [&](const glm::ivec2& at) {
        take(static_cast<std::uint32_t>(at.y * sums_.size().x + at.x), upTo);
    });
}

/// An extra round, before any other; false if there is none.
bool AreaPicture::takeOverlooked() {
    if (!overlooked_)
        return false;
    const std::vector<std::uint32_t> pixels = std::exchange(overlooked_, {})(sums_.image());
    const auto each = static_cast<std::size_t>(nextSamples(0));
    // Half of the allowed rays are left for visible pixels. If not all are possible they are spread.
    const std::size_t most = goal_.rays / (2 * each), taken = std::min(pixels.size(), most);
    for (std::size_t n = 0; n < taken; ++n)
        take(pixels[n * pixels.size() / taken], nextSamples(0));
    ofOverlooked_ = taken * each;
    return taken > 0;
}

void AreaPicture::chooseNeedy() {
    if (round_ == 1) {
        left_ = goal_.rays - std::min(goal_.rays, ofOverlooked_);
        for (std::size_t i = 0; i < sums_.count(); ++i)
            left_ += sums_.mean(i).a > 0 ? 1 : 0;
        budget_ = left_;
    }
    if (left_ < static_cast<std::size_t>(nextSamples(0)))
        return;
    const auto cost = [&](std::uint32_t pixel) {
        return static_cast<std::size_t>(nextSamples(sums_.samples(pixel)) - sums_.samples(pixel));
    };
    // The gain of a ray: the error's square falls at least as fast as samples grow.
    struct Needy {
        float gain;
        std::uint32_t pixel;
        bool operator<(const Needy& o) const { return gain > o.gain || (gain == o.gain && pixel < o.pixel); }
    };
    if (needs_.empty())
        needs_ = sampleNeeds(sums_, goal_.target, threads_);
    std::vector<Needy> needy;
    for (std::uint32_t i = 0; i < needs_.size(); ++i)
        if (needs_[i] > 1 && sums_.samples(i) < goal_.most)
            needy.push_back({needs_[i] * needs_[i] / static_cast<float>(cost(i)), i});
    std::size_t room = left_ > budget_ / kLittle ? left_ / 2 : left_;
    const std::size_t most = std::min(needy.size(), room / static_cast<std::size_t>(nextSamples(0)));
    const auto end = needy.begin() + static_cast<std::ptrdiff_t>(most);
    std::nth_element(needy.begin(), end, needy.end());
    std::sort(needy.begin(), end);
    std::vector<bool> chosen(sums_.count(), false);
    for (auto n = needy.begin(); n != end && cost(n->pixel) <= room; ++n) {
        room -= cost(n->pixel);
        left_ -= cost(n->pixel);
        chosen[n->pixel] = true;
    }
    pixels_.clear();
    forEachPixel(sums_.size(), [&](const glm::ivec2& at) {
        const auto i = static_cast<std::uint32_t>(at.y * sums_.size().x + at.x);
        if (chosen[i])
            take(i, nextSamples(sums_.samples(i)));
    });
}

/// Calls visit(pixel, set, first, count, ray) for the samples of a part of the current array, in order:
/// missing samples of its pixels, as far as they fit. Where all pixels have the same number, a run is in one
/// array: so its sum does not depend on where in the picture arrays end.
template <typename Visit>
AreaPicture::Runs AreaPicture::forEachRun(const Part& part, const Visit& visit) const {
    const std::size_t most = mostRays_;
    std::size_t ray = part.firstRay;
    for (std::size_t n = part.first; n < part.end && ray < most; ++n)
        for (int set = 0; set < 2; ++set) {
            const int has = sums_.samplesOf(pixels_[n], set);
            // Of one net at a time (pixel_places.h).
            const int whole = std::min(partOf(upTo_[n] + 1, set) - has, kMostInSet - has % kMostInSet);
            const int count = std::min(
                static_cast<int>(std::min<std::size_t>(most - ray, static_cast<std::size_t>(kMostInSet))),
                whole);
            if (count < whole && ray > 0 && !decides())
                return {ray, true};
            if (count <= 0)
                continue;
            visit(pixels_[n], set, has, count, ray);
            ray += static_cast<std::size_t>(count);
        }
    return {ray, ray >= most};
}

/// Fills parts_. Returns the number of the array's rays.
std::size_t AreaPicture::divide() {
    constexpr std::size_t kPixelsOfPart = 256;
    parts_.clear();
    Runs runs{0, false};
    for (std::size_t n = first_; n < pixels_.size() && !runs.full; n += kPixelsOfPart) {
        parts_.push_back({n, std::min(n + kPixelsOfPart, pixels_.size()), runs.end});
        runs = forEachRun(parts_.back(), [](std::uint32_t, int, int, int, std::size_t) {});
    }
    return runs.end;
}

std::optional<Rays> AreaPicture::next() {
    TESSERA_CHECK(!drawing_);
    if (decides() && round_ == 0 && taken_ == 0) {
        drawing_ = true;
        return picture_;
    }
    while (first_ == pixels_.size() && round_ < rounds())
        beginRound();
    if (first_ == pixels_.size()) { // later pixels that are drawn again use this memory
        array_ = {}, numbers_ = {}, pixels_ = {}, upTo_ = {}, needs_ = {}, parts_ = {};
        first_ = 0;
        return std::nullopt;
    }
    const std::size_t rays = divide();
    ofArray_ = rays;
    arraySize_ = rayArraySize(rays);
    array_.resize(rayCount(arraySize_));
    if (picture_.paths)
        numbers_.assign(array_.size(), 0);
    parallelFor(parts_.size(), threads_, [&](std::size_t part) {
        glm::vec2 places[kMostInSet];
        forEachRun(parts_[part], [&](std::uint32_t pixel, int set, int first, int count, std::size_t ray) {
            const std::span mine = std::span(places).first(static_cast<std::size_t>(count));
            places_.put(pixelAt(pixel), static_cast<std::uint32_t>(set), first, mine);
            auto number = static_cast<std::uint32_t>(2 * first + set); // Rays::numbers
            for (const glm::vec2& place : mine) {
                const std::size_t slot = raySlot(ray++, arraySize_);
                array_[slot] = place;
                if (picture_.paths)
                    numbers_[slot] = number;
                number += 2;
            }
        });
    });
    std::size_t k = rays;
    for (const glm::vec2 last = array_[raySlot(rays - 1, arraySize_)]; k < array_.size(); ++k)
        array_[raySlot(k, arraySize_)] = last; // unused; results there are dropped
    drawing_ = true;
    Rays out = picture_;
    if (phasedStep_) {
        // A pixel's samples are adjacent, by eights, so that each eight have all phases.
        out.frame.segmentVoxels = out.strides.segmentVoxels = *phasedStep_;
        out.frame.phased = true;
    }
    out.places = array_;
    if (picture_.paths)
        out.numbers = numbers_;
    out.arraySize = arraySize_;
    return out;
}

void AreaPicture::add(const Image& drawn, std::span<const Image> others) {
    TESSERA_CHECK(drawing_ && others.size() == others_.size());
    drawing_ = false;
    if (array_.empty()) {
        TESSERA_CHECK(drawn.size == sums_.size());
        const auto width = static_cast<std::size_t>(sums_.size().x);
        parallelFor(static_cast<std::size_t>(sums_.size().y), threads_, [&](std::size_t row) {
            for (std::size_t i = row * width; i < (row + 1) * width; ++i) {
                sums_.setMiddle(i, drawn.pixels[i]);
                for (std::size_t n = 0; n < others.size(); ++n)
                    others_[n].setMiddle(i, others[n].pixels[i]);
            }
        });
        taken_ = sums_.count();
        return;
    }
    TESSERA_CHECK(drawn.size == arraySize_);
    parallelFor(parts_.size(), threads_, [&](std::size_t part) {
        forEachRun(parts_[part], [&](std::uint32_t pixel, int set, int has, int count, std::size_t ray) {
            const auto sumOf = [&](const Image& of) {
                const auto colour = [&](int i) {
                    return of.pixels[raySlot(ray + static_cast<std::size_t>(i), arraySize_)];
                };
                if (2 * has >= PixelSums::kManySamples) {
                    glm::dvec4 sum(0);
                    for (int i = 0; i < count; ++i)
                        sum += glm::dvec4(colour(i));
                    return sum;
                }
                glm::vec4 sum(0);
                for (int i = 0; i < count; ++i)
                    sum += colour(i);
                return glm::dvec4(sum);
            };
            sums_.add(pixel, set, sumOf(drawn), count);
            for (std::size_t n = 0; n < others.size(); ++n)
                others_[n].add(pixel, set, sumOf(others[n]), count);
        });
    });
    while (first_ < pixels_.size() && sums_.samples(pixels_[first_]) > upTo_[first_])
        ++first_;
    taken_ += ofArray_;
    array_.clear();
}

PixelReport AreaPicture::report() const {
    PixelReport report;
    report.asked = sampling_.samples;
    report.taken = static_cast<double>(taken_) / static_cast<double>(sums_.count());
    for (std::size_t i = 0; i < sums_.count(); ++i)
        report.most = std::max(report.most, sums_.samples(i));
    // Sets that decided when to stop are too similar, and a centre alone gives no estimate.
    if (!decides() && report.most > 1)
        report.error = standardError(sums_);
    return report;
}

double AreaPicture::share(double ofArray) const {
    const int count = rounds();
    if (round_ == count)
        return 1;
    if (!decides()) {
        // Of all samples; or of as many as the noise so far takes, which falls as their root.
        const auto pixels = static_cast<double>(sums_.count());
        double all = sampling_.samples * pixels;
        if (sampling_.noise > 0 && noise_) {
            const double more = *noise_ / sampling_.noise;
            all = std::clamp(samplesAfter(round_ - 1) * pixels * more * more, samplesAfter(round_) * pixels,
                             all);
        }
        const double drawn =
            static_cast<double>(taken_) + (drawing_ ? ofArray * static_cast<double>(ofArray_) : 0);
        return std::min(1.0, drawn / all);
    }
    const double within = pixels_.empty() ? 0
                                          : (static_cast<double>(first_) + (drawing_ ? ofArray : 0)) /
                                                static_cast<double>(pixels_.size());
    // Each round takes about half of the remaining rays, the first a third.
    return 1 - std::exp2(-round_) * (1 - 0.5 * within);
}

std::size_t AreaPicture::bytesPerPixel(const PixelSampling& sampling) {
    // Sums; the list of pixels with samples; needs and choices of all; an array's points, and the engine's
    // picture of it. Parts of arrays are left out, a tenth of a byte a pixel.
    return PixelSums::bytesPerPixel(sampling.samples) + sizeof(std::uint32_t) + sizeof(std::uint16_t) +
           sizeof(float) + 1 + sizeof(glm::vec2) + sizeof(glm::vec4);
}

std::size_t AreaPicture::mostRays(const glm::ivec2& imageSize) {
    // Whole rows of patches if there is one: then no array is larger than the picture.
    constexpr std::size_t row = kPatchRays * kPatchesAcross;
    const std::size_t pixels = rayCount(imageSize), of = pixels < row ? kPatchRays : row;
    return std::max(kPatchRays, pixels / of * of);
}

} // namespace tessera
