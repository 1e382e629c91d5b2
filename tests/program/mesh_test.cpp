// tests/program/mesh_test.cpp: `tessera mesh` from outside: what it writes and says, and what it refuses.
#include "tests/support/program_fixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <utility>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

/// Triangles of a binary STL file; every side of one must be a side of another, the other way round.
struct Triangles {
    std::vector<std::array<std::array<float, 3>, 3>> all;
    double volume = 0;
    bool closed = false;

    explicit Triangles(const std::string& stl) {
        std::uint32_t count = 0;
        std::memcpy(&count, stl.data() + 80, 4);
        EXPECT_EQ(stl.size(), 84 + 50 * std::size_t{count});
        std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> sides;
        for (std::size_t t = 0; t < count; ++t) {
            std::array<std::array<float, 3>, 3> c;
            std::memcpy(&c, stl.data() + 84 + 50 * t + 12, sizeof c);
            all.push_back(c);
            for (std::size_t i = 0; i < 3; ++i)
                ++sides[{c[i], c[(i + 1) % 3]}], --sides[{c[(i + 1) % 3], c[i]}];
            const auto at = [&](std::size_t i, std::size_t axis) { return static_cast<double>(c[i][axis]); };
            volume += (at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)) -
                       at(0, 1) * (at(1, 0) * at(2, 2) - at(1, 2) * at(2, 0)) +
                       at(0, 2) * (at(1, 0) * at(2, 1) - at(1, 1) * at(2, 0))) /
                      6;
        }
        closed = std::ranges::all_of(sides, [](const auto& side) { return side.second == 0; });
    }
};

TEST_F(Program, MeshWritesTheBorderOfLabels) {
    ASSERT_EQ(run("phantom ramp --size 16x16x16 -o r.zarr -q").exitCode, 0);
    // 256 mm wide. About its middle, half as wide: two labels side by side along x.
    std::string voxels;
    for (int i = 0; i < 16 * 16 * 16; ++i) {
        const int x = i % 16, y = i / 16 % 16, z = i / 256;
        const bool in = std::min({x, y, z}) >= 4 && std::max({x, y, z}) < 12;
        voxels += !in ? "0 " : x < 8 ? "1 " : "2 ";
    }
    write("l.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 16 16 16\n"
                    "space directions: (16,0,0) (0,16,0) (0,0,16)\nkinds: domain domain domain\n"
                    "encoding: ascii\nspace origin: (-120,-120,-120)\n\n" +
                        voxels + "\n");
    const auto volumeOf = [&](const std::string& options) {
        const Outcome outcome = run("mesh r.zarr m.stl --force --labels l.nrrd " + options);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        const std::string stl = readAll(folder_ / "m.stl");
        EXPECT_THAT(stl.substr(0, 80), HasSubstr("mm in patient space, LPS"));
        const Triangles mesh(stl);
        EXPECT_TRUE(mesh.closed);
        return mesh.volume;
    };
    const double one = volumeOf("--label 1"), both = volumeOf("--label 1 --label 2"), all = volumeOf("");
    EXPECT_EQ(both, all);
    EXPECT_NEAR(both, std::pow(128.0, 3), 0.1 * both) << "corners are cut";
    EXPECT_NEAR(one, 0.5 * both, 0.1 * one);
}

TEST_F(Program, MeshWritesTheSurfaceOfAValue) {
    ASSERT_EQ(run("phantom torso --size 60x45x70 -o t.zarr -q").exitCode, 0);
    const Outcome whole = run("mesh t.zarr bone.stl --isosurface 300 -v");
    ASSERT_EQ(whole.exitCode, 0) << whole.problems;
    EXPECT_THAT(whole.problems, HasSubstr("wrote bone.stl: "));
    EXPECT_THAT(whole.problems, HasSubstr(" triangles, "));
    EXPECT_THAT(whole.problems, HasSubstr("looked at "));
    const Triangles bone(readAll(folder_ / "bone.stl"));
    EXPECT_TRUE(bone.closed);
    EXPECT_GT(bone.volume, 0);
    ASSERT_EQ(run("mesh t.zarr skin.stl --isosurface=-300 -q --ram 32MiB").exitCode, 0);
    const Triangles skin(readAll(folder_ / "skin.stl"));
    EXPECT_TRUE(skin.closed);
    EXPECT_GT(skin.volume, 5 * bone.volume);
    ASSERT_EQ(run("mesh t.zarr coarse.stl --isosurface=-300 --level 1 -q").exitCode, 0);
    const Triangles coarse(readAll(folder_ / "coarse.stl"));
    EXPECT_LT(coarse.all.size(), skin.all.size() / 2);
    EXPECT_NEAR(coarse.volume, skin.volume, 0.05 * skin.volume);
    // two halves of a body
    ASSERT_EQ(run("mesh t.zarr a.stl --isosurface=-300 -q --crop-voxels 0,60,0,45,0,31").exitCode, 0);
    ASSERT_EQ(run("mesh t.zarr b.stl --isosurface=-300 -q --crop-voxels 0,60,0,45,31,70").exitCode, 0);
    const Triangles a(readAll(folder_ / "a.stl")), b(readAll(folder_ / "b.stl"));
    EXPECT_TRUE(a.closed && b.closed);
    EXPECT_NEAR(a.volume + b.volume, skin.volume, 0.003 * skin.volume);
    ASSERT_EQ(run("mesh t.zarr c.stl --isosurface=-300 -q --crop-voxels 0,60,0,45,31,70 --crop "
                  "-1e4,1e4,-1e4,0,-1e4,1e4")
                  .exitCode,
              0);
    const Triangles c(readAll(folder_ / "c.stl"));
    EXPECT_TRUE(c.closed);
    EXPECT_LT(c.volume, b.volume);
    EXPECT_GT(c.volume, 0.2 * b.volume);
    float behind = -1e9f;
    for (const auto& triangle : c.all)
        for (const auto& corner : triangle)
            behind = std::max(behind, corner[1]);
    EXPECT_NEAR(behind, 0, 1e-5);
}

TEST_F(Program, MeshKeepsPartsAndFewerTriangles) {
    ASSERT_EQ(run("phantom torso --size 60x45x70 -o t.zarr -q").exitCode, 0);
    const auto meshed = [&](const std::string& options) {
        const Outcome outcome = run("mesh t.zarr m.stl --force --isosurface 200 " + options);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        return Triangles(readAll(folder_ / "m.stl"));
    };
    const Triangles all = meshed("-q"), largest = meshed("--keep-largest"), half = meshed("--simplify 0.5"),
                    rough = meshed("--error 0.5mm --keep-largest"), large = meshed("--min-volume 50000mm3");
    for (const Triangles* mesh : {&all, &largest, &half, &rough, &large})
        EXPECT_TRUE(mesh->closed);
    EXPECT_LT(largest.all.size(), all.all.size());
    EXPECT_GT(largest.volume, 0.2 * all.volume);
    EXPECT_LE(half.all.size(), all.all.size() / 2);
    EXPECT_GT(half.all.size(), all.all.size() / 2 - 10);
    EXPECT_NEAR(half.volume, all.volume, 0.02 * all.volume);
    EXPECT_LT(rough.all.size(), largest.all.size() / 2);
    EXPECT_NEAR(rough.volume, largest.volume, 0.03 * std::abs(largest.volume));
    EXPECT_LT(large.all.size(), all.all.size());
    expectRefused("mesh t.zarr n.stl --isosurface 200 --simplify 2", {"--simplify"});
    expectRefused("mesh t.zarr n.stl --isosurface 200 --simplify 0.5 --ram 7MiB",
                  {"--simplify: expected RAM for ", " triangles at once, --ram ", "found 7 MiB"});
    expectRefused("mesh t.zarr n.stl --isosurface 200 --min-volume 1e11", {"--min-volume"});
}

TEST_F(Program, MeshRefusesWhatItCannotDo) {
    ASSERT_EQ(run("phantom torso --size 60x45x70 -o t.zarr -q").exitCode, 0);
    expectRefused("mesh t.zarr m.ply", {"--isosurface: expected a value, or --labels, found neither"});
    expectRefused("mesh t.zarr m.ply --isosurface 1 --labels x.nrrd", {"found both"});
    expectRefused("mesh t.zarr m.ply --isosurface 1 --label liver", {"--label", "--labels"});
    expectRefused("mesh t.zarr m.off --isosurface 1", {"m.off", ".ply, .stl, .obj, .glb"});
    expectRefused("mesh t.zarr m.ply --isosurface 9999",
                  {"--isosurface", "whose values are", "found 9999 HU"});
    expectRefused("mesh t.zarr m.ply --isosurface nan", {"--isosurface"});
    expectRefused("mesh t.zarr m.ply --isosurface 1 --level 6", {"--level"});
    expectRefused("mesh t.zarr m.ply --isosurface 1 --crop-voxels 0,1,2",
                  {"--crop-voxels", "X0,X1,Y0,Y1,Z0,Z1"});
    expectRefused("mesh t.zarr m.ply --isosurface 1 --crop-voxels 70,90,0,9,0,9",
                  {"--crop-voxels", "found none along axis x"});
    expectRefused("mesh t.zarr m.ply --isosurface 1 --ram 1MiB", {"--ram"});
    expectRefused("mesh t.zarr m.ply --labels none.nrrd", {"none.nrrd"});
    // Before anything is opened, or imported for long.
    expectRefused("mesh nothing.zarr m.ply --isosurface 1 --crop 1,2",
                  {"--crop: expected X0,X1,Y0,Y1,Z0,Z1"});
    expectRefused("mesh nothing.zarr m.ply --isosurface 1 --crop-voxels 5,4,0,1,0,1",
                  {"--crop-voxels", "5 to 4"});
    write("there.ply", "old");
    expectRefused("mesh t.zarr there.ply --isosurface 1", {"there.ply", "--force"});
    EXPECT_EQ(readAll(folder_ / "there.ply"), "old");
    EXPECT_EQ(run("mesh t.zarr there.ply --isosurface 1 --force").exitCode, 0);
    EXPECT_GT(fs::file_size(folder_ / "there.ply"), 1000u);
    EXPECT_FALSE(fs::exists(folder_ / "m.ply"));
    EXPECT_EQ(std::count_if(fs::directory_iterator(folder_.path()), fs::directory_iterator(),
                            [](const auto& entry) {
                                return entry.path().filename().string().find("m.ply") != std::string::npos;
                            }),
              0);
}

} // namespace
} // namespace tessera::test
