// tests/render/backends/splat/splat_footprint_test.cpp: footprints of kernels, by numerical integration of
// the Gaussian along rays and by sums over pixels; the choice of filters.
#include "render/backends/splat/sheet_tiles.h"
#include "render/backends/splat/splat_filter.h"
#include "render/backends/splat/splat_projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace tessera::test {
namespace {

constexpr glm::ivec2 kSize{128, 96};
constexpr double kMassMm2 = 0.5; // of the splat: so little that 1 - e^-q tells q

/// A lattice whose voxels are turned, anisotropic and sheared.
VolumeInfo lattice(int kind) {
    VolumeInfo info;
    info.extentVoxels = {40, 40, 40};
    glm::dmat4 m(1);
    if (kind >= 1)
        m = glm::rotate(m, 0.7, glm::dvec3(0.3, 1, -0.4));
    if (kind >= 2)
        for (int axis = 0; axis < 3; ++axis)
            m[axis] *= std::array{0.6, 1.0, 2.2}[static_cast<std::size_t>(axis)];
    if (kind == 3)
        m[2] += 0.5 * m[0] - 0.3 * m[1];
    info.patientFromVoxel = m;
    return info;
}

struct OneSplat {
    VolumeInfo info;
    Camera camera;
    SplatView view;
    glm::dvec3 voxel{20, 21, 18}, u;

    OneSplat(int kind, Projection projection, double mmAside, double distance) : info(lattice(kind)) {
        const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(voxel, 1));
        camera.projection = projection;
        camera.position = middle + glm::dvec3(0.2, -distance, 0.1 * distance);
        camera.focalPoint = middle + glm::dvec3(mmAside, 0, -0.4 * mmAside);
        camera.viewAngle = 30;
        camera.parallelScale = 8;
        view = splatView(camera, info, kSize);
        u = view.place(voxel);
    }
    DrawnSplat splat(const SplatSettings& settings, SplatFilter filter) const {
        DrawnSplat s;
        EXPECT_TRUE(filtered(footprintOf(view.perspective, static_cast<float>(view.scale),
                                         glm::vec2(view.middle), glm::vec3(u), view.kernel(settings.sigma)),
                             filter, FilterNumbers(settings), static_cast<float>(kMassMm2), s));
        s.red = s.green = s.blue = 1;
        return s;
    }
};

/// Optical depths of a picture that one splat makes.
std::vector<double> drawn(const DrawnSplat& splat, float cutOff) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    SheetTiles tiles(kSize, 0, cutOff, SplatComposition::sheet, ram);
    for (std::size_t tile = 0; tile < tiles.count(); ++tile)
        tiles.draw(tile, 0, std::span(&splat, 1));
    std::vector<double> depths;
    for (const glm::vec4& pixel : tiles.picture().pixels)
        depths.push_back(-std::log1p(-double{pixel.a}));
    return depths;
}

/// The Gaussian's integral along the ray through a point of the picture, mm^-2, by Simpson's rule.
double alongRay(const OneSplat& v, double sigma, const glm::dvec2& pixel) {
    const glm::dmat3 kernel = v.view.axes * sigma;
    const glm::dmat3 inverse = glm::inverse(kernel * glm::transpose(kernel));
    const glm::dvec2 at = (pixel - v.view.middle) / v.view.scale;
    const glm::dvec3 base = v.view.perspective ? glm::dvec3(0) : glm::dvec3(at, 0);
    const glm::dvec3 direction = v.view.perspective ? glm::normalize(glm::dvec3(at, 1)) : glm::dvec3(0, 0, 1);
    const double middle = glm::dot(v.u - base, direction), reach = 8 * sigma * v.view.deviations.z;
    constexpr int kSteps = 400;
    double sum = 0;
    for (int n = 0; n <= kSteps; ++n) {
        const glm::dvec3 d = base + (middle + reach * (2.0 * n / kSteps - 1)) * direction - v.u;
        sum += (n % kSteps == 0 ? 1 : n % 2 ? 4 : 2) * std::exp(-0.5 * glm::dot(d, inverse * d));
    }
    const double normal = std::sqrt(std::pow(2 * std::numbers::pi, 3)) * std::abs(glm::determinant(kernel));
    return sum * 2 * reach / kSteps / 3 / normal;
}

TEST(SplatFootprints, SumsOverPixelsAreTheKernelsMass) {
    SplatSettings settings;
    for (int kind = 0; kind < 4; ++kind)
        for (const Projection projection : {Projection::perspective, Projection::parallel})
            for (const SplatFilter filter : {SplatFilter::reconstruction, SplatFilter::full}) {
                const OneSplat v(kind, projection, 3, 25);
                double sum = 0;
                for (const double q : drawn(v.splat(settings, filter), 3))
                    sum += q;
                const double j = projection == Projection::parallel
                                     ? v.view.scale * v.view.scale
                                     : v.view.scale * v.view.scale * glm::length(v.u) / std::pow(v.u.z, 3);
                EXPECT_NEAR(sum / (kMassMm2 * j), 1, 1e-3) << kind << " " << static_cast<int>(filter);
            }
}

// The linearised projection errs by the kernel's size over its distance.
TEST(SplatFootprints, AreTheGaussiansIntegralsAlongRays) {
    SplatSettings settings;
    settings.cutOff = 3;
    const double kept = -std::expm1(-4.5);
    for (int kind = 0; kind < 4; ++kind)
        for (const auto& [projection, distance, within] : {std::tuple(Projection::parallel, 300.0, 2e-5),
                                                           std::tuple(Projection::perspective, 300.0, 1e-3),
                                                           {Projection::perspective, 3000.0, 1e-3}}) {
            OneSplat v(kind, projection, 0.2 * distance * (projection == Projection::perspective), distance);
            if (projection == Projection::perspective) { // the same size in pixels, 12 degrees off the axis
                v.view.scale *= distance / 15;
                v.view.middle -= v.view.scale / v.u.z * glm::dvec2(v.u) - glm::dvec2(kSize) / 2.0;
            }
            const DrawnSplat s = v.splat(settings, SplatFilter::reconstruction);
            const std::vector<double> q = drawn(s, 3);
            double worst = 0;
            const double peak = kMassMm2 * alongRay(v, settings.sigma, {s.x, s.y});
            int compared = 0;
            for (int y = 0; y < kSize.y; ++y)
                for (int x = 0; x < kSize.x; ++x) {
                    const double drawnHere = q[static_cast<std::size_t>(y * kSize.x + x)] * kept;
                    if (!(drawnHere > 0))
                        continue;
                    ++compared;
                    worst = std::max(worst, std::abs(drawnHere - kMassMm2 * alongRay(v, settings.sigma,
                                                                                     {x + 0.5, y + 0.5})));
                }
            EXPECT_GT(compared, 20);
            EXPECT_LT(worst / peak, within) << kind << ", compared " << compared;
        }
}

TEST(SplatFootprints, DeviationsAreSingularValues) {
    const glm::dvec3 plain = singularValues(glm::dmat3(lattice(2).patientFromVoxel));
    EXPECT_NEAR(plain.x, 0.6, 1e-12);
    EXPECT_NEAR(plain.y, 1, 1e-12);
    EXPECT_NEAR(plain.z, 2.2, 1e-12);
    const glm::dmat3 sheared(lattice(3).patientFromVoxel);
    const glm::dvec3 s = singularValues(sheared);
    EXPECT_NEAR(s.x * s.y * s.z, std::abs(glm::determinant(sheared)), 1e-12);
    EXPECT_GT(s.z, 2.2);
    EXPECT_LT(s.x, 0.6);
    EXPECT_EQ(singularValues(glm::dmat3(3)), glm::dvec3(3));
}

// Where a patch changes its filter, the other one is nearly it.
TEST(SplatFilters, ChangeWhereTheOtherIsNear) {
    const OneSplat v(0, Projection::perspective, 0, 100);
    const SplatSettings settings;
    const FilterDepths depths = FilterDepths::of(v.view, settings, 0);
    EXPECT_NEAR(depths.farthest / depths.nearest, 2.287 / 0.3, 2e-3); // at 30 degrees, as the paper has it
    EXPECT_EQ(FilterDepths::of(v.view, settings, 2).nearest, 4 * depths.nearest);
    const double onlyNear[] = {0.5 * depths.nearest, 0.9 * depths.nearest, depths.nearest * 0.8, 1},
                 across[] = {0.5 * depths.nearest, 1.1 * depths.nearest, 1, 1},
                 far[] = {1.1 * depths.farthest, 2 * depths.farthest, 3 * depths.farthest, 1e6};
    EXPECT_EQ(depths.choose(onlyNear), SplatFilter::reconstruction);
    EXPECT_EQ(depths.choose(across), SplatFilter::full);
    EXPECT_EQ(depths.choose(far), SplatFilter::lowPass);
    const auto pixels = [&](double depth) { return settings.sigma * v.view.scale / depth; };
    EXPECT_NEAR(settings.lowPass / pixels(depths.nearest), 0.3, 1e-6);
}

TEST(SplatFilters, FootprintsWithoutAreaAreLeftOut) {
    Footprint flat{{8, 8}, 1, 1, 1, 1};
    DrawnSplat s;
    const FilterNumbers numbers{SplatSettings()};
    EXPECT_FALSE(filtered(flat, SplatFilter::reconstruction, numbers, 1, s));
    EXPECT_TRUE(filtered(flat, SplatFilter::full, numbers, 1, s));
    EXPECT_TRUE(filtered(flat, SplatFilter::lowPass, numbers, 1, s));
}

} // namespace
} // namespace tessera::test
