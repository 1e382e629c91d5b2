// tests/render/interactive/interactive_parts_test.cpp: what options and setters of interactive pictures
// promise: room that stays free, patience, haste, windows, meshes along rays, volumes that there are not.
#include "core/image/image_metrics.h"
#include "render/geometry/tube_shape.h"
#include "tests/support/interactive_fixture.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;
using std::chrono::milliseconds;
using Clock = InteractiveRenderer::Clock;

constexpr std::size_t kPlenty = std::size_t{1} << 30;

class InteractiveParts : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Engines, InteractiveParts, testing::Values(true),
                         [](const auto& info) { return info.param ? "native" : "gpu"; });

// The asked share of pages stays free, half of them at most; the others are used.
TEST_P(InteractiveParts, LeaveTheAskedShareFree) {
    const Scene scene = interactiveScene("soft-tissue", 0, {32, 32});
    const std::size_t bytes = gpuBytesFor(scene, 40, GetParam());
    for (const double share : {-1.0, 0.0, 1.0 / 16, 0.25, 0.5, 0.9}) {
        InteractiveOptions options;
        options.spareShare = share;
        Session session(scene, bytes, options, storePath("torso"), GetParam());
        session.converge();
        const std::size_t pages = session.renderer.atlasPages(),
                          free = static_cast<std::size_t>(static_cast<double>(pages) *
                                                          std::clamp(share, 0.0, 0.5)),
                          used = pagesFor(session.renderer.wanted()->counts);
        EXPECT_EQ(used, pages - free) << share;
    }
}

TEST_P(InteractiveParts, WithoutPatienceThePictureComesAtOnce) {
    InteractiveOptions options;
    options.firstPatience = milliseconds(0);
    const Scene scene = interactiveScene("bone-1", 0, {32, 32});
    Session session(scene, kPlenty, options, storePath("torso"), GetParam());
    EXPECT_TRUE(session.renderer.picture().pixels.empty());
    const auto progress = session.renderer.advance(Clock::now() + std::chrono::hours(1));
    EXPECT_TRUE(progress.newPicture);
    EXPECT_FALSE(progress.converged);
    EXPECT_EQ(session.renderer.picture().size, glm::ivec2(32, 32));
    session.converge();
    EXPECT_FALSE(isBlank(session.renderer.picture()));
    EXPECT_GT(session.renderer.pictureMs(), 0);
    EXPECT_GT(session.renderer.work().bricksUploaded, 0u);
}

// Pictures in haste have the asked size, and the scene's again afterwards.
TEST_P(InteractiveParts, HasteIsTheAskedSize) {
    const Scene scene = interactiveScene("bone-1", 0, {40, 32});
    Session session(scene, kPlenty, {}, storePath("torso"), GetParam());
    session.converge();
    const Image whole = session.renderer.picture();
    const auto next = [&] {
        for (int n = 0; n < 500; ++n)
            if (session.renderer.advance(Clock::now() + milliseconds(100)).newPicture)
                return true;
        return false;
    };
    session.renderer.setHaste(InteractiveRenderer::Haste{{10, 8}, 2});
    ASSERT_TRUE(next());
    EXPECT_EQ(session.renderer.picture().size, glm::ivec2(10, 8));
    session.converge();
    session.renderer.setHaste(InteractiveRenderer::Haste{{10, 8}, 2}); // as it is: nothing to do
    EXPECT_TRUE(session.renderer.advance(Clock::now()).converged);
    session.renderer.setHaste(InteractiveRenderer::Haste{{40, 32}, 2}); // as many pixels, longer steps
    session.converge();
    EXPECT_EQ(session.renderer.picture().size, glm::ivec2(40, 32));
    EXPECT_FALSE(bitEqual(session.renderer.picture(), whole));
    session.renderer.setHaste(std::nullopt);
    session.converge();
    EXPECT_TRUE(bitEqual(session.renderer.picture(), whole));
}

// What is set of a volume that there is not, or set as it is, draws nothing anew.
TEST_P(InteractiveParts, VolumesThatThereAreNotChangeNothing) {
    const Scene scene = interactiveScene("bone-1", 0, {32, 32});
    Session session(scene, kPlenty, {}, storePath("torso"), GetParam());
    session.converge();
    EXPECT_EQ(session.renderer.sceneVolumes(), 1u);
    EXPECT_EQ(session.renderer.drawnVolumes(), 1u);
    const TransferFunction soft = session.renderer.functionOf(std::string("soft-tissue"), 0);
    session.renderer.setFunction(soft, 1);
    session.renderer.setOpacity(0.2, 1);
    session.renderer.setHaste(std::nullopt);
    const auto progress = session.renderer.advance(Clock::now());
    EXPECT_TRUE(progress.converged);
    EXPECT_FALSE(progress.newPicture || progress.choosing || progress.lightIsCoarse);
    EXPECT_EQ(progress.movesLeft, 0u);
    session.renderer.setFunction(soft);
    EXPECT_FALSE(session.renderer.advance(Clock::now()).converged);
}

// Pictures of single values in another window are those of a renderer that began with it.
TEST_P(InteractiveParts, WindowsAreThoseOfAFreshOne) {
    Scene scene = interactiveScene("bone-1", 0, {32, 32});
    scene.mode = Mode::maximum;
    scene.window = GreyWindow{40, 400};
    Image before, after;
    {
        Session session(scene, kPlenty, {}, storePath("torso"), GetParam());
        session.converge();
        before = session.renderer.picture();
        session.renderer.setWindow(GreyWindow{500, 1500});
        session.converge();
        after = session.renderer.picture();
    }
    scene.window = GreyWindow{500, 1500};
    Session session(scene, kPlenty, {}, storePath("torso"), GetParam());
    session.converge();
    EXPECT_TRUE(bitEqual(after, session.renderer.picture()));
    EXPECT_FALSE(bitEqual(before, after));
}

// A tube across the picture's middle: its front and its back, as far as the first opaque surface.
TEST_P(InteractiveParts, MeshesAreMetAlongARay) {
    Scene scene = interactiveScene("bone-1", 0, {32, 32});
    const VolumeInfo info = Session(scene, kPlenty, {}, storePath("torso"), GetParam()).reader.info();
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    Camera camera;
    camera.projection = Projection::parallel;
    camera.focalPoint = middle;
    camera.position = middle + glm::dvec3(0, -500, 0);
    camera.parallelScale = 160;
    scene.camera = camera;
    MemoryBudget ram("RAM", "--ram", 1 << 20);
    SceneMesh& mesh = scene.meshes.emplace_back();
    mesh.tube = Tube{{middle - glm::dvec3(400, 0, 0), middle + glm::dvec3(400, 0, 0)}, 5};
    mesh.shape = std::make_shared<const TubeShape>(*mesh.tube, ram);
    for (const double opacity : {0.5, 1.0}) {
        mesh.opacity = opacity;
        Session session(scene, kPlenty, {}, storePath("torso"), GetParam());
        const auto met = session.renderer.meshesAlong({64, 48}, {32, 24});
        ASSERT_EQ(met.size(), opacity < 1 ? 2u : 1u);
        for (std::size_t n = 0; n < met.size(); ++n) {
            const glm::dvec3 at(info.patientFromVoxel * glm::dvec4(met[n].voxel, 1));
            EXPECT_LT(glm::length(at - middle - glm::dvec3(0, n == 0 ? -5 : 5, 0)), 1e-6);
            EXPECT_EQ(met[n].mesh, &session.renderer.meshes()[0]);
        }
        // 160 mm are half of the picture's height: 5 mm are three quarters of a pixel of 48.
        EXPECT_EQ(session.renderer.meshesAlong({64, 48}, {32, 24.74}).size(), met.size());
        EXPECT_TRUE(session.renderer.meshesAlong({64, 48}, {32, 24.76}).empty());
        EXPECT_TRUE(session.renderer.meshesAlong({64, 48}, {32, 3}).empty());
    }
    scene.meshes.clear();
    EXPECT_TRUE(Session(scene, kPlenty, {}, storePath("torso"), GetParam())
                    .renderer.meshesAlong({64, 48}, {32, 24})
                    .empty());
}

} // namespace
} // namespace tessera
