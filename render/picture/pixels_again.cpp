// render/picture/pixels_again.cpp: see pixels_again.h.
#include "render/picture/pixels_again.h"

#include "core/base/error.h"
#include "core/image/colour.h"
#include "render/pixels/area_picture.h"
#include "render/pixels/pixel_places.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <span>

namespace tessera {
namespace {

/// Pixels count where the truth shows as much as can be seen, as compare() has it.
constexpr float kShown = 1.0f / 255;
/// Sets of a pixel from here on are the truth's: no picture takes so many.
constexpr std::uint32_t kFirstSet = 1u << 20, kSetsOfRound = 1u << 12;
constexpr int kRun = 16; // samples of a replicate that are drawn side by side, at most
/// Of a pixel that is too noisy: sets of each step, steps, samples at most.
constexpr int kSetsOfStep = 1 << 10, kMostSteps = 2, kMostOfPixel = 4096;
/// The possible error of the mean of a pixel's samples, as a share of the distance that one of 100 pixels
/// exceeds. Its square is then a 25th of those of the largest distances, which their bound includes.
constexpr double kNoiseOfTail = 0.2;

glm::dvec3 luvOf(const glm::vec4& pixel) {
    return luvFromLinear(glm::clamp(glm::dvec3(pixel), glm::dvec3(0.0), glm::dvec3(1.0)));
}

/// The error of the truth besides its noise, as a part of an error: mostly the error of the step that a
/// quarter of the step leaves. Pictures drawn again whole, where nothing else is left, measured up to 3.4 %
/// beside the true errors.
constexpr double kTruthsOwn = 0.035;

void widen(MeasuredErrors& errors) {
    for (std::optional<Estimate>* e : {&errors.rms, &errors.luvMean, &errors.luvP99})
        if (*e) {
            (*e)->low *= 1 - kTruthsOwn;
            (*e)->high *= 1 + kTruthsOwn;
        }
}

/// L*u*v* standard error of the mean over replicates.
double noiseOf(std::span<const glm::vec4> replicates) {
    glm::dvec3 mean(0.0);
    for (const glm::vec4& one : replicates)
        mean += luvOf(one) / static_cast<double>(replicates.size());
    double squares = 0;
    for (const glm::vec4& one : replicates)
        squares += glm::dot(luvOf(one) - mean, luvOf(one) - mean);
    return std::sqrt(squares / static_cast<double>(replicates.size() * (replicates.size() - 1)));
}

std::string between(const Estimate& e) {
    char text[80];
    std::snprintf(text, sizeof text, "%.2g (%.2g to %.2g)", e.value, e.low, e.high);
    return text;
}

std::string raysOf(const PictureMeasurement& m) {
    return std::to_string(m.samples) +
           (m.mostSamples > m.samples ? " to " + std::to_string(m.mostSamples) : "");
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

std::vector<std::string> describe(const PictureMeasurement& m) {
    if (!m.whyNot.empty())
        return {"measured error: not measured, because " + m.whyNot};
    std::vector<std::string> lines = {"measured error: " + numbers(m.all) + ", from " +
                                      std::to_string(m.all.shown) + " pixels drawn again with " + raysOf(m) +
                                      " rays each" +
                                      (m.keptLight  ? m.light ? "; beside it what light itself errs by"
                                                              : "; what light itself errs by is not in it"
                                       : m.keptRays ? "; what levels and step err by is not in it"
                                                    : "")};
    if (m.all.whyNoP99 == NotMeasured::tooFewPixels && m.all.shown >= kFewestForP99)
        lines.push_back("measured error: no 99th percentile, because they lie in " +
                        std::to_string(m.all.clusters) + " clusters, as bytes allow; it takes " +
                        std::to_string(kFewestForP99));
    else if (m.all.whyNoP99 == NotMeasured::tooFewPixels)
        lines.push_back("measured error: no 99th percentile, because fewer than " +
                        std::to_string(kFewestForP99) + " pixels that show something were drawn again");
    if (m.all.whyNoP99 == NotMeasured::truthTooNoisy)
        lines.push_back("measured error: no 99th percentile, because " + raysOf(m) +
                        " rays a pixel leave the truth too noisy");
    if (m.keptRays)
        return lines;
    lines.push_back("of it the picture's samples of its pixels: " + numbers(m.sampling));
    lines.push_back("of it levels, step, filtering and ended rays: " + numbers(m.rays) +
                    ", of the mean over a pixel's " + raysOf(m) + " rays" +
                    (m.singleRays ? "; single rays, as the picture has, err by as much or more" : ""));
    if (m.light)
        lines.push_back("beside it the light, of voxels and maps: " + numbers(*m.light) +
                        ", against single ways of light through the same places");
    else if (!m.whyNoLight.empty())
        lines.push_back("the light's own error: not measured, because " + m.whyNoLight);
    return lines;
}

DrawnPixels pixelsOf(const Image& image) {
    const auto shows = [](const glm::vec4& p) { return !(p.a <= kShown); };
    return {image.size,
            static_cast<std::size_t>(std::count_if(image.pixels.begin(), image.pixels.end(), shows)),
            [&image](const glm::ivec2& at) { return image.at(at.x, at.y); }, image.size};
}

PixelsAgain::PixelsAgain(const DrawnPixels& picture, const VerifyPlan& plan, const PixelSampling& sampling,
                         int round, PixelOver over)
    : together_(picture.together),
      sample_(
          choosePixels(picture.size, plan.design,
                       static_cast<std::size_t>(plan.design.pixels) >= rayCount(picture.size) ? 0 : round)),
      replicates_(plan.replicates),
      samples_(static_cast<int>(std::bit_ceil(static_cast<unsigned>(plan.samples)))),
      places_(sampling.seed, sampling.filter),
      firstSet_(kFirstSet + static_cast<std::uint32_t>(round) * kSetsOfRound), over_(std::move(over)) {
    TESSERA_CHECK(replicates_ > 0 && plan.samples > 0 && samples_ <= kMostInSet);
    step_.assign(pixels(), 0);
    picture_.reserve(pixels());
    for (const SampledPixel& p : sample_.pixels)
        picture_.push_back(picture.colour(p.at));
}

std::size_t PixelsAgain::bytes() const {
    const auto replicates = static_cast<std::size_t>(replicates_);
    return pixels() *
           (sizeof(SampledPixel) + sizeof(std::uint8_t) + sizeof(glm::vec4) * (3 + 3 * replicates));
}

bool PixelsAgain::drawStep(int step, PixelSource& source, const Limits& limits, Work& work,
                           std::vector<glm::vec4>& out) const {
    std::vector<std::size_t> chosen;
    for (std::size_t n = 0; n < pixels(); ++n)
        if (step_[n] == step)
            chosen.push_back(n);
    const int samples = samplesOf(step);
    const auto inRun = static_cast<std::size_t>(std::min(samples, kRun));
    const std::size_t runsOfReplicate = static_cast<std::size_t>(samples) / inRun;
    const std::size_t runsOfPixel = runsOfReplicate * static_cast<std::size_t>(replicates_);
    const int setsOfReplicate = (samples + kMostInSet - 1) / kMostInSet;
    const std::size_t runs = chosen.size() * runsOfPixel;
    const std::size_t atOnce = std::max<std::size_t>(1, AreaPicture::mostRays(together_) / inRun);
    std::vector<glm::vec2> array;
    glm::vec2 places[kRun];
    for (std::size_t first = 0; first < runs; first += atOnce) {
        const std::size_t count = std::min(atOnce, runs - first);
        const glm::ivec2 arraySize = rayArraySize(count * inRun);
        array.assign(rayCount(arraySize), glm::vec2(0));
        for (std::size_t n = 0; n < count; ++n) {
            const std::size_t run = first + n;
            const auto replicate = static_cast<int>(run % runsOfPixel / runsOfReplicate);
            const auto sample = static_cast<int>(run % runsOfReplicate * inRun);
            const int set = step * kSetsOfStep + replicate * setsOfReplicate + sample / kMostInSet;
            places_.put(sample_.pixels[chosen[run / runsOfPixel]].at,
                        firstSet_ + static_cast<std::uint32_t>(set), sample % kMostInSet,
                        std::span(places).first(inRun));
            for (std::size_t i = 0; i < inRun; ++i)
                array[raySlot(n * inRun + i, arraySize)] = places[i];
        }
        for (std::size_t k = count * inRun; k < array.size();
             ++k) // left over: pixels drawn there are dropped
            array[raySlot(k, arraySize)] = places[inRun - 1];
        const auto drawn = source.draw(array, arraySize, limits.slicing, limits.mostBytes, work);
        if (!drawn)
            return false;
        for (std::size_t n = 0; n < count; ++n) {
            glm::vec4 sum(0);
            for (std::size_t i = 0; i < inRun; ++i)
                sum += drawn->pixels[raySlot(n * inRun + i, arraySize)];
            const std::size_t run = first + n, replicate = run % runsOfPixel / runsOfReplicate;
            out[chosen[run / runsOfPixel] * static_cast<std::size_t>(replicates_) + replicate] +=
                sum / static_cast<float>(samples);
        }
    }
    for (std::size_t n = 0; over_ && n < chosen.size(); ++n) {
        const LabelsOver over = over_(sample_.pixels[chosen[n]].at);
        for (std::size_t k = 0; k < static_cast<std::size_t>(replicates_); ++k) {
            glm::vec4& colour = out[chosen[n] * static_cast<std::size_t>(replicates_) + k];
            colour = over(colour);
        }
    }
    return true;
}

bool PixelsAgain::chooseNoisy(int step, const std::vector<glm::vec4>& own) {
    const std::vector<glm::vec4> mean = means(own);
    std::vector<double> distances, noise(pixels());
    for (std::size_t n = 0; n < pixels(); ++n) {
        if (mean[n].a > kShown)
            distances.push_back(glm::length(luvOf(mean[n]) - luvOf(picture_[n])));
        if (step_[n] == step)
            noise[n] = noiseOf(std::span(own).subspan(n * static_cast<std::size_t>(replicates_),
                                                      static_cast<std::size_t>(replicates_)));
    }
    if (distances.empty())
        return false;
    const auto rank = static_cast<std::ptrdiff_t>(kTailShare * static_cast<double>(distances.size() - 1));
    std::nth_element(distances.begin(), distances.begin() + rank, distances.end());
    const double most = kNoiseOfTail * distances[static_cast<std::size_t>(rank)];
    bool any = false;
    for (std::size_t n = 0; n < pixels(); ++n)
        if (step_[n] == step && noise[n] > most) {
            ++step_[n];
            any = true;
        }
    return any;
}

std::optional<std::vector<glm::vec4>> PixelsAgain::drawOwn(PixelSource& source, const Limits& limits,
                                                           bool more, Work& work) {
    const auto replicates = static_cast<std::size_t>(replicates_);
    std::vector<glm::vec4> own(pixels() * replicates, glm::vec4(0));
    for (int step = 0;; ++step) {
        if (!drawStep(step, source, limits, work, own))
            return std::nullopt;
        if (!more || step == kMostSteps || samplesOf(step + 1) * replicates_ > kMostOfPixel ||
            !chooseNoisy(step, own))
            return own;
        for (std::size_t n = 0; n < own.size(); ++n)
            if (step_[n / replicates] > step)
                own[n] = glm::vec4(0);
    }
}

std::optional<std::vector<glm::vec4>> PixelsAgain::drawAgain(PixelSource& source, const Limits& limits,
                                                             Work& work) const {
    std::vector<glm::vec4> truth(pixels() * static_cast<std::size_t>(replicates_), glm::vec4(0));
    const int last = step_.empty() ? 0 : *std::max_element(step_.begin(), step_.end());
    for (int step = 0; step <= last; ++step)
        if (!drawStep(step, source, limits, work, truth))
            return std::nullopt;
    return truth;
}

std::vector<glm::vec4> PixelsAgain::means(const std::vector<glm::vec4>& replicates) const {
    std::vector<glm::vec4> out(pixels(), glm::vec4(0));
    for (std::size_t n = 0; n < replicates.size(); ++n)
        out[n / static_cast<std::size_t>(replicates_)] += replicates[n] / static_cast<float>(replicates_);
    return out;
}

void PixelsAgain::measureOwn(const std::vector<glm::vec4>& own, PictureMeasurement& out) const {
    const int most = step_.empty() ? 0 : *std::max_element(step_.begin(), step_.end());
    out.samples = replicates_ * samples_;
    out.mostSamples = replicates_ * samplesOf(most);
    out.all = out.sampling = measuredErrors({sample_, replicates_, picture_, own}, kShown);
}

MeasuredErrors PixelsAgain::lightError(const std::vector<glm::vec4>& own,
                                       const std::vector<glm::vec4>& byWays) const {
    // Both went through the same places: what these differ by from replicate to replicate is no noise.
    const std::vector<glm::vec4> mean = means(own);
    std::vector<glm::vec4> light(byWays.size());
    for (std::size_t n = 0; n < light.size(); ++n)
        light[n] = mean[n / static_cast<std::size_t>(replicates_)] - own[n] + byWays[n];
    return measuredErrors({sample_, replicates_, mean, light}, kShown);
}

void PixelsAgain::measure(const std::vector<glm::vec4>& own, const std::vector<glm::vec4>& truth,
                          double boundChance, PictureMeasurement& out) const {
    measureOwn(own, out);
    out.all = measuredErrors({sample_, replicates_, picture_, truth}, kShown, boundChance);
    // Both went through the same places, so that the remainder of their noise is small.
    out.rays = measuredErrors({sample_, 1, means(own), means(truth)}, kShown);
    widen(out.all);
    widen(out.rays);
}

} // namespace tessera
