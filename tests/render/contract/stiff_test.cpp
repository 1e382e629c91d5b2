// tests/render/contract/stiff_test.cpp: guarantees of each integrator: its order for smooth or piecewise
// linear fields and functions, and its error for a step or a spike. No extinction, however large or small,
// makes it leave [0, full opacity] (closed forms T6, T11).
#include "render/backends/reference/reference.h"
#include "tests/support/bricking_test_volumes.h"
#include "tests/support/ray_quadrature.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr Integrator kIntegrators[] = {Integrator::midpoint, Integrator::linear, Integrator::preintegrated,
                                       Integrator::preintegrated2d};
const char* nameOf(Integrator i) {
    return integratorNames()[static_cast<std::size_t>(i)].c_str();
}

double largest(const glm::dvec4& a, const glm::dvec4& b) {
    double d = 0;
    for (int c = 0; c < 4; ++c)
        d = std::max(d, std::abs(a[c] - b[c]));
    return d;
}

/// Smooth extinction and colour, nowhere zero.
glm::dvec4 smoothEntry(double s) {
    const double x = (s - 0.55) / 0.25;
    return {s, 1 - s, 0.5 + 0.5 * std::sin(4 * s), 6 * std::exp(-x * x)};
}

/// A: a smooth field, not monotone.
LineField smoothField() {
    return {[](double t) { return 0.5 + 0.45 * std::sin(5 * t + 0.4); },
            {(0.5 * std::numbers::pi - 0.4) / 5, (1.5 * std::numbers::pi - 0.4) / 5}};
}
/// B: linear between 65 hashed values, as a ray along an axis sees voxels.
LineField cells() {
    std::vector<double> values;
    for (std::uint64_t i = 0; i < 65; ++i)
        values.push_back(0.1 + 0.8 * static_cast<double>(mixed(i + 1) >> 40) / double(1 << 24));
    LineField line;
    line.value = [values](double t) {
        const double x = std::clamp(t, 0.0, 1.0) * 64;
        const int i = std::min(static_cast<int>(x), 63);
        const auto at = static_cast<std::size_t>(i);
        return values[at] + (x - i) * (values[at + 1] - values[at]);
    };
    for (int i = 1; i < 64; ++i)
        line.breaks.push_back(i / 64.0);
    return line;
}

std::vector<double> errors(const TransferTable& table, const LineField& line, Integrator integrator,
                           const std::vector<int>& segments) {
    std::vector<double> out;
    glm::dvec4 exact(0);
    for (const int n : segments) {
        const Optics optics = lineOptics(table, integrator, 1.0 / n);
        if (out.empty())
            exact = trueIntegral(optics, line);
        out.push_back(largest(integrate<double>(optics, line, n), exact));
    }
    return out;
}

/// Least squares slope of log error against log segments, and monotone.
double slope(const std::vector<double>& e, const std::vector<int>& n) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < e.size(); ++i) {
        const double x = std::log2(n[i]), y = std::log2(e[i]);
        sx += x, sy += y, sxx += x * x, sxy += x * y;
        if (i > 0) {
            EXPECT_LT(e[i], e[i - 1]) << n[i] << " segments";
        }
    }
    const double count = static_cast<double>(e.size());
    return -(count * sxy - sx * sy) / (count * sxx - sx * sx);
}

void print(const char* scene, Integrator integrator, const std::vector<double>& e) {
    std::printf("%s, %s:", scene, nameOf(integrator));
    for (const double error : e)
        std::printf(" %.2e", error);
    std::printf("\n");
}

TEST(IntegratorOrder, SmoothFieldAndFunction) {
    const std::vector<int> segments = {16, 32, 64, 128, 256};
    const TransferTable table = tableOf(smoothEntry, 4096);
    for (const Integrator integrator : kIntegrators) {
        SCOPED_TRACE(nameOf(integrator));
        const std::vector<double> e = errors(table, smoothField(), integrator, segments);
        print("A", integrator, e);
        EXPECT_NEAR(slope(e, segments), 2, 0.15);
    }
}

TEST(IntegratorOrder, PiecewiseLinearField) {
    // From four segments a cell on: before, no rule sees what lies between two voxels.
    const std::vector<int> segments = {256, 512, 1024, 2048, 4096};
    const TransferTable table = tableOf(smoothEntry, 4096);
    for (const Integrator integrator : kIntegrators) {
        SCOPED_TRACE(nameOf(integrator));
        const std::vector<double> e = errors(table, cells(), integrator, segments);
        print("B", integrator, e);
        if (integrator == Integrator::preintegrated2d)
            // Every segment is linear: exact but for the table of colours, bilinear between 256 x 256 places.
            EXPECT_LE(*std::max_element(e.begin(), e.end()), 1e-5);
        else
            EXPECT_NEAR(slope(e, segments), 2, 0.15);
    }
}

// C: extinction is a step in the value. Sampled rules misplace each of the two crossings by up to half a
// segment; pre-integration knows where it lies and keeps its order.
TEST(IntegratorBound, StepFunction) {
    const std::vector<int> segments = {16, 64, 256, 1024};
    const double extinction = 6;
    const TransferTable table =
        tableOf([&](double s) { return glm::dvec4(1, 0.5, s, s < 0.4723 ? 0 : extinction); }, 4096);
    for (const Integrator integrator : kIntegrators) {
        SCOPED_TRACE(nameOf(integrator));
        const std::vector<double> e = errors(table, smoothField(), integrator, segments);
        print("C", integrator, e);
        for (std::size_t i = 0; i < e.size(); ++i)
            EXPECT_LE(e[i], 2 * extinction * 0.5 / segments[i]);
        if (integrator == Integrator::preintegrated || integrator == Integrator::preintegrated2d) {
            EXPECT_LE(e[2], 5e-5);
            EXPECT_NEAR(slope(e, segments), 2, 0.15);
        }
    }
}

// D: a tent 1/4096 wide across a ramp, by the function's own points (T9). Sixteen samples miss it wholly.
TEST(IntegratorBound, SpikeOfOneIn4096) {
    const double width = 1.0 / 4096, alpha = 0.336, at = 0.4371;
    const double peak = -std::log1p(-alpha) / (0.5 * width);
    const TransferTable table = makeTable(TransferFunction::fromExtinction(
        {{0, 0}, {at - width / 2, 0}, {at, peak}, {at + width / 2, 0}, {1, 0}},
        {{0, {0, 1, 0.5}}, {1, {1, 0, 0.5}}}));
    const LineField ramp{[](double t) { return t; }, {}};
    for (const Integrator integrator : kIntegrators) {
        SCOPED_TRACE(nameOf(integrator));
        std::printf("D, %s:", nameOf(integrator));
        std::vector<glm::dvec4> e;
        for (const int n : {16, 256, 4096, 16384}) {
            e.push_back(integrate<double>(lineOptics(table, integrator, 1.0 / n), ramp, n) -
                        glm::dvec4(at * alpha, (1 - at) * alpha, 0.5 * alpha, alpha));
            std::printf(" alpha %.1e, colour %.1e;", e.back().a, e.back().r);
        }
        std::printf("\n");
        if (integrator == Integrator::midpoint || integrator == Integrator::linear) {
            EXPECT_EQ(e[0].a, -alpha); // nothing of it
            EXPECT_LE(largest(e[3], glm::dvec4(0)), 1e-3);
            continue;
        }
        EXPECT_LE(std::abs(e[0].a), 1e-6);
        // The two-dimensional table has 256 places a side: it knows whether a segment crosses the spike, but
        // not to which of its places the colour belongs.
        EXPECT_LE(largest(e[0], glm::dvec4(0)), integrator == Integrator::preintegrated ? 1e-3 : 1e-2);
    }
}

/// T6: constant extinction, colour from c0 to c1: what is seen of it. x: optical depth.
double colourRamp(double x, double c0, double c1) {
    double ramp = -std::expm1(-x) / x - std::exp(-x);
    if (x < 0.5) { // by its series, which does not cancel
        ramp = 0;
        double term = 1;
        for (int k = 1; k < 24; ++k) {
            term *= -x / (k + 1);
            ramp -= term * k;
        }
    }
    return c0 * -std::expm1(-x) + (c1 - c0) * ramp;
}

constexpr int kVoxels = 64;

template <typename Real> void sweepStiffness(const char* type, double phiBound) {
    const LineField ramp{[](double t) { return t; }, {}};
    for (const Integrator integrator : kIntegrators) {
        std::printf("T6 in %s, %s:", type, nameOf(integrator));
        for (double perVoxel = 1e-6; perVoxel < 2e6; perVoxel *= 10) {
            SCOPED_TRACE(testing::Message() << nameOf(integrator) << ", " << perVoxel << " per voxel");
            const TransferTable table =
                tableOf([&](double s) { return glm::dvec4(0.2 + 0.7 * s, 1, 0, perVoxel); }, 1);
            const Optics optics = lineOptics(table, integrator, 1);
            const glm::dvec4 c = integrate<Real>(optics, ramp, kVoxels, kVoxels);
            // Extinction and colours as the table's floats have them.
            const double sigma = static_cast<double>(optics.table[0].a), depth = sigma * kVoxels;
            const double c0 = static_cast<double>(optics.table[0].r),
                         c1 = static_cast<double>(optics.table[1].r);
            const double exact = colourRamp(depth, c0, c1), alpha = -std::expm1(-depth);
            for (int n = 0; n < 4; ++n)
                ASSERT_TRUE(std::isfinite(c[n]));
            EXPECT_GE(c.a, 0);
            EXPECT_LE(c.a, 1); // no overshoot, not by a bit
            EXPECT_NEAR(c.a, alpha, 2e-6 * alpha);
            EXPECT_LE(c.g, c.a * (1 + 1e-6));
            const double relative = std::abs(c.r - exact) / exact;
            std::printf(" %.1e", relative);
            if (integrator == Integrator::linear) {
                EXPECT_LE(relative, phiBound);
            } else // one segment's change of colour, all of it in front at worst
                EXPECT_LE(std::abs(c.r - exact), alpha * 0.7 / kVoxels);
        }
        std::printf("\n");
    }
}

TEST(Stiff, ColourRampInDouble) {
    sweepStiffness<double>("double", 1e-9);
}
TEST(Stiff, ColourRampInFloat) {
    sweepStiffness<float>("float", 2e-6);
}

/// T11: extinction k/(t + epsilon). The field is 1/(t + epsilon), the function linear.
TEST(Stiff, BoundaryLayer) {
    for (double epsilon = 1e-1; epsilon > 0.5e-8; epsilon /= 10)
        for (const double k : {1e-3, 0.1, 1.0, 30.0}) {
            SCOPED_TRACE(testing::Message() << "epsilon " << epsilon << ", k " << k);
            // The arbiter, to 1e-10 of the transmittance's logarithm.
            ReferenceIntegrator reference;
            reference.add(0, 1, [&](double t) { return RadiantPoint{k / (t + epsilon), glm::dvec3(0.5)}; });
            const double depth = k * std::log((1 + epsilon) / epsilon);
            if (!reference.opaque()) {
                EXPECT_NEAR(reference.depth(), depth, 1e-10 * depth);
            }
            EXPECT_NEAR(reference.alpha(), -std::expm1(-depth), 1e-10);

            // Sixty-four even segments cannot see such a layer, but must stand it.
            const LineField layer{[&](double t) { return epsilon / (t + epsilon); }, {}};
            const TransferTable table =
                tableOf([&](double s) { return glm::dvec4(0.5, 1, 0, s * k / epsilon); }, 1);
            for (const Integrator integrator :
                 {Integrator::midpoint, Integrator::linear, Integrator::preintegrated}) {
                const Optics optics = lineOptics(table, integrator, 1.0 / 64);
                for (const glm::dvec4& c :
                     {integrate<double>(optics, layer, 64), integrate<float>(optics, layer, 64)}) {
                    EXPECT_TRUE(c.a >= 0 && c.a <= 1 && c.r >= 0 && c.r <= 0.5 * c.a * (1 + 1e-5))
                        << nameOf(integrator) << ": " << c.r << ", " << c.a;
                    // The midpoint rule sees too little of a function that is convex, the mean of ends too
                    // much.
                    if (integrator == Integrator::midpoint)
                        EXPECT_LE(c.a, -std::expm1(-depth) + 2e-6);
                    else
                        EXPECT_GE(c.a, -std::expm1(-depth) - 2e-6);
                }
            }
        }
}

/// The rules themselves are not at fault in a boundary layer: on segments that grow with the distance from
/// the wall they are of second order down to epsilon = 1e-8.
TEST(Stiff, BoundaryLayerOnGradedSegments) {
    const double epsilon = 1e-8, k = 0.1, depth = k * std::log((1 + epsilon) / epsilon);
    const TransferTable table = tableOf([&](double s) { return glm::dvec4(0.5, 1, 0, s * k / epsilon); }, 1);
    const std::vector<int> segments = {64, 128, 256, 512, 1024};
    for (const Integrator integrator :
         {Integrator::midpoint, Integrator::linear, Integrator::preintegrated}) {
        SCOPED_TRACE(nameOf(integrator));
        const Optics optics = lineOptics(table, integrator, 1);
        std::vector<double> e;
        for (const int n : segments) {
            double alpha = 0;
            const auto at = [&](double i) { return epsilon * std::expm1(i / n * std::log1p(1 / epsilon)); };
            const auto end = [&](double t) { return endOf(optics, epsilon / (t + epsilon)); };
            for (int i = 0; i < n; ++i) {
                const double a = at(i), b = at(i + 1), middle = 0.5 * (a + b);
                const bool ends = needsEnds(integrator);
                const double extinction =
                    segmentExtinction(optics, end(ends ? a : middle), end(ends ? b : middle));
                alpha += (1 - alpha) * opacityOf(extinction * (b - a));
            }
            e.push_back(std::abs(alpha - -std::expm1(-depth)));
        }
        print("T11", integrator, e);
        EXPECT_NEAR(slope(e, segments), 2, 0.15);
    }
}

/// T6 on the GPU, and by the mirror through a store: voxels whose values are their numbers, seen along the
/// axis.
TEST(Stiff, ColourRampOnTheGpu) {
    const GlContext context({"software"});
    const ScratchFolder folder;
    VolumeInfo info;
    info.extentVoxels = {3, 3, kVoxels};
    info.type = ValueType::f32;
    info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    {
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        ImportOptions options;
        options.durable = false;
        HashSource source(info, [](int, int, int z) { return z + 0.5; });
        importToStore(source, folder / "ramp.zarr", ram, options);
    }
    for (const Integrator integrator : kIntegrators) {
        std::printf("T6 on the GPU, %s:", nameOf(integrator));
        for (double perVoxel = 1e-6; perVoxel < 2e6; perVoxel *= 10) {
            SCOPED_TRACE(testing::Message() << nameOf(integrator) << ", " << perVoxel << " per voxel");
            Scene scene = sceneOn(info, "auto", 0, {4, 3});
            scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
                {{0, perVoxel}, {kVoxels, perVoxel}}, {{0, {0.2, 1, 0}}, {kVoxels, {0.9, 1, 0}}});
            scene.shading.on = false;
            scene.quality.integrator = integrator;
            scene.quality.stepVoxels = 0.5; // so that the flat half voxels at both ends are segments
            Camera camera;
            camera.projection = Projection::parallel;
            camera.position = {1, 1, -100};
            camera.focalPoint = {1, 1, 0};
            camera.viewUp = {0, 1, 0};
            camera.parallelScale = 1;
            scene.camera = camera;
            Prepared prepared((folder / "ramp").string(), scene);
            Planner& p = prepared.p;
            const GpuPicture gpu = marchOn(prepared, marchFeatures(p, true));
            const auto truth = renderReference(
                {p.layer().cache.get(), &p.info(), &p.layer().function, scene.shading, &p.layer().statistics},
                referenceRays(p.view.camera, p.info(), p.view.imageSize), 1);
            double worst = 0;
            for (std::size_t i = 0; i < truth.size(); ++i) {
                const glm::dvec4 c(gpu.image.pixels[i]);
                ASSERT_TRUE(std::isfinite(c.r) && c.a >= 0 && c.a <= 1 && c.g <= c.a * (1 + 1e-6));
                EXPECT_NEAR(c.a, truth[i].a, 2e-6 * truth[i].a);
                EXPECT_LE(std::abs(c.r - truth[i].r), truth[i].a * 0.7 / kVoxels);
                worst = std::max(worst, std::abs(c.r - truth[i].r) / truth[i].r);
            }
            std::printf(" %.1e", worst);
            if (integrator == Integrator::linear) {
                EXPECT_LE(worst, 2e-6);
            }
        }
        std::printf("\n");
    }
}

} // namespace
} // namespace tessera
