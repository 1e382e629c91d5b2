// Features of the GPU ray caster: their combinations and buffers, and how one is added. Their programs
// compile and leave out everything that is not requested, and idioms for llvmpipe change no bit.
#include "core/base/error.h"
#include "render/backends/gpu/composition.h"
#include "render/plan/visibility_rays.h"
#include "tests/support/dummy_feature.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/surface_fixture.h"

#include <array>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;
using testing::HasSubstr;

const std::vector<std::uint32_t>& allowedCombinations() {
    static const std::vector<std::uint32_t> allowed = [] {
        std::vector<std::uint32_t> out;
        // Bit by bit from the highest, so that what excludes one another is never gone into.
        const std::function<void(unsigned, std::uint32_t)> add = [&](unsigned left, std::uint32_t f) {
            if (left == 0) {
                if (featureConflict(f, featureModules()).empty())
                    out.push_back(f);
                return;
            }
            add(left - 1, f);
            const FeatureModule& m = featureModules()[left - 1];
            for (const FeatureModule& other : featureModules())
                if ((f & other.bit) && ((m.excludes & other.bit) || (other.excludes & m.bit)))
                    return;
            add(left - 1, f | m.bit);
        };
        add(features::kCount, 0);
        return out;
    }();
    return allowed;
}

/// Triples of features, each on or off.
constexpr unsigned kFeatures = features::kCount;
std::vector<std::size_t> triplesOf(std::uint32_t combination) {
    std::vector<std::size_t> out;
    const auto on = [&](unsigned feature) { return combination >> feature & 1u; };
    std::size_t triple = 0;
    for (unsigned a = 0; a < kFeatures; ++a)
        for (unsigned b = a + 1; b < kFeatures; ++b)
            for (unsigned c = b + 1; c < kFeatures; ++c)
                out.push_back(8 * triple++ + (on(a) | on(b) << 1 | on(c) << 2));
    return out;
}

/// Combinations that hold every triple that some allowed one holds.
std::vector<std::uint32_t> coveringCombinations() {
    const std::vector<std::uint32_t>& allowed = allowedCombinations();
    std::vector<bool> missing(8 * kFeatures * (kFeatures - 1) * (kFeatures - 2) / 6);
    std::size_t left = 0;
    for (const std::uint32_t f : allowed)
        for (const std::size_t t : triplesOf(f))
            if (!missing[t])
                missing[t] = true, ++left;
    const auto gain = [&](std::uint32_t f) {
        const std::vector<std::size_t> triples = triplesOf(f);
        return std::count_if(triples.begin(), triples.end(), [&](std::size_t t) { return missing[t]; });
    };
    std::mt19937 random(7);
    std::vector<std::uint32_t> rows;
    while (left > 0) {
        std::uint32_t best = 0;
        std::ptrdiff_t most = 0;
        for (int candidate = 0; candidate < 300 || most == 0; ++candidate) {
            const std::uint32_t f = allowed[random() % allowed.size()];
            if (const std::ptrdiff_t g = gain(f); g > most)
                most = g, best = f;
        }
        for (const std::size_t t : triplesOf(best))
            if (missing[t])
                missing[t] = false, --left;
        rows.push_back(best);
    }
    return rows;
}

// docs/design.md says these numbers.
TEST(Features, ProgramsOfAllTriplesCompileAndOmitWhatTheyDoNotNeed) {
    const GlContext context({"software"});
    const std::vector<std::uint32_t> rows = coveringCombinations();
    EXPECT_EQ(allowedCombinations().size(), 2120192u);
    EXPECT_EQ(rows.size(), 107u);
    for (const std::uint32_t f : rows) {
        const GlProgram program = marchComposition(f).program("march.comp");
        const auto ofVolume = [&](const std::string& name) {
            return program.hasUniform(((f & kFeatureFused) ? name + "Of[0]" : name).c_str());
        };
        EXPECT_EQ(program.hasUniform("uPhong"), (f & kFeatureShading) != 0) << f;
        EXPECT_EQ(ofVolume("uGradientPoints"), (f & kFeatureGradientOpacity) != 0) << f;
        EXPECT_EQ(ofVolume("uLights"), (f & kFeatureLights) != 0) << f;
        EXPECT_EQ(ofVolume("uMaterials"), (f & kFeatureMaterials) != 0) << f;
        EXPECT_EQ(ofVolume("uMaterialEmission"), (f & kFeatureEmission) != 0 && (f & kFeatureMaterials) != 0)
            << f;
        EXPECT_EQ(ofVolume("uSkipping"), (f & kFeatureSkipping) != 0 && !(f & kFeatureValues)) << f;
        EXPECT_EQ(program.hasUniform("uIsovalues"), (f & kFeatureSurfaces) != 0) << f;
        EXPECT_EQ(ofVolume("uCorners"), (f & kFeatureMixed) != 0) << f;
        EXPECT_EQ(program.hasUniform("uFusion"), (f & kFeatureFused) != 0) << f;
        EXPECT_EQ(program.hasUniform("uCutEnds[0]"), (f & kFeatureOwnCuts) != 0) << f;
        EXPECT_EQ(program.hasUniform("uReduction"), (f & kFeatureValues) != 0) << f;
        EXPECT_EQ(program.hasUniform("uSlabs"), (f & kFeatureSlabs) != 0) << f;
        EXPECT_EQ(program.hasUniform("uTermination"), (f & kFeatureTermination) != 0) << f;
        EXPECT_EQ(ofVolume("uStoredBias"), (f & kFeatureNormalised) != 0) << f;
    }
    EXPECT_TRUE(context.errors().empty());
}

TEST(Features, NoCombinationNeedsMoreBuffersThanEveryDeviceHas) {
    std::size_t most = 0;
    for (const std::uint32_t f : allowedCombinations()) {
        const std::vector<StorageBuffer> buffers = marchComposition(f).buffers();
        most = std::max(most, buffers.size());
        for (std::size_t a = 0; a < buffers.size(); ++a)
            for (std::size_t b = a + 1; b < buffers.size(); ++b)
                ASSERT_STRNE(buffers[a].name, buffers[b].name);
    }
    EXPECT_LE(most, kStorageBuffersEverywhere);
    EXPECT_GT(most, 5u);
}

std::string refusal(std::uint32_t features, const std::vector<FeatureModule>& modules = featureModules()) {
    try {
        Composition({}, features, modules);
    } catch (const Error& e) {
        return e.what();
    }
    return {};
}

TEST(Features, WhatDoesNotGoTogetherIsRefused) {
    EXPECT_THAT(refusal(kFeatureHits),
                testing::AllOf(HasSubstr("FEATURE_HITS"), HasSubstr("needs FEATURE_SURFACES")));
    EXPECT_THAT(refusal(kFeatureSurfaces | kFeatureVisibility), HasSubstr("does not go with"));
    EXPECT_THAT(refusal(kFeatureVisibility | kFeatureLinear), HasSubstr("does not go with FEATURE_LINEAR"));
    EXPECT_THAT(refusal(kFeatureLights), HasSubstr("needs FEATURE_SHADING"));
    EXPECT_THAT(refusal(kFeatureLights | kFeatureShading | kFeatureMaterials), "");
    EXPECT_THAT(refusal(kFeatureLinear | kFeaturePreintegrated), HasSubstr("does not go with"));
    EXPECT_THAT(refusal(kFeaturePreintegration2d), HasSubstr("needs FEATURE_PREINTEGRATED"));
    EXPECT_THAT(refusal(kFeatureSobelGradient | kFeatureForwardGradient), HasSubstr("does not go with"));
    EXPECT_EQ(refusal(kFeatureHits | kFeatureSurfaces | kFeaturePreintegrated | kFeaturePreintegration2d),
              "");
}

TEST(Features, AMarchTakesTheBytesThatItsModulesSay) {
    const GlContext context({"software"});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Scene scene = sceneOn(info, "bone-1", 0, {31, 17});
    const glm::ivec3 bricks = brickGrid(info.extentVoxels);
    for (const bool surfaces : {false, true}) {
        if (surfaces)
            scene.surfaces = {{250, {1, 1, 1}, 1}};
        Prepared prepared("torso", scene);
        Planner& p = prepared.p;
        const std::uint32_t base = surfaces ? kFeatureSurfaces : 0u;
        std::map<std::uint32_t, std::size_t> more = {{0u, 0}, {kFeaturePasses, wantedBytes(bricks)}};
        if (surfaces)
            more[kFeatureHits] = sizeof(SurfaceHit) * rayCount(p.view.imageSize);
        else
            more[kFeatureVisibility] = countingBytes(p.view.imageSize, bricks);
        for (const auto& [feature, bytes] : more) {
            MemoryBudget& gpu = prepared.budgets.gpu;
            const std::size_t before = gpu.usedBytes();
            const March march(base | feature, p.view.frame, p.info(), p.strides(), p.layer().optics, nullptr,
                              gpu);
            const std::size_t stated = marchComposition(base | feature).bytes(p.view.imageSize, bricks);
            EXPECT_EQ(stated, rayStateBytes(p.view.imageSize) + bytes) << feature;
            EXPECT_EQ(gpu.usedBytes() - before, stated + p.layer().optics.gpuBytes()) << feature;
        }
    }
}

// One file (dummy_feature.h) and a line among the modules.
TEST(Features, ADummyIsAFileAndALine) {
    const GlContext context({"software"});
    MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{1} << 20);
    const EmbeddedFiles files = {{"marks.comp", R"(
layout(local_size_x = 1) in;
layout(std430, binding = BINDING_OTHERS) buffer Others { uint uOthers[]; };
#if FEATURE_DUMMY
layout(std430, binding = BINDING_MARKS) buffer Marks { uint uMarks[]; };
#endif
void main() {
    uOthers[gl_WorkGroupID.x] = 1u;
#if FEATURE_DUMMY
    uMarks[gl_WorkGroupID.x] += 35u;
#endif
}
)"}};
    const glm::ivec2 image(5, 3);
    const std::vector<FeatureModule> modules = modulesWithDummy();
    const auto perPixel = [](const glm::ivec2& size, const glm::ivec3&) { return 4 * rayCount(size); };
    const std::vector<StorageBuffer> own = {{"OTHERS", "others", perPixel}};
    const std::uint32_t on = kFeatureCounting | kFeatureDummy;
    for (const std::uint32_t features : {std::uint32_t{kFeatureCounting}, on}) {
        const Composition composition(own, features, modules);
        const bool has = features == on;
        EXPECT_EQ(composition.buffers().size(), has ? 2u : 1u);
        EXPECT_EQ(composition.bytes(image, glm::ivec3(1)), (has ? 2u : 1u) * 4u * 15u);
        StorageBuffers buffers;
        buffers.fit(composition, image, glm::ivec3(1), gpu);
        EXPECT_EQ(gpu.usedBytes(), composition.bytes(image, glm::ivec3(1)));
        const GlProgram program = composition.program("marks.comp", files);
        buffers.begin();
        buffers.bind();
        program.use();
        glDispatchCompute(15, 1, 1);
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        const auto all = [&](const char* name, std::uint32_t value) {
            std::array<std::uint32_t, 15> words{};
            buffers[name].read(0, std::as_writable_bytes(std::span(words)));
            EXPECT_THAT(words, testing::Each(value)) << name;
        };
        all("OTHERS", 1);
        if (has) {
            EXPECT_NE(composition.binding("MARKS"), composition.binding("OTHERS"));
            all("MARKS", 7 + 35); // 7: as it is when rays begin
        }
    }
    EXPECT_THAT(refusal(kFeatureDummy, modules),
                HasSubstr("FEATURE_DUMMY (marks of pixels) needs FEATURE_COUNTING"));
    EXPECT_THAT(refusal(on | kFeaturePasses, modules),
                HasSubstr("FEATURE_DUMMY (marks of pixels) does not go with"));
}

/// Small dispatches, so that uncounted loops stay below llvmpipe's limit.
Slicing smallDispatches() {
    Slicing slicing;
    slicing.fixedTile = 16;
    slicing.fixedIterations = 24;
    return slicing;
}

/// Bricks come as rays ask for them, all that are asked for at a time.
Image inPasses(Prepared& prepared, std::uint32_t features) {
    Planner& p = prepared.p;
    Work work;
    GpuEngine engine(prepared.budgets.gpu, prepared.budgets.ram);
    engine.open(p, pagesFor(p.layer().selection.counts));
    GpuCaster caster(p, engine, features | kFeaturePasses, prepared.budgets.gpu);
    int passes = 0;
    while (caster.draw(smallDispatches(), RayCaster::Clock::time_point::max(), work) &&
           caster.waiting() > 0) {
        const std::vector<std::uint32_t> wanted = caster.takeWanted();
        std::vector<std::size_t> bricks;
        for (std::size_t b = 0; b < wanted.size(); ++b)
            if (wanted[b] != UINT32_MAX)
                bricks.push_back(b);
        engine.bricks()->serve(bricks, *p.layer().cache, work);
        ++passes;
    }
    EXPECT_GT(passes, 2);
    return caster.image();
}

TEST(Features, IdiomsForLlvmpipeChangeNoBit) {
    const GlContext context({"software"});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Scene scene = sceneOn(info, "soft-tissue", 0, {20, 16});
    Prepared uniform("torso", scene), mixed("torso", scene);
    Prepared surfaces("torso", torsoScene(0, true, Integrator::midpoint, {20, 16}));
    std::mt19937 random(3);
    Selection levels = mixed.p.layer().selection;
    levels.counts = {};
    for (std::uint8_t& level : levels.levels) {
        if (level != Selection::kEmpty)
            level = static_cast<std::uint8_t>(random() % 3);
        ++levels.counts[level];
    }
    mixed.p.setSelection(levels);
    const std::uint32_t lit = kFeatureSkipping | kFeatureShading;
    struct Pictures {
        std::vector<Image> images;
        std::vector<SurfaceHit> hits;
    };
    const auto all = [&] {
        Pictures out;
        const std::pair<Prepared*, Gradient> lightings[] = {{&uniform, Gradient::central},
                                                            {&uniform, Gradient::sobel},
                                                            {&mixed, Gradient::central},
                                                            {&mixed, Gradient::analytic},
                                                            {&mixed, Gradient::cubic}};
        for (const auto& [prepared, kind] : lightings)
            out.images.push_back(marchOn(*prepared, lit | gradientFeature(kind), smallDispatches()).image);
        const std::uint32_t texels =
            texelFormat(info.type).normalised ? std::uint32_t{kFeatureNormalised} : 0u;
        out.images.push_back(inPasses(mixed, lit | texels | kFeatureMixed));
        Drawn drawn = draw(surfaces, 0, smallDispatches());
        out.images.push_back(std::move(drawn.image));
        out.hits = std::move(drawn.hits);
        return out;
    };
    std::array<Pictures, 2> drawn;
    for (const bool llvmpipe : {false, true}) {
        const ComposeAsFor composed(llvmpipe);
        EXPECT_EQ(marchComposition(0).defines().find("#define DRIVER_LLVMPIPE 1") != std::string::npos,
                  llvmpipe);
        drawn[llvmpipe] = all();
    }
    for (std::size_t i = 0; i < drawn[0].images.size(); ++i) {
        EXPECT_FALSE(isBlank(drawn[0].images[i])) << i;
        EXPECT_TRUE(bitEqual(drawn[0].images[i], drawn[1].images[i])) << i;
    }
    EXPECT_GT(hitCount(drawn[0].hits), 50u);
    EXPECT_EQ(drawn[0].hits, drawn[1].hits);
}

} // namespace
} // namespace tessera
