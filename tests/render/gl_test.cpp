// GL without a picture: shader composition and its line numbers, every legal feature combination compiles and
// leaves out what it does not need, page allocation.
#include "core/error.h"
#include "render/engines/gpu/features.h"
#include "render/engines/gpu/gl/context.h"
#include "render/engines/gpu/gl/program.h"
#include "render/residency/page_allocator.h"

#include <bit>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using testing::HasSubstr;

TEST(ShaderComposition, IncludesOnceAndMapsLogLinesToFiles) {
    const EmbeddedFiles files = {
        {"main.comp",
         "layout(local_size_x=1) in;\n#include \"a.glsl\"\n#include \"b.glsl\"\nvoid main() {}\n"},
        {"a.glsl", "// a\nconst int kA = 1;\n"},
        {"b.glsl", "#include \"a.glsl\"\nconst int kB = kA;\n"}};
    const ComposedShader shader = composeShader(files, "main.comp", "#define X 1\n");
    EXPECT_THAT(shader.files, testing::ElementsAre("main.comp", "a.glsl", "b.glsl"));
    const std::string text = shader.text;
    EXPECT_EQ(text.find("kA = 1"), text.rfind("kA = 1"));
    EXPECT_THAT(mapShaderLog("1:2(5): error: x\n2(7) : error C1: y\nother\n", shader.files),
                "a.glsl:2: error: x\nb.glsl:7 : error C1: y\nother\n");
    EXPECT_THROW(composeShader(files, "none.comp", ""), Error);
}

TEST(Program, EveryFeatureCombinationCompilesAndOmitsWhatItDoesNotNeed) {
    const GlContext context({"software"});
    for (std::uint32_t f = 0; f <= kAllFeatures; ++f) {
        // What replaces one formula by another meets a part of the other combinations: one in 128.
        const std::uint32_t integrator = f & kIntegratorFeatures, gradient = f & kGradientFeatures;
        if (integrator != 0 && (f & kFeatureVisibility) != 0)
            continue;
        if (std::popcount(gradient) > 1 || (integrator & (kFeatureLinear | kFeaturePreintegrated)) ==
                                               (kFeatureLinear | kFeaturePreintegrated))
            continue;
        const std::uint32_t surfaces = f & (kFeatureSurfaces | kFeatureHits);
        if (surfaces == kFeatureHits || (surfaces != 0 && (f & kFeatureVisibility) != 0))
            continue;
        if ((integrator | gradient | surfaces) != 0 && (f * 2654435761u) >> 25 != 0)
            continue;
        const GlProgram program("march.comp", featureDefines(f));
        ASSERT_EQ(program.hasUniform("uPhong"), (f & kFeatureShading) != 0) << f;
        ASSERT_EQ(program.hasUniform("uSkipping"), (f & kFeatureSkipping) != 0) << f;
        ASSERT_EQ(program.hasUniform("uIsovalues"), (f & kFeatureSurfaces) != 0) << f;
        ASSERT_EQ(program.hasUniform("uCorners"), (f & kFeatureMixed) != 0) << f;
        ASSERT_EQ(program.hasUniform("uTermination"), (f & kFeatureTermination) != 0) << f;
        ASSERT_EQ(program.hasUniform("uStoredBias"), (f & kFeatureNormalised) != 0) << f;
    }
    EXPECT_TRUE(context.errors().empty());
}

TEST(Program, FailureNamesFileLineAndDefines) {
    const GlContext context({"software"});
    try {
        const GlProgram program("march.comp", "#define FEATURE_SHADING 1\n#define FEATURE_MIXED broken\n");
        FAIL() << "compiled without its features";
    } catch (const Error& e) {
        EXPECT_THAT(e.what(), testing::AllOf(HasSubstr("march.comp"), HasSubstr("FEATURE_MIXED broken")));
    }
}

TEST(Context, RefusesUnknownDevices) {
    EXPECT_THROW(GlContext({"99"}), InputError);
    EXPECT_THROW(GlContext({"fast"}), InputError);
}

TEST(PageAllocator, SlotsAreDisjointAndReturn) {
    std::mt19937 random(5);
    PageAllocator allocator({3, 2, 2});
    std::vector<AtlasSlot> held;
    std::uniform_int_distribution<int> level(0, 5), coin(0, 2);
    const auto covers = [](const AtlasSlot& a, const AtlasSlot& b) {
        const glm::ivec3 lo = glm::max(a.originTexels(), b.originTexels());
        const glm::ivec3 hi =
            glm::min(a.originTexels() + (32 >> a.level), b.originTexels() + (32 >> b.level));
        return lo.x < hi.x && lo.y < hi.y && lo.z < hi.z;
    };
    for (int turn = 0; turn < 3000; ++turn) {
        if (coin(random) == 0 && !held.empty()) {
            allocator.release(held.back());
            held.pop_back();
        } else if (const auto slot = allocator.allocate(level(random))) {
            for (const AtlasSlot& other : held)
                ASSERT_FALSE(covers(*slot, other)) << turn;
            if (held.size() < 200)
                held.push_back(*slot);
            else
                allocator.release(*slot);
        }
    }
    for (const AtlasSlot& slot : held)
        allocator.release(slot);
    EXPECT_EQ(allocator.freePages(), 12u);
}

} // namespace
} // namespace tessera
