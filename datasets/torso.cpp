// datasets/torso.cpp: the CT-like torso: its parts in painting order, quantum noise, and storage as int16 HU.
// The body's outline, its layers of skin, fat and muscle, and the muscles of the back.
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

namespace {

constexpr float kSkinMm = 2;

const std::vector<Section> kSkin = {
    {-216, 169, 97, 112, 0}, {-170, 164, 102, 107, 0}, {-130, 154, 104, 99, 0}, {-90, 146, 104, 94, 0},
    {-50, 146, 104, 95, 0},  {0, 150, 104, 99, 0},     {50, 154, 105, 103, 0},  {100, 157, 102, 105, 0},
    {150, 161, 94, 105, 0},  {185, 154, 82, 100, 0},   {216, 122, 70, 92, 0}};
const std::vector<Section> kMuscle = {{-216, 144, 72, 90, 0}, {-170, 141, 79, 88, 0}, {-130, 134, 86, 83, 0},
                                      {-90, 130, 88, 82, 0},  {-50, 132, 90, 84, 0},  {0, 138, 94, 90, 0},
                                      {50, 143, 96, 94, 0},   {100, 147, 92, 97, 0},  {150, 151, 84, 97, 0},
                                      {185, 144, 73, 92, 0},  {216, 112, 61, 85, 0}};
const std::vector<Section> kInnerWall = {
    {-216, 96, 58, 52, 0}, {-170, 116, 68, 60, 0}, {-130, 122, 75, 62, 0}, {-80, 120, 77, 65, 0},
    {-40, 126, 82, 71, 0}, {0, 129, 84, 75, 0},    {50, 127, 83, 76, 0},   {100, 119, 77, 73, 2},
    {140, 104, 68, 66, 4}, {170, 83, 56, 54, 8},   {190, 58, 38, 40, 12},  {204, 34, 24, 26, 15},
    {216, 26, 20, 20, 16}};

} // namespace

std::shared_ptr<const Loft> torsoInnerWall() {
    return std::make_shared<Loft>(kInnerWall);
}

void addBodyWall(TorsoBuilder& torso) {
    torso.skin = std::make_shared<Loft>(kSkin);
    torso.muscle = std::make_shared<Loft>(kMuscle);
    torso.innerWall = torsoInnerWall();

    Tissue& skin = torso.add({{0, 30}, {-kSkinMm, -105}});
    skin.shapes.push_back(std::make_unique<Loft>(kSkin));
    Tissue& marks = torso.add({{0, 40}}, 8); // nipples
    for (const float side : {-1.0F, 1.0F})
        marks.shapes.push_back(std::make_unique<Ellipsoid>(
            mirrored(torso.skin->wallPoint(136, 92, -1.5F), side), glm::vec3(4.5F, 4.5F, 4.5F)));
    Tissue& navel = torso.add({{2.5F, 30}, {0, -1000}});
    navel.shapes.push_back(
        std::make_unique<Ellipsoid>(torso.skin->wallPoint(180, -92, 1), glm::vec3(5, 8, 7)));
    navel.clip = torso.skin;
    Tissue& muscle = torso.add({{0, 55}, {-6.2F, -40}, {-7.3F, 57}}); // in two layers
    muscle.shapes.push_back(std::make_unique<Loft>(kMuscle));
    // fat planes between the layers of muscle of the back and the flank
    Tissue& planes = torso.add({{0, -60}});
    planes.clip = torso.muscle;
    planes.clipOffsetMm = -3;
    for (const float side : {-1.0F, 1.0F}) {
        addTube(planes.shapes,
                {{{side * 52, 72, -210}, 2},
                 {{side * 55, 74, -60}, 1.6F},
                 {{side * 58, 84, 60}, 1.3F},
                 {{side * 60, 88, 190}, 1.5F}},
                torso.voxelMm, 10);
        addTube(planes.shapes, {{{side * 4, -88, -190}, 1.6F}, {{side * 4, -93, -20}, 1.2F}}, torso.voxelMm,
                10);
    }
    Tissue& inside = torso.add({{0, -98}});
    inside.shapes.push_back(std::make_unique<Loft>(kInnerWall));

    // erector spinae, psoas, iliacus and gluteal fat, left and right alike
    Tissue& muscles = torso.add({{0, 58}}, 6);
    for (const float side : {-1.0F, 1.0F}) {
        addTube(muscles.shapes,
                {{{side * 22, 70, -175}, 12},
                 {{side * 27, 62, -110}, 17},
                 {{side * 27, 62, -50}, 18},
                 {{side * 24, 72, 40}, 15},
                 {{side * 20, 74, 130}, 13},
                 {{side * 18, 62, 205}, 12}},
                torso.voxelMm, 12);
        addTube(muscles.shapes,
                {{{side * 26, 30, 0}, 6},
                 {{side * 34, 26, -50}, 13},
                 {{side * 42, 18, -110}, 16},
                 {{side * 58, -4, -160}, 15},
                 {{side * 78, -28, -215}, 15}},
                torso.voxelMm, 12);
        addTube(muscles.shapes,
                {{{side * 52, 56, -15}, 6}, {{side * 58, 56, -60}, 12}, {{side * 62, 54, -112}, 12}},
                torso.voxelMm, 12);
        addTube(muscles.shapes,
                {{{side * 92, 14, -125}, 8}, {{side * 88, 12, -160}, 12}, {{side * 84, -8, -205}, 12}},
                torso.voxelMm, 12);
    }
}

} // namespace tessera
