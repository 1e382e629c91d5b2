// tests/render/verify/max_error_scenes_test.cpp: pictures within a requested error (quality.maxError) are
// that near to the reference, whatever a scene combines.
#include "core/scene/scene_presets.h"
#include "render/geometry/mesh_shape.h"
#include "render/geometry/tube_shape.h"
#include "render/picture/render_scene.h"
#include "tests/support/fused.h"
#include "tests/support/label_tools.h"
#include "tests/support/labelled.h"
#include "tests/support/lights.h"
#include "tests/support/mesh_shapes.h"

#include <gtest/gtest.h>
#include <map>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kMixtureSize(24, 20);

MemoryBudget& shapesRam() {
    static MemoryBudget ram("RAM", "--ram", std::size_t{1} << 28);
    return ram;
}

/// The volumes of fusedScene() by number, and what is added to them.
struct Mixture {
    const char* name;
    std::vector<int> volumes;
    void (*add)(Scene& scene);
    double asked = 3;
    std::size_t gpuMib = 1024; // for bricks
    EngineKind engine = EngineKind::native;
};
std::ostream& operator<<(std::ostream& out, const Mixture& m) {
    return out << m.name;
}

/// Labels of a volume: balls, a rod and a lone voxel.
void labelled(Scene& scene, std::size_t number, LabelLook look) {
    static std::map<std::filesystem::path, std::unique_ptr<BallsOfLabels>> kept;
    std::unique_ptr<BallsOfLabels>& here = kept[scene.volumes[number].path];
    if (!here) {
        Budgets budgets;
        const StoreReader store(scene.volumes[number].path, budgets.ram);
        here = std::make_unique<BallsOfLabels>(store.info(), 5 + static_cast<unsigned>(number));
    }
    Labels& labels = scene.volumes[number].labels;
    labels.path = labels.store = here->store;
    labels.look = look;
}
void ball(Scene& scene, const glm::dvec3& at, double radius, double opacity) {
    SceneMesh mesh;
    mesh.tube = Tube{{at, at + glm::dvec3(14, -6, 9)}, radius};
    mesh.colour = glm::dvec3(0.2, 0.9, 0.3);
    mesh.opacity = opacity;
    mesh.shape = std::make_shared<const TubeShape>(*mesh.tube, shapesRam());
    scene.meshes.push_back(mesh);
}
void surface(Scene& scene, double opacity) {
    SceneMesh mesh;
    mesh.path = "ball.ply";
    mesh.colour = glm::dvec3(0.9, 0.8, 0.2);
    mesh.opacity = opacity;
    mesh.shape = std::make_shared<const MeshShape>(sphereMesh({-4, 2, 6}, 13, 24), shapesRam(), "a ball");
    scene.meshes.push_back(mesh);
}
void lit(Scene& scene) {
    scene.lighting.lights =
        fourLights(gridAt({0, 0, 0}, {140, 132, 144}, {0.45, 0.5, 0.4}, 0, ValueType::i16));
}

class MaxErrorScenes : public testing::TestWithParam<Mixture> {};
INSTANTIATE_TEST_SUITE_P(
    Of, MaxErrorScenes,
    testing::Values(
        Mixture{"solid labels", {0}, [](Scene& s) { labelled(s, 0, LabelLook::solid); }},
        Mixture{"tinted labels, some hidden, lights",
                {0},
                [](Scene& s) {
                    labelled(s, 0, LabelLook::tint);
                    s.volumes[0].labels.hide = {"two", "5"};
                    lit(s);
                }},
        Mixture{"isolated labels in little memory",
                {0},
                [](Scene& s) {
                    labelled(s, 0, LabelLook::solid);
                    s.volumes[0].labels.show = {"group:pair", "7"};
                },
                3,
                32},
        Mixture{"labels to the faces of voxels",
                {0},
                [](Scene& s) {
                    labelled(s, 0, LabelLook::solid);
                    s.volumes[0].labels.show = {"group:pair", "7"};
                    s.volumes[0].labels.borders = LabelBorders::nearest;
                }},
        Mixture{
            "a volume that alone is cut",
            {0, 1},
            [](Scene& s) {
                s.volumes[0].cuts.planes = {{{2, 3, 1}, {0.2, 1, 0.4}, Keep::inside}};
                s.volumes[0].cuts.boxes = {{{-6, 0, -9}, {5, 30, 8}, CropBox::Space::patient, Keep::outside}};
            }},
        Mixture{"labels with functions of their own",
                {0},
                [](Scene& s) {
                    labelled(s, 0, LabelLook::plain);
                    s.volumes[0].labels.each = {{.of = "two",
                                                 .transferFunction = TransferFunction::fromOpacity(
                                                     {{100, 0.1}, {300, 0.4}}, {{100, {1, 0, 0}}}, 1),
                                                 .material = MaterialResponse{0.3, 0.7, 0.1, 5}},
                                                {.of = "40", .look = LabelLook::tint, .opacity = 0.4}};
                }},
        Mixture{"two volumes", {0, 1}, [](Scene&) {}, 1.5},
        Mixture{
            "a volume over another, cut",
            {1, 0},
            [](Scene& s) {
                s.fusion = Fusion::over;
                s.cuts.boxes.push_back({{-8, -20, -9}, {12, 9, 14}, CropBox::Space::patient, Keep::outside});
            }},
        Mixture{"the maximum of three, lights, little memory",
                {0, 1, 2},
                [](Scene& s) {
                    s.fusion = Fusion::maximum;
                    lit(s);
                },
                3,
                16},
        Mixture{"two volumes by gradients",
                {0, 2},
                [](Scene& s) {
                    for (SceneVolume& volume : s.volumes)
                        std::get<TransferFunction>(volume.transferFunction)
                            .setGradientOpacity(GradientOpacity::fromPoints({{0.2, 0.1}, {3, 0.8}, {30, 1}}));
                }},
        Mixture{"two volumes under one sky",
                {0, 1},
                [](Scene& s) { s.lighting.occlusion = Occlusion{.rays = 4, .radiusMm = 6}; }},
        Mixture{"a surface in a volume", {0}, [](Scene& s) { surface(s, 1); }, 1.5},
        Mixture{"a translucent tube among labels",
                {0},
                [](Scene& s) {
                    labelled(s, 0, LabelLook::solid);
                    s.volumes[0].labels.opacity = 0.1;
                    ball(s, {-6, 0, 0}, 5, 0.5);
                }},
        Mixture{"two volumes, labels, a surface",
                {0, 1},
                [](Scene& s) {
                    labelled(s, 0, LabelLook::tint);
                    surface(s, 0.6);
                }},
        Mixture{
            "all of it",
            {0, 1},
            [](Scene& s) {
                labelled(s, 0, LabelLook::plain);
                labelled(s, 1, LabelLook::solid);
                s.volumes[1].labels.show = {"1"};
                s.volumes[0].labels.each = {{.of = "group:pair",
                                             .transferFunction = TransferFunction::fromOpacity(
                                                 {{100, 0.05}, {300, 0.5}}, {{100, {0, 1, 1}}}, 1)}};
                surface(s, 0.5);
                ball(s, {8, -6, -10}, 3, 1);
                s.cuts.boxes.push_back({{-30, -40, 2}, {-2, 0, 40}, CropBox::Space::patient, Keep::outside});
            },
            3,
            96},
        Mixture{"two volumes by the GPU ray caster, little memory",
                {1, 2},
                [](Scene& s) { s.quality.fetch = Fetch::hardware; },
                3,
                8,
                EngineKind::gpu},
        Mixture{"a label with a function of its own by the GPU ray caster",
                {1},
                [](Scene& s) {
                    labelled(s, 0, LabelLook::plain);
                    s.volumes[0].labels.each = {{.of = "two",
                                                 .transferFunction = TransferFunction::fromOpacity(
                                                     {{1, 0.1}, {8, 0.4}}, {{1, {0, 1, 0}}}, 1)}};
                },
                3,
                1024,
                EngineKind::gpu}));

// Both pictures have the same rays, so that the reference's has no noise of its own.
TEST_P(MaxErrorScenes, AreAsNearToTheReference) {
    const Mixture& mixture = GetParam();
    const bool inSoftware = mixture.engine == EngineKind::gpu; // takes long for each ray
    Scene scene = fusedScene(mixture.volumes, inSoftware ? kMixtureSize / 2 : kMixtureSize);
    mixture.add(scene);
    // The reference takes long for a ray through three volumes.
    scene.quality.pixels.samples = inSoftware || mixture.volumes.size() > 2 ? 1 : 6;
    constexpr std::size_t kAmple = std::size_t{1} << 30;
    const Image truth =
        fusedPicture(scene, EngineKind::reference, kAmple, kAmple, LevelChoice::oneForAll).image;
    scene.quality.maxError = mixture.asked;
    scene.quality.automaticStep = true;
    scene.quality.terminationTransmittance = 1.0 / 510;
    OpenedVolumes opened(scene);
    MemoryBudget gpu("GPU memory", "--gpu-memory", mixture.gpuMib << 20);
    RenderOptions options;
    options.engine = mixture.engine;
    options.device.text = "software";
    options.verify = Verify::quick;
    options.searching = options.checking = true;
    const RenderResult result = renderScene(scene, opened.stores, opened.budgets.ram, gpu, options);
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
    ASSERT_TRUE(result.measured);
    EXPECT_EQ(result.measured->whyNot, "");
    const double is = errorBetween(result.image, truth).luvP99;
    EXPECT_LE(is, mixture.asked);
    const auto& measured = result.measured->rays.luvP99;
    ASSERT_TRUE(measured);
    EXPECT_LE(measured->value, mixture.asked);
    RecordProperty("true", std::to_string(is));
    RecordProperty("measured", std::to_string(measured->value));
}

} // namespace
} // namespace tessera
