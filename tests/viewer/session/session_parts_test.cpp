// tests/viewer/session/session_parts_test.cpp: parts of a session by themselves, against results written out:
// small pictures of offers, options of a choice, sizes of pictures in time, changes of scenes, values in a
// circle.
#include "bricking/cache/brick_cache.h"
#include "bricking/import/importer.h"
#include "bricking/store/store_reader.h"
#include "core/base/program_folders.h"
#include "tests/support/formula_source.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/session/disc_values.h"
#include "viewer/session/file_kind.h"
#include "viewer/session/frame_pace.h"
#include "viewer/session/scene_change.h"
#include "viewer/session/volume_offers.h"
#include "viewer/session/volume_values.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

VolumeInfo wideVolume() {
    VolumeInfo info;
    info.extentVoxels = {40, 30, 7};
    info.type = ValueType::i16;
    info.patientFromVoxel = glm::dmat4(1);
    info.patientFromVoxel[0][0] = 2; // voxels twice as wide as high
    return info;
}

// The middle slice, greys from its 1st to its 99th percentile; a pixel is the mean of the voxels it covers.
TEST(Thumbnails, AreTheMiddleSlice) {
    const VolumeInfo info = wideVolume();
    const auto formula = [](const glm::dvec3& p) {
        return std::floor(p.z) * 1000 + std::floor(p.x) * 5 + std::floor(p.y) * 7;
    };
    FormulaSource source(info, formula);
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 20);
    const auto thumbnail = middleSlice(source, ram, 20);
    ASSERT_TRUE(thumbnail);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_EQ(thumbnail->size, glm::ivec2(20, 8)); // 80 x 30 mm; 7.5 pixels high
    ASSERT_EQ(thumbnail->display.size(), 160u);
    std::vector<double> sorted;
    const auto value = [](int x, int y) { return 3000.0 + 5 * x + 7 * y; };
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x)
            sorted.push_back(value(x, y));
    std::sort(sorted.begin(), sorted.end());
    const double dark = sorted[12], bright = sorted[1200 - 1 - 12];
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 20; ++x) {
            double sum = 0;
            int count = 0;
            for (int v = y * 30 / 8; v < (y + 1) * 30 / 8; ++v)
                for (int u = 2 * x; u < 2 * x + 2; ++u, ++count)
                    sum += value(u, v);
            const double grey = std::min(1.0, std::max(0.0, (sum / count - dark) / (bright - dark)));
            const auto code = static_cast<std::uint32_t>(std::lround(255 * grey));
            EXPECT_EQ(thumbnail->display[static_cast<std::size_t>(20 * y + x)], code * 0x10101u | 0xFF000000u)
                << x << " " << y;
        }
    // A slice of 2 bytes a voxel takes 18 more while it is looked at: with less there is no picture.
    for (const bool fits : {true, false}) {
        FormulaSource again(info, formula);
        MemoryBudget tight("RAM", "--ram", 1200u * 18 - (fits ? 0 : 1));
        EXPECT_EQ(middleSlice(again, tight, 20) != nullptr, fits);
    }
    FormulaSource flat(info, [](const glm::dvec3&) { return 5.0; });
    EXPECT_EQ(middleSlice(flat, ram, 20)->display.front(), 0xFF000000u) << "of one value, black";
}

TEST(Offers, OptionsAreThoseOfTheChoice) {
    InputOptions input;
    input.series = 4;
    input.largest = true;
    EXPECT_EQ(optionsFor({}, input).series, 4) << "nothing was chosen";
    EXPECT_TRUE(optionsFor({}, input).largest);
    const InputOptions chosen = optionsFor({2, 3, true, false}, input);
    EXPECT_EQ(chosen.series, 2);
    EXPECT_EQ(chosen.phase, 3);
    EXPECT_FALSE(chosen.largest);
    EXPECT_TRUE(chosen.resampleZ);
    EXPECT_FALSE(chosen.allowMissing);
    input.allowMissing = true;
    EXPECT_TRUE(optionsFor({2, 0, false, false}, input).allowMissing);
    EXPECT_FALSE(optionsFor({2, 0, false, false}, input).resampleZ);
    EXPECT_TRUE(optionsFor({2, 0, false, true}, {}).allowMissing);
    for (const char* const option : {"--series", "--largest", "--phase", "--resample-z", "--allow-missing"})
        EXPECT_TRUE(asksForChoice(std::string("give ") + option + " N"));
    EXPECT_FALSE(asksForChoice("a file that cannot be read; --ram"));
}

TEST(FramePace, SizesAreWorkedOut) {
    const glm::ivec2 whole(1280, 720);
    FramePace pace(50);
    EXPECT_EQ(pace.sizeFor(whole), glm::ivec2(453, 255)) << "unknown: six steps, of four to a half";
    pace.drew({100, 100}, 10); // 921.6 ms for all pixels: 8.41 steps, rounded up
    EXPECT_EQ(pace.sizeFor(whole), glm::ivec2(269, 151));
    pace.drew({100, 100}, 20);
    EXPECT_EQ(pace.sizeFor(whole), glm::ivec2(190, 107)) << "dearer at once: 10.41";
    pace.drew({100, 100}, 0); // cheaper slowly: 1.4e-3 a pixel, 9.38; a step of more needs 0.4
    EXPECT_EQ(pace.sizeFor(whole), glm::ivec2(226, 127));
    FramePace quick(50);
    quick.drew({100, 100}, 0.01);
    EXPECT_EQ(quick.sizeFor(whole), whole);
    quick.forget();
    EXPECT_EQ(quick.sizeFor(whole), glm::ivec2(453, 255));
    // A size grows only where it clearly fits: at 0.7 of a step, not yet; at 0.5.
    const auto after = [&](double steps) {
        FramePace slow(50);
        slow.drew({100, 100}, 20); // 10.41: eleven steps
        (void)slow.sizeFor(whole);
        slow.forget();
        slow.drew({1, 1}, 50 / (1280.0 * 720) * std::exp2(steps / 2));
        return slow.sizeFor(whole);
    };
    EXPECT_EQ(after(9.7), glm::ivec2(190, 107));
    EXPECT_EQ(after(9.5), glm::ivec2(226, 127));
}

TEST(SceneChanges, AreThoseThatWereMade) {
    Scene drawn;
    drawn.volumes = {{"v", TransferFunction::fromOpacity({{0, 0}, {1, 1}}, {}, 1)}, {"w"}};
    const Camera camera;
    drawn.camera = camera;
    const auto flags = [&](const auto& change, bool compiles = false) {
        Scene wished = drawn;
        change(wished);
        const SceneChange c = changeOf(wished, drawn, camera, compiles);
        std::string text = std::string(c.another ? "A" : "") + (c.turned ? "T" : "") +
                           (c.rewindowed ? "W" : "") + (c.recut ? "C" : "") + (c.relit ? "L" : "");
        for (const std::size_t n : c.recoloured)
            text += "F" + std::to_string(n);
        for (const std::size_t n : c.faded)
            text += "O" + std::to_string(n);
        EXPECT_EQ(c.any(), !text.empty());
        return text;
    };
    EXPECT_EQ(flags([](Scene&) {}), "");
    EXPECT_EQ(flags([](Scene& s) { std::get<Camera>(s.camera).viewAngle += 1; }), "T");
    EXPECT_EQ(flags([](Scene& s) { s.camera = FittedView{}; }), "T");
    EXPECT_EQ(flags([](Scene& s) {
                  s.volumes[0].transferFunction = TransferFunction::fromOpacity({{0, 0}, {2, 1}}, {}, 1);
              }),
              "F0");
    EXPECT_EQ(flags([](Scene& s) { s.volumes[1].transferFunction = std::string("lung"); }), "F1");
    EXPECT_EQ(flags([](Scene& s) {
                  s.volumes[0].opacity = 0.5;
                  s.volumes[1].opacity = 0.25;
              }),
              "O0O1");
    EXPECT_EQ(flags([](Scene& s) { s.volumes[1].unit = "HU"; }), "A");
    EXPECT_EQ(flags([](Scene& s) { s.volumes[1].labels.path = "l.nrrd"; }), "A");
    EXPECT_EQ(flags([](Scene& s) { s.volumes.pop_back(); }), "A");
    EXPECT_EQ(flags([](Scene& s) { s.window = std::string("lung"); }), "W");
    EXPECT_EQ(flags([](Scene& s) { s.shading.ambient = 0.9; }), "L");
    EXPECT_EQ(flags([](Scene& s) { s.lighting.finestLevel = 3; }), "L");
    EXPECT_EQ(flags([](Scene& s) {
                  s.measurements.push_back({MeasurementKind::distance, {{0, 0, 0}, {1, 1, 1}}});
              }),
              "");
    const auto cut = [](Scene& s) { s.cuts.planes.push_back({}); };
    EXPECT_EQ(flags(cut), "C");
    EXPECT_EQ(flags(cut, true), "AC") << "compiled in";
    EXPECT_EQ(flags([](Scene& s) { s.imageSize.x += 1; }), "A");
    EXPECT_EQ(flags([](Scene& s) { s.mode = Mode::maximum; }), "A");
    EXPECT_EQ(flags([](Scene& s) { s.surfaces.push_back({}); }), "A");
    EXPECT_EQ(flags([](Scene& s) { s.background = glm::vec3(1); }), "A");
    const auto outlined = [](Scene& s) {
        s.volumes[0].labels.outline = 3;
        s.volumes[0].labels.each[0].fill = 0.2;
    };
    drawn.volumes[0].labels.each = {{"liver"}};
    EXPECT_EQ(flags(outlined), "") << "over planes alone";
    EXPECT_EQ(flags([](Scene& s) { s.volumes[0].labels.each[0].opacity = 0.2; }), "A");
    drawn.mode = Mode::slice;
    EXPECT_EQ(flags(outlined), "A");
}

/// Of a field that is linear, mean and deviation over a disc are known.
TEST(DiscValues, AreThoseOfTheDisc) {
    VolumeInfo info;
    info.extentVoxels = {64, 64, 16};
    info.type = ValueType::i16;
    info.rescaleSlope = 0.5;
    info.rescaleIntercept = -10;
    info.patientFromVoxel = glm::dmat4(1);
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    FormulaSource source(info, [](const glm::dvec3& p) { return 20 * std::floor(p.x); });
    importToStore(source, folder / "v.zarr", ram, {});
    StoreReader store(folder / "v.zarr", ram);
    BrickCache cache(store, ram, std::size_t{16} << 20, 2);
    const auto circle = [](const glm::dvec3& at, double r) {
        return Measurement{MeasurementKind::circle,
                           {at + glm::dvec3(r, 0, 0), at + glm::dvec3(0, r, 0), at - glm::dvec3(r, 0, 0)}};
    };
    const DiscValues whole = discValues(cache, info, circle({32.5, 32.5, 8.5}, 10));
    EXPECT_NEAR(static_cast<double>(whole.samples), 3.14159 * 100 / 0.25, 25)
        << "two a voxel along each axis";
    EXPECT_NEAR(whole.mean, 310, 1e-6);               // 0.5 * 20 * 32 - 10
    EXPECT_NEAR(whole.deviation, 10 * 10 / 2.0, 0.5); // of a disc along an axis: half the radius
    EXPECT_NEAR(whole.least, 210, 1e-6);
    EXPECT_NEAR(whole.most, 410, 1e-6);
    const DiscValues half = discValues(cache, info, circle({64, 32.5, 8.5}, 10));
    EXPECT_NEAR(static_cast<double>(half.samples), static_cast<double>(whole.samples) / 2, 45);
    EXPECT_EQ(discValues(cache, info, circle({200, 200, 8.5}, 10)).samples, 0u) << "outside";
    EXPECT_EQ(discValues(cache, info, {MeasurementKind::distance, {{1, 1, 1}, {5, 5, 5}}}).samples, 0u);
    EXPECT_EQ(discValues(cache, info, {MeasurementKind::circle, {{1, 1, 1}, {2, 1, 1}, {3, 1, 1}}}).samples,
              0u);
}

/// A single slice is shown as the plane it is, from the feet, the front or the left, whichever way its rows,
/// columns and itself are numbered: by name along the patient's axes, else where it lies.
TEST(ThinVolumes, AreShownAsTheirPlane) {
    constexpr Orientation kNames[] = {Orientation::sagittal, Orientation::coronal, Orientation::axial};
    for (int thin = 0; thin < 3; ++thin)
        for (const double tilt : {0.0, 0.4})
            for (int flips = 0; flips < 8; ++flips) {
                VolumeInfo info;
                info.extentVoxels = {20, 16, 12};
                info.extentVoxels[thin] = 1;
                std::array<glm::dvec3, 3> axes = {glm::dvec3(0.8, 0, 0), glm::dvec3(0, 1.1, 0),
                                                  glm::dvec3(0, 0, 2)};
                const int b = (thin + 2) % 3; // turned about the third axis
                for (glm::dvec3& axis : axes) {
                    const double from = axis[b], to = axis[thin];
                    axis[b] = std::cos(tilt) * from - std::sin(tilt) * to;
                    axis[thin] = std::sin(tilt) * from + std::cos(tilt) * to;
                }
                const glm::dvec3 towards = axes[static_cast<std::size_t>(thin)] * (thin == 0 ? 1.0 : -1.0);
                glm::dvec3 first(10, -20, 30);
                const glm::dvec3 middle = first + 0.5 * (axes[0] * (info.extentVoxels.x - 1.0) +
                                                         axes[1] * (info.extentVoxels.y - 1.0) +
                                                         axes[2] * (info.extentVoxels.z - 1.0));
                for (int n = 0; n < 3; ++n)
                    if (glm::dvec3& axis = axes[static_cast<std::size_t>(n)]; flips >> n & 1) {
                        first += axis * (info.extentVoxels[n] - 1.0);
                        axis = -axis;
                    }
                info.patientFromVoxel = patientFromVoxelOf(first, axes[0], axes[1], axes[2]);
                Scene scene = sceneOf("v.zarr");
                const std::string said = faceThinVolume(scene, info, false);
                EXPECT_EQ(scene.mode, Mode::slice);
                if (tilt == 0) {
                    EXPECT_EQ(scene.slice.orientation, kNames[thin]) << "axis " << thin << ", " << flips;
                    EXPECT_EQ(scene.slice.positionMm, std::nullopt) << "its middle";
                } else {
                    EXPECT_EQ(scene.slice.orientation, Orientation::oblique);
                    EXPECT_LT(glm::length(scene.slice.normal - glm::normalize(towards)), 1e-12)
                        << "axis " << thin << ", " << flips;
                    EXPECT_LT(glm::length(scene.slice.point - middle), 1e-9);
                }
                EXPECT_NE(said.find("--slice " +
                                    orientationNames()[static_cast<std::size_t>(scene.slice.orientation)]),
                          std::string::npos);
                Scene asked = sceneOf("v.zarr"); // a side that somebody named stays
                faceThinVolume(asked, info, true);
                EXPECT_EQ(asked.mode, Mode::composite);
            }
}

/// A structure set by its kind, which stands whole within the first KiB; a mesh by its name's ending.
TEST(FileKinds, AreKnownByKindAndEnding) {
    const ScratchFolder folder;
    const std::string kind = "1.2.840.10008.5.1.4.1.1.481.3", front = std::string(128, '\0') + "DICM";
    const auto means = [&](const std::string& bytes) {
        std::ofstream(folder / "file", std::ios::binary) << bytes;
        return meansStructureSet(folder / "file");
    };
    EXPECT_TRUE(means(front + kind + '\0'));
    EXPECT_TRUE(means(front + "UI" + kind + "\x08\x01"));
    EXPECT_FALSE(means(front + kind)) << "perhaps it goes on";
    EXPECT_FALSE(means(front + kind + "1"));
    EXPECT_FALSE(means(front + kind + ".1"));
    EXPECT_TRUE(means(front + kind + '\0' + '.')) << "what follows is another element";
    EXPECT_FALSE(means(front + kind.substr(0, kind.size() - 1) + "2" + '\0'));
    EXPECT_FALSE(means(std::string(127, '\0') + "DICM" + kind + '\0' + '\0'));
    EXPECT_FALSE(means(std::string(128, '\0') + "DICN" + kind + '\0'));
    EXPECT_FALSE(means("DICM"));
    EXPECT_FALSE(means(""));
    const std::size_t room = 1024 - front.size() - kind.size();
    EXPECT_TRUE(means(front + std::string(room - 1, 'x') + kind + '\0'));
    EXPECT_FALSE(means(front + std::string(room, 'x') + kind + '\0')) << "its end is not looked at";
    for (const auto& [name, isMesh] : std::vector<std::pair<std::string, bool>>{{"a.ply", true},
                                                                                {"a.STL", true},
                                                                                {"a.Obj", true},
                                                                                {"a.gltf", true},
                                                                                {"a.glb", true},
                                                                                {"a.gl", false},
                                                                                {"ply", false},
                                                                                {"a.ply.gz", false}}) {
        EXPECT_FALSE(meansMesh(folder / name)) << name << " is not there";
        std::ofstream(folder / name) << "x";
        EXPECT_EQ(meansMesh(folder / name), isMesh) << name;
    }
    std::filesystem::create_directory(folder / "b.ply");
    EXPECT_FALSE(meansMesh(folder / "b.ply")) << "a folder";
    EXPECT_FALSE(meansStructureSet(folder / "b.ply"));
}

} // namespace
} // namespace tessera::test
