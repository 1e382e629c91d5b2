// datasets/torso.cpp: the CT-like torso: its parts in painting order, quantum noise, and storage as int16 HU.
#include "core/base/error.h"
#include "datasets/phantom.h"
#include "datasets/slice_generator.h"
#include "datasets/torso_parts.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace tessera {
namespace {

const glm::dvec3 kBodyMm(360, 260, 420);
constexpr float kAirHu = -1000, kNoiseHu = 12, kLowestHu = -1024, kHighestHu = 3071; // 12-bit scanner range
// Surfaces are as sharp as the voxels, but no sharper than a scanner, and still surfaces in a tiny volume.
constexpr float kSharpestMm = 0.5F, kBluntestMm = 6;

/// A scanner's point spread is wider than a voxel; edges of one voxel would show as terraces on lit surfaces.
constexpr float kPointSpreadVoxels = 1.75F;

float blendMm(const glm::dvec3& spacing) {
    return std::clamp(static_cast<float>(std::cbrt(spacing.x * spacing.y * spacing.z)), kSharpestMm,
                      kBluntestMm);
}

std::deque<Tissue> buildTorso(float voxelMm, bool colonCollapsed) {
    TorsoBuilder torso{voxelMm, {}, nullptr, nullptr, nullptr, colonCollapsed};
    addBodyWall(torso);
    addLungs(torso);
    addAbdomen(torso);
    addLungTrees(torso);
    addHeart(torso);
    addVessels(torso);
    addRibsAndGirdles(torso);
    addSpine(torso);
    addColon(torso);
    return std::move(torso.tissues);
}

/// About normal, standard deviation 1: the sum of four uniform 16-bit numbers hashed from the voxel's place.
float noise(std::uint64_t voxel) {
    std::uint64_t h = voxel * 0x9E3779B97F4A7C15ULL + 0x632BE59BD9B4E019ULL;
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ULL;
    h = (h ^ (h >> 27)) * 0x94D049BB133111EBULL;
    h ^= h >> 31;
    const auto sum = static_cast<int>((h & 0xFFFF) + ((h >> 16) & 0xFFFF) + ((h >> 32) & 0xFFFF) + (h >> 48));
    return static_cast<float>(sum - 131070) * (1 / 37837.2F); // 4 * 65535 / 2 and 2 * 65536 / sqrt(12)
}

TissuePainter torsoPainter(const VolumeInfo& info, bool colonCollapsed) {
    const float blend = blendMm(info.spacingMm());
    return {buildTorso(blend, colonCollapsed), kAirHu, kPointSpreadVoxels * blend};
}

class TorsoSlices final : public SliceGenerator {
  public:
    TorsoSlices(const glm::ivec3& extentVoxels, bool colonCollapsed)
        : info_(centredVolume("torso", extentVoxels, kBodyMm, ValueType::i16)),
          painter_(torsoPainter(info_, colonCollapsed)) {
        info_.unit = "HU";
        info_.fillStored = static_cast<double>(kLowestHu);
        info_.acquisition.modality = "CT";
    }

    const VolumeInfo& info() const override { return info_; }

    void slice(int z, std::span<std::byte> out) const override {
        const glm::ivec3 n = info_.extentVoxels;
        const glm::vec3 spacing(info_.spacingMm());
        const glm::vec3 first(info_.patientFromVoxel * glm::dvec4(0.5, 0.5, z + 0.5, 1));
        std::vector<float> values(static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y));
        painter_.slice(first, spacing.x, spacing.y, n.x, n.y, values);
        const std::uint64_t firstVoxel = static_cast<std::uint64_t>(z) * values.size();
        for (std::size_t i = 0; i < values.size(); ++i) {
            const float noisy = values[i] + kNoiseHu * noise(firstVoxel + i);
            const auto stored =
                static_cast<std::int16_t>(std::floor(std::clamp(noisy, kLowestHu, kHighestHu) + 0.5F));
            std::memcpy(out.data() + 2 * i, &stored, 2);
        }
    }

  private:
    VolumeInfo info_;
    TissuePainter painter_;
};

} // namespace

std::function<double(const glm::dvec3&)> torsoFormulaHu(const glm::ivec3& extentVoxels) {
    const VolumeInfo info = centredVolume("torso", extentVoxels, kBodyMm, ValueType::i16);
    return [painter = std::make_shared<const TissuePainter>(torsoPainter(info, false))](const glm::dvec3& p) {
        return static_cast<double>(painter->valueAt(glm::vec3(p)));
    };
}

std::unique_ptr<SliceGenerator> makeTorso(const glm::ivec3& extentVoxels, bool colonCollapsed) {
    return std::make_unique<TorsoSlices>(extentVoxels, colonCollapsed);
}

} // namespace tessera
