// The proof of the reference holds on phantoms: closed forms, panels halved, a second integrator; and it
// would notice a reference that is wrong.
#include "render/backends/reference/reference_proof.h"

#include "bricking/import/importer.h"
#include "bricking/statistics/statistics.h"
#include "core/base/program_folders.h"
#include "core/scene/preset.h"
#include "datasets/phantom.h"
#include "tests/support/graded.h"
#include "tests/support/lights.h"

#include <gtest/gtest.h>
#include <optional>

namespace tessera {
namespace {

TEST(ReferenceProof, ClosedFormsAreMet) {
    const std::vector<ClosedFormError> forms = closedFormErrors();
    ASSERT_EQ(forms.size(), 9u);
    for (const ClosedFormError& form : forms) {
        EXPECT_LE(form.relativeError, form.limit) << form.name << ": " << form.about;
        EXPECT_GE(form.relativeError, 0) << form.name;
    }
    EXPECT_EQ(forms.back().name, "surface");
}

class ProofOnRays : public testing::Test {
  protected:
    void load(const std::string& phantom, const glm::ivec3& extent) {
        ImportOptions options;
        options.durable = false;
        importToStore(*makePhantom(phantom, extent), folder_ / "v.zarr", ram_, options);
        store_ = std::make_unique<StoreReader>(folder_ / "v.zarr", ram_);
        statistics_ = loadStatistics(*store_, ram_, 0);
        cache_ = std::make_unique<BrickCache>(*store_, ram_, std::size_t{64} << 20, 2);
    }
    RayProof prove(const TransferFunction& function, bool lit, const std::vector<Isosurface>& surfaces = {},
                   Gradient gradient = Gradient::central, const Lighting& lighting = {},
                   const std::optional<GradientWeight>& weight = {}) {
        Shading shading;
        shading.on = lit;
        shading.gradient = gradient;
        shading.gradientWeight = weight;
        shading.ambient = 0.3; // by default what faces the eye has the colour of what is not lit
        const VolumeInfo& info = store_->info();
        const glm::ivec2 size(64);
        const Camera camera = fitCamera(info, View::anterior, Projection::perspective, size);
        return proveOnRays(
            {cache_.get(), &info, &function, shading, &statistics_, 1, surfaces, {}, lighting, camera},
            sampledRays(referenceRays(camera, info, size), 49), 0);
    }
    const ScratchFolder folder_;
    MemoryBudget ram_{"RAM", "--ram", std::size_t{512} << 20};
    std::unique_ptr<StoreReader> store_;
    Statistics statistics_;
    std::unique_ptr<BrickCache> cache_;
};

TEST_F(ProofOnRays, HoldsOnAPhantomWithAPreset) {
    load("torso", {48, 36, 56});
    for (const char* preset : {"bone-1", "soft-tissue"}) {
        const RayProof proof = prove(presetFunction(preset, {-1024, 2000, true, 1, {}}), true);
        EXPECT_EQ(proof.rays, 49u);
        EXPECT_LE(proof.halving, RayProof::kHalvingLimit) << preset;
        EXPECT_LE(proof.independent, RayProof::kIndependentLimit) << preset;
        EXPECT_GT(proof.independent, 0) << preset << ": nothing was seen";
        EXPECT_TRUE(proof.holds());
    }
}

// Rays are cut where the shaded gradient, of whatever kind, turns away from them. Light has a corner there,
// and rays cut for another gradient miss it by 1e-8 and more. Between cuts the reference takes each gradient
// as a cubic, the second integrator as it is.
TEST_F(ProofOnRays, HoldsWithEveryGradient) {
    load("torso", {48, 36, 56});
    const auto function = presetFunction("soft-tissue", {-1024, 2000, true, 1, {}});
    for (std::size_t kind = 0; kind < gradientNames().size(); ++kind) {
        const RayProof proof = prove(function, true, {}, static_cast<Gradient>(kind));
        RecordProperty(gradientNames()[kind], std::to_string(1e12 * proof.halving) + "e-12, " +
                                                  std::to_string(1e9 * proof.independent) + "e-9");
        EXPECT_LE(proof.halving, RayProof::kHalvingLimit) << gradientNames()[kind];
        EXPECT_LE(proof.independent, RayProof::kIndependentLimit) << gradientNames()[kind];
    }
}

// With gradient opacity rays are cut where the gradient's length is one of its points', lit or not.
TEST_F(ProofOnRays, HoldsWithOpacityByGradient) {
    load("torso", {48, 36, 56});
    const auto function = test::graded(presetFunction("soft-tissue", {-1024, 2000, true, 1, {}}));
    for (std::size_t kind = 0; kind < gradientNames().size(); ++kind)
        for (const bool isLit : {false, true}) {
            const RayProof proof = prove(function, isLit, {}, static_cast<Gradient>(kind));
            EXPECT_LE(proof.halving, RayProof::kHalvingLimit) << gradientNames()[kind];
            EXPECT_LE(proof.independent, RayProof::kIndependentLimit) << gradientNames()[kind];
            EXPECT_GT(proof.independent, 0);
        }
}

// Lights of the scene's own, two of them points: rays are cut where the gradient turns away from each, and
// where materials change.
TEST_F(ProofOnRays, HoldsUnderManyLights) {
    load("torso", {48, 36, 56});
    Lighting lighting;
    lighting.lights = test::fourLights(store_->info());
    const TransferFunction function = test::presetWithMaterials("soft-tissue");
    for (const bool surfaces : {false, true})
        for (const bool weighed : {false, true}) {
            const RayProof proof = prove(
                function, true,
                surfaces ? std::vector<Isosurface>{{-300, glm::dvec3(0.5), 0.3}} : std::vector<Isosurface>{},
                Gradient::central, lighting, weighed ? std::optional(GradientWeight{2, 60}) : std::nullopt);
            EXPECT_TRUE(proof.holds()) << proof.halving << ", " << proof.independent;
            EXPECT_LE(proof.independent, 1e-9) << "without cuts for point lights it is 6e-8";
            EXPECT_GT(proof.independent, 0);
        }
}

// Inside cubes of one value nothing has a direction, and colours stay as they are.
TEST_F(ProofOnRays, HoldsWhereNothingIsLit) {
    load("checkerboard", {40, 33, 24});
    const auto thin = TransferFunction::fromOpacity({{-2000, 0.02}, {2000, 0.04}}, {{0, glm::dvec3(0.5)}}, 1);
    EXPECT_TRUE(prove(thin, true).holds()) << prove(thin, true).independent;
}

// Surfaces inside the volume and alone, opaque and not. Alone their places would not show: the proof takes
// them into a fog, where both numbers are of something.
TEST_F(ProofOnRays, HoldsOnIsosurfaces) {
    load("torso", {48, 36, 56});
    const std::vector<Isosurface> surfaces = {{250, {0.9, 0.9, 0.8}, 1}, {-300, {0.9, 0.6, 0.5}, 0.3}};
    for (const bool volume : {false, true}) {
        const auto function = volume ? presetFunction("soft-tissue", {-1024, 2000, true, 1, {}})
                                     : TransferFunction::fromExtinction({}, {});
        const RayProof proof = prove(function, true, surfaces);
        EXPECT_TRUE(proof.holds()) << proof.halving << ", " << proof.independent;
        EXPECT_GT(proof.halving, 0) << "nothing was compared";
        EXPECT_GT(proof.independent, 0) << "nothing was compared";
    }
}

// A surface that no ray meets leaves the proof as it is without: of the volume's own function and light.
TEST_F(ProofOnRays, SurfacesThatNoRayMeetsChangeNothing) {
    load("torso", {30, 22, 34});
    const auto function = presetFunction("soft-tissue", {-1024, 2000, true, 1, {}});
    const RayProof plain = prove(function, true), beside = prove(function, true, {{9000, glm::dvec3(1), 1}});
    EXPECT_GT(plain.independent, 0);
    EXPECT_NEAR(beside.independent, plain.independent, 0.5 * plain.independent);
    EXPECT_NEAR(beside.halving, plain.halving, 1e-14);
}

// A spike 1/4096 of the range wide, and a step to the largest opacity.
TEST_F(ProofOnRays, HoldsOnNarrowAndSteepFunctions) {
    load("sphere", {40, 33, 24});
    const double width = 2000.0 / 4096;
    const glm::dvec3 grey(0.5);
    const auto spike = TransferFunction::fromOpacity({{-width / 2, 0}, {0, 0.9}, {width / 2, 0}},
                                                     {{-500, grey}, {500, {1, 0.2, 0}}}, 1);
    const auto step = TransferFunction::fromOpacity({{100, 0}, {100, 1}, {1000, 1}}, {{0, grey}}, 1);
    for (const TransferFunction& function : {spike, step})
        EXPECT_TRUE(prove(function, false).holds())
            << prove(function, false).halving << ", " << prove(function, false).independent;
}

TEST(SampledRays, AreSpreadAndNoMoreThanThereAre) {
    std::vector<ReferenceRay> rays(10);
    for (int i = 0; i < 10; ++i)
        rays[static_cast<std::size_t>(i)].tMin = i;
    EXPECT_EQ(sampledRays(rays, 100).size(), 10u);
    const auto two = sampledRays(rays, 2);
    ASSERT_EQ(two.size(), 2u);
    EXPECT_EQ(two[0].tMin, 2);
    EXPECT_EQ(two[1].tMin, 7);
    EXPECT_TRUE(sampledRays({}, 5).empty());
}

} // namespace
} // namespace tessera
