// tests/datasets/phantom_test.cpp: the generated volumes: their formulas, gradients and determinism.
#include "core/base/brick.h"
#include "core/base/error.h"
#include "datasets/analytic_field.h"
#include "datasets/colon_shape.h"
#include "datasets/phantom.h"
#include "datasets/torso_parts.h"
#include "tests/support/folders.h"
#include "tests/support/recorded_numbers.h"

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

std::vector<std::byte> readAll(SlabSource& source, int slabSlices) {
    const glm::ivec3 n = source.info().extentVoxels;
    const std::size_t sliceBytes =
        static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) * bytesPerValue(source.info().type);
    std::vector<std::byte> bytes(sliceBytes * static_cast<std::size_t>(n.z));
    for (int z = 0; z < n.z; z += slabSlices) {
        const int count = std::min(slabSlices, n.z - z);
        source.readSlices(count, std::span(bytes).subspan(sliceBytes * static_cast<std::size_t>(z),
                                                          sliceBytes * static_cast<std::size_t>(count)));
    }
    return bytes;
}

template <class T> std::vector<T> valuesOf(const std::string& name, const glm::ivec3& extent) {
    const auto source = makePhantom(name, extent);
    const std::vector<std::byte> bytes = readAll(*source, 16);
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
}

const std::vector<std::string> kAnalyticNames = {"marschner-lobb", "sphere", "ramp", "checkerboard"};

TEST(Phantom, StoredVoxelsAreTheFormulaAtTheirCentres) {
    const glm::ivec3 n(20, 17, 12);
    for (const std::string& name : kAnalyticNames) {
        const auto source = makePhantom(name, n);
        const glm::dmat4 patientFromVoxel = source->info().patientFromVoxel;
        const std::vector<std::byte> bytes = readAll(*source, 5);
        const AnalyticField field = AnalyticField::named(name, n);
        std::size_t at = 0;
        for (int z = 0; z < n.z; ++z)
            for (int y = 0; y < n.y; ++y)
                for (int x = 0; x < n.x; ++x, ++at) {
                    const glm::dvec3 p(patientFromVoxel * glm::dvec4(x + 0.5, y + 0.5, z + 0.5, 1));
                    double stored = 0, tolerance = 1e-6;
                    if (source->info().type == ValueType::f32) {
                        float v = 0;
                        std::memcpy(&v, bytes.data() + at * 4, 4);
                        stored = static_cast<double>(v);
                    } else if (source->info().type == ValueType::i16) {
                        std::int16_t v = 0;
                        std::memcpy(&v, bytes.data() + at * 2, 2);
                        stored = v;
                        tolerance = 0.5 + 1e-9;
                    } else {
                        stored = static_cast<double>(bytes[at]);
                    }
                    ASSERT_NEAR(stored, field.value(p), tolerance)
                        << name << " " << x << " " << y << " " << z;
                }
    }
}

TEST(Phantom, AnalyticGradientsMatchDifferences) {
    const double h = 1e-4;
    for (const std::string& name : kAnalyticNames) {
        const AnalyticField field = AnalyticField::named(name, glm::ivec3(64));
        // none of these points is within h of a kink or jump
        for (const glm::dvec3 p :
             {glm::dvec3(13.1, -47.3, 60.7), {71, 3.3, -9.1}, {-90.2, 20.9, 1.7}, {1, 1, 1}}) {
            for (int axis = 0; axis < 3; ++axis) {
                glm::dvec3 step(0);
                step[axis] = h;
                const double difference = (field.value(p + step) - field.value(p - step)) / (2 * h);
                EXPECT_NEAR(field.gradient(p)[axis], difference, 1e-6 * (1 + std::abs(difference))) << name;
            }
        }
    }
}

TEST(Phantom, KnownValues) {
    const AnalyticField sphere = AnalyticField::named("sphere");
    EXPECT_NEAR(sphere.value(glm::normalize(glm::dvec3(1, 2, -2)) * kSphereRadiusMm), 0, 1e-9);
    EXPECT_EQ(sphere.value({0, 0, 0}), 1000);
    EXPECT_EQ(sphere.value({128, 128, 128}), -1000);
    const AnalyticField marschnerLobb = AnalyticField::named("marschner-lobb");
    // at the origin: (1 - 0 + 0.25 (1 + cos(12 pi))) / 2.5
    EXPECT_NEAR(marschnerLobb.value({0, 0, 0}), 0.6, 1e-12);
    EXPECT_NEAR(marschnerLobb.value({0, 0, 128}), 0.2, 1e-12);

    const std::vector<float> ramp = valuesOf<float>("ramp", {64, 2, 2});
    for (std::size_t i = 0; i < 64; ++i)
        EXPECT_EQ(ramp[i], (static_cast<float>(i) + 0.5F) / 64);
    const std::vector<std::uint8_t> boxes = valuesOf<std::uint8_t>("checkerboard", {24, 9, 9});
    EXPECT_EQ(boxes[7], 0);
    EXPECT_EQ(boxes[8], 255);
    EXPECT_EQ(boxes[24 * 8 + 8], 0);
    EXPECT_EQ(boxes[24 * 9 * 8 + 24 * 8 + 8], 255);
}

TEST(Phantom, SlabSizeAndThreadsDoNotMatter) {
    for (const std::string& name : phantomNames()) {
        for (const glm::ivec3 n : {glm::ivec3(1, 1, 1), glm::ivec3(3, 1, 7), glm::ivec3(23, 20, 26)}) {
            const std::vector<std::byte> whole = readAll(*makePhantom(name, n, 1), n.z);
            EXPECT_EQ(whole, readAll(*makePhantom(name, n, 3), 1)) << name;
            EXPECT_EQ(whole, readAll(*makePhantom(name, n, 2), 5)) << name;
        }
    }
}

TEST(Phantom, BoxIsCentredAtEveryExtent) {
    for (const std::string& name : phantomNames()) {
        const VolumeInfo info = makePhantom(name, {5, 8, 13})->info();
        const glm::dvec3 first(info.patientFromVoxel * glm::dvec4(0, 0, 0, 1));
        const glm::dvec3 last(info.patientFromVoxel * glm::dvec4(5, 8, 13, 1));
        EXPECT_NEAR(glm::length(first + last), 0, 1e-9);
        const glm::dvec3 body = isTorso(name) ? glm::dvec3(360, 260, 420) : glm::dvec3(256);
        EXPECT_NEAR(glm::length(last - first - body), 0, 1e-9);
    }
}

TEST(Phantom, BadRequestsAreRefused) {
    try {
        makePhantom("tosro", {4, 4, 4});
        FAIL() << "an unknown name was accepted";
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("did you mean 'torso'"));
    }
    EXPECT_THROW(makePhantom("ramp", {4, 0, 4}), InputError);
    EXPECT_THROW(makePhantom("torso", {4, 4, -1}), InputError);
    const auto source = makePhantom("ramp", {2, 2, 2});
    std::vector<std::byte> three(3 * 16);
    EXPECT_THROW(source->readSlices(3, three), InputError);
}

/// The torso up to some height, asked for in patient space.
class TorsoVolume {
  public:
    TorsoVolume(const glm::ivec3& extent, double topMm) : extent_(extent) {
        const auto source = makePhantom("torso", extent);
        const int slices = std::min(extent.z, static_cast<int>((topMm + 210) / 420 * extent.z) + 1);
        values_.resize(static_cast<std::size_t>(extent.x * extent.y * slices));
        source->readSlices(slices, std::as_writable_bytes(std::span(values_)));
    }
    const std::vector<std::int16_t>& values() const { return values_; }
    int huAt(const glm::dvec3& mm) const {
        const glm::ivec3 v((mm / glm::dvec3(360, 260, 420) + 0.5) * glm::dvec3(extent_));
        return values_.at(static_cast<std::size_t>((v.z * extent_.y + v.y) * extent_.x + v.x));
    }
    /// Mean over a ball of radius 6 mm.
    double meanAt(const glm::dvec3& mm) const {
        double sum = 0;
        int count = 0;
        for (int k = -4; k <= 4; ++k)
            for (int j = -4; j <= 4; ++j)
                for (int i = -4; i <= 4; ++i)
                    if (i * i + j * j + k * k <= 16) {
                        sum += huAt(mm + 1.5 * glm::dvec3(i, j, k));
                        ++count;
                    }
        return sum / count;
    }

  private:
    glm::ivec3 extent_;
    std::vector<std::int16_t> values_;
};

void expectCentrelineInTheAir(const TorsoVolume& torso) {
    const std::vector<glm::dvec3> line = torsoColonCentreline();
    ASSERT_GT(line.size(), 300U);
    std::size_t narrow = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
        ASSERT_LT(torso.huAt(line[i]), -900) << "point " << i;
        if (i == 0)
            continue;
        const glm::dvec3 step = line[i] - line[i - 1];
        EXPECT_NEAR(glm::length(step), 2, 0.05);
        // a ring of 8 mm around it is air too, but where a fold or a polyp hangs in
        const glm::dvec3 side = glm::normalize(glm::cross(step, glm::dvec3(0.3, 0.5, 0.8)));
        const glm::dvec3 other = glm::normalize(glm::cross(step, side));
        for (int k = 0; k < 8; ++k) {
            const double angle = k * 0.7853981633974483;
            if (torso.huAt(line[i] + 8.0 * (std::cos(angle) * side + std::sin(angle) * other)) > -700)
                ++narrow;
        }
    }
    EXPECT_LT(static_cast<double>(narrow), 0.03 * 8 * static_cast<double>(line.size()));
    EXPECT_LT(line.front().x, -40) << "the caecum is on the right";
    EXPECT_NEAR(line.back().x, 0, 15) << "the rectum is in the middle";
}

void expectDeclaredRadius(const TorsoVolume& torso) {
    // the distance to the wall, averaged over directions and a stretch of the colon, folds included
    const std::vector<glm::dvec3> line = torsoColonCentreline();
    for (const double u : {0.2, 0.4, 0.6, 0.8}) {
        const auto at = static_cast<std::size_t>(u * static_cast<double>(line.size() - 1));
        double sum = 0;
        int count = 0;
        for (std::size_t i = at - 7; i <= at + 7; ++i) {
            const glm::dvec3 along = glm::normalize(line[i + 1] - line[i - 1]);
            const glm::dvec3 side = glm::normalize(glm::cross(along, glm::dvec3(0.3, 0.5, 0.8)));
            const glm::dvec3 other = glm::cross(along, side);
            for (int k = 0; k < 24; ++k, ++count) {
                const double angle = k * 0.2617993877991494;
                double r = 4;
                while (r < 40 &&
                       torso.huAt(line[i] + r * (std::cos(angle) * side + std::sin(angle) * other)) < -475)
                    r += 0.25;
                sum += r;
            }
        }
        EXPECT_NEAR(sum / count, torsoColonRadiusMm(u), 0.15 * torsoColonRadiusMm(u)) << "u = " << u;
    }
}

void expectDeclaredPolyps(const TorsoVolume& torso) {
    const std::vector<ColonPolyp> polyps = torsoColonPolyps();
    int stalked = 0;
    for (const ColonPolyp& polyp : polyps) {
        stalked += polyp.pedunculated ? 1 : 0;
        // its half towards the lumen is tissue
        const std::vector<glm::dvec3> line = torsoColonCentreline();
        const auto at =
            static_cast<std::size_t>(polyp.arcFraction * static_cast<double>(line.size() - 1) + 0.5);
        const glm::dvec3 inward = glm::normalize(line[at] - polyp.centreMm);
        EXPECT_GT(torso.huAt(polyp.centreMm + inward * 0.15 * polyp.diameterMm), -450) << polyp.arcFraction;
        EXPECT_LT(torso.huAt(polyp.centreMm + inward * (0.5 * polyp.diameterMm + 2.5)), -700)
            << polyp.arcFraction;
    }
    EXPECT_EQ(stalked, 2);
    EXPECT_GE(polyps.size(), 8U);
}

// one case for all three, because the volume costs more than the questions
TEST(Torso, ColonIsAsDeclared) {
    const TorsoVolume torso({256, 192, 300}, 0);
    expectCentrelineInTheAir(torso);
    expectDeclaredRadius(torso);
    expectDeclaredPolyps(torso);
}

TEST(Torso, OrgansLieWhereTheyShould) {
    const TorsoVolume torso({128, 96, 150}, 210);
    EXPECT_NEAR(torso.meanAt({-75, 10, -15}), 110, 25) << "liver, on the right";
    EXPECT_NEAR(torso.meanAt({97, 33, -25}), 120, 10) << "spleen, on the left";
    EXPECT_NEAR(torso.meanAt({24, 34, 70}), 350, 10) << "descending aorta";
    EXPECT_NEAR(torso.meanAt({-6, -4, 98}), 230, 15) << "pulmonary artery, to the right lung";
    EXPECT_NEAR(torso.meanAt({34, 4, 101}), 230, 15) << "pulmonary artery, to the left lung";
    EXPECT_NEAR(torso.meanAt({0, 46, 100}), 280, 90) << "vertebral marrow";
    EXPECT_LT(torso.meanAt({-85, 0, 90}), -600) << "right lung";
    EXPECT_LT(torso.meanAt({85, 0, 90}), -600) << "left lung";
    EXPECT_NEAR(torso.meanAt({0, 6.5, 190}), -1000, 20) << "trachea";
    EXPECT_NEAR(torso.meanAt({172, -120, 0}), -1000, 3) << "air around";
    std::size_t air = 0, lung = 0, bone = 0, fat = 0;
    for (const std::int16_t hu : torso.values()) {
        air += hu < -930 ? 1 : 0;
        lung += hu > -920 && hu < -800 ? 1 : 0;
        fat += hu > -140 && hu < -60 ? 1 : 0;
        bone += hu > 400 ? 1 : 0;
    }
    const auto share = [&](std::size_t n) {
        return static_cast<double>(n) / static_cast<double>(torso.values().size());
    };
    EXPECT_NEAR(share(air), 0.46, 0.04);
    EXPECT_NEAR(share(lung), 0.065, 0.02);
    EXPECT_NEAR(share(fat), 0.14, 0.05);
    EXPECT_NEAR(share(bone), 0.015, 0.008);
}

/// Means over boxes of the body, HU: tissue stays where it is recorded to be. Voxels at a border may differ
/// by a HU from machine to machine.
TEST(Torso, IsThatOfTheRecord) {
    const glm::ivec3 boxes(6, 5, 15), voxels(15, 13, 7), extent = boxes * voxels;
    for (const std::string& name : phantomNames()) {
        if (!isTorso(name))
            continue;
        const std::vector<std::int16_t> values = valuesOf<std::int16_t>(name, extent);
        std::vector<double> means(cellCount(boxes));
        for (std::size_t i = 0; i < values.size(); ++i)
            means[linearIndex(gridPosition(i, extent) / voxels, boxes)] +=
                static_cast<double>(values[i]) / static_cast<double>(cellCount(voxels));
        test::RecordedNumbers record("tests/datasets/recorded/" + name + ".txt");
        for (std::size_t row = 0; row < means.size(); row += 6)
            record.expect("means",
                          {means.begin() + static_cast<std::ptrdiff_t>(row),
                           means.begin() + static_cast<std::ptrdiff_t>(row) + 6},
                          0, 0.06);
    }
}

/// The curves of its tubes, and its polyps.
TEST(Torso, CurvesAreThoseOfTheRecord) {
    test::RecordedNumbers record("tests/datasets/recorded/curves.txt");
    const auto expectCurve = [&](const std::string& name, const PhantomCurve& curve) {
        glm::dvec3 sum(0);
        double radii = 0;
        for (std::size_t i = 0; i < curve.pointsMm.size(); ++i) {
            sum += static_cast<double>(i + 1) * curve.pointsMm[i];
            radii += static_cast<double>(i + 1) * curve.radiiMm[i];
        }
        const glm::dvec3 &first = curve.pointsMm.front(), &last = curve.pointsMm.back();
        record.expect(name,
                      {static_cast<double>(curve.pointsMm.size()), static_cast<double>(curve.parent),
                       static_cast<double>(curve.generation), first.x, first.y, first.z, last.x, last.y,
                       last.z, sum.x, sum.y, sum.z, radii},
                      1e-4, 1e-2);
    };
    expectCurve("aorta", torsoAorta());
    expectCurve("colon", torsoColon());
    const std::vector<PhantomCurve> airways = torsoAirways();
    record.expect("airways", {static_cast<double>(airways.size())});
    for (std::size_t i = 0; i < airways.size(); i += i < 8 ? 1 : 61)
        expectCurve("airway", airways[i]);
    for (const ColonPolyp& polyp : torsoColonPolyps())
        record.expect("polyp",
                      {polyp.centreMm.x, polyp.centreMm.y, polyp.centreMm.z, polyp.arcFraction,
                       polyp.diameterMm, polyp.pedunculated ? 1.0 : 0.0},
                      1e-4, 1e-2);
    for (const double u : {0.0, 0.13, 0.5, 0.77, 1.0})
        record.expect("radius", {torsoColonRadiusMm(u)}, 1e-4);
}

/// Between the muscles of the back and the flank fat shows as lines in every slice of the chest.
TEST(Torso, FatPartsTheMusclesOfTheBack) {
    TorsoBuilder torso{1.2F, {}, nullptr, nullptr, nullptr};
    addBodyWall(torso);
    const TissuePainter painter(std::move(torso.tissues), -1000, 1.2F);
    for (const float side : {-1.0F, 1.0F})
        for (const float z : {80.0F, 100.0F, 125.0F, 150.0F}) {
            float least = 1000, most = -1000;
            for (float y = 83; y <= 89; y += 0.5F)
                for (float x = 55; x <= 61; x += 0.5F) {
                    least = std::min(least, painter.valueAt({side * x, y, z}));
                    most = std::max(most, painter.valueAt({side * x, y, z}));
                }
            EXPECT_NEAR(least, -60, 5) << side << " " << z;
            EXPECT_NEAR(most, 55, 5) << side << " " << z;
        }
}

/// In each of three directions about the course the lumen has crests of folds, 28 mm apart but for a quarter
/// of it.
TEST(Torso, FoldsOfTheColonAreEvenlySpread) {
    const ColonCourse course;
    const float from = 40, to = 0.85F * course.lengthMm();
    for (const float angle : {0.0F, 2.0943951F, 4.1887902F}) {
        const auto radiusAt = [&](float arcMm) {
            return course.lumen(arcMm, std::cos(angle), std::sin(angle), true).radiusMm;
        };
        std::vector<float> crests;
        for (float arc = from; arc < to; arc += 0.25F) {
            const float here = radiusAt(arc);
            if (here < radiusAt(arc - 0.25F) && here <= radiusAt(arc + 0.25F) &&
                here < radiusAt(arc + 3) - 2 && here < radiusAt(arc - 3) - 2)
                crests.push_back(arc);
        }
        ASSERT_GT(crests.size(), 15u);
        for (std::size_t i = 1; i < crests.size(); ++i)
            EXPECT_NEAR(crests[i] - crests[i - 1], 28, 7) << angle << ", " << crests[i];
    }
}

TEST(Torso, PruningTilesChangesNoVoxel) {
    TorsoBuilder torso{1.2F, {}, nullptr, nullptr, nullptr};
    for (const auto add : {addBodyWall, addLungs, addAbdomen, addLungTrees, addHeart, addVessels,
                           addRibsAndGirdles, addSpine, addColon})
        add(torso);
    const TissuePainter painter(std::move(torso.tissues), -1000, 1.2F);
    const int nx = 150, ny = 110;
    std::vector<float> slice(static_cast<std::size_t>(nx * ny));
    for (const float z : {-185.0F, -122.0F, -95.0F, -40.0F, 4.0F, 60.0F, 150.0F}) {
        const glm::vec3 first(-179, -129, z);
        painter.slice(first, 2.4F, 2.35F, nx, ny, slice);
        for (int i = 3; i < nx * ny; i += 61) {
            const glm::vec3 p =
                first + glm::vec3(static_cast<float>(i % nx) * 2.4F, static_cast<float>(i / nx) * 2.35F, 0);
            ASSERT_NEAR(slice[static_cast<std::size_t>(i)], painter.valueAt(p), 0.5)
                << p.x << " " << p.y << " " << z;
        }
    }
}

} // namespace
} // namespace tessera
