// verify_coverage PICTURE TRUTH PIXELS PER_CLUSTER TILE REPLICATES SAMPLES TRIALS: how often intervals of
// measured errors hold what they claim, on a real field of errors. TRUTH has four times the picture's size
// each way: its 16 pixels in one are what a replicate's samples are drawn from. PICTURE may have that size
// too: then it is averaged. REPLICATES 1: the truth without noise.
#include "core/image_file.h"
#include "core/image_metrics.h"
#include "render/verify/measured_errors.h"
#include "render/verify/random.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

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
        std::printf(" %s (-%d) %5.1f%%(>%4.1f) w%.2f b%.3f |", name, none, 100.0 * covered / std::max(1, n),
                    100.0 * below / std::max(1, n), width / std::max(1, n), bias / std::max(1, n));
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
    Count rms, mean, p99;
    int held = 0, bounds = 0;
    double loose = 0, deff = 0;
    for (int trial = 0; trial < trials; ++trial) {
        PixelPairs pairs;
        pairs.sample =
            choosePixels(truth.size, {pixels, perCluster, tile, static_cast<std::uint64_t>(trial)});
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
        deff += m.tailDesignEffect;
        if (m.luvP99Bound) {
            ++bounds;
            held += is.luvP99 <= *m.luvP99Bound;
            loose += *m.luvP99Bound / is.luvP99;
        }
    }
    std::printf("%-20s n%d k%d t%d R%dx%d rms %.4f mean %.3f p99 %.2f shown %.0f%%|",
                argv[1] + std::string(argv[1]).rfind('/') + 1, pixels, perCluster, tile, replicates, samples,
                is.rmse, is.luvMean, is.luvP99,
                100.0 * static_cast<double>(is.maskedPixels) / static_cast<double>(truth.pixels.size()));
    rms.print("rms");
    mean.print("mean");
    p99.print("p99");
    std::printf(" bound %d: %.1f%% x%.2f deff %.2f\n", bounds, 100.0 * held / std::max(1, bounds),
                loose / std::max(1, bounds), deff / trials);
}
