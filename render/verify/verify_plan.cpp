// render/verify/verify_plan.cpp: see verify_plan.h.
#include "render/verify/verify_plan.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

constexpr int kReplicates = 4;
constexpr double kLarge = 512.0 * 512;
constexpr int kMostSamples = 256; // of a pixel
// Where bricks must be read: clusters that show something, their pixels, tiles of a brick along a side. A
// tile of a quarter of a brick lies in 1.6 bricks in the mean, one of a brick in four.
constexpr double kClusters = 64;
constexpr int kPerCluster = 8, kTilesOfBrick = 4, kLeastTile = 12;
// Pixels that show something. With the least number for a 99th percentile, 299 are reached with a margin of 2
// standard deviations.
constexpr double kMostTiles = 1 << 17;
constexpr double kMany = 1000, kSome = 400, kFull = 2000, kLeast = 340;

} // namespace

const std::vector<std::string>& verifyNames() {
    static const std::vector<std::string> names = {"none", "quick", "full"};
    return names;
}

VerifyPlan verifyPlan(const VerifyInput& input) {
    TESSERA_CHECK(input.size.x > 0 && input.size.y > 0 && input.samplesPerPixel > 0 &&
                  input.costOfTruthRay > 0);
    VerifyPlan plan;
    plan.design = {0, 1, 4, input.seed};
    const double pixels = static_cast<double>(input.size.x) * input.size.y;
    const double shown = std::min(pixels, static_cast<double>(input.shown));
    if (input.mode == Verify::none || shown == 0)
        return plan;
    const double pictureRays = shown * input.samplesPerPixel;
    // Rays for a truth with at most a quarter of the noise of the picture's own samples.
    const int wanted =
        std::clamp(4 * input.samplesPerPixel, input.mode == Verify::full ? 64 : 16, kMostSamples);
    const auto costOf = [&](double count, int samples) {
        return count * samples * input.costOfTruthRay / pictureRays;
    };
    double count = kFull;
    int samples = wanted;
    if (input.mode == Verify::quick) {
        count = pixels < kLarge ? kSome : kMany;
        const double most = std::max(0.0, kMostQuickCost - input.costTaken);
        if (pixels >= kLarge && costOf(count, samples) > most) {
            if (costOf(kSome, samples) > most)
                samples /= 2;
            count = std::min(count, std::floor(most / costOf(1, samples)));
        }
    }
    count = std::min(count, shown);
    plan.tellsP99 = count >= kLeast || count == shown;
    if (input.mode == Verify::quick && input.brickPixels > 0) {
        // Clusters cost bytes, their pixels rays: if these are scarce, there are fewer.
        plan.design.perCluster = std::clamp(static_cast<int>(count / kClusters), 1, kPerCluster);
        plan.design.tile = std::max(input.brickPixels / kTilesOfBrick, kLeastTile);
        count = std::min(count, kClusters * kPerCluster);
        plan.tellsP99 = false;
    }
    // Of large pictures tiles are larger, so that their list is short.
    const double least = std::sqrt(pixels / kMostTiles);
    plan.design.tile = std::max(plan.design.tile, static_cast<int>(std::ceil(least)));
    plan.design.pixels = static_cast<int>(std::ceil(std::max(1.0, count) * pixels / shown));
    plan.replicates = kReplicates;
    plan.samples = samples / kReplicates;
    plan.cost = costOf(count, samples);
    return plan;
}

} // namespace tessera
