// tests/program/structures_test.cpp: contours of a DICOM structure set as lines and as closed surfaces:
// options, keys, notes and what the picture shows.
#include "tests/support/program_fixture.h"

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

template <class T> std::string littleEndian(T number) {
    return {reinterpret_cast<const char*>(&number), sizeof number};
}

std::string element(std::uint16_t group, std::uint16_t number, const std::string& kind, std::string value) {
    if (value.size() % 2 == 1)
        value += kind == "UI" ? '\0' : ' ';
    const bool isLong = kind == "SQ" || kind == "OB";
    return littleEndian(group) + littleEndian(number) + kind +
           (isLong ? std::string(2, '\0') + littleEndian(static_cast<std::uint32_t>(value.size()))
                   : littleEndian(static_cast<std::uint16_t>(value.size()))) +
           value;
}

std::string item(const std::string& value) {
    return littleEndian(std::uint16_t{0xfffe}) + littleEndian(std::uint16_t{0xe000}) +
           littleEndian(static_cast<std::uint32_t>(value.size())) + value;
}

/// A green ball of radius 10 around a place: planes 2 mm apart, from `first` on.
std::string ballOfContours(const std::string& number, const glm::dvec3& centre, int first) {
    std::string contours;
    for (int z = first; z < 10; z += 2) {
        std::string data;
        const double radius = std::sqrt(100.0 - z * z);
        for (int i = 0; i < 48; ++i) {
            char text[80];
            const double angle = i * 0.1308996938995747;
            std::snprintf(text, sizeof text, "%s%.2f\\%.2f\\%.2f", i == 0 ? "" : "\\",
                          centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle),
                          centre.z + z);
            data += text;
        }
        contours += item(element(0x3006, 0x42, "CS", "CLOSED_PLANAR") + element(0x3006, 0x46, "IS", "48") +
                         element(0x3006, 0x50, "DS", data));
    }
    return item(element(0x3006, 0x2a, "IS", "0\\255\\0") + element(0x3006, 0x40, "SQ", contours) +
                element(0x3006, 0x84, "IS", number));
}

class Structures : public Program {
  protected:
    void SetUp() override {
        const std::string kind = "1.2.840.10008.5.1.4.1.1.481.3";
        const std::string meta = element(2, 2, "UI", kind) + element(2, 3, "UI", "1.2.3") +
                                 element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
        const auto named = [](const char* number, const char* name) {
            return item(element(0x3006, 0x22, "IS", number) + element(0x3006, 0x26, "LO", name));
        };
        std::ofstream(folder_ / "rs.dcm", std::ios::binary)
            << std::string(128, '\0') << "DICM"
            << element(2, 0, "UL", littleEndian(std::uint32_t(meta.size()))) << meta
            << element(8, 0x16, "UI", kind) << element(8, 0x18, "UI", "1.2.3")
            << element(0x3006, 0x20, "SQ", named("1", "GTV") + named("2", "one slice"))
            << element(0x3006, 0x39, "SQ",
                       ballOfContours("1", {0, 0, 0}, -9) + ballOfContours("2", {0, 0, 20}, 9));
        ASSERT_EQ(run("phantom ramp --size 32x32x32 -o a.zarr").exitCode, 0);
    }
    Outcome drawn(const std::string& more) {
        return run("render a.zarr -o a.png --size 64x64 --engine native --samples 1 --no-check --no-shading "
                   "--view anterior --mesh rs.dcm " +
                   more);
    }
};

TEST_F(Structures, AreLinesOrClosedSurfaces) {
    const Outcome lines = drawn("--explain");
    ASSERT_EQ(lines.exitCode, 0) << lines.problems;
    const Outcome surface = drawn("--mesh-contours surface --explain");
    ASSERT_EQ(surface.exitCode, 0) << surface.problems;
    EXPECT_THAT(lines.out + lines.problems, Not(HasSubstr("one plane alone")));
    EXPECT_THAT(surface.out + surface.problems,
                AllOf(HasSubstr("\"one slice\""), HasSubstr("one plane alone"), HasSubstr("triangles")));
    const Outcome keyed = drawn("--set meshes[0].contours=surface --set meshes[0].surfaceStep=0.5");
    EXPECT_EQ(keyed.exitCode, 0) << keyed.problems;
}

TEST_F(Structures, RefusalsNameTheOption) {
    std::ofstream(folder_ / "a.stl") << "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\n"
                                        "vertex 0 9 0\nendloop\nendfacet\nendsolid\n";
    expectRefused("render a.zarr -o a.png --mesh rs.dcm --mesh-contours solid",
                  {"--mesh-contours", "surface"});
    expectRefused("render a.zarr -o a.png --mesh a.stl --mesh-contours surface",
                  {"--mesh-contours", "structure set"});
    expectRefused("render a.zarr -o a.png --mesh a.stl --set meshes[0].contours=surface",
                  {"a.stl", "structure set", "contours"});
    expectRefused(
        "render a.zarr -o a.png --mesh rs.dcm --mesh-contours surface --set meshes[0].surfaceStep=1e-6",
        {"GTV", "surfaceStep"});
}

} // namespace
} // namespace tessera::test
