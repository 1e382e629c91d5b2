// render/light/histogram_light.cpp: see histogram_light.h.
#include "render/light/histogram_light.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace tessera {
namespace {

constexpr int kPartsOfBin = 16; // at which the function is asked, to either side of a centre

/// What a bin's values take, and the colours that they add, in the mean over them.
struct BinLight {
    double taken = 0;
    glm::dvec3 colour{0};
};

BinLight lightOf(const std::vector<double>& centres, std::size_t bin, const Optics& optics, double radiusMm) {
    BinLight sum;
    double weights = 0;
    const auto add = [&](double stored, double weight) {
        const auto value = static_cast<float>(stored);
        const double taken =
            HistogramLight::takenBy(static_cast<double>(occlusionExtinction(optics, value)), radiusMm);
        sum.taken += weight * taken;
        sum.colour += weight * taken * glm::dvec3(glm::vec3(lookUp(optics, value)));
        weights += weight;
    };
    // The values that are nearer to its centre than to others.
    for (const int side : {-1, 1})
        if (side < 0 ? bin > 0 : bin + 1 < centres.size()) {
            const double half = 0.5 * (centres[side < 0 ? bin - 1 : bin + 1] - centres[bin]);
            for (int n = 0; n < kPartsOfBin; ++n)
                add(centres[bin] + half * (n + 0.5) / kPartsOfBin, std::abs(half));
        }
    if (weights == 0)
        add(centres[bin], 1); // the only one
    return {sum.taken / weights, sum.colour / weights};
}

} // namespace

HistogramLight::HistogramLight(const VolumeInfo& info, const LocalHistograms& histograms,
                               const Occlusion& occlusion)
    : histograms_(histograms), occlusion_(occlusion), bleeds_(occlusion.bleeding > 0) {
    TESSERA_CHECK(histograms.settings.radiusMm == occlusion.radiusMm &&
                  histograms.extent == levelExtent(info.extentVoxels, histograms.level));
}

double HistogramLight::takenBy(double extinctionPerMm, double radiusMm) {
    const double depth = extinctionPerMm * radiusMm;
    return depth < 1e-4 ? 0.5 * depth : 1 + std::expm1(-depth) / depth;
}

void HistogramLight::functionChanged(const TransferTable&, const Optics& optics) {
    std::vector<BinLight> bins;
    for (std::size_t b = 0; b < histograms_.centres.size(); ++b)
        bins.push_back(lightOf(histograms_.centres, b, optics, occlusion_.radiusMm));
    rows_.resize(histograms_.representatives());
    for (std::size_t r = 0; r < rows_.size(); ++r) {
        double taken = 0, whole = 0;
        glm::dvec3 colour(0);
        // A plane of light has one number for all sides: the mean of both.
        for (const LocalSide side : {LocalSide::rising, LocalSide::falling}) {
            const std::uint16_t* const shares = histograms_.of(r, side);
            for (std::size_t b = 0; b < bins.size(); ++b) {
                const double share = shares[b];
                whole += share;
                taken += share * bins[b].taken;
                colour += share * bins[b].colour;
            }
        }
        whole = std::max(whole, 1.0); // a damaged row alone has none
        rows_[r] = {static_cast<float>(1 - taken / whole), glm::vec3(occlusion_.bleeding * colour / whole)};
    }
    for (int c = 0; c < channels(); ++c) {
        std::vector<std::uint16_t>& texels = texels_[static_cast<std::size_t>(c)];
        texels.clear();
        for (const Row& row : rows_)
            texels.push_back(texel(row, c));
    }
}

std::uint16_t HistogramLight::texel(const Row& row, int channel) const {
    return lightTexel(std::pow(static_cast<float>(occlusion_.bias) + row.open + row.colour[channel],
                               static_cast<float>(occlusion_.gamma)));
}

/// The mean over the samples that one of a coarser level stands for.
HistogramLight::Row HistogramLight::at(const glm::ivec3& sample, int level) const {
    const int shift = level - histograms_.level;
    const glm::ivec3 first = sample << shift, end = glm::min((sample + 1) << shift, histograms_.extent);
    double open = 0;
    glm::dvec3 colour(0);
    int count = 0;
    for (int z = first.z; z < end.z; ++z)
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x, ++count) {
                const Row& row = rows_[histograms_.numbers[linearIndex({x, y, z}, histograms_.extent)]];
                open += static_cast<double>(row.open);
                colour += glm::dvec3(row.colour);
            }
    return {static_cast<float>(open / count), glm::vec3(colour / static_cast<double>(count))};
}

void HistogramLight::fill(const ChunkKey& chunk, BrickCache&, OcclusionRoom& room,
                          std::uint16_t* texels) const {
    TESSERA_CHECK(chunk.level >= histograms_.level && !rows_.empty());
    const glm::ivec3 corner = glm::ivec3(chunk.i, chunk.j, chunk.k) * kChunkExtent,
                     extent = levelExtent(histograms_.extent, chunk.level - histograms_.level);
    for (const OcclusionRoom::Run& run : room.runs) {
        const glm::ivec3 first = corner + run.at;
        const int count = std::min(native::kOcclusionRun, extent.x - first.x);
        for (int n = 0; n < count; ++n) {
            const glm::ivec3 sample = first + glm::ivec3(n, 0, 0);
            std::uint16_t* const to = texels + run.to + static_cast<std::size_t>(n);
            if (chunk.level == histograms_.level) {
                const std::uint16_t number = histograms_.numbers[linearIndex(sample, extent)];
                for (std::size_t c = 0; c < static_cast<std::size_t>(channels()); ++c)
                    to[c * kChunkTexels] = texels_[c][number];
            } else {
                const Row row = at(sample, chunk.level);
                for (int c = 0; c < channels(); ++c)
                    to[static_cast<std::size_t>(c) * kChunkTexels] = texel(row, c);
            }
        }
    }
}

} // namespace tessera
