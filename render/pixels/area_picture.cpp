// render/pixels/area_picture.cpp: see area_picture.h.
#include "render/pixels/area_picture.h"

#include "core/error.h"
#include "render/pixels/ray_array.h"

#include <algorithm>

namespace tessera {
namespace {

/// Samples of a set where a pixel is to have so many: two sets at least, or nothing would tell how far they
/// are off, and 4 x 4 strata at most, or many samples would be few sets.
int samplesInSet(int samples) {
    int size = 1;
    while (size < kMostInSet && 4 * size <= samples)
        size *= 2;
    return size;
}

int setsOf(int samples) {
    const int size = samplesInSet(samples);
    return (samples + size - 1) / size;
}

} // namespace

AreaPicture::AreaPicture(const Rays& picture, const PixelSampling& sampling)
    : picture_(picture), sampling_(sampling), places_(sampling.seed, sampling.filter), sums_(picture.size()) {
    TESSERA_CHECK(picture.places.empty() && sampling.samples > 1);
    beginRound();
}

void AreaPicture::beginRound() {
    ++round_;
    first_ = count_ = 0;
    if (round_ == setsOf(sampling_.samples)) {
        pixels_.clear();
        return;
    }
    if (round_ > 0)
        return; // all pixels again
    inSet_ = samplesInSet(sampling_.samples);
    pixels_.reserve(sums_.count());
    forEachPixel(sums_.size(), [&](const glm::ivec2& at) {
        pixels_.push_back(static_cast<std::uint32_t>(at.y * sums_.size().x + at.x));
    });
}

std::optional<Rays> AreaPicture::next() {
    TESSERA_CHECK(count_ == 0);
    if (first_ == pixels_.size())
        beginRound();
    if (pixels_.empty())
        return std::nullopt;
    const auto inSet = static_cast<std::size_t>(inSet_);
    count_ = std::min(pixels_.size() - first_, mostRays(sums_.size()) / inSet);
    arraySize_ = rayArraySize(count_ * inSet);
    array_.assign(rayCount(arraySize_), glm::vec2(0));
    glm::vec2 places[kMostInSet];
    for (std::size_t n = 0; n < count_; ++n) {
        const auto pixel = static_cast<int>(pixels_[first_ + n]);
        const glm::ivec2 at(pixel % sums_.size().x, pixel / sums_.size().x);
        places_.put(at, static_cast<std::uint32_t>(sums_.sets(pixels_[first_ + n])),
                    std::span(places).first(inSet));
        for (std::size_t i = 0; i < inSet; ++i)
            array_[raySlot(n * inSet + i, arraySize_)] = places[i];
    }
    for (std::size_t k = count_ * inSet; k < array_.size(); ++k) // left over: what is drawn there is dropped
        array_[raySlot(k, arraySize_)] = places[inSet - 1];
    Rays rays = picture_;
    rays.places = array_;
    rays.arraySize = arraySize_;
    return rays;
}

void AreaPicture::add(const Image& drawn) {
    TESSERA_CHECK(count_ > 0 && drawn.size == arraySize_);
    const auto inSet = static_cast<std::size_t>(inSet_);
    for (std::size_t n = 0; n < count_; ++n) {
        glm::vec4 sum(0);
        for (std::size_t i = 0; i < inSet; ++i)
            sum += drawn.pixels[raySlot(n * inSet + i, arraySize_)];
        sums_.add(pixels_[first_ + n], sum / static_cast<float>(inSet), inSet_);
    }
    first_ += count_;
    count_ = 0;
}

PixelReport AreaPicture::report() const {
    PixelReport report;
    report.asked = sampling_.samples;
    report.taken = static_cast<double>(sums_.samplesTaken()) / static_cast<double>(sums_.count());
    report.most = sums_.mostSamples();
    std::vector<glm::vec4> offsets(sums_.count(), glm::vec4(0));
    for (std::size_t i = 0; i < offsets.size(); ++i)
        if (sums_.sets(i) > 1)
            offsets[i] = sums_.offset(i);
    report.error = standardError(sums_.image(), offsets);
    return report;
}

double AreaPicture::share(double ofArray) const {
    const double round = pixels_.empty()
                             ? 0
                             : (static_cast<double>(first_) + ofArray * static_cast<double>(count_)) /
                                   static_cast<double>(pixels_.size());
    return std::min(1.0, (round_ + round) / setsOf(sampling_.samples));
}

std::size_t AreaPicture::bytesPerPixel() {
    // Sums; the list of pixels; an array's places, and its picture as the engine hands it out.
    return PixelSums::bytesPerPixel() + sizeof(std::uint32_t) + sizeof(glm::vec2) + sizeof(glm::vec4);
}

std::size_t AreaPicture::mostRays(const glm::ivec2& imageSize) {
    // Whole rows of patches where there is one: then no array is larger than the picture.
    constexpr std::size_t row = kPatchRays * kPatchesAcross;
    const std::size_t pixels = rayCount(imageSize), of = pixels < row ? kPatchRays : row;
    return std::max(kPatchRays, pixels / of * of);
}

} // namespace tessera
