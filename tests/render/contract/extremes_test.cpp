// tests/render/contract/extremes_test.cpp: every pair of nasty conditions (extreme_cases.h) and 500 random
// mixes of them. Pictures are finite, in range and equal to the mirror's. Their work is bounded, and their
// error against the true integral is as expected from the step.
//
// A failure prints TESSERA_EXTREME_CASE=...: with that in the environment, Extremes.OneCase draws it alone.
#include "render/backends/reference/reference.h"
#include "render/picture/render_scene.h"
#include "tests/support/extreme_cases.h"

#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>
#include <optional>
#include <sstream>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr int kShards = 4; // test cases, so that ctest may run them beside each other
constexpr int kRandomCases = 500;

/// Largest and rms difference of two pictures' components.
struct PictureDifference {
    double largest = 0, squares = 0;
    void add(double difference) {
        // A NaN must not vanish in a comparison.
        largest = std::isnan(difference) ? INFINITY : std::max(largest, std::abs(difference));
        squares += difference * difference;
    }
};
template <typename A, typename B>
PictureDifference differenceOf(const std::vector<A>& a, const std::vector<B>& b) {
    PictureDifference d;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 4; ++c)
            d.add(static_cast<double>(a[i][c]) - static_cast<double>(b[i][c]));
    return d;
}

SegmentedRay<double> inDouble(const SegmentedRay<float>& r) {
    SegmentedRay<double> d;
    d.entry = r.entry, d.step = r.step, d.direction = r.direction;
    d.segmentMm = static_cast<double>(r.segmentMm), d.tail = static_cast<double>(r.tail);
    d.count = r.count;
    return d;
}

/// Random levels that keep what is proven empty.
Selection randomShownLevels(const Selection& like, unsigned seed) {
    std::mt19937 random(seed);
    Selection s = like;
    s.counts = {};
    for (std::uint8_t& mine : s.levels) {
        if (mine != Selection::kEmpty)
            mine = static_cast<std::uint8_t>(random() % kLevelCount);
        ++s.counts[mine];
    }
    return s;
}

/// The counts of a run's cases; a test that compared nothing must fail.
struct Tally {
    int cases = 0, visible = 0, equal = 0, filtered = 0, skipping = 0, constant = 0;
    double worstMarch = 0; // largest difference of GPU ray caster and float mirror
};

/// Double mirror of a camera's own double rays.
std::vector<glm::dvec4> mirrorInDouble(const FramePlan& p, double stepVoxels) {
    RayFrame<double> frame = p.view.frame;
    frame.segmentVoxels = stepVoxels;
    MirrorInput input = mirrorInput(p, p.view.quality.skipping);
    input.strides.segmentVoxels = stepVoxels;
    Work work;
    return mirrorRays<double>(input, static_cast<std::size_t>(p.view.imageSize.x) * p.view.imageSize.y,
                              frameRays(frame), 1, work);
}

class ExtremeRun {
  public:
    void draw(const ExtremeCase& c, Tally& tally) {
        const ExtremeVolume volume = volumeOf(c);
        const Structure& structure = c.structure();
        const Scene scene = sceneOf(c, volume);
        Prepared prepared(stores_.path(c), scene, true, 0, &volume.info.patientFromVoxel);
        Planner& p = prepared.p;
        if (structure.mixed) {
            p.setSelection(randomShownLevels(p.layer().selection, static_cast<unsigned>(c[kVariant] + 7)));
            if (!p.layer().mixed()) // few bricks: the general path all the same
                p.mapLevels(true);
        }
        ++tally.cases;

        Slicing slicing; // fixed, so that the number of dispatches can be said beforehand
        slicing.fixedTile = 64;
        slicing.fixedIterations = 512;
        const GpuPicture gpu = marchOn(prepared, marchFeatures(p, true), slicing);
        const std::vector<glm::dvec4> marched = widened(gpu.image.pixels);
        expectInRange(marched, scene, "march");
        const std::vector<SegmentedRay<float>> rays = gpuRays(p.view.frame, prepared.budgets.gpu);
        expectRaysOfCamera(p, rays);
        std::size_t segments = 0, longest = 0;
        for (const SegmentedRay<float>& ray : rays) {
            segments += static_cast<std::size_t>(ray.count);
            longest = std::max(longest, static_cast<std::size_t>(ray.count));
        }
        // A turn either takes a stride or finds out how to: two a stride at most.
        EXPECT_LE(gpu.work.iterations, 2 * segments + rays.size());
        // A dispatch also ends where the turns of all its loops are spent (kMostTurns of sampler_atlas.glsl):
        // a stride between levels, lit by Sobel's gradient, takes some 500 of its 3700.
        EXPECT_LE(gpu.work.dispatches, longest / 4 + 2);
        EXPECT_LE(gpu.work.segments, segments);
        for (const glm::dvec4& pixel : marched)
            if (pixel.a > 0) {
                ++tally.visible;
                break;
            }

        const MirrorInput input = mirrorInput(p, structure.skipping);
        Work work, unused;
        const auto single = mirrorRays<float>(
            input, rays.size(), [&](std::size_t i) { return rays[i]; }, 1, work);
        expectInRange(widened(single), scene, "float mirror");
        if (structure.skipping && !volume.beyondFloat) { // skipping never changes the picture
            EXPECT_EQ(single, mirrorRays<float>(
                                  mirrorInput(p, false), rays.size(), [&](std::size_t i) { return rays[i]; },
                                  1, unused));
            ++tally.skipping;
        }
        const auto exact = mirrorRays<double>(
            input, rays.size(), [&](std::size_t i) { return inDouble(rays[i]); }, 1, unused);
        expectInRange(exact, scene, "double mirror");
        if (structure.fetch == Fetch::exact) {
            // SAMPLING's rule; the slack is what the driver's square root and the order of a dot product may
            // add where float and double happen to agree.
            constexpr double kSlack = 2e-6;
            const PictureDifference march = differenceOf(gpu.image.pixels, single),
                                    rounding = differenceOf(single, exact);
            EXPECT_LE(march.largest, 4 * rounding.largest + kSlack);
            tally.worstMarch = std::max(tally.worstMarch, march.largest);
            ++tally.equal;
        }
        if (structure.fetch == Fetch::hardware && isWide(c) && !structure.shading && !volume.beyondFloat &&
            peakPerVoxel(c) <=
                1) { // OpenImageIO's gate, where a small error of a value is one of the picture
            EXPECT_LE(differenceOf(gpu.image.pixels, single).largest, 0.012);
            ++tally.filtered;
        }
        if (isConstant(c) && !structure.shading) {
            // Any step, level and integrator is exact here (T1), on the rays as they are: what remains is
            // what the products of n floats lose.
            const double termination = structure.termination ? 1.0 / 510 : 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const double alpha = constantAlpha(p, inDouble(rays[i]));
                ASSERT_NEAR(marched[i].a, alpha, termination + 1e-5) << "pixel " << i;
                ASSERT_NEAR(exact[i].a, alpha, termination + 1e-12) << "pixel " << i;
            }
            ++tally.constant;
        }
    }

    /// CPU only: the double mirror against the true integral, on the camera's double rays. False where the
    /// case lets expect nothing: then nothing was done.
    bool compareWithReference(const ExtremeCase& c) {
        const ExtremeVolume volume = volumeOf(c);
        Scene scene = sceneOf(c, volume);
        const double q = scene.quality.stepVoxels;
        // Halving tells something where the function is wide and a step thin. Nearest bricks' fields jump.
        const bool halving = isWide(c) && q <= 1 && peakPerVoxel(c) * q <= 1 &&
                             scene.quality.edgeFunction != EdgeFunction::nearest;
        if (volume.beyondFloat || c.structure().shading || (!isConstant(c) && !halving))
            return false;
        if (halving)
            scene.imageSize = {12, 10}; // a single ray may be right by chance
        scene.quality.terminationTransmittance = 0;
        Prepared prepared(stores_.path(c), scene, true, 0, &volume.info.patientFromVoxel);
        const FramePlan& p = prepared.p;
        const std::vector<glm::dvec4> truth = renderReference(
            {p.layer().cache.get(), &p.info(), &p.layer().function, scene.shading, &p.layer().statistics},
            referenceRays(p.view.camera, p.info(), p.view.imageSize), 1);
        expectInRange(truth, scene, "reference");
        const auto mirror = mirrorInDouble(p, q);
        const std::vector<double> uncertain = uncertainInDouble(p);
        if (isConstant(c)) { // the table's floats are off by 2^-24 of a depth, so by 2^-24/e of alpha at most
            for (std::size_t i = 0; i < truth.size(); ++i)
                for (int n = 0; n < 4; ++n)
                    EXPECT_NEAR(mirror[i][n], truth[i][n],
                                1e-7 + static_cast<double>(p.layer().optics.table.front().a) * uncertain[i])
                        << "pixel " << i;
            return true;
        }
        const auto halved = mirrorInDouble(p, q / 2);
        PictureDifference change, error;
        for (std::size_t i = 0; i < truth.size(); ++i)
            for (int n = 0; n < 4; ++n)
                if (peakPerVoxel(c) * uncertain[i] < 1e-9 * voxelMm(p.info())) {
                    change.add(mirror[i][n] - halved[i][n]);
                    error.add(halved[i][n] - truth[i][n]);
                }
        // A rule of first order errs by as much as halving changes it, one of second order by a third of
        // that. Pictures of few pixels may err by half of it more. The table is off by its own known error,
        // in depth at most the same share of the longest ray's. A table of two-dimensional pre-integration is
        // bilinear between 256 x 256 places; these functions' colours bend little there.
        const double ownError = p.layer().table.relativeError +
                                (p.layer().optics.integrator == Integrator::preintegrated2d ? 1e-4 : 1e-6);
        const double n = 4.0 * static_cast<double>(truth.size());
        const double depth = std::min(1.0, peakPerVoxel(c) * glm::length(glm::dvec3(p.info().extentVoxels)));
        EXPECT_LE(std::sqrt(error.squares / n), 1.5 * std::sqrt(change.squares / n) + ownError * depth);
        return true;
    }

  private:
    static double lengthMm(const SegmentedRay<double>& ray) {
        return ray.count == 0 ? 0 : (ray.count - 1 + ray.tail) * ray.segmentMm;
    }
    static double constantAlpha(const FramePlan& p, const SegmentedRay<double>& ray) {
        return opacityOf(static_cast<double>(p.layer().optics.table.front().a) * lengthMm(ray));
    }
    /// Per pixel, the part of a ray's length in the volume, mm, that changes if the ray moves by so many
    /// voxels. It is the whole length for a ray that lies in a face.
    static std::vector<double> uncertainLengths(const FramePlan& p, double voxels) {
        std::vector<double> out(static_cast<std::size_t>(p.view.imageSize.x) *
                                static_cast<std::size_t>(p.view.imageSize.y));
        const auto rays = frameRays(p.view.frame);
        for (int direction = 0; direction < 27; ++direction) {
            RayFrame<double> moved = p.view.frame;
            moved.centre +=
                voxels * (glm::dvec3(direction % 3, direction / 3 % 3, direction / 9) - glm::dvec3(1));
            const auto movedRays = frameRays(moved);
            for (std::size_t i = 0; i < out.size(); ++i)
                out[i] = std::max(out[i], std::abs(lengthMm(movedRays(i)) - lengthMm(rays(i))));
        }
        return out;
    }
    /// Of a camera in patient space, in double.
    static std::vector<double> uncertainInDouble(const FramePlan& p) {
        const glm::dmat4& place = p.info().patientFromVoxel;
        const glm::dvec3 mm = p.info().spacingMm();
        return uncertainLengths(
            p, 1e-14 * glm::length(glm::dvec3(p.info().extentVoxels)) +
                   1e-15 * (glm::length(glm::dvec3(place[3])) + glm::length(p.view.camera.position)) /
                       std::min({mm.x, mm.y, mm.z}));
    }
    /// The GPU's float rays are the camera's: their lengths, as far as float positions can say.
    static void expectRaysOfCamera(const FramePlan& p, const std::vector<SegmentedRay<float>>& rays) {
        const RayFrame<double>& f = p.view.frame;
        const double far = glm::length(f.centre) + glm::length(f.right) + glm::length(f.up) +
                           glm::length(f.extent) + (f.perspective ? glm::length(f.toCentre) : 0);
        const std::vector<double> uncertain = uncertainLengths(p, 0x1p-21 * far);
        // A direction's small component counts as much more as voxels are longer along it.
        const glm::dvec3 mm = p.info().spacingMm();
        const double ofLength = 1e-5 + 1e-6 * std::max({mm.x, mm.y, mm.z}) / std::min({mm.x, mm.y, mm.z});
        const auto exact = frameRays(f);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const double length = lengthMm(exact(i));
            // Ends are counted from the plane that rays start from: far away, in voxels, where these are
            // flat.
            const double ends = 0x1p-21 * far * exact(i).segmentMm / f.segmentVoxels;
            ASSERT_NEAR(lengthMm(inDouble(rays[i])), length, 2 * uncertain[i] + ends + ofLength * length)
                << "pixel " << i;
        }
    }

    ExtremeStores stores_;
};

/// The cases of a shard, sorted by what they compile.
std::vector<ExtremeCase> casesOf(int shard) {
    std::vector<ExtremeCase> cases = pairwiseCases();
    for (ExtremeCase& c : randomCases(kRandomCases, 20240229))
        cases.push_back(std::move(c));
    std::erase_if(cases, [&](const ExtremeCase& c) { return c[kStructure] % kShards != shard; });
    std::stable_sort(cases.begin(), cases.end(), [](const ExtremeCase& a, const ExtremeCase& b) {
        return a[kStructure] < b[kStructure];
    });
    return cases;
}

class Extremes : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Shard, Extremes, testing::Range(0, kShards));

TEST_P(Extremes, AreFiniteAndEqualTheMirror) {
    const GlContext context({"software"});
    ExtremeRun run;
    Tally tally;
    for (const ExtremeCase& c : casesOf(GetParam())) {
        SCOPED_TRACE(c);
        try {
            run.draw(c, tally);
        } catch (const std::exception& error) {
            ADD_FAILURE() << error.what();
        }
        if (HasFatalFailure())
            return;
    }
    RecordProperty("cases", tally.cases);
    RecordProperty("worstMarch", std::to_string(tally.worstMarch));
    std::printf("%d cases: %d show something; march against mirror: %d exact (worst %.2g), %d filtered; "
                "%d without skipping, %d constant\n",
                tally.cases, tally.visible, tally.equal, tally.worstMarch, tally.filtered, tally.skipping,
                tally.constant);
    EXPECT_GE(tally.cases, 100);
    EXPECT_GE(tally.visible, tally.cases / 4);
}

// Mirror and reference, wherever the step is fine enough to expect something.
TEST(ExtremeReference, MirrorComesAsNearAsItsStepLetsExpect) {
    ExtremeRun run;
    int compared = 0, constant = 0;
    for (const ExtremeCase& c : randomCases(3000, 7)) {
        SCOPED_TRACE(c);
        if (!run.compareWithReference(c))
            continue;
        ++compared;
        constant += isConstant(c) ? 1 : 0;
        if (HasFatalFailure())
            return;
    }
    std::printf("%d compared, %d of them constant\n", compared, constant);
    EXPECT_GE(compared - constant, 60);
    EXPECT_GE(constant, 100);
}

TEST(ExtremeCases, CoverEveryPairOfLevels) {
    const std::vector<int> levels = levelCounts();
    MissingPairs missing(levels);
    const std::size_t pairs = missing.count();
    const std::vector<ExtremeCase> cases = pairwiseCases();
    for (const ExtremeCase& c : cases)
        missing.take(c.levels);
    EXPECT_EQ(missing.count(), 0u);
    std::printf("%zu pairs in %zu cases, %zu combinations of what is compiled\n", pairs, cases.size(),
                structures().size());
    // The check has teeth: one case less misses something.
    MissingPairs without(levels);
    for (std::size_t i = 1; i < cases.size(); ++i)
        without.take(cases[i].levels);
    EXPECT_GT(without.count(), 0u);
    EXPECT_LE(cases.size(), 400u);
    // All pairs of what is compiled, too.
    for (const Structure& s : structures())
        EXPECT_EQ(std::count(structures().begin(), structures().end(), s), 1);
}

TEST(ExtremeCases, OneCase) {
    const char* code = std::getenv("TESSERA_EXTREME_CASE");
    if (!code)
        GTEST_SKIP() << "no TESSERA_EXTREME_CASE is named";
    ExtremeCase c;
    std::istringstream numbers(code);
    for (std::string number; std::getline(numbers, number, ',');)
        c.levels.push_back(std::stoi(number));
    ASSERT_EQ(c.levels.size(), std::size_t{kFactorCount});
    SCOPED_TRACE(c);
    std::ostringstream text;
    text << c;
    std::printf("%s\n", text.str().c_str());
    const GlContext context({"software"});
    ExtremeRun run;
    Tally tally;
    run.draw(c, tally);
    std::printf("%s the reference\n", run.compareWithReference(c) ? "compared with" : "not compared with");
}

} // namespace
} // namespace tessera
