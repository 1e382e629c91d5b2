// tests/render/geometry/mesh_occlusion_test.cpp: meshes that take ambient light from meshes, isosurfaces and
// the volume (docs/sampling.md, "Voxelised meshes"): closed forms, engines, half of the pixels, refusals, no
// cost.
#include "core/base/error.h"
#include "render/geometry/tube_shape.h"
#include "render/light/light_memory.h"
#include "render/light/scene_light.h"
#include "render/picture/render_scene.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/native_fixture.h"
#include "tests/support/occluded_surfaces.h"
#include "tests/support/voxel_checks.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;
using ::testing::HasSubstr;

MemoryBudget& shapeRam() {
    static MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    return ram;
}
glm::dvec3 centreOf(const VolumeInfo& info) {
    return glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
}

/// Of ambient light alone, which is 1; a volume that shows nothing.
Scene ambientScene(const VolumeInfo& info, const glm::ivec2& size, double perMm = 0) {
    Scene scene = sceneOn(info, "bone-1", 0, size);
    scene.shading.ambient = 1, scene.shading.diffuse = 0, scene.shading.specular = 0;
    scene.volumes.front().transferFunction =
        TransferFunction::fromExtinction({{-5000, perMm}, {5000, perMm}}, {{0, glm::vec3(0.5f)}});
    return scene;
}

/// A floor and a wall across the middle of the volume, white.
Scene cornerScene(const glm::ivec2& size, double perMm = 0) {
    const VolumeInfo info = infoOf("sphere");
    Scene scene = ambientScene(info, size, perMm);
    const glm::dvec3 c = centreOf(info);
    SceneMesh floor = sceneMesh(quadMesh(c + glm::dvec3(-30, -30, 0), {60, 0, 0}, {0, 60, 0}), shapeRam()),
              wall = sceneMesh(quadMesh(c + glm::dvec3(-30, 0, 0), {60, 0, 0}, {0, 0, 30}), shapeRam());
    floor.colour = wall.colour = glm::dvec3(1);
    scene.meshes = {floor, wall};
    scene.lighting.surfaceOcclusion = SurfaceOcclusion{.rays = 64, .radiusMm = 20};
    Camera camera = std::get<Camera>(scene.camera);
    camera.focalPoint = c;
    camera.position = c + glm::dvec3(40, -90, 70);
    camera.viewUp = {0, 0, 1};
    scene.camera = camera;
    return scene;
}

RenderResult pictureOf(const Scene& scene, EngineKind engine, const std::string& store = "sphere",
                       RenderOptions options = {}) {
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30),
        gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader reader(storePath(store), ram);
    options.engine = engine;
    options.device.text = "software";
    options.checking = options.searching = false;
    return renderScene(scene, reader, ram, gpu, options);
}

double rmsOf(const Image& a, const Image& b) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t n = 0; n < a.pixels.size(); ++n)
        if (a.pixels[n].a > 0) {
            sum += std::pow(double{a.pixels[n].g} - double{b.pixels[n].g}, 2);
            ++count;
        }
    return std::sqrt(sum / double(std::max<std::size_t>(count, 1)));
}

/// The light of a place at a distance from a wall that meets its floor at a right angle, by many directions.
double cornerOpen(double distance, double radius) {
    double open = 0;
    constexpr int kAngles = 200, kRings = 200;
    for (int a = 0; a < kAngles; ++a)
        for (int r = 0; r < kRings; ++r) {
            const double along =
                std::sqrt((r + 0.5) / kRings) * std::cos(2 * 3.14159265358979 * (a + 0.5) / kAngles);
            open += std::min(along > 0 ? distance / along : radius, radius) / radius / kAngles / kRings;
        }
    return open;
}

TEST(MeshOcclusion, ACornerIsAsDarkAsItsFormula) {
    for (const bool filter : {false, true}) {
        Scene scene = cornerScene({64, 64});
        scene.lighting.surfaceOcclusion->filter = filter;
        const Image image = pictureOf(scene, EngineKind::native).image;
        const VolumeInfo info = infoOf("sphere");
        const RayPlane plane = rayPlane(std::get<Camera>(scene.camera), info, scene.imageSize);
        double sum = 0, bias = 0, least = 1;
        int count = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                const PatientRay ray = pixelRay(plane, glm::dvec2(x, y) + 0.5, scene.imageSize);
                const glm::dvec3 o = ray.base - centreOf(info), d = ray.direction;
                const glm::dvec3 onWall = o - o.y / d.y * d, onFloor = o - o.z / d.z * d;
                const bool wall = onWall.z > 0 && onWall.z < 18 && std::abs(onWall.x) < 15;
                const bool floor = !wall && onFloor.y < 0 && onFloor.y > -18 && std::abs(onFloor.x) < 15;
                if (!wall && !floor)
                    continue;
                const double off = double{image.at(x, y).g} - cornerOpen(wall ? onWall.z : -onFloor.y, 20);
                least = std::min(least, double{image.at(x, y).g});
                sum += off * off, bias += off, ++count;
            }
        EXPECT_GT(count, 150);
        EXPECT_LT(least, 0.75);
        EXPECT_LT(std::sqrt(sum / count), filter ? 0.02 : 0.025) << filter;
        EXPECT_LT(std::abs(bias / count), 0.012);
    }
}

/// Native and mirror, threads, the way the work is cut; fog takes light too, and so does glass.
TEST(MeshOcclusion, EnginesAndThreadsAgree) {
    Scene scene = cornerScene({24, 24}, 0.003);
    scene.lighting.surfaceOcclusion->rays = 8;
    scene.meshes[1].opacity = 0.5;
    for (const int scale : {1, 2}) {
        scene.lighting.surfaceOcclusion->scale = scale;
        RenderOptions one;
        one.threads = 1;
        const Image native = pictureOf(scene, EngineKind::native).image;
        EXPECT_EQ(native.pixels, pictureOf(scene, EngineKind::native, "sphere", one).image.pixels);
        EXPECT_EQ(native.pixels, pictureOf(scene, EngineKind::mirror).image.pixels);
        EXPECT_LT(rmsOf(native, pictureOf(scene, EngineKind::gpu).image), 1e-4);
        EXPECT_LT(rmsOf(native, pictureOf(scene, EngineKind::reference).image), 0.02);
        Scene samples = scene;
        samples.quality.pixels.samples = 4;
        EXPECT_LT(rmsOf(pictureOf(samples, EngineKind::native).image, native), 0.08);
        Scene open = scene;
        open.lighting.surfaceOcclusion.reset();
        EXPECT_GT(rmsOf(pictureOf(open, EngineKind::native).image, native), 0.03);
    }
}

/// What a mesh leaves an isosurface, and the other way round; without it the isosurface has the bits of a
/// scene without meshes.
TEST(MeshOcclusion, MeshesAndIsosurfacesShadeOneAnother) {
    Scene scene = occludedScene(0, {32, 32}, {.rays = 16, .radiusMm = 60});
    const VolumeInfo info = infoOf("torso");
    const Image alone = pictureOf(scene, EngineKind::native, "torso").image;
    // A ball that no ray meets and that is too far to take light changes no bit.
    SceneMesh ball;
    ball.tube = Tube{{centreOf(info) + glm::dvec3(4000, 0, 0)}, 5};
    ball.shape = std::make_shared<const TubeShape>(*ball.tube, shapeRam());
    Scene far = scene;
    far.meshes = {ball};
    EXPECT_EQ(pictureOf(far, EngineKind::native, "torso").image.pixels, alone.pixels);
    Scene near = scene;
    near.meshes = {sceneMesh(quadMesh(centreOf(info) + glm::dvec3(-400, -400, 100), {800, 0, 0}, {0, 800, 0}),
                             shapeRam())};
    const Image shaded = pictureOf(near, EngineKind::native, "torso").image;
    Scene open = near;
    open.lighting.surfaceOcclusion.reset();
    const Image lit = pictureOf(open, EngineKind::native, "torso").image;
    double darker = 0, brighter = 0;
    for (std::size_t n = 0; n < lit.pixels.size(); ++n) {
        const double off = double{lit.pixels[n].g} - double{shaded.pixels[n].g};
        darker = std::max(darker, off), brighter = std::min(brighter, off);
    }
    EXPECT_GT(darker, 0.05);
    EXPECT_GE(brighter, -1e-6);
    EXPECT_EQ(shaded.pixels, pictureOf(near, EngineKind::mirror, "torso").image.pixels);
}

/// Half of the pixels along each axis: a quarter of the places, and nearly the same picture.
TEST(MeshOcclusion, HalfOfThePixelsIsNearlyAsGood) {
    Scene scene = cornerScene({128, 128});
    scene.lighting.surfaceOcclusion->rays = 256;
    const Image truth = pictureOf(scene, EngineKind::native).image;
    scene.lighting.surfaceOcclusion->rays = 16;
    const RenderResult full = pictureOf(scene, EngineKind::native);
    const double rms = rmsOf(full.image, truth);
    for (const int scale : {2, 4}) {
        scene.lighting.surfaceOcclusion->scale = scale;
        const RenderResult coarse = pictureOf(scene, EngineKind::native);
        EXPECT_NEAR(double(coarse.surfaceLight->places) * scale * scale / double(full.surfaceLight->places),
                    1, 0.06);
        EXPECT_LT(rmsOf(coarse.image, truth), rms + (scale == 2 ? 0.01 : 0.02)) << scale;
        EXPECT_LT(double(coarse.surfaceLight->alone), 0.1 * double(full.surfaceLight->places));
    }
}

/// Occlusion of the volume beside a large plate: of local occlusion in thin fog 1/2 + (h/R)(1 + ln(R/h))/2 at
/// a height h. Translucent plates take their share of that.
TEST(MeshOcclusion, MeshesDarkenTheVolume) {
    constexpr double kRadius = 12;
    const VolumeInfo info = infoOf("sphere");
    for (const double opacity : {1.0, 0.4}) {
        Scene scene = ambientScene(info, {16, 16}, 1e-5);
        scene.lighting.occlusion = Occlusion{.rays = 320, .radiusMm = kRadius, .bias = 0, .gamma = 1};
        const glm::dvec3 c = centreOf(info) + glm::dvec3(0, 0, 0.3);
        scene.meshes = {
            sceneMesh(quadMesh(c - glm::dvec3(90, 90, 0), {180, 0, 0}, {0, 180, 0}), shapeRam(), opacity)};
        Prepared prepared("sphere", scene);
        SceneLight light(prepared.p, 2);
        const StoredLight texels(light, prepared.p, prepared.budgets.ram);
        const StoredLight::Channel found(texels, 0);
        const glm::ivec3 middle(info.extentVoxels / 2);
        double most = 0, near = 0, darkest = 1;
        const int level = prepared.p.layer().selection.finest();
        ASSERT_EQ(level, 0);
        for (int z = middle.z - 10; z < middle.z + 10; ++z) {
            const glm::ivec3 i(middle.x, middle.y, z);
            const glm::dvec3 p(info.patientFromVoxel * glm::dvec4(glm::dvec3(i) + 0.5, 1));
            const double h = std::abs(p.z - c.z),
                         truth = h < kRadius
                                     ? 1 - opacity * (0.5 - 0.5 * h / kRadius * (1 + std::log(kRadius / h)))
                                     : 1;
            const double open = double{found.at(0, i)} / double{leaf::kLightOne};
            darkest = std::min(darkest, open);
            double& off = h > 1.5 * info.spacingMm().z ? most : near;
            off = std::max(off, std::abs(open - truth));
        }
        EXPECT_LT(most, 0.06) << opacity;
        EXPECT_LT(near, 0.15) << opacity << ": a sample in the plate's voxels does not darken itself";
        EXPECT_LT(darkest, 1 - 0.3 * opacity);
        EXPECT_LE(std::max(lightOfMeshesBytes(scene.lighting, info, scene.meshes), std::size_t{1}),
                  prepared.p.layer().lightCharge.bytes());
    }
}

/// The light of a sample behind a large plate along the lattice, at the end of the half of rays that cross it
/// at one angle: the plate takes the share of a layer of its medium, however thick slices are.
TEST(MeshOcclusion, SlicesMayBeThick) {
    for (const glm::dvec3 spacing : {glm::dvec3(1, 1, 1), {1, 1, 4}, {4, 1, 1}, {1, 0.3, 1}})
        for (int axis = 0; axis < 3; ++axis) {
            const glm::dmat4 place = glm::scale(glm::dmat4(1), spacing);
            VolumeInfo info = infoOf("sphere");
            info.patientFromVoxel = place;
            Scene scene = ambientScene(info, {16, 16}, 1e-6);
            scene.lighting.occlusion = Occlusion{
                .method = OcclusionMethod::positional, .rays = 8, .radiusMm = 16, .bias = 0, .gamma = 1};
            const glm::dvec3 c = centreOf(info);
            glm::dvec3 u(0), v(0), n(0);
            n[axis] = 1, u[(axis + 1) % 3] = 120, v[(axis + 2) % 3] = 120;
            scene.meshes = {
                sceneMesh(quadMesh(c + 0.3 * spacing * n - 0.5 * (u + v), u, v), shapeRam(), 0.4)};
            Prepared prepared("sphere", scene, true, 0, &place);
            SceneLight light(prepared.p, 2);
            const StoredLight texels(light, prepared.p, prepared.budgets.ram);
            glm::ivec3 i(info.extentVoxels / 2);
            i[axis] += static_cast<int>(std::ceil(1.5 / spacing[axis]));
            const double open = double{StoredLight::Channel(texels, 0).at(0, i)} / double{leaf::kLightOne};
            EXPECT_NEAR(open, 0.5 + 0.5 * std::pow(0.6, std::sqrt(3.0)), 0.05)
                << axis << " of " << spacing.x << " " << spacing.y << " " << spacing.z;
        }
}

/// Surfaces by which rays count are those of tissue, as the reference has them: even fog has none.
TEST(MeshOcclusion, MeshesAreNoSurfacesOfTissue) {
    const VolumeInfo info = infoOf("sphere");
    Scene scene = ambientScene(info, {16, 16}, 0.01);
    scene.lighting.occlusion = Occlusion{.rays = 32, .radiusMm = 8};
    const glm::dvec3 c = centreOf(info);
    scene.meshes = {sceneMesh(quadMesh(c - glm::dvec3(9, 9, 0.3), {18, 3, 0}, {0, 18, 5}), shapeRam())};
    std::vector<std::vector<std::uint16_t>> found;
    for (const auto directions : {OcclusionDirections::sphere, OcclusionDirections::hemisphere}) {
        scene.lighting.occlusion->directions = directions;
        Prepared prepared("sphere", scene);
        SceneLight light(prepared.p, 2);
        const StoredLight texels(light, prepared.p, prepared.budgets.ram);
        const StoredLight::Channel channel(texels, 0);
        std::vector<std::uint16_t>& of = found.emplace_back();
        const glm::ivec3 middle(info.extentVoxels / 2);
        for (int n = 0; n < 1000; ++n)
            of.push_back(static_cast<std::uint16_t>(
                channel.at(0, middle + glm::ivec3(n % 10, n / 10 % 10, n / 100) - 5)));
    }
    int apart = 0;
    for (std::size_t n = 0; n < found[0].size(); ++n)
        apart = std::max(apart, std::abs(int{found[0][n]} - int{found[1][n]}));
    EXPECT_LE(apart, 2) << "of " << static_cast<int>(leaf::kLightOne);
}

/// In pictures: native and mirror, mixed with a shadow; hits of the mesh have the occlusion of surfaces
/// beside.
TEST(MeshOcclusion, TheVolumesOcclusionStaysWithoutIsosurfaces) {
    Scene scene = cornerScene({24, 24}, 0.01);
    scene.lighting.surfaceOcclusion->rays = 4;
    Scene both = scene;
    both.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 10};
    const Image image = pictureOf(both, EngineKind::native).image;
    EXPECT_EQ(image.pixels, pictureOf(both, EngineKind::mirror).image.pixels);
    EXPECT_NE(image.pixels, pictureOf(scene, EngineKind::native).image.pixels);
    both.surfaces = {{300, {1, 1, 1}, 0.5}}; // where there are some it replaces that
    Scene one = both;
    one.lighting.occlusion.reset();
    EXPECT_EQ(pictureOf(both, EngineKind::native).image.pixels,
              pictureOf(one, EngineKind::native).image.pixels);
}

TEST(MeshOcclusion, Refusals) {
    const auto refused = [](const Scene& scene, std::size_t bytes = std::size_t{1} << 30) -> std::string {
        MemoryBudget ram("RAM", "--ram", bytes), gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
        const StoreReader reader(storePath("sphere"), ram);
        try {
            renderScene(scene, reader, ram, gpu, {});
        } catch (const InputError& e) {
            return e.what();
        }
        return "nothing was refused";
    };
    Scene scene = cornerScene({16, 16});
    EXPECT_EQ(refused(scene), "nothing was refused");
    Scene coarse = scene;
    coarse.lighting.surfaceOcclusion->scale = 2;
    coarse.lighting.surfaceOcclusion->filter = false;
    EXPECT_THAT(refused(coarse), HasSubstr("expected scale 1 without filter"));
    // Another mesh far away makes the voxels of all too large for any ray.
    Scene apart = scene;
    apart.meshes.push_back(sceneMesh(quadMesh({0, 20000, 0}, {1, 0, 0}, {0, 0, 1}), shapeRam()));
    EXPECT_THAT(refused(apart), HasSubstr("surfaceOcclusion.resolution: expected voxels"));
    Scene hidden = scene;
    for (SceneMesh& mesh : hidden.meshes)
        mesh.show = false;
    EXPECT_THAT(refused(hidden),
                HasSubstr("expected an isosurface that is not wholly transparent, or a mesh"));
}

// A budget that a refusal names suffices, whatever the voxels take.
TEST(MeshOcclusion, RefusalsNameTheTrueMinimum) {
    Scene scene = cornerScene({16, 16});
    scene.lighting.surfaceOcclusion->rays = 1;
    scene.lighting.surfaceOcclusion->resolution = 512;
    scene.meshes[1].opacity = 0.5;
    std::size_t bytes = std::size_t{8} << 20;
    int refusals = 0;
    for (; refusals < 3; ++refusals) {
        MemoryBudget ram("RAM", "--ram", bytes), gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
        try {
            const StoreReader reader(storePath("sphere"), ram);
            RenderOptions one;
            one.threads = 1;
            renderScene(scene, reader, ram, gpu, one);
            break;
        } catch (const InputError& e) {
            const std::string what = e.what(), key = "needs at least ";
            const std::size_t at = what.find(key);
            ASSERT_NE(at, std::string::npos) << what;
            const std::size_t end = what.find_first_of("(,", at);
            bytes = parseBytes(what.substr(at + key.size(), end - at - key.size()), "--ram");
        }
    }
    EXPECT_EQ(refusals, 1);
}

// Alphas of a large volume take a coarser lattice, and no more than their share of memory.
TEST(MeshOcclusion, ALatticeOfManyBytesIsCoarser) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(1024);
    SceneMesh mesh = sceneMesh(quadMesh({0, 0, 0}, {1000, 0, 0}, {0, 1000, 1000}), shapeRam());
    const auto levelOf = [&] {
        const MeshLattice lattice = meshLattice(info, Occlusion{}, std::span(&mesh, 1));
        EXPECT_LE(MeshBits::bytesAtMost(std::span(&mesh, 1), lattice.grid, false), std::size_t{64} << 20);
        return lattice.level;
    };
    EXPECT_EQ(levelOf(), 1); // bits of the whole box
    mesh.opacity = 0.5;
    EXPECT_EQ(levelOf(), 2);
    info.extentVoxels = glm::ivec3(256);
    EXPECT_EQ(levelOf(), 0);
}

/// No ray ends at the plane that it comes from: not where normals are between those of corners, nor where
/// floats are far apart.
TEST(MeshOcclusion, APlaneIsBrightWhateverItsNormalsAndPlace) {
    const VolumeInfo info = infoOf("sphere");
    for (const double far : {0.0, 300000.0})
        for (const double bend : {0.0, 0.8}) {
            Scene scene = ambientScene(info, {24, 24});
            const glm::dvec3 u(20, 3, 1), v(-2, 18, 5),
                n = glm::normalize(glm::cross(u, v)),
                c = centreOf(info) + far * glm::normalize(glm::dvec3(1, 0.7, -0.4));
            TriangleMesh plane; // one triangle: floats far away do not lie on a quad's plane
            plane.points = {glm::vec3(c - u - v), glm::vec3(c + 1.5 * u - 0.5 * v), glm::vec3(c + 1.5 * v)};
            plane.triangles = {{0, 1, 2}};
            if (bend > 0)
                plane.normals.assign(3, glm::vec3(glm::normalize(n + bend * glm::normalize(u))));
            SceneMesh mesh = sceneMesh(std::move(plane), shapeRam());
            mesh.colour = glm::dvec3(1);
            scene.meshes = {mesh};
            scene.lighting.surfaceOcclusion =
                SurfaceOcclusion{.rays = 32, .radiusMm = 8, .filter = false, .resolution = 512};
            Camera camera = std::get<Camera>(scene.camera);
            camera.focalPoint = c;
            camera.position = c + 45.0 * glm::normalize(n + glm::dvec3(0.1, 0.05, 0));
            camera.viewUp = glm::normalize(v);
            scene.camera = camera;
            float least = 1;
            int count = 0;
            for (const glm::vec4& pixel : pictureOf(scene, EngineKind::native).image.pixels)
                if (pixel.a > 0)
                    least = std::min(least, pixel.g), ++count;
            EXPECT_GT(count, 200);
            EXPECT_GT(least, 1 - 1e-5f) << far << " mm away, bent by " << bend;
        }
}

/// Without the key a scene with meshes has the bits and the memory of before; without meshes likewise.
TEST(MeshOcclusion, CostsNothingWhereItIsNotAskedFor) {
    Scene scene = cornerScene({48, 48});
    Scene plain = scene;
    plain.lighting.surfaceOcclusion.reset();
    const auto peak = [](const Scene& s) {
        MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30),
            gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
        const StoreReader reader(storePath("sphere"), ram);
        renderScene(s, reader, ram, gpu, {});
        return ram.peakBytes();
    };
    const RenderResult with = pictureOf(scene, EngineKind::native),
                       without = pictureOf(plain, EngineKind::native);
    EXPECT_TRUE(with.surfaceLight && with.surfaceLight->places > 500);
    EXPECT_FALSE(without.surfaceLight);
    EXPECT_GT(peak(scene), peak(plain) + 100000);
    for (std::size_t n = 0; n < with.image.pixels.size(); ++n)
        EXPECT_TRUE(without.image.pixels[n].a != 0 || with.image.pixels[n] == without.image.pixels[n]);
    Prepared none("sphere", plain);
    EXPECT_FALSE(none.p.view.meshBits);
    plain.meshes.clear();
    EXPECT_EQ(lightOfMeshesBytes(plain.lighting, infoOf("sphere"), plain.meshes), 0u);
}

} // namespace
} // namespace tessera
