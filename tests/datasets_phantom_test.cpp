// tests/datasets_phantom_test.cpp: the generated volumes: their formulas, gradients and determinism.
#include "core/error.h"
#include "datasets/analytic_field.h"
#include "datasets/phantom.h"

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
        for (const glm::ivec3 n : {glm::ivec3(1, 1, 1), glm::ivec3(3, 1, 7), glm::ivec3(40, 33, 37)}) {
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
        const glm::dvec3 body = name == "torso" ? glm::dvec3(360, 260, 420) : glm::dvec3(256);
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

} // namespace
} // namespace tessera
