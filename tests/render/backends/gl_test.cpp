// GL without a picture: shader composition and its line numbers, page allocation.
#include "core/base/error.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/gl/program.h"
#include "render/residency/pages.h"

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

TEST(ShaderComposition, EveryFeatureIsDefinedAsZeroOrOne) {
    const EmbeddedFiles files = {{"main.comp", "#if FEATURE_FOG && !FEATURE_MIST\n#endif\n"}};
    EXPECT_NO_THROW(composeShader(files, "main.comp", "#define FEATURE_FOG 1\n#define FEATURE_MIST 0\n"));
    const auto refusal = [&](const std::string& defines) -> std::string {
        try {
            composeShader(files, "main.comp", defines);
        } catch (const Error& e) {
            return e.what();
        }
        return {};
    };
    EXPECT_THAT(refusal("#define FEATURE_FOG 1\n"),
                testing::AllOf(HasSubstr("main.comp"), HasSubstr("FEATURE_MIST"), HasSubstr("nobody")));
    EXPECT_THAT(refusal("#define FEATURE_FOG 1\n#define FEATURE_MIST broken\n"), HasSubstr("broken"));
}

TEST(Program, FailureNamesFileLineAndDefines) {
    const GlContext context({"software"});
    const EmbeddedFiles files = {{"main.comp", "#include \"a.glsl\"\nvoid main() {}\n"},
                                 {"a.glsl", "\n\nint broken = ;\n"}};
    try {
        const GlProgram program("main.comp", "#define X 1\n", files);
        FAIL() << "compiled";
    } catch (const Error& e) {
        EXPECT_THAT(e.what(),
                    testing::AllOf(HasSubstr("main.comp"), HasSubstr("a.glsl:3"), HasSubstr("#define X 1")));
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
