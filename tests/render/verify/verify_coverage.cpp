// verify_coverage PICTURE TRUTH PIXELS PER_CLUSTER TILE REPLICATES SAMPLES TRIALS: the share of measured
// intervals that contain the true error, on a real field of errors (docs/measurements/measured-errors.md has
// its figures). TRUTH has four times the picture's size each way: its 16 pixels in one are the area truth,
// and what a replicate's samples are drawn from. PICTURE may have that size too: then it is averaged. PIXELS
// are those that show something. REPLICATES 1: the truth without noise. Widths and values are printed as
// multiples of the truth.
#include "core/image/image_file.h"
#include "core/image/image_metrics.h"
#include "render/verify/measured_errors.h"
#include "render/verify/pixel_sample.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

using namespace tessera;

namespace {

constexpr int kFiner = 4;

glm::vec4 subPixel(const Image& fine, const glm::ivec2& at, std::uint64_t which) {
    return fine.at(kFiner * at.x + static_cast<int>(which % kFiner),
                   kFiner * at.y + static_cast<int>(which / kFiner));
}

Image averaged(const Image& fine) {
    Image out(fine.size / kFiner);
    for (int y = 0; y < out.size.y; ++y)
        for (int x = 0; x < out.size.x; ++x) {
            glm::dvec4 sum(0);
            for (std::uint64_t i = 0; i < kFiner * kFiner; ++i)
                sum += glm::dvec4(subPixel(fine, {x, y}, i));
            out.at(x, y) = glm::vec4(sum / double{kFiner * kFiner});
        }
    return out;
}

struct Count {
    int covered = 0, below = 0, none = 0, n = 0;
    double width = 0, bias = 0;
    void add(const std::optional<Estimate>& e, double truth) {
        if (!e) {
            ++none;
            return;
        }
        ++n;
        covered += e->low <= truth && truth <= e->high;
        below += truth > e->high;
        width += (e->high - e->low) / truth;
        bias += e->value / truth;
    }
    void print(const char* name) const {
        if (n == 0) {
            std::printf(" | %s: not measured", name);
            return;
        }
        std::printf(" | %s: %.1f %% (%.1f %% above), width %.2f, value %.3f", name, 100.0 * covered / n,
                    100.0 * below / n, width / n, bias / n);
        if (none > 0)
            std::printf(", in %d of %d", n, n + none);
    }
};

} // namespace

int main(int argc, char** argv) {
    if (argc != 9)
        return 2;
    Image picture = readImage(argv[1]);
    const Image fine = readImage(argv[2]);
    const int pixels = std::atoi(argv[3]), perCluster = std::atoi(argv[4]), tile = std::atoi(argv[5]),
              replicates = std::atoi(argv[6]), samples = std::atoi(argv[7]), trials = std::atoi(argv[8]);
    const Image truth = averaged(fine);
    if (picture.size == fine.size)
        picture = averaged(picture);
    const ImageError is = measureError(picture, truth);
    const double shown = static_cast<double>(is.maskedPixels) / static_cast<double>(truth.pixels.size());
    const int chosen = static_cast<int>(pixels / shown);
    Count rms, mean, p99;
    int held = 0, bounds = 0;
    double loose = 0, deff = 0;
    for (int trial = 0; trial < trials; ++trial) {
        PixelPairs pairs;
        pairs.sample =
            choosePixels(truth.size, {chosen, perCluster, tile, static_cast<std::uint64_t>(trial)});
        pairs.replicates = replicates;
        RandomNumbers random(static_cast<std::uint64_t>(trial), 77);
        for (const SampledPixel& p : pairs.sample.pixels) {
            pairs.picture.push_back(picture.at(p.at.x, p.at.y));
            for (int r = 0; r < replicates; ++r) {
                if (replicates == 1) {
                    pairs.truth.push_back(truth.at(p.at.x, p.at.y));
                    continue;
                }
                glm::dvec4 sum(0);
                for (int s = 0; s < samples; ++s)
                    sum += glm::dvec4(subPixel(fine, p.at, random.below(kFiner * kFiner)));
                pairs.truth.push_back(glm::vec4(sum / static_cast<double>(samples)));
            }
        }
        const MeasuredErrors m = measuredErrors(pairs, 0);
        rms.add(m.rms, is.rmse);
        mean.add(m.luvMean, is.luvMean);
        p99.add(m.luvP99, is.luvP99);
        const std::vector<PixelError> errors = pixelErrors(pairs, 0);
        deff += tailDesignEffect(errors, Tail(errors), pairs.sample.clusters);
        if (m.luvP99Bound) {
            ++bounds;
            held += is.luvP99 <= *m.luvP99Bound;
            loose += *m.luvP99Bound / is.luvP99;
        }
    }
    std::printf(
        "%s, %d pixels, %d a cluster in %d, %d x %d rays; rms %.4f, mean %.3f, p99 %.2f, shown %.0f %%",
        std::filesystem::path(argv[1]).stem().c_str(), pixels, perCluster, tile, replicates, samples, is.rmse,
        is.luvMean, is.luvP99, 100 * shown);
    rms.print("rms");
    mean.print("mean");
    p99.print("p99");
    if (bounds > 0)
        std::printf(" | bound: %.1f %%, %.2f of p99", 100.0 * held / bounds, loose / bounds);
    std::printf(" | design effect %.2f\n", deff / trials);
}
