// render/picture/measure_picture.cpp: see measure_picture.h.
#include "render/picture/measure_picture.h"

#include "core/base/error.h"
#include "core/base/stopwatch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr double kStepsOfTruth = 4; // in a step of the picture
/// Rays of the truth end where this part of the light is left at which those of the picture end; not never,
/// because most that lies behind what is opaque would be walked through for nothing.
constexpr float kEndsOfTruth = 1.0f / 64;
constexpr int kLarge = 512 * 512; // pixels from which on quick measurements are bounded
constexpr std::uint64_t kShareOfBytes = 4;
constexpr std::size_t kSharesOfNothing = 4;
/// Single pixels took 1.9 to 3.9 times the bytes of clusters: tried where these leave half of what there is.
constexpr std::uint64_t kShareOfClusters = 2;
constexpr char kTooManyBytes[] =
    "the bricks that some pixels need are more than a quarter of the picture's bytes";

std::size_t shownPixels(const Image& image) {
    return static_cast<std::size_t>(std::count_if(image.pixels.begin(), image.pixels.end(),
                                                  [](const glm::vec4& p) { return !(p.a <= 1.0f / 255); }));
}

/// Every round takes pixels of its own. Where those would be too few for each, all take all: then nothing is
/// chosen, and what decided to go on decides nothing about which pixels tell.
void leaveForOthers(VerifyPlan& plan, const VerifyInput& input, int rounds) {
    const double pixels = static_cast<double>(input.size.x) * input.size.y;
    const double share = std::floor(pixels / rounds);
    if (plan.design.pixels <= share)
        return;
    constexpr double kEnough = 950; // that show something: the sixth attempt's bound takes 712
    const bool enough = share * static_cast<double>(input.shown) / pixels >= kEnough;
    plan.design.pixels = static_cast<int>(enough ? share : pixels);
}

bool hasFinestLevels(const ScenePlan& plan) {
    const Selection& s = plan.volume.selection;
    return s.counts[0] == s.shownBricks();
}

/// Rays of the picture wait for bricks: those that pixels need are mostly gone again.
bool drawnInPasses(const ScenePlan& plan, Engine& engine) {
    return engine.bricks() && plan.chosen.atlasPages < pagesFor(plan.volume.selection.counts);
}

/// A brick's width in the middle of the volume, in pixels, along the axis of the picture where it is smaller.
int brickPixels(const RayFrame<double>& frame) {
    const double voxels = std::max(2 * glm::length(frame.right) / frame.imageSize.x,
                                   2 * glm::length(frame.up) / frame.imageSize.y); // of a pixel
    return std::max(1, static_cast<int>(std::lround(kBrickExtent / voxels)));
}

} // namespace

PictureMeasurement measurePicture(const DrawnPicture& picture, ScenePlan& plan, Engine& engine,
                                  std::unique_ptr<RayCaster>& caster, const FrameContext& context) {
    MemoryBudget& ram = context.ram;
    const auto start = std::chrono::steady_clock::now();
    PictureMeasurement out;
    out.mode = picture.mode;
    const Lighting& lighting = picture.scene.lighting;
    out.keptLight = reductionOf(picture.scene) == Reduction::composite &&
                    (lightChannels(lighting) > 0 || lighting.surfaceOcclusion);
    out.singleRays = picture.samplesPerPixel == 1;
    const bool finest = hasFinestLevels(plan);
    const glm::ivec2 size = picture.image.size;
    const bool large = size.x * size.y >= kLarge;
    VerifyInput input;
    input.size = size;
    const std::size_t shown = shownPixels(picture.image), pixels = picture.image.pixels.size();
    // A picture that shows nothing may have missed what there is: as many pixels as if a part did.
    input.shown = shown > 0 ? shown : (pixels + kSharesOfNothing - 1) / kSharesOfNothing;
    input.samplesPerPixel = std::max(1, static_cast<int>(std::lround(picture.samplesPerPixel)));
    input.costOfTruthRay = kStepsOfTruth;
    input.mode = picture.mode;
    input.seed = picture.scene.quality.pixels.seed;
    const bool passes = drawnInPasses(plan, engine);
    if (large && (!finest || passes))
        input.brickPixels = brickPixels(plan.view.frame);
    std::vector<VerifyPlan> designs{verifyPlan(input)};
    if (picture.rounds > 1)
        leaveForOthers(designs[0], input, picture.rounds);
    if (designs[0].design.pixels == 0) {
        out.whyNot = "it was not asked for";
        return out;
    }
    // Pixels on their own tell more than clusters, and come after them where that leaves rays and bytes.
    if (designs[0].design.perCluster > 1 && !passes) {
        input.brickPixels = 0;
        input.costTaken = designs[0].cost;
        if (const VerifyPlan single = verifyPlan(input); single.tellsP99)
            designs.push_back(single);
    }
    std::vector<PixelsAgain> again;
    std::size_t bytes = 0;
    for (const VerifyPlan& design : designs) {
        again.emplace_back(picture.image, design, picture.scene.quality.pixels, picture.round);
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
        limits.mostBytes = picture.work.bytesUploaded / kShareOfBytes;
    const double step = plan.view.quality.stepVoxels;
    const bool more = picture.mode == Verify::full; // at any cost
    std::vector<std::vector<glm::vec4>> own;
    for (PixelsAgain& pixels : again) {
        auto drawn = pixels.drawOwn(*caster, engine, plan, step, limits, more, work);
        if (!drawn) {
            out.whyNot = kTooManyBytes;
            return out;
        }
        own.push_back(*std::move(drawn));
    }
    if (finest) {
        caster->fetchExactly();
    } else {
        caster.reset();
        engine.close();
        Scene all = picture.scene;
        all.quality.stepVoxels = step;
        all.quality.automaticStep = false;
        all.quality.integrator = plan.volume.optics.integrator;
        all.quality.fetch = Fetch::exact;
        all.quality.maxError = 0; // rays wait for bricks
        try {
            chooseAgain(plan, all, engine.limits(), context, LevelChoice::finest);
        } catch (const InputError& e) {
            out.whyNot = e.what();
            return out;
        }
        ScenePlan* const volumes[] = {&plan};
        engine.open(volumes, plan.chosen.atlasPages);
        caster = engine.caster({false, false, true}, context.gpu);
    }
    plan.setStep(step / kStepsOfTruth);
    const float ends = plan.volume.optics.termination;
    plan.volume.optics.termination = ends * kEndsOfTruth;
    caster->functionChanged(); // tables of segments of this length, and where rays end
    out.whyNot = kTooManyBytes;
    for (std::size_t n = 0; n < again.size(); ++n) {
        if (n > 0 && work.bytesUploaded > limits.mostBytes / kShareOfClusters)
            break;
        const auto truth = again[n].drawTruth(*caster, engine, plan, step / kStepsOfTruth, limits, work);
        if (!truth)
            break;
        out.whyNot.clear();
        again[n].measure(own[n], *truth, picture.rounds > 1 ? chanceOfAttempt(picture.round) : 0.95, out);
    }
    plan.volume.optics.termination = ends;
    if (out.whyNot.empty() && shown == 0 && out.all.shown == 0)
        out.whyNot = "the picture shows nothing, nor do the " + std::to_string(again[0].pixels()) +
                     " pixels that were drawn again";
    out.bytesRead = work.bytesUploaded;
    out.seconds = secondsSince(start);
    return out;
}

} // namespace tessera
