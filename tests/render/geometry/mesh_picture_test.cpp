// tests/render/geometry/mesh_picture_test.cpp: meshes in pictures (docs/sampling.md, "Meshes"): closed forms
// in an even medium, order, cuts, light; every engine, every division of the work.
#include "core/base/error.h"
#include "render/contract/optics.h"
#include "render/geometry/mesh_shape.h"
#include "render/geometry/tube_shape.h"
#include "render/picture/render_scene.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/native_fixture.h"
#include "tests/support/value_scenes.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr double kPerMm = 0.011;
constexpr glm::dvec3 kFogColour(0.2, 0.6, 0.9);
constexpr glm::ivec2 kMeshSize(37, 41); // no packet's edges divide it

const VolumeInfo& sphereInfo() {
    static const VolumeInfo info = infoOf("sphere");
    return info;
}
MemoryBudget& meshRam() {
    static MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    return ram;
}
SceneMesh ballOf(const glm::dvec3& centre, double radius, const glm::dvec3& colour, double opacity = 1) {
    SceneMesh mesh;
    mesh.tube = Tube{{centre}, radius};
    mesh.colour = colour;
    mesh.opacity = opacity;
    mesh.shape = std::make_shared<const TubeShape>(*mesh.tube, meshRam());
    return mesh;
}
SceneMesh meshOf(TriangleMesh triangles, const glm::dvec3& colour, double opacity = 1) {
    SceneMesh mesh;
    mesh.path = "a.ply";
    mesh.colour = colour;
    mesh.opacity = opacity;
    mesh.shape = std::make_shared<const MeshShape>(std::move(triangles), meshRam(), "a mesh");
    return mesh;
}

/// Camera 0: perspective, oblique; 1: parallel; 2: inside.
Scene fogScene(int camera = 0, const glm::ivec2& size = kMeshSize) {
    Scene scene = sceneOn(sphereInfo(), "bone-1", camera, size);
    scene.shading.on = false;
    scene.volumes.front().transferFunction =
        TransferFunction::fromExtinction({{-5000, kPerMm}, {5000, kPerMm}}, {{0, glm::vec3(kFogColour)}});
    scene.quality.stepVoxels = 0.5;
    return scene;
}

RenderResult drawn(const Scene& scene, EngineKind engine, const std::string& store = "sphere",
                   std::size_t gpuBytes = std::size_t{1} << 30, RenderOptions options = {}) {
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader reader(storePath(store), ram);
    options.engine = engine;
    options.device.text = "software";
    options.levels = scene.quality.maxError ? LevelChoice::perBrick : LevelChoice::oneForAll;
    return renderScene(scene, reader, ram, gpu, options);
}

double largestDifference(const Image& a, const Image& b) {
    double largest = a.size == b.size ? 0 : 1e9;
    for (std::size_t n = 0; n < a.pixels.size() && largest < 1e9; ++n)
        for (int c = 0; c < 4; ++c)
            largest = std::max(largest, double{std::abs(a.pixels[n][c] - b.pixels[n][c])});
    return largest;
}

/// What a ray meets, by formulas of the test's own: mm along it.
struct Event {
    double t;
    glm::dvec3 colour;
    double opacity;
};
using Events = std::function<std::vector<Event>(const PatientRay& ray)>;

/// Surfaces in the fog of the volume's box, or of the part of a ray in it that a condition keeps.
Image expectedInFog(const Scene& scene, const Events& eventsOf,
                    const std::function<void(const PatientRay&, double&, double&)>& cut = {}) {
    const VolumeInfo& info = sphereInfo();
    const RayPlane plane = rayPlane(std::get<Camera>(scene.camera), info, scene.imageSize);
    const glm::dmat4 toVoxels = glm::inverse(info.patientFromVoxel);
    Image image(scene.imageSize);
    for (int y = 0; y < scene.imageSize.y; ++y)
        for (int x = 0; x < scene.imageSize.x; ++x) {
            const PatientRay ray = pixelRay(plane, glm::dvec2(x, y) + 0.5, scene.imageSize);
            const glm::dvec3 from(toVoxels * glm::dvec4(ray.base, 1)),
                along = glm::dmat3(toVoxels) * ray.direction;
            double in = ray.minT, out = 1e9;
            for (int axis = 0; axis < 3; ++axis) {
                const double a = -from[axis] / along[axis],
                             b = (info.extentVoxels[axis] - from[axis]) / along[axis];
                in = std::max(in, std::min(a, b));
                out = std::min(out, std::max(a, b));
            }
            if (cut)
                cut(ray, in, out);
            std::vector<Event> events = eventsOf(ray);
            std::erase_if(events, [&](const Event& e) { return !(e.t > ray.minT); });
            std::stable_sort(events.begin(), events.end(),
                             [](const Event& a, const Event& b) { return a.t < b.t; });
            events.push_back({1e9, {}, 0});
            glm::dvec3 sum(0);
            double left = 1, before = -1e9;
            for (const Event& e : events) {
                const double mm = std::max(0.0, std::min(out, e.t) - std::max(in, before));
                const double alpha = -std::expm1(-kPerMm * mm);
                sum += left * alpha * kFogColour;
                left *= 1 - alpha;
                sum += left * e.opacity * e.colour;
                left *= 1 - e.opacity;
                before = e.t;
            }
            image.at(x, y) = glm::vec4(glm::vec3(sum), static_cast<float>(1 - left));
        }
    return image;
}

std::vector<Event> ofBall(const PatientRay& ray, const SceneMesh& mesh) {
    const glm::dvec3 o = ray.base - mesh.tube->points[0];
    const double b = glm::dot(o, ray.direction), a = glm::dot(ray.direction, ray.direction);
    const double root = b * b - a * (glm::dot(o, o) - mesh.tube->radiusMm * mesh.tube->radiusMm);
    if (!(root > 0))
        return {};
    return {{(-b - std::sqrt(root)) / a, *mesh.colour, mesh.opacity},
            {(-b + std::sqrt(root)) / a, *mesh.colour, mesh.opacity}};
}
Events ofBalls(const Scene& scene) {
    return [&scene](const PatientRay& ray) {
        std::vector<Event> all;
        for (const SceneMesh& mesh : scene.meshes)
            for (const Event& e : ofBall(ray, mesh))
                all.push_back(e);
        return all;
    };
}

/// Every engine has the closed form; native and mirror the same bits.
void expectForm(const Scene& scene, const Image& form) {
    const Image mirror = drawn(scene, EngineKind::mirror).image;
    EXPECT_LE(largestDifference(mirror, form), 1e-5);
    EXPECT_EQ(differing(drawn(scene, EngineKind::native).image, mirror), 0u);
    EXPECT_LE(largestDifference(drawn(scene, EngineKind::reference).image, form), 2e-6);
    EXPECT_LE(largestDifference(drawn(scene, EngineKind::gpu).image, form), 2e-5);
}

/// On the volume's face, half in the fog and half outside of it.
glm::dvec3 onFace(const glm::dvec3& side) {
    const VolumeInfo& info = sphereInfo();
    return middleOf(info) + 0.5 * side * info.spacingMm() * glm::dvec3(info.extentVoxels);
}
double sizeMm() {
    const VolumeInfo& info = sphereInfo();
    return glm::length(info.spacingMm() * glm::dvec3(info.extentVoxels));
}

class MeshCamera : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Cameras, MeshCamera, testing::Values(0, 1, 2));

TEST_P(MeshCamera, ABallHalfInFog) {
    for (const double opacity : {1.0, 0.4})
        for (const glm::dvec3& side : {glm::dvec3(0, -1, 0), {0.3, 1, 0.2}, {1, 0, 0}, {-0.71, 1, 0.48}}) {
            Scene scene = fogScene(GetParam());
            scene.meshes = {ballOf(onFace(side), 0.13 * sizeMm(), {0.9, 0.5, 0.1}, opacity)};
            const Image form = expectedInFog(scene, ofBalls(scene));
            scene.meshes[0].opacity = 0;
            const double shows = largestDifference(form, expectedInFog(scene, ofBalls(scene)));
            scene.meshes[0].opacity = opacity;
            EXPECT_GT(shows, GetParam() < 2 || side.x < -0.5 ? 0.02 : -1);
            expectForm(scene, form);
        }
}

TEST_P(MeshCamera, InsideTheMesh) {
    Scene scene = fogScene(GetParam());
    const glm::dvec3 eye = std::get<Camera>(scene.camera).position;
    scene.meshes = {ballOf(eye + 0.02 * sizeMm(), 0.21 * sizeMm(), {0.9, 0.5, 0.1}, 0.7)};
    expectForm(scene, expectedInFog(scene, ofBalls(scene)));
    scene.meshes[0].opacity = 1;
    const Image form = expectedInFog(scene, ofBalls(scene));
    EXPECT_TRUE(GetParam() == 1 || form.at(3, 3).a == 1);
    expectForm(scene, form);
}

// Surfaces that lie through one another: their order differs from ray to ray, and is not that of the scene.
TEST_P(MeshCamera, OrderIsThatOfRays) {
    Scene scene = fogScene(GetParam());
    const glm::dvec3 middle = onFace({0, 0, 0});
    const double r = 0.16 * sizeMm();
    scene.meshes = {ballOf(middle + glm::dvec3(0.5 * r, 0.2 * r, 0), r, {0.9, 0.1, 0.1}, 0.5),
                    ballOf(middle - glm::dvec3(0.4 * r, 0, 0.1 * r), r, {0.1, 0.2, 0.9}, 0.6),
                    ballOf(middle + glm::dvec3(0, -0.7 * r, 0.4 * r), 0.6 * r, {0.1, 0.9, 0.1}, 1)};
    const Image form = expectedInFog(scene, ofBalls(scene));
    expectForm(scene, form);
    const Image picture = drawn(scene, EngineKind::native).image;
    std::rotate(scene.meshes.begin(), scene.meshes.begin() + 1, scene.meshes.end());
    EXPECT_EQ(differing(drawn(scene, EngineKind::native).image, picture), 0u);
    // The wrong order, surface by surface as the scene has them, is another picture.
    const Image wrong = expectedInFog(scene, [&](const PatientRay& ray) {
        std::vector<Event> events = ofBalls(scene)(ray);
        for (std::size_t n = 1; n < events.size(); ++n)
            events[n].t = std::max(events[n].t, events[n - 1].t);
        return events;
    });
    EXPECT_GT(largestDifference(wrong, form), 0.05);
}

// A quad in the plane of a cut: there is no fog before it from the side that is cut away, and all of it from
// the other.
TEST(MeshInFog, CoplanarWithACut) {
    for (const int camera : {0, 1})
        for (const double sign : {1.0, -1.0}) {
            Scene scene = fogScene(camera);
            const Camera& c = std::get<Camera>(scene.camera);
            const glm::dvec3 point = onFace({0, 0, 0}) + glm::dvec3(1.0 / 3);
            const glm::dvec3 normal = sign * glm::normalize(c.focalPoint - c.position + 0.3 * sizeMm());
            scene.cuts.planes.push_back({point, normal, Keep::inside});
            const glm::dvec3 a = glm::normalize(glm::cross(normal, {0.1, 0.2, 1})), b = glm::cross(normal, a);
            const double half = 0.2 * sizeMm();
            scene.meshes = {
                meshOf(quadMesh(point - half * (a + b), 2 * half * a, 2 * half * b), {0.9, 0.5, 0.1}, 0.8)};
            const auto crossing = [&](const PatientRay& ray) {
                return glm::dot(point - ray.base, normal) / glm::dot(ray.direction, normal);
            };
            int beside = 0;
            const Image form = expectedInFog(
                scene,
                [&](const PatientRay& ray) -> std::vector<Event> {
                    const double t = crossing(ray);
                    const glm::dvec3 p = ray.base + t * ray.direction - point;
                    const double u = std::abs(glm::dot(p, a)), v = std::abs(glm::dot(p, b));
                    beside += std::max(u, v) > half;
                    if (std::max(u, v) > half)
                        return {};
                    return {{t, *scene.meshes[0].colour, 0.8}};
                },
                [&](const PatientRay& ray, double& in, double& out) {
                    (glm::dot(ray.direction, normal) > 0 ? in : out) = glm::dot(ray.direction, normal) > 0
                                                                           ? std::max(in, crossing(ray))
                                                                           : std::min(out, crossing(ray));
                });
            EXPECT_GT(beside, 0);
            expectForm(scene, form);
        }
}

TEST(MeshInFog, CutsCutMeshesUnlessTheySayNot) {
    Scene scene = fogScene(0);
    const glm::dvec3 middle = onFace({0, 0, 0});
    scene.cuts.planes.push_back({middle, {1, 0.2, -0.1}, Keep::inside});
    scene.meshes = {ballOf(middle, 0.2 * sizeMm(), {0.9, 0.5, 0.1}, 0.6)};
    const auto cut = [&](const PatientRay& ray, double& in, double& out) {
        const glm::dvec3 normal = glm::normalize(glm::dvec3(1, 0.2, -0.1));
        const double along = glm::dot(ray.direction, normal), t = glm::dot(middle - ray.base, normal) / along;
        along > 0 ? in = std::max(in, t) : out = std::min(out, t);
    };
    const auto kept = [&](const PatientRay& ray) {
        std::vector<Event> events = ofBalls(scene)(ray);
        std::erase_if(events, [&](const Event& e) {
            return glm::dot(ray.base + e.t * ray.direction - middle, glm::dvec3(1, 0.2, -0.1)) < 0;
        });
        return events;
    };
    const Image form = expectedInFog(scene, kept, cut);
    expectForm(scene, form);
    scene.meshes[0].clipped = false;
    const Image whole = expectedInFog(scene, ofBalls(scene), cut);
    EXPECT_GT(largestDifference(whole, form), 0.1);
    expectForm(scene, whole);
}

TEST(MeshInFog, InsideOutIsTheSame) {
    Scene scene = fogScene(0);
    scene.shading.on = true;
    const auto picture = [&](bool insideOut, double opacity, int copies) {
        scene.meshes.clear();
        for (int n = 0; n < copies; ++n)
            scene.meshes.push_back(meshOf(sphereMesh(onFace({0, -1, 0}), 0.2 * sizeMm(), 20, insideOut),
                                          {0.9, 0.5, 0.1}, opacity));
        return drawn(scene, EngineKind::native).image;
    };
    for (const double opacity : {1.0, 0.4})
        EXPECT_LE(largestDifference(picture(true, opacity, 1), picture(false, opacity, 1)), 1e-6) << opacity;
    EXPECT_EQ(differing(picture(false, 1, 3), picture(false, 1, 1)), 0u) << "hidden copies";
    // Two copies of 0.4 at one place are one of 0.64.
    EXPECT_LE(largestDifference(picture(false, 0.4, 2), picture(false, 0.64, 1)), 1e-6);
}

TEST(MeshInFog, AQuadFromItsEdgeShowsNothing) {
    Scene scene = fogScene(1);
    const Camera& c = std::get<Camera>(scene.camera);
    const glm::dvec3 along = glm::normalize(c.focalPoint - c.position), side = glm::cross(along, c.viewUp);
    const Image without = drawn(scene, EngineKind::native).image;
    scene.meshes = {meshOf(quadMesh(onFace({0, 0, 0}) - 0.2 * sizeMm() * along + 0.013 * sizeMm() * side,
                                    0.4 * sizeMm() * along, 0.2 * sizeMm() * c.viewUp),
                           {0.9, 0.5, 0.1})};
    // No pixel has more than the quad's rounding of its corners shows.
    EXPECT_LE(differing(drawn(scene, EngineKind::native).image, without),
              static_cast<std::size_t>(kMeshSize.y));
}

// The light of a needle a tenth of a pixel wide is that of its area.
TEST(MeshInFog, ANeedleThinnerThanAPixel) {
    Scene scene = fogScene(1, {64, 64});
    scene.volumes.front().transferFunction = TransferFunction::fromExtinction({{0, 0}}, {{0, glm::vec3(1)}});
    Camera& c = std::get<Camera>(scene.camera);
    const double pixel = 2 * c.parallelScale / 64;
    const glm::dvec3 side = glm::normalize(glm::cross(c.focalPoint - c.position, c.viewUp));
    const glm::dvec3 half = 20 * pixel * glm::normalize(side + 0.31 * c.viewUp);
    SceneMesh needle = ballOf({0, 0, 0}, 1, {1, 1, 1});
    needle.tube = Tube{{c.focalPoint - half, c.focalPoint + half}, 0.05 * pixel};
    needle.shape = std::make_shared<const TubeShape>(*needle.tube, meshRam());
    scene.meshes = {needle};
    scene.quality.pixels.samples = 64;
    const Image image = drawn(scene, EngineKind::native).image;
    double light = 0;
    for (const glm::vec4& p : image.pixels)
        light += p.a;
    const double area = 40 * 0.1 + std::acos(-1.0) * 0.05 * 0.05; // pixels
    EXPECT_NEAR(light, area, 0.06 * area);
}

// colour * (ambient + diffuse * cos) + highlights, worked out by hand; two-sided.
TEST(MeshLight, IsThatOfTheScene) {
    Scene scene = fogScene(1);
    scene.volumes.front().transferFunction = TransferFunction::fromExtinction({{0, 0}}, {{0, glm::vec3(1)}});
    scene.shading.on = true;
    scene.shading.ambient = 0.15, scene.shading.diffuse = 0.7, scene.shading.specular = 0;
    const Camera& c = std::get<Camera>(scene.camera);
    const glm::dvec3 v = glm::normalize(c.position - c.focalPoint), u = glm::normalize(c.viewUp);
    const auto middlePixel = [&](EngineKind engine) { return drawn(scene, engine).image.at(18, 20); };
    for (const double degrees : {0.0, 35.0, 70.0})
        for (const double side : {1.0, -1.0}) {
            const double angle = degrees * std::acos(-1.0) / 180;
            const glm::dvec3 n = std::cos(angle) * v + std::sin(angle) * u, a = glm::cross(v, u),
                             b = glm::cross(n, a);
            scene.meshes = {
                meshOf(quadMesh(onFace({0, 0, 0}) - 40.0 * (a + side * b), 80.0 * a, side * 80.0 * b),
                       {0.9, 0.5, 0.2})};
            scene.lighting = {};
            EXPECT_NEAR(middlePixel(EngineKind::native).r, 0.9 * (0.15 + 0.7 * std::cos(angle)), 1e-5);
            Light light;
            light.kind = LightKind::directional;
            light.frame = LightFrame::patient;
            light.direction = glm::normalize(v + u);
            light.intensity = 0.8;
            light.colour = {1, 0.5, 1};
            scene.lighting.lights = {light};
            const double cosine = std::max(0.0, glm::dot(n, glm::normalize(v + u)));
            const glm::vec4 p = middlePixel(EngineKind::mirror);
            EXPECT_NEAR(p.r, 0.9 * (0.15 + 0.7 * 0.8 * cosine), 1e-5);
            EXPECT_NEAR(p.g, 0.5 * (0.15 + 0.7 * 0.4 * cosine), 1e-5);
            scene.meshes[0].material = MaterialResponse{0.5, 0.25, 0, 1};
            EXPECT_NEAR(middlePixel(EngineKind::native).r, 0.9 * (0.5 + 0.25 * 0.8 * cosine), 1e-5);
        }
}

/// A directional light with a shadow, in patient space.
Light shadowLight(const glm::dvec3& towards) {
    Light light;
    light.kind = LightKind::directional;
    light.frame = LightFrame::patient;
    light.direction = towards;
    light.shadow = true;
    return light;
}

// A thin medium shows how much of each ray is lit: that which is not behind the ball, seen from the light.
TEST(MeshShadows, FallIntoTheVolume) {
    for (const double opacity : {1.0, 0.5}) {
        Scene scene = fogScene(1, {12, 12});
        constexpr double kThin = 1e-5;
        scene.volumes.front().transferFunction =
            TransferFunction::fromExtinction({{-5000, kThin}, {5000, kThin}}, {{0, glm::vec3(1)}});
        scene.shading.on = true;
        scene.shading.ambient = 0.1, scene.shading.diffuse = 0.6, scene.shading.specular = 0;
        scene.shading.gradientWeight = GradientWeight{1e8, 1e9}; // all of it is volume
        const glm::dvec3 towards = glm::normalize(glm::dvec3(0.2, -1, 0.3));
        scene.lighting.lights = {shadowLight(towards)};
        const glm::dvec3 centre = onFace({0, 0, 0}) + 0.9 * sizeMm() * towards; // outside of the volume
        const double radius = 0.12 * sizeMm();
        scene.meshes = {ballOf(centre, radius, {1, 0, 0}, opacity)};
        const Image mirror = drawn(scene, EngineKind::mirror).image,
                    native = drawn(scene, EngineKind::native).image;
        EXPECT_EQ(differing(native, mirror), 0u);
        const Image reference = opacity == 1 ? drawn(scene, EngineKind::reference).image : native;
        const VolumeInfo& info = sphereInfo();
        const RayPlane plane = rayPlane(std::get<Camera>(scene.camera), info, scene.imageSize);
        const glm::dmat4 toVoxels = glm::inverse(info.patientFromVoxel);
        double squares = 0, ofReference = 0, shaded = 0;
        int seen = 0;
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 12; ++x) {
                const glm::vec4 p = native.at(x, y);
                if (!(p.a > 0))
                    continue;
                const PatientRay ray = pixelRay(plane, glm::dvec2(x, y) + 0.5, scene.imageSize);
                double inside = 0, dark = 0;
                for (double t = -2 * sizeMm(); t < 2 * sizeMm(); t += 0.1) {
                    const glm::dvec3 at = ray.base + t * ray.direction;
                    const glm::dvec3 voxel(toVoxels * glm::dvec4(at, 1));
                    if (glm::any(glm::lessThan(voxel, glm::dvec3(0))) ||
                        glm::any(glm::greaterThan(voxel, glm::dvec3(info.extentVoxels))))
                        continue;
                    inside += 1;
                    dark += glm::length(glm::cross(centre - at, towards)) < radius;
                }
                if (inside < 20)
                    continue;
                const double left = opacity == 1 ? 0 : 0.25; // two surfaces
                const double form = 0.1 + 0.6 * (1 - (1 - left) * dark / inside);
                squares += std::pow(p.r / p.a - form, 2);
                ofReference += std::pow(reference.at(x, y).r / reference.at(x, y).a - form, 2);
                shaded += dark > 0;
                ++seen;
            }
        EXPECT_GT(shaded, 8);
        EXPECT_LT(shaded, 0.9 * seen);
        EXPECT_LT(std::sqrt(squares / seen), 0.02) << "rms, by maps and samples of light";
        if (opacity == 1) {
            EXPECT_LT(std::sqrt(ofReference / seen), 0.005);
        }
    }
}

// On a quad beside the volume: the shadow of a ball is dark, that of the fog as dark as the fog is long.
TEST(MeshShadows, FallOnMeshes) {
    Scene scene = fogScene(0, {40, 40});
    const VolumeInfo& info = sphereInfo();
    scene.shading.on = true;
    scene.shading.ambient = 0.1, scene.shading.diffuse = 0.6, scene.shading.specular = 0;
    const glm::dvec3 middle = onFace({0, 0, 0}),
                     below = onFace({0, 0, -1}) - glm::dvec3(0, 0, 0.1 * sizeMm());
    const double half = 2 * sizeMm();
    Camera& c = std::get<Camera>(scene.camera); // from below: the quad is before the volume
    c.focalPoint = below + glm::dvec3(0, -0.35, 0) * sizeMm();
    c.position = below + glm::dvec3(0.2, -0.8, 0.09) * sizeMm();
    c.viewUp = {0, 0, 1};
    c.viewAngle = 90;
    const glm::dvec3 towards = glm::normalize(glm::dvec3(0.1, 0.2, 1));
    scene.lighting.lights = {shadowLight(towards)};
    const glm::dvec3 centre = middle + glm::dvec3(0.1, -0.1, 0.9) * sizeMm();
    const double radius = 0.1 * sizeMm();
    const SceneMesh quad = meshOf(
        quadMesh(below - glm::dvec3(half, half, 0), {2 * half, 0, 0}, {0, 2 * half, 0}), {0.5, 0.9, 0.7});
    scene.meshes = {quad, ballOf(centre, radius, {1, 0, 0})};
    const Image native = drawn(scene, EngineKind::native).image;
    EXPECT_EQ(differing(native, drawn(scene, EngineKind::mirror).image), 0u);
    const RayPlane plane = rayPlane(c, info, scene.imageSize);
    const glm::dmat4 toVoxels = glm::inverse(info.patientFromVoxel);
    int dark = 0, fogged = 0, open = 0;
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
            const PatientRay ray = pixelRay(plane, glm::dvec2(x, y) + 0.5, scene.imageSize);
            const double t = (below.z - ray.base.z) / ray.direction.z;
            if (!(t > ray.minT))
                continue;
            const auto inBox = [&](const glm::dvec3& from, const glm::dvec3& direction, double least,
                                   double most) {
                const glm::dvec3 o(toVoxels * glm::dvec4(from, 1)), d = glm::dmat3(toVoxels) * direction;
                double in = least, out = most;
                for (int axis = 0; axis < 3; ++axis) {
                    const double a = -o[axis] / d[axis], b = (info.extentVoxels[axis] - o[axis]) / d[axis];
                    in = std::max(in, std::min(a, b)), out = std::min(out, std::max(a, b));
                }
                return std::max(0.0, out - in);
            };
            const glm::dvec3 at = ray.base + t * ray.direction;
            if (glm::length(at - below) > half || inBox(ray.base, ray.direction, ray.minT, t) > 0)
                continue; // beyond the quad, or fog before it
            const double past = glm::length(glm::cross(centre - at, towards)) / radius;
            if (std::abs(past - 1) < 0.02)
                continue;
            const double fog = inBox(at, towards, 0, 1e9);
            const double share = past < 1 ? 0 : std::exp(-kPerMm * fog);
            EXPECT_NEAR(native.at(x, y).g, 0.9 * (0.1 + 0.6 * towards.z * share), 0.012) << x << ", " << y;
            ++(past < 1 ? dark : fog > 0 ? fogged : open);
        }
    EXPECT_GT(dark, 5);
    EXPECT_GT(fogged, 30);
    EXPECT_GT(open, 50);
}

Scene torsoScene(int camera, const char* preset = "soft-tissue") {
    const VolumeInfo info = infoOf("torso");
    Scene scene = sceneOn(info, preset, camera, {53, 47});
    const glm::dvec3 middle = middleOf(info);
    scene.quality.stepVoxels = 1;
    scene.quality.terminationTransmittance = 1.0 / 510;
    scene.meshes = {meshOf(sphereMesh(middle + glm::dvec3(30, -100, 10), 70, 30), {0.9, 0.7, 0.1}, 0.5),
                    meshOf(sphereMesh(middle + glm::dvec3(-60, 20, -90), 60, 20), {0.1, 0.7, 0.9}),
                    ballOf(middle + glm::dvec3(160, 0, 120), 60, {0.5, 0.9, 0.5}, 0.3)};
    return scene;
}

TEST(MeshEngines, NativeHasTheMirrorsBits) {
    for (const int camera : {0, 1, 2})
        for (const int variant : {0, 1, 2, 3}) {
            Scene scene = torsoScene(camera, variant == 1 ? "bone-1" : "soft-tissue");
            if (variant == 1)
                scene.surfaces = {{200, {0.9, 0.8, 0.7}, 0.6}};
            if (variant == 2)
                scene.quality.integrator = Integrator::preintegrated, scene.quality.pixels.samples = 4;
            if (variant == 3)
                scene.cuts.boxes.push_back({middleOf(infoOf("torso")) - 55.0,
                                            middleOf(infoOf("torso")) + 75.0, CropBox::Space::patient,
                                            Keep::outside});
            const Image native = drawn(scene, EngineKind::native, "torso").image;
            EXPECT_EQ(differing(native, drawn(scene, EngineKind::mirror, "torso").image), 0u)
                << camera << variant;
            RenderOptions one;
            one.threads = 1;
            one.slicing.fixedIterations = 3;
            EXPECT_EQ(
                differing(native, drawn(scene, EngineKind::native, "torso", std::size_t{1} << 30, one).image),
                0u);
            scene.meshes.clear();
            EXPECT_GT(differing(native, drawn(scene, EngineKind::native, "torso").image), 100u);
        }
}

TEST(MeshEngines, PassesChangeNoBit) {
    Scene scene = torsoScene(0);
    scene.quality.maxError = 0;
    scene.quality.stepVoxels = 0.5;
    const RenderResult whole = drawn(scene, EngineKind::native, "torso");
    const RenderResult parts = drawn(scene, EngineKind::native, "torso", std::size_t{5} << 20);
    EXPECT_GT(parts.passes, 1);
    EXPECT_EQ(differing(whole.image, parts.image), 0u);
}

TEST(MeshEngines, TheGpuAndTheReferenceComeNear) {
    Scene scene = torsoScene(0);
    scene.quality.terminationTransmittance = 0;
    scene.quality.stepVoxels = 0.125;
    const Image mirror = drawn(scene, EngineKind::mirror, "torso").image;
    EXPECT_LE(largestDifference(drawn(scene, EngineKind::gpu, "torso").image, mirror), 1e-4);
    EXPECT_LE(largestDifference(drawn(scene, EngineKind::reference, "torso").image, mirror), 0.01);
}

// Rays of several volumes count in voxels of their own.
TEST(MeshEngines, SeveralVolumesHaveMeshesBetween) {
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30),
        gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader torso(storePath("torso"), ram), sphere(storePath("sphere"), ram);
    const StoreReader* const stores[] = {&torso, &sphere};
    Scene scene = torsoScene(0, "bone-1");
    scene.volumes.resize(2);
    scene.volumes[1].transferFunction =
        TransferFunction::fromExtinction({{-5000, kPerMm}, {5000, kPerMm}}, {{0, glm::vec3(kFogColour)}});
    const auto picture = [&](EngineKind engine) {
        RenderOptions options;
        options.engine = engine;
        return renderScene(scene, stores, ram, gpu, options).image;
    };
    const Image native = picture(EngineKind::native);
    EXPECT_EQ(differing(native, picture(EngineKind::mirror)), 0u);
    // The reference lies no further off than without meshes: those hide volume.
    const auto away = [](const Image& a, const Image& b) {
        double squares = 0;
        for (std::size_t n = 0; n < a.pixels.size(); ++n)
            squares += glm::dot(a.pixels[n] - b.pixels[n], a.pixels[n] - b.pixels[n]);
        return std::sqrt(squares / static_cast<double>(a.pixels.size()));
    };
    const double withMeshes = away(picture(EngineKind::reference), native);
    scene.meshes.clear();
    const Image without = picture(EngineKind::native);
    EXPECT_LE(withMeshes, 1.05 * away(picture(EngineKind::reference), without));
    EXPECT_GT(away(native, without), 1.5 * withMeshes);
}

// Rays that are drawn again meet the same meshes: without them, half of the picture would be wrong.
TEST(MeshErrors, AreMeasuredThroughMeshes) {
    Scene scene = torsoScene(0);
    scene.imageSize = {128, 112};
    scene.quality.pixels.samples = 8;
    RenderOptions options;
    options.verify = Verify::full;
    options.checking = true;
    const RenderResult result = drawn(scene, EngineKind::native, "torso", std::size_t{1} << 30, options);
    ASSERT_TRUE(result.measured);
    EXPECT_EQ(result.measured->whyNot, "");
    ASSERT_TRUE(result.measured->rays.rms);
    EXPECT_LT(result.measured->rays.rms->value, 0.01);
    scene.quality.maxError = 3;
    scene.quality.pixels.samples = PixelSampling::kAutomatic;
    const RenderResult within = drawn(scene, EngineKind::native, "torso", std::size_t{1} << 30, options);
    EXPECT_EQ(within.shortfall, "");
}

TEST(MeshCosts, ScenesWithoutMeshesPayNothing) {
    Scene scene = torsoScene(0);
    const auto meshes = scene.meshes;
    for (SceneMesh& mesh : scene.meshes)
        mesh.show = false;
    EXPECT_TRUE(drawnMeshes(scene).empty());
    const Prepared hidden("torso", scene);
    EXPECT_EQ(hidden.p.view.frame.cuts, nullptr);
    const RenderResult one = drawn(scene, EngineKind::native, "torso");
    scene.meshes.clear();
    const RenderResult none = drawn(scene, EngineKind::native, "torso");
    EXPECT_EQ(differing(one.image, none.image), 0u);
    EXPECT_EQ(one.work.samples, none.work.samples);
    scene.meshes = meshes;
    scene.mode = Mode::maximum;
    const RenderResult values = drawn(scene, EngineKind::native, "torso");
    scene.meshes.clear();
    EXPECT_EQ(differing(values.image, drawn(scene, EngineKind::native, "torso").image), 0u);
}

} // namespace
} // namespace tessera
