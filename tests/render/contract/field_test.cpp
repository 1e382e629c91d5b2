// The field itself: the shader's sampler against its C++ counterpart at single points, and exact values of
// every type. Also continuity at brick faces, edges and corners, empty bricks, and the volume's border.
#include "render/backends/gpu/probe.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

/// Positions that matter: random ones, and ones on and beside brick faces, edges, corners and the border.
std::vector<glm::vec3> tellingPositions(const glm::ivec3& extent, int level) {
    std::mt19937 random(11);
    std::vector<glm::vec3> out;
    const auto along = [&](int axis) {
        std::uniform_real_distribution<float> anywhere(-1, static_cast<float>(extent[axis]) + 1);
        std::uniform_int_distribution<int> kind(0, 4), brick(0, extent[axis] / 32),
            sample(0, extent[axis] >> level);
        const float edge = static_cast<float>(32 * brick(random));
        switch (kind(random)) {
        case 0:
            return edge;
        case 1:
            return std::nextafter(edge, -1e9f);
        case 2:
            return edge + 0.5f * static_cast<float>(1 << level); // the first sample of a brick
        case 3:
            return (static_cast<float>(sample(random)) + 0.5f) * static_cast<float>(1 << level);
        default:
            return anywhere(random);
        }
    };
    for (int i = 0; i < 4000; ++i)
        out.emplace_back(along(0), along(1), along(2));
    return out;
}

struct FieldCase {
    const char* store;
    const char* preset;
    std::size_t gpuBytes; // 0: roomy, level 0
    bool culling;
};
class Field : public testing::TestWithParam<FieldCase> {};
INSTANTIATE_TEST_SUITE_P(Volumes, Field,
                         testing::Values(FieldCase{"torso", "bone-1", 0, true},
                                         FieldCase{"torso", "bone-1", 3 << 20, true},
                                         FieldCase{"sphere", "auto", 0, false},
                                         FieldCase{"checkerboard", "auto", 0, false},
                                         FieldCase{"marschner-lobb", "auto", 0, false},
                                         FieldCase{"torso", "skin-1", 2 << 20, false}));

TEST_P(Field, ShaderEqualsItsTwin) {
    const GlContext context({"software"});
    const FieldCase c = GetParam();
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath(c.store), ram).info();
    Prepared prepared(c.store, sceneOn(info, c.preset, 0, {16, 16}), c.culling, c.gpuBytes);
    Planner& p = prepared.p;
    if (c.gpuBytes > 0) {
        EXPECT_GT(p.layer().selection.finest(), 0);
    }
    if (c.culling) {
        EXPECT_LT(p.layer().selection.shownBricks(), p.layer().selection.levels.size())
            << "nothing was culled";
    }
    const auto positions = tellingPositions(info.extentVoxels, p.layer().selection.finest());
    Work work;
    Atlas atlas(info, p.layer().selection, pagesFor(p.layer().selection.counts), TextureLimits{},
                prepared.budgets.gpu, prepared.budgets.ram);
    atlas.bricks.load(*p.layer().cache, work);
    const FieldSource source{&atlas, p.layer().selection.finest()};
    std::uint32_t features = 0;
    if (texelFormat(info.type).normalised)
        features |= kFeatureNormalised;
    const auto exact = probeField(positions, features, info, source, prepared.budgets.gpu);
    const auto filtered =
        probeField(positions, features | kFeatureHardware, info, source, prepared.budgets.gpu);
    LatticeReader samples(*p.layer().cache, info, p.layer().selection.finest(), &p.layer().selection);
    const float perVoxel = 1.0f / static_cast<float>(1 << p.layer().selection.finest());
    const float range = p.layer().statistics.highest - p.layer().statistics.lowest;
    float worst = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const float value = fieldValue(samples, positions[i], perVoxel);
        const glm::vec3 gradient = fieldGradient(samples, positions[i], perVoxel);
        ASSERT_EQ(exact[i].w, value) << i; // the same operations in the same order
        ASSERT_EQ(glm::vec3(exact[i]), gradient) << i;
        worst = std::max(worst, std::abs(filtered[i].w - value));
    }
    for (const Gradient kind :
         {Gradient::forward, Gradient::sobel, Gradient::analytic, Gradient::centralHalf, Gradient::cubic}) {
        const auto probed =
            probeField(positions, features | gradientFeature(kind), info, source, prepared.budgets.gpu);
        for (std::size_t i = 0; i < positions.size(); ++i)
            ASSERT_EQ(glm::vec3(probed[i]), fieldGradient(samples, positions[i], perVoxel, kind))
                << gradientNames()[static_cast<std::size_t>(kind)] << " " << i;
    }
    // llvmpipe filters in float; what remains is the slot's shift of coordinates, up to 6e-5 texel.
    EXPECT_LE(worst, 4e-4f * range);
}

// Row: at brick faces, edges, corners the formulas of both sides agree to 1e-6 of the range.
TEST_P(Field, IsContinuousAcrossBricks) {
    const FieldCase c = GetParam();
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath(c.store), ram).info();
    Prepared prepared(c.store, sceneOn(info, c.preset, 0, {16, 16}), c.culling, c.gpuBytes);
    Planner& p = prepared.p;
    LatticeReader samples(*p.layer().cache, info, p.layer().selection.finest(), &p.layer().selection);
    const double perVoxel = 1.0 / (1 << p.layer().selection.finest());
    const double range =
        static_cast<double>(p.layer().statistics.highest) - static_cast<double>(p.layer().statistics.lowest);
    std::mt19937 random(13);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 4000; ++i) {
        // On a face (1 axis at a brick boundary), edge (2) or corner (3), approached from every side.
        glm::dvec3 at = glm::dvec3(info.extentVoxels) * glm::dvec3(unit(random), unit(random), unit(random));
        const int axes = 1 + i % 3;
        for (int a = 0; a < axes; ++a) {
            const int axis = (i + a) % 3;
            at[axis] = 32.0 * std::round(at[axis] / 32);
        }
        const double here = fieldValue(samples, at, perVoxel);
        for (int side = 0; side < 8; ++side) {
            const glm::dvec3 offset =
                1e-9 * glm::dvec3((side & 1) * 2 - 1, (side & 2) - 1, (side & 4) / 2 - 1);
            ASSERT_NEAR(fieldValue(samples, at + offset, perVoxel), here, 1e-6 * range);
        }
    }
}

// 16-bit values reach the shader exactly, all 65536 of them, signed and unsigned; floats as floats.
TEST(Texels, EveryValueSurvives) {
    const GlContext context({"software"});
    MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    for (const ValueType type : {ValueType::i16, ValueType::u16, ValueType::f32, ValueType::u8}) {
        const std::size_t bytes = bytesPerValue(type);
        VolumeInfo info;
        info.type = type;
        info.extentVoxels = {64, 32, 32}; // 65536 voxels
        std::vector<std::byte> stored(65536 * bytes);
        for (std::size_t i = 0; i < 65536; ++i) {
            const auto low = static_cast<std::uint16_t>(i);
            const float real = static_cast<float>(i) * 1.1e-3f - 7;
            const auto byte = static_cast<std::uint8_t>(i);
            const void* from = type == ValueType::f32  ? static_cast<const void*>(&real)
                               : type == ValueType::u8 ? static_cast<const void*>(&byte)
                                                       : &low;
            std::memcpy(stored.data() + i * bytes, from, bytes);
        }
        Selection selection;
        selection.bricks = brickGrid(info.extentVoxels);
        selection.levels = {0, 0};
        selection.means = {0, 0};
        selection.counts[0] = 2;
        Atlas atlas(info, selection, 2, TextureLimits{}, gpu, ram);
        std::vector<BrickEntry> entries;
        Work work;
        for (int brick = 0; brick < 2; ++brick) { // 32768 values each, in the order of their numbers
            Chunk chunk{std::make_unique<std::byte[]>(32768 * bytes), 32768 * bytes};
            std::memcpy(chunk.bytes.get(), stored.data() + chunk.size * static_cast<std::size_t>(brick),
                        chunk.size);
            AtlasSlot slot;
            slot.page = gridPosition(static_cast<std::size_t>(brick), atlas.values.extentTexels() / 32);
            atlas.values.put(slot, {chunk, glm::ivec3(0), kBrickExtent}, work);
            entries.emplace_back(slot.page.x | slot.page.y << 10 | slot.page.z << 20, 0);
        }
        atlas.values.publish(entries);
        std::vector<glm::vec3> centres;
        for (int i = 0; i < 65536; ++i)
            centres.push_back(glm::vec3(glm::ivec3(i % 32 + i / 32768 * 32, i / 32 % 32, i / 1024 % 32)) +
                              0.5f);
        const auto read =
            probeField(centres, texelFormat(type).normalised ? kFeatureNormalised : 0u, info, {&atlas}, gpu);
        for (std::size_t i = 0; i < 65536; ++i) {
            float expected = 0;
            switch (type) {
            case ValueType::i16:
                expected = static_cast<float>(static_cast<std::int16_t>(i));
                break;
            case ValueType::u16:
                expected = static_cast<float>(i);
                break;
            case ValueType::u8:
                expected = static_cast<float>(i % 256);
                break;
            case ValueType::f32:
                expected = static_cast<float>(i) * 1.1e-3f - 7;
                break;
            }
            ASSERT_EQ(read[i].w, expected) << name(type) << " " << i;
        }
    }
}

} // namespace
} // namespace tessera
