// tests/render/contract/gates_test.cpp: the tolerances between GPU ray caster and mirror detect faults in
// every kind of scene. Each tolerance is absolute, and does not follow a scene's own rounding. A picture
// whose field is half a voxel off, along any axis, fails each of them.
#include "core/image/image_metrics.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

/// Same operations in the same order on the same rays: what remains is the driver's square root.
constexpr double kExactGate = 1e-5;

struct GateCase {
    const char* name;
    const char* preset; // "": nothing of the volume shows
    int camera;
    bool lit, mixed, surfaces;
    Integrator integrator = Integrator::midpoint;
    EdgeFunction edge = EdgeFunction::split;
    Sampling sampling = Sampling::limited;
};
std::ostream& operator<<(std::ostream& out, const GateCase& c) {
    return out << c.name;
}
std::string nameOf(const testing::TestParamInfo<GateCase>& info) {
    return info.param.name;
}

std::unique_ptr<Prepared> prepare(const GateCase& c) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Scene scene = sceneOn(info, c.preset, c.camera, {24, 24});
    if (*c.preset == '\0')
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
    scene.shading.on = c.lit;
    scene.quality.integrator = c.integrator;
    scene.quality.edgeFunction = c.edge;
    scene.quality.sampling = c.sampling;
    if (c.surfaces)
        scene.surfaces = {{-300, {0.9, 0.6, 0.5}, 0.3}, {250, {0.95, 0.9, 0.8}, 1}};
    auto prepared = std::make_unique<Prepared>("torso", scene);
    if (c.mixed)
        prepared->p.setSelection(randomShownLevels(prepared->p.layer().selection, 7));
    return prepared;
}

double largestDifference(const Image& a, const Image& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c)
            largest = std::max(
                largest, std::abs(static_cast<double>(a.pixels[i][c]) - static_cast<double>(b.pixels[i][c])));
    return largest;
}

class Gates : public testing::TestWithParam<GateCase> {
  protected:
    void SetUp() override {
        prepared = prepare(GetParam());
        rays = gpuRays(prepared->p.view.frame, prepared->budgets.gpu);
    }
    RaySource<float> shifted(const glm::vec3& shift) const {
        return [this, shift](std::size_t i) {
            SegmentedRay<float> ray = rays[i];
            ray.entry += shift;
            return ray;
        };
    }
    Image mirrored(const glm::vec3& shift, int threads = 0) {
        Work work;
        Image image(glm::ivec2(24));
        image.pixels =
            mirrorRays<float>(mirrorInput(prepared->p, true), rays.size(), shifted(shift), threads, work);
        segments = work.segments;
        return image;
    }
    const GlContext context{GlDeviceChoice{"software"}};
    std::unique_ptr<Prepared> prepared;
    std::vector<SegmentedRay<float>> rays;
    std::uint64_t segments = 0;
};

INSTANTIATE_TEST_SUITE_P(
    Scenes, Gates,
    testing::Values(GateCase{"uniform", "soft-tissue", 2, false, false, false},
                    GateCase{"uniformLit", "bone-1", 0, true, false, false, Integrator::preintegrated},
                    GateCase{"mixed", "soft-tissue", 2, false, true, false, Integrator::linear},
                    GateCase{"mixedLit", "bone-1", 0, true, true, false, Integrator::midpoint,
                             EdgeFunction::maximum},
                    GateCase{"mixedNaive", "soft-tissue", 0, true, true, false, Integrator::preintegrated2d,
                             EdgeFunction::minimum, Sampling::naive},
                    GateCase{"mixedNearest", "soft-tissue", 0, true, true, false, Integrator::midpoint,
                             EdgeFunction::nearest, Sampling::full},
                    GateCase{"surfacesAlone", "", 2, true, false, true},
                    GateCase{"surfaces", "soft-tissue", 0, true, false, true, Integrator::preintegrated},
                    GateCase{"surfacesMixed", "soft-tissue", 0, true, true, true, Integrator::preintegrated}),
    nameOf);

TEST_P(Gates, ExactFetchesMeetTheMirrorAndAHalfVoxelShiftDoesNot) {
    Drawn drawn;
    if (GetParam().surfaces)
        drawn = draw(*prepared);
    else {
        GpuPicture picture = marchOn(*prepared, marchFeatures(prepared->p, true));
        drawn = {std::move(picture.image), {}, picture.work};
    }
    EXPECT_FALSE(isBlank(drawn.image));
    const Image mirror = mirrored(glm::vec3(0));
    EXPECT_EQ(segments, drawn.work.segments);
    EXPECT_LE(largestDifference(drawn.image, mirror), kExactGate);
    const auto hits =
        mirrorHits<float>(mirrorInput(prepared->p, true), rays.size(), shifted(glm::vec3(0)), 0);
    if (GetParam().surfaces) {
        EXPECT_EQ(drawn.hits, hits);
    }
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 shift(0);
        shift[axis] = 0.5f;
        EXPECT_GT(largestDifference(drawn.image, mirrored(shift)), 100 * kExactGate) << "axis " << axis;
    }
}

// OpenImageIO's gate, as the finest level meets it (Contract.HardwareFetchStaysInsideTheGate).
TEST_P(Gates, FilteredFetchesMeetTheMirrorAndAHalfVoxelShiftDoesNot) {
    Planner& p = prepared->p;
    OnDevice device(*prepared);
    GpuCaster caster(p, device.engine, marchFeatures(p, true) | kFeatureHardware, prepared->budgets.gpu);
    Work work;
    drawToTheEnd(caster, device.engine, p, {}, work);
    const auto passes = [&](const Image& mirror) {
        const ImageDifference d = compare(caster.image(), mirror);
        return d.nonFinite == 0 && d.valuesAbove012 == 0 &&
               static_cast<double>(d.valuesAbove004) <= 0.0002 * static_cast<double>(d.values);
    };
    const Image mirror = mirrored(glm::vec3(0));
    EXPECT_TRUE(passes(mirror)) << compare(caster.image(), mirror).maxAbs;
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 shift(0);
        shift[axis] = 0.5f;
        EXPECT_FALSE(passes(mirrored(shift))) << "axis " << axis;
    }
}

TEST_P(Gates, ThreadsChangeNoBitOfTheMirror) {
    const Image one = mirrored(glm::vec3(0), 1);
    EXPECT_TRUE(bitEqual(one, mirrored(glm::vec3(0), 2)));
    EXPECT_TRUE(bitEqual(one, mirrored(glm::vec3(0), 5)));
}

} // namespace
} // namespace tessera
