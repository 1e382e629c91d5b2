// The reference through store and sampler against closed forms, on anisotropic and sheared volumes. The
// mirror against the reference: the error falls at the rule's order as the step is halved.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "render/backends/reference/reference.h"
#include "tests/support/formula_source.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

namespace tessera {
namespace {

using namespace tessera::test;

/// Extent (16,16,n), spacing 0.5 x 0.9 x 2 mm, sheared in y as a tilted gantry shears.
VolumeInfo shearedInfo(int n) {
    VolumeInfo info;
    info.type = ValueType::f32;
    info.extentVoxels = {16, 16, n};
    info.patientFromVoxel = patientFromVoxelOf({-3, 5, 7}, {0.5, 0, 0}, {0, 0.9, 0}, {0, 0.6, 2});
    return info;
}

/// Imports a formula, integrates rays along the z voxel axis at x,y of the middle; gives one pixel.
class Stored {
  public:
    Stored(const VolumeInfo& info, const std::function<double(glm::dvec3)>& value) : info_(info) {
        FormulaSource source(info, value);
        ImportOptions options;
        options.force = true;
        importToStore(source, folder_ / "v.zarr", ram_, options);
        reader_ = std::make_unique<StoreReader>(folder_ / "v.zarr", ram_);
        cache_ = std::make_unique<BrickCache>(*reader_, ram_, std::size_t{64} << 20, 2);
    }
    glm::dvec4 alongZ(const TransferFunction& function) {
        ReferenceInput input{cache_.get(), &reader_->info(), &function, Shading{.on = false}, nullptr};
        ReferenceRay ray;
        ray.base = {8.3, 7.7, -5};
        ray.direction = glm::dvec3(0, 0, 1) / mmPerVoxel();
        ray.tMin = -1e9;
        return renderReference(input, {ray}, 1).at(0);
    }
    double mmPerVoxel() const { return glm::length(glm::dvec3(info_.patientFromVoxel[2])); }
    MemoryBudget ram_{"RAM", "--ram", std::size_t{512} << 20};
    VolumeInfo info_;
    const ScratchFolder folder_;
    std::unique_ptr<StoreReader> reader_;
    std::unique_ptr<BrickCache> cache_;
};

// T1, T7, T8 with flat half-voxel ends, to 1e-10: a ramp of 64 samples whose values are exact in float.
TEST(ReferenceThroughStore, RampsOnAnisotropicShearedVolumes) {
    constexpr int n = 64;
    const auto ramp = [](glm::dvec3 p) { return p.z / n; }; // (k + 1/2)/64
    Stored stored(shearedInfo(n), ramp);
    const double mm = stored.mmPerVoxel(), length = n * mm;
    const double first = 0.5 / n, last = (n - 0.5) / n; // beyond these centres the field is flat

    const auto constant = TransferFunction::fromExtinction({{0, 0.02}}, {{0, glm::dvec3(1)}});
    EXPECT_NEAR(stored.alongZ(constant).a, -std::expm1(-0.02 * length), 1e-10);

    const double s0 = 0.37, sigma = 0.05;
    const auto step = TransferFunction::fromExtinction({{0, 0}, {s0, 0}, {s0, sigma}, {1, sigma}}, {});
    EXPECT_NEAR(stored.alongZ(step).a, -std::expm1(-sigma * (1 - s0) * length), 1e-10);

    // T8: extinction kappa*u, colour u: flat ends integrate in closed form, the ramp between by erf.
    const double kappa = 0.03; // 1/mm at u = 1
    const auto linear =
        TransferFunction::fromExtinction({{0, 0}, {1, kappa}}, {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}});
    const double half = 0.5 * mm;
    const double t1 = kappa * first * half;     // depth of the front flat end
    const double rise = length * kappa;         // depth = rise * (u^2 - first^2) / 2
    const auto antiderivative = [&](double u) { // of rise u^2 exp(-rise u^2 / 2)
        return std::sqrt(std::numbers::pi / (2 * rise)) * std::erf(u * std::sqrt(rise / 2)) -
               u * std::exp(-rise * u * u / 2);
    };
    const double t2 = t1 + rise * (last * last - first * first) / 2;
    const double exact =
        first * -std::expm1(-t1) +
        std::exp(-t1 + rise * first * first / 2) * (antiderivative(last) - antiderivative(first)) +
        std::exp(-t2) * last * -std::expm1(-kappa * last * half);
    EXPECT_NEAR(stored.alongZ(linear).r, exact, 1e-10);
}

// T3 and T5 are not linear between samples: second order in the size of the grid.
TEST(ReferenceThroughStore, SmoothProfilesConvergeAtSecondOrder) {
    const auto identity = TransferFunction::fromExtinction({{0, 0}, {8, 8}}, {});
    const auto slope = [&](const std::function<double(double)>& profile, double exactDepth) {
        std::vector<double> errors;
        for (const int n : {16, 32, 64, 128}) {
            VolumeInfo info = shearedInfo(n);
            info.patientFromVoxel =
                patientFromVoxelOf({-3, 5, 7}, {0.5, 0, 0}, {0, 0.9, 0}, glm::dvec3(0, 0.6, 2) * (16.0 / n));
            Stored stored(info, [&](glm::dvec3 p) { return profile(p.z / n); });
            const double length = n * stored.mmPerVoxel();
            errors.push_back(std::abs(-std::log1p(-stored.alongZ(identity).a) - exactDepth * length));
        }
        return std::log2(errors.front() / errors.back()) / 3;
    };
    const double h = 0.3;
    // Flat ends replace the profile's slope there, which is second order too.
    EXPECT_NEAR(slope([&](double u) { return 0.2 * std::exp(-u / h); }, 0.2 * h * -std::expm1(-1 / h)), 2,
                0.15);
    const double s = 0.15;
    EXPECT_NEAR(slope([&](double u) { return 0.2 * std::exp(-(u - 0.5) * (u - 0.5) / (2 * s * s)); },
                      0.2 * s * std::sqrt(2 * std::numbers::pi) * std::erf(0.5 / (s * std::numbers::sqrt2))),
                2, 0.15);
}

// Row: mirror and reference: falls at the rule's order (2: midpoint), double, smooth function, rms over
// pixels.
TEST(MirrorAgainstReference, FallsAtSecondOrder) {
    // Marschner-Lobb under a function without a corner inside the data's range [0,1]: extinction linear in v,
    // no shading, and a table that is exact for linear functions. Rays lie in the interior on lattice lines
    // of z, so that the field's own kinks fall on segment ends for every step 1/2^k.
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const StoreReader reader(storePath("marschner-lobb"), ram);
    const VolumeInfo& info = reader.info();
    Scene scene = sceneOn(info, "auto", 1, {16, 16});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
        {{-1, 0}, {3, 0.0625}}, {{-1, glm::dvec3(0, 0.5, 1)}, {3, glm::dvec3(1, 0.25, 0)}});
    scene.shading.on = false;
    Prepared prepared("marschner-lobb", scene, false);
    Planner& p = prepared.p;
    const double mm = glm::length(glm::dvec3(info.patientFromVoxel[2]));
    std::vector<ReferenceRay> rays;
    for (int i = 0; i < 64; ++i)
        rays.push_back({{3.25 + 7.1 * (i % 8), 4.5 + 6.9 * (i / 8), 0.0}, glm::dvec3(0, 0, 1) / mm, 0});
    const auto exact =
        renderReference({p.layer().cache.get(), &info, &p.layer().function, scene.shading, nullptr}, rays, 0);
    // Two entries hold this function exactly, in float too; the usual table would put a floor of 3e-8 under
    // the rms.
    TransferTable table;
    table.firstValue = -1;
    table.entriesPerValue = 0.25f;
    table.entries = {glm::vec4(0, 0.5f, 1, 0), glm::vec4(1, 0.25f, 0, 0.0625f)};
    p.layer().optics = makeOptics(table, info, scene.shading, 0);
    const MirrorInput input = mirrorInput(p, false);
    std::vector<double> errors;
    for (double q = 0.5; q > 0.01; q /= 2) {
        Work work;
        const auto pixels = mirrorRays<double>(
            input, rays.size(),
            [&](std::size_t i) {
                SegmentedRay<double> ray;
                ray.entry = rays[i].base;
                ray.direction = {0, 0, 1};
                ray.step = ray.direction * q;
                ray.segmentMm = q * mm;
                ray.count = static_cast<int>(info.extentVoxels.z / q);
                return ray;
            },
            0, work);
        double squares = 0;
        for (std::size_t i = 0; i < rays.size(); ++i)
            for (int c = 0; c < 4; ++c)
                squares += std::pow(pixels[i][c] - exact[i][c], 2);
        errors.push_back(std::sqrt(squares / (4.0 * static_cast<double>(rays.size()))));
    }
    for (std::size_t i = 1; i < errors.size(); ++i) {
        RecordProperty("rms" + std::to_string(i), std::to_string(errors[i]));
        EXPECT_NEAR(std::log2(errors[i - 1] / errors[i]), 2, 0.15)
            << "rms " << errors[i - 1] << " then " << errors[i];
    }
}

// A whole lit picture of a phantom. The mirror's error against the reference falls with the step, down to the
// error of the transfer function's float table, which is known and reported.
TEST(MirrorAgainstReference, LitPictureConvergesToTheTablesOwnError) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const VolumeInfo info = StoreReader(storePath("sphere"), ram).info();
    std::vector<double> errors;
    for (const double q : {2.0, 1.0, 0.5, 0.125}) {
        Scene scene = sceneOn(info, "auto", 0, {24, 24});
        scene.quality.stepVoxels = q;
        Prepared prepared("sphere", scene, true);
        Planner& p = prepared.p;
        const MirrorInput input = mirrorInput(p, true);
        Work work;
        const auto pixels = mirrorRays<double>(input, 24 * 24, frameRays(p.view.frame), 0, work);
        const auto exact = renderReference(
            {p.layer().cache.get(), &info, &p.layer().function, scene.shading, &p.layer().statistics},
            referenceRays(p.view.camera, info, {24, 24}), 0);
        double squares = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i)
            for (int c = 0; c < 4; ++c)
                squares += std::pow(pixels[i][c] - exact[i][c], 2);
        errors.push_back(std::sqrt(squares / (4.0 * static_cast<double>(pixels.size()))));
        EXPECT_LT(p.layer().table.relativeError, 0.02);
    }
    EXPECT_LT(errors[1], 0.7 * errors[0]);
    EXPECT_LT(errors[2], 0.7 * errors[1]);
    EXPECT_LT(errors[3], 2e-5);
}

} // namespace
} // namespace tessera
