// render/picture/measure_picture.cpp: see measure_picture.h.
#include "render/picture/measure_picture.h"

#include "core/base/error.h"
#include "core/base/progress.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr double kCostOfTruth = 4; // of a ray, in rays of the picture: a quarter of its step
constexpr int kLarge = 512 * 512;  // pixels from which on quick measurements are bounded
constexpr std::uint64_t kShareOfBytes = 4;
constexpr std::size_t kSharesOfNothing = 4;
/// Single pixels took 1.9 to 3.9 times the bytes of clusters: tried if these leave half of the budget.
constexpr std::uint64_t kShareOfClusters = 2;
constexpr char kTooManyBytes[] =
    "the bricks that some pixels need are more than a quarter of the picture's bytes";

/// Every round takes pixels of its own. If those would be too few for each, all rounds take all pixels. Then
/// no pixels are chosen, and the decision to go on has no effect on the choice.
void leaveForOthers(VerifyPlan& plan, const VerifyInput& input, int rounds) {
    const double pixels = static_cast<double>(input.size.x) * input.size.y;
    const double share = std::floor(pixels / rounds);
    if (plan.design.pixels <= share)
        return;
    constexpr double kEnough = 950; // that show something: the sixth attempt's bound takes 712
    const bool enough = share * static_cast<double>(input.shown) / pixels >= kEnough;
    plan.design.pixels = static_cast<int>(enough ? share : pixels);
}

} // namespace

PictureMeasurement measurePicture(const DrawnPicture& picture, PixelSource& source, MemoryBudget& ram) {
    const auto start = std::chrono::steady_clock::now();
    PictureMeasurement out;
    out.mode = picture.mode;
    const Lighting& lighting = picture.scene.lighting;
    out.keptLight = reductionOf(picture.scene) == Reduction::composite && !lighting.transport &&
                    (lightChannels(lighting) > 0 || lighting.surfaceOcclusion);
    out.singleRays = picture.samplesPerPixel == 1;
    const PixelSource::About about = source.about();
    const glm::ivec2 size = picture.pixels.size;
    const bool large = size.x * size.y >= kLarge;
    VerifyInput input;
    input.size = size;
    const std::size_t shown = picture.pixels.shown, pixels = rayCount(size);
    // A picture that shows nothing may have missed the contents: as many pixels as if a part did.
    input.shown = shown > 0 ? shown : (pixels + kSharesOfNothing - 1) / kSharesOfNothing;
    input.samplesPerPixel = std::max(1, static_cast<int>(std::lround(picture.samplesPerPixel)));
    input.costOfTruthRay = kCostOfTruth;
    input.mode = picture.mode;
    input.seed = picture.scene.quality.pixels.seed;
    if (large && !lighting.transport && (!about.finest || about.passes))
        input.brickPixels = about.brickPixels;
    std::vector<VerifyPlan> designs{verifyPlan(input)};
    if (picture.rounds > 1)
        leaveForOthers(designs[0], input, picture.rounds);
    if (designs[0].design.pixels == 0) {
        out.whyNot = "it was not asked for";
        return out;
    }
    // Pixels on their own tell more than clusters, and come after them where that leaves rays and bytes.
    if (designs[0].design.perCluster > 1 && !about.passes) {
        input.brickPixels = 0;
        input.costTaken = designs[0].cost;
        if (const VerifyPlan single = verifyPlan(input); single.tellsP99)
            designs.push_back(single);
    }
    std::vector<PixelsAgain> again;
    std::size_t bytes = 0;
    for (const VerifyPlan& design : designs) {
        again.emplace_back(picture.pixels, design, picture.scene.quality.pixels, picture.round, picture.over);
        bytes += again.back().bytes();
    }
    if (again[0].pixels() == 0) {
        out.whyNot = "no pixels are left that were not drawn again before";
        return out;
    }
    if (ram.freeBytes() < bytes) {
        out.whyNot = "RAM is too short for it";
        return out;
    }
    const Charge charge = ram.charge(bytes, "pixels drawn again");
    Work work; // not the picture's
    PixelsAgain::Limits limits{picture.slicing};
    limits.slicing.progress = {};
    if (picture.mode == Verify::quick && large)
        limits.mostBytes = picture.bytes / kShareOfBytes;
    const bool more = picture.mode == Verify::full; // at any cost
    std::vector<std::vector<glm::vec4>> own;
    for (PixelsAgain& pixels : again) {
        auto drawn = pixels.drawOwn(source, limits, more, work);
        if (!drawn) {
            out.whyNot = kTooManyBytes;
            return out;
        }
        own.push_back(*std::move(drawn));
    }
    if (lighting.transport) {
        out.keptRays = true;
        again[0].measureOwn(own[0], out);
        out.bytesRead = work.bytesUploaded;
        out.seconds = secondsSince(start);
        return out;
    }
    if (picture.light && out.keptLight) {
        out.whyNoLight = source.toSingleWays();
        if (out.whyNoLight.empty())
            if (const auto ways = again[0].drawAgain(source, limits, work))
                out.light = again[0].lightError(own[0], *ways);
    }
    if (out.whyNot = source.toTruth(); !out.whyNot.empty())
        return out;
    out.whyNot = kTooManyBytes;
    for (std::size_t n = 0; n < again.size(); ++n) {
        if (n > 0 && work.bytesUploaded > limits.mostBytes / kShareOfClusters)
            break;
        const auto truth = again[n].drawAgain(source, limits, work);
        if (!truth)
            break;
        out.whyNot.clear();
        again[n].measure(own[n], *truth, picture.rounds > 1 ? chanceOfAttempt(picture.round) : 0.95, out);
    }
    if (out.whyNot.empty() && shown == 0 && out.all.shown == 0)
        out.whyNot = "the picture shows nothing, nor do the " + std::to_string(again[0].pixels()) +
                     " pixels that were drawn again";
    out.bytesRead = work.bytesUploaded;
    out.seconds = secondsSince(start);
    return out;
}

} // namespace tessera
