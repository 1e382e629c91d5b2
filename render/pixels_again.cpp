// render/pixels_again.cpp: see pixels_again.h.
#include "render/pixels_again.h"

#include "core/error.h"
#include "render/picture.h"
#include "render/pixels/area_picture.h"
#include "render/pixels/ray_array.h"

#include <algorithm>
#include <cstdio>

namespace tessera {
namespace {

/// Pixels count where the truth shows as much as can be seen, as compare() has it.
constexpr float kShown = 1.0f / 255;
/// Sets of a pixel from here on are the truth's: no picture takes so many.
constexpr std::uint32_t kFirstSet = 1u << 20, kSetsOfRound = 1u << 12;

std::string between(const Estimate& e) {
    char text[80];
    std::snprintf(text, sizeof text, "%.2g (%.2g to %.2g)", e.value, e.low, e.high);
    return text;
}

std::string numbers(const MeasuredErrors& e) {
    std::string text;
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
    if (e.luvP99)
        add("L*u*v* " + between(*e.luvP99) + " at the 99th percentile");
    if (e.luvMean)
        add((e.luvP99 ? "" : "L*u*v* ") + between(*e.luvMean) + " in the mean");
    if (e.rms)
        add("rms " + between(*e.rms));
    return text.empty() ? "too few pixels show something to tell" : text;
}

} // namespace

const std::vector<std::string>& verifyNames() {
    static const std::vector<std::string> names = {"none", "quick", "full"};
    return names;
}

std::vector<std::string> describe(const PictureMeasurement& m) {
    if (!m.whyNot.empty())
        return {"measured error: not measured, because " + m.whyNot};
    std::vector<std::string> lines = {"measured error: " + numbers(m.all) + ", from " +
                                      std::to_string(m.all.shown) + " pixels drawn again with " +
                                      std::to_string(m.samples) + " rays each"};
    if (m.all.whyNoP99 == NotMeasured::tooFewPixels)
        lines.push_back("measured error: no 99th percentile, because fewer than " +
                        std::to_string(kFewestForP99) + " pixels that show something were drawn again");
    if (m.all.whyNoP99 == NotMeasured::truthTooNoisy)
        lines.push_back("measured error: no 99th percentile, because " + std::to_string(m.samples) +
                        " rays a pixel leave the truth too noisy");
    lines.push_back("of it the picture's samples of its pixels: " + numbers(m.sampling));
    lines.push_back("of it levels, step and filtering: " + numbers(m.rays));
    return lines;
}

PixelsAgain::PixelsAgain(const Image& picture, const VerifyPlan& plan, const PixelSampling& sampling,
                         int round)
    : size_(picture.size),
      sample_(
          choosePixels(picture.size, plan.design,
                       static_cast<std::size_t>(plan.design.pixels) >= picture.pixels.size() ? 0 : round)),
      replicates_(plan.replicates), samples_(plan.samples), places_(sampling.seed, sampling.filter),
      firstSet_(kFirstSet + static_cast<std::uint32_t>(round) * kSetsOfRound) {
    TESSERA_CHECK(replicates_ > 0 && samples_ > 0);
    picture_.reserve(pixels());
    for (const SampledPixel& p : sample_.pixels)
        picture_.push_back(picture.at(p.at.x, p.at.y));
}

std::size_t PixelsAgain::bytes() const {
    const auto replicates = static_cast<std::size_t>(replicates_);
    return pixels() * (sizeof(SampledPixel) + sizeof(glm::vec4) * (2 + 3 * replicates));
}

std::optional<std::vector<glm::vec4>> PixelsAgain::draw(RayCaster& caster, Engine& engine,
                                                        const ScenePlan& plan, double segmentVoxels,
                                                        const Limits& limits, Work& work) const {
    RayFrame<double> frame = plan.view.frame;
    frame.segmentVoxels = segmentVoxels;
    Strides strides = plan.strides();
    strides.segmentVoxels = segmentVoxels;
    const auto inSet = static_cast<std::size_t>(std::min(samples_, static_cast<int>(kPatchRays)));
    const std::size_t setsOfReplicate = static_cast<std::size_t>(samples_) / inSet;
    const std::size_t setsOfPixel = setsOfReplicate * static_cast<std::size_t>(replicates_);
    const std::size_t sets = pixels() * setsOfPixel;
    const std::size_t atOnce = std::max<std::size_t>(1, AreaPicture::mostRays(size_) / inSet);
    std::vector<glm::vec4> out(pixels() * static_cast<std::size_t>(replicates_), glm::vec4(0));
    std::vector<glm::vec2> array;
    glm::vec2 places[kPatchRays];
    for (std::size_t first = 0; first < sets; first += atOnce) {
        const std::size_t count = std::min(atOnce, sets - first);
        Rays rays{frame, strides};
        rays.arraySize = rayArraySize(count * inSet);
        array.assign(rayCount(rays.arraySize), glm::vec2(0));
        for (std::size_t n = 0; n < count; ++n) {
            const std::size_t set = first + n;
            places_.put(sample_.pixels[set / setsOfPixel].at,
                        firstSet_ + static_cast<std::uint32_t>(set % setsOfPixel), 0,
                        std::span(places).first(inSet));
            for (std::size_t i = 0; i < inSet; ++i)
                array[raySlot(n * inSet + i, rays.arraySize)] = places[i];
        }
        for (std::size_t k = count * inSet; k < array.size();
             ++k) // left over: what is drawn there is dropped
            array[raySlot(k, rays.arraySize)] = places[inSet - 1];
        rays.places = array;
        caster.begin(rays);
        if (!drawWithin(caster, engine, plan, limits.slicing, limits.mostBytes, work))
            return std::nullopt;
        const Image drawn = caster.image();
        for (std::size_t n = 0; n < count; ++n) {
            glm::vec4 sum(0);
            for (std::size_t i = 0; i < inSet; ++i)
                sum += drawn.pixels[raySlot(n * inSet + i, rays.arraySize)];
            out[(first + n) / setsOfReplicate] += sum / static_cast<float>(samples_);
        }
    }
    return out;
}

std::vector<glm::vec4> PixelsAgain::means(const std::vector<glm::vec4>& replicates) const {
    std::vector<glm::vec4> out(pixels(), glm::vec4(0));
    for (std::size_t n = 0; n < replicates.size(); ++n)
        out[n / static_cast<std::size_t>(replicates_)] += replicates[n] / static_cast<float>(replicates_);
    return out;
}

void PixelsAgain::measure(const std::vector<glm::vec4>& own, const std::vector<glm::vec4>& truth,
                          PictureMeasurement& out) const {
    out.samples = replicates_ * samples_;
    out.all = measuredErrors({sample_, replicates_, picture_, truth}, kShown);
    out.sampling = measuredErrors({sample_, replicates_, picture_, own}, kShown);
    // Both went through the same places, so that what is left of their noise is small.
    out.rays = measuredErrors({sample_, 1, means(own), means(truth)}, kShown);
}

} // namespace tessera
