// render/measure_picture.cpp: see measure_picture.h.
#include "render/measure_picture.h"

#include "core/error.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace tessera {
namespace {

constexpr double kStepsOfTruth = 4; // in a step of the picture
/// Rays of the truth end where this part of the light is left at which those of the picture end; not never,
/// because most that lies behind what is opaque would be walked through for nothing.
constexpr float kEndsOfTruth = 1.0f / 64;
constexpr int kLarge = 512 * 512; // pixels from which on quick measurements are bounded
constexpr std::uint64_t kShareOfBytes = 4;

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

} // namespace

PictureMeasurement measurePicture(const DrawnPicture& picture, ScenePlan& plan, Engine& engine,
                                  std::unique_ptr<RayCaster>& caster, Ledger& ram, Ledger& gpu) {
    const auto start = std::chrono::steady_clock::now();
    PictureMeasurement out;
    out.mode = picture.mode;
    const bool finest = hasFinestLevels(plan);
    const glm::ivec2 size = picture.image.size;
    const bool large = size.x * size.y >= kLarge;
    VerifyInput input;
    input.size = size;
    input.shown = shownPixels(picture.image);
    input.samplesPerPixel = std::max(1, static_cast<int>(std::lround(picture.samplesPerPixel)));
    input.costOfTruthRay = kStepsOfTruth;
    input.mode = picture.mode;
    input.seed = picture.scene.quality.pixels.seed;
    VerifyPlan design = verifyPlan(input);
    if (picture.rounds > 1)
        leaveForOthers(design, input, picture.rounds);
    if (design.design.pixels == 0) {
        out.whyNot = input.shown == 0 ? "the picture shows nothing" : "it was not asked for";
        return out;
    }
    PixelsAgain again(picture.image, design, picture.scene.quality.pixels, picture.round);
    if (again.pixels() == 0) {
        out.whyNot = "no pixels are left that were not drawn again before";
        return out;
    }
    if (ram.freeBytes() < again.bytes()) {
        out.whyNot = "RAM is too short for it";
        return out;
    }
    const Charge charge = ram.charge(again.bytes(), "pixels drawn again");
    Work work; // not the picture's
    PixelsAgain::Limits limits{picture.slicing};
    limits.slicing.progress = {};
    const double step = plan.view.quality.stepVoxels;
    const bool more = picture.mode == Verify::full; // at any cost
    const auto own = again.drawOwn(*caster, engine, plan, step, limits, more, work);
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
        if (picture.mode == Verify::quick && large)
            limits.mostBytes = picture.work.bytesUploaded / kShareOfBytes;
        try {
            chooseAgain(plan, all, engine.limits(), ram, gpu, picture.threads, LevelChoice::finest);
        } catch (const InputError& e) {
            out.whyNot = e.what();
            return out;
        }
        ScenePlan* const volumes[] = {&plan};
        engine.open(volumes, plan.chosen.atlasPages);
        caster = engine.caster({false, false, true}, gpu);
        work.bytesUploaded = 0;
    }
    plan.setStep(step / kStepsOfTruth);
    const float ends = plan.volume.optics.termination;
    plan.volume.optics.termination = ends * kEndsOfTruth;
    caster->functionChanged(); // tables of segments of this length, and where rays end
    const auto truth = again.drawTruth(*caster, engine, plan, step / kStepsOfTruth, limits, work);
    plan.volume.optics.termination = ends;
    out.bytesRead = work.bytesUploaded;
    if (truth)
        again.measure(own, *truth, picture.rounds > 1 ? chanceOfAttempt(picture.round) : 0.95, out);
    else
        out.whyNot = "the finest levels around some pixels are more than a quarter of the picture's bytes";
    out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return out;
}

} // namespace tessera
