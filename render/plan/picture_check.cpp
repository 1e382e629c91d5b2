// render/plan/picture_check.cpp: see picture_check.h.
#include "render/plan/picture_check.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

EstimatedError scaled(const ImageDifference& d, double factor) {
    return {factor * d.rms, factor * d.maxAbs, factor * d.luvMean, factor * d.luvP99};
}

} // namespace

PixelGrid::PixelGrid(const glm::ivec2& imageSize)
    : picture_(imageSize), every_((std::max(imageSize.x, imageSize.y) + kMostPixels - 1) / kMostPixels) {
    size_ = thinnedSize(imageSize, every_);
}

RayFrame<double> PixelGrid::frame(const RayFrame<double>& picture, double segmentVoxels) const {
    RayFrame<double> f = picture;
    // A pixel x of the grid is pixel every * x + every / 2 of the picture: from -1 to 1 across each, the
    // picture's place is share * the grid's + shift.
    const glm::dvec2 share = glm::dvec2(size_ * every_) / glm::dvec2(picture_);
    const double middle = every_ / 2 + 0.5 - 0.5 * every_;
    const glm::dvec2 shift = share - 1.0 + 2 * middle / glm::dvec2(picture_);
    const glm::dvec3 offset = shift.x * picture.right - shift.y * picture.up;
    f.right *= share.x;
    f.up *= share.y;
    f.centre += offset;
    if (picture.perspective)
        f.toCentre += offset;
    f.imageSize = glm::dvec2(size_);
    f.segmentVoxels = segmentVoxels;
    return f;
}

Image PixelGrid::of(const Image& picture) const {
    TESSERA_CHECK(picture.size == picture_);
    return thinned(picture, every_);
}

EstimatedError errorBetween(const Image& picture, const Image& better) {
    return scaled(compare(picture, better), 1);
}

StepError stepError(const Image& picture, const Image& half, const Image& quarter) {
    const ImageDifference first = compare(picture, half), second = compare(half, quarter);
    StepError e;
    if (first.rms > 0 && second.rms > 0)
        e.order = std::log2(first.rms / second.rms);
    // Not extrapolated from the first two: on scans their errors are hardly correlated, and terms that would
    // cancel in a smooth scene add up. The quarter's own error is a 16th where the order is 2.
    e.error = scaled(compare(picture, quarter), 16.0 / 15);
    return e;
}

double PictureErrors::luvP99() const {
    return (step ? step->error.luvP99 : 0) + (filtering ? filtering->luvP99 : 0) + levelsLuvP99.value_or(0);
}

} // namespace tessera
