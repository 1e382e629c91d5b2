// tests/render/labels/slice_labels_test.cpp: labels over slices (docs/sampling.md, "Labels in slices"): areas
// by closed forms, the voxels themselves, every engine, and what must change nothing.
#include "core/image/image_metrics.h"
#include "render/labels/slice_labels.h"
#include "render/picture/render_scene.h"
#include "tests/support/formula_source.h"
#include "tests/support/labelled.h"
#include "tests/support/native_fixture.h"
#include "tests/support/refusals.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

using LabelAt = std::function<std::uint32_t(const glm::dvec3& mm)>;

/// A dark scan of voxels of 1 x 1 x 2 mm, and labels that are a formula of places.
struct SlicedScan {
    static constexpr glm::ivec3 kExtent{90, 96, 50};
    explicit SlicedScan(
        const LabelAt& at, const Formula& value = [](const glm::dvec3&) { return -1000.0; },
        const LabelAt& second = {}) {
        info.extentVoxels = kExtent;
        info.unit = "HU";
        info.patientFromVoxel = glm::dmat4(1);
        info.patientFromVoxel[2][2] = 2;
        info.patientFromVoxel[3] = {-40, 13, 5, 1};
        FormulaSource source(info, value);
        importToStore(source, store, ram, {});
        std::vector<HeldLayer> layers;
        for (const LabelAt& layer : {at, second})
            if (layer) {
                Values values(cellCount(kExtent));
                for (std::size_t i = 0; i < values.size(); ++i)
                    values[i] = layer(glm::dvec3(info.patientFromVoxel *
                                                 glm::dvec4(middleOf(gridPosition(i, kExtent)), 1)));
                layers.emplace_back(info, std::move(values));
            }
        LabelFile file = fileOf(layers);
        importLabels(file, info, labels, ram, quickly());
    }
    static glm::dvec3 middleOf(const glm::ivec3& voxel) { return glm::dvec3(voxel) + 0.5; }
    glm::dvec3 centre() const {
        return glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(kExtent), 1));
    }
    /// Black, where no label is; labels in pure red, without outlines.
    Scene scene(double mmPerPixel, const glm::ivec2& size) const {
        Scene s;
        s.volumes.resize(1);
        s.volumes[0].transferFunction = std::string("bone-1");
        s.mode = Mode::slice;
        s.slice.orientation = Orientation::axial;
        FittedView view;
        view.projection = Projection::parallel;
        view.mmPerPixel = mmPerPixel;
        s.camera = view;
        s.imageSize = size;
        s.window = GreyWindow{500, 1000};
        label(s, labels);
        Labels& l = s.volumes[0].labels;
        l.fill = 1;
        l.outline = 0;
        l.each = {{"*", {}, {}, glm::dvec3(1, 0, 0)}};
        return s;
    }
    RenderResult draw(const Scene& s, EngineKind engine = EngineKind::native,
                      const std::function<void(RenderOptions&)>& set = {}) {
        const StoreReader reader(store, ram);
        RenderOptions options;
        options.engine = engine;
        options.device.text = "software";
        if (set)
            set(options);
        return renderScene(s, reader, ram, gpu, options);
    }

  private:
    const ScratchFolder folder_;

  public:
    VolumeInfo info;
    MemoryBudget ram{"RAM", "--ram", std::size_t{512} << 20},
        gpu{"GPU memory", "--gpu-memory", std::size_t{512} << 20};
    const std::filesystem::path store = folder_ / "v.zarr", labels = folder_ / "l.zarr";
};

constexpr double kBall = 30; // mm
LabelAt ballAt(const glm::dvec3& centre, double radius = kBall) {
    return [=](const glm::dvec3& mm) { return glm::distance(mm, centre) < radius ? 1u : 0u; };
}
const glm::dvec3 kCentre{4, 60, 54};

double redOf(const Image& image) {
    double sum = 0;
    for (const glm::vec4& pixel : image.pixels)
        sum += static_cast<double>(pixel.r);
    return sum;
}

/// Looks along the normal of an oblique plane through a point, at an angle to all axes.
void lookObliquely(Scene& scene, const glm::dvec3& point, double mmPerPixel) {
    scene.slice.orientation = Orientation::oblique;
    scene.slice.normal = glm::normalize(glm::dvec3(0.4, -0.7, 0.59));
    scene.slice.point = point;
    Camera camera;
    camera.projection = Projection::parallel;
    camera.position = point + 300.0 * scene.slice.normal;
    camera.focalPoint = point;
    camera.viewUp = {0.5, 0.2, 1};
    camera.parallelScale = parallelScaleOf(mmPerPixel, scene.imageSize);
    scene.camera = camera;
}

// A ball is cut in a circle: its area, at any zoom.
TEST(SliceLabels, OfABallAreACircle) {
    SlicedScan scan(ballAt(kCentre));
    for (const double mmPerPixel : {0.2, 0.55, 1.7}) {
        Scene scene = scan.scene(mmPerPixel, glm::ivec2(static_cast<int>(std::lround(80 / mmPerPixel))));
        lookObliquely(scene, kCentre + 11.0 * glm::normalize(glm::dvec3(0.4, -0.7, 0.59)), mmPerPixel);
        const double radius = std::sqrt(kBall * kBall - 11 * 11) / mmPerPixel;
        const double area = glm::pi<double>() * radius * radius;
        EXPECT_NEAR(redOf(scan.draw(scene).image), area, std::max(0.005 * area, 0.15 * radius))
            << mmPerPixel << " mm a pixel, a circle of " << radius << " pixels";
    }
}

// An outline lies inside of a border, and is as wide as it says wherever that goes on the picture.
TEST(SliceLabels, HaveOutlinesOfTheirWidth) {
    constexpr double kFrom = -10, kTo = 12; // mm, faces of voxels
    SlicedScan scan([](const glm::dvec3& mm) { return mm.x > kFrom && mm.x < kTo ? 1u : 0u; });
    for (const double mmPerPixel : {0.15, 0.5, 1.9}) {
        Scene scene = scan.scene(mmPerPixel, glm::ivec2(static_cast<int>(std::lround(56 / mmPerPixel))));
        lookObliquely(scene, kCentre, mmPerPixel);
        Labels& labels = scene.volumes[0].labels;
        labels.fill = 0;
        const PlanePlaces places =
            planePlaces(std::get<Camera>(scene.camera), scene.slice, scan.info, scene.imageSize);
        const auto x = [&](const glm::dvec2& pixel) { return places.at(pixel)->x - 40; };
        const double mm =
            glm::length(glm::dvec2(x({1, 0}) - x({0, 0}), x({0, 1}) - x({0, 0}))); // across, a pixel
        for (const double width : {1.0, 2.75}) {
            labels.outline = width;
            double expected = 0;
            constexpr int kFine = 8; // places along a pixel
            for (int j = 0; j < scene.imageSize.y * kFine; ++j)
                for (int i = 0; i < scene.imageSize.x * kFine; ++i) {
                    const double at = x((glm::dvec2(i, j) + 0.5) / double{kFine});
                    expected +=
                        (at > kFrom && at < kFrom + width * mm) || (at < kTo && at > kTo - width * mm);
                }
            expected /= kFine * kFine;
            EXPECT_NEAR(redOf(scan.draw(scene).image), expected, 0.06 / width * expected)
                << width << " pixels, " << mmPerPixel << " mm a pixel";
        }
    }
}

// A camera in perspective looks at the same plane.
TEST(SliceLabels, ArePlacesOnThePlaneFromAnywhere) {
    SlicedScan scan(ballAt(kCentre));
    Scene scene = scan.scene(0.5, {200, 200});
    scene.slice.positionMm = kCentre.z;
    const double area = glm::pi<double>() * kBall * kBall / (0.5 * 0.5);
    Camera camera;
    camera.position = kCentre - glm::dvec3(0, 0, 200);
    camera.focalPoint = kCentre;
    camera.viewUp = {0, -1, 0};
    camera.viewAngle = 2 * glm::degrees(std::atan(50.0 / 200));
    scene.camera = camera;
    EXPECT_NEAR(redOf(scan.draw(scene).image), area, 0.005 * area);
    // Obliquely, a circle is an ellipse: its width is that of the circle.
    camera.projection = Projection::parallel;
    camera.position = kCentre + glm::dvec3(0, 100, -173.2);
    camera.viewUp = {0, -1, 0};
    camera.parallelScale = 50;
    scene.camera = camera;
    EXPECT_NEAR(redOf(scan.draw(scene).image), area * std::cos(glm::radians(30.0)), 0.01 * area);
}

// Nearest borders are the voxels' faces.
TEST(SliceLabels, WithNearestBordersAreTheVoxels) {
    const auto at = [](const glm::dvec3& mm) {
        const auto x = static_cast<std::uint32_t>(mm.x + 100), y = static_cast<std::uint32_t>(mm.y);
        return (x * 7 + y * 13 + static_cast<std::uint32_t>(mm.z) * 5) % 11 / 4;
    };
    SlicedScan scan(at);
    constexpr int kPixels = 3; // a voxel's edge
    Scene scene =
        scan.scene(1.0 / kPixels, {kPixels * SlicedScan::kExtent.x, kPixels * SlicedScan::kExtent.y});
    Labels& labels = scene.volumes[0].labels;
    labels.borders = LabelBorders::nearest;
    labels.each = {{"1", {}, {}, glm::dvec3(1, 0, 0)}, {"2", {}, {}, glm::dvec3(0, 1, 0)}};
    for (const double z : {54.0, 54.5, 55.0, 55.9}) { // of one layer of voxels; 55 is on a face
        scene.slice.positionMm = z;
        const Image image = scan.draw(scene).image;
        std::size_t wrong = 0;
        const auto layer = static_cast<int>(std::floor((z - 5) / 2));
        for (int y = 0; y < image.size.y; ++y)
            for (int x = 0; x < image.size.x; ++x) {
                const glm::ivec3 voxel(x / kPixels, y / kPixels, layer);
                const glm::dvec3 mm(scan.info.patientFromVoxel * glm::dvec4(SlicedScan::middleOf(voxel), 1));
                const std::uint32_t value = at(mm);
                const glm::vec4 expected(value == 1, value == 2, 0, 1);
                wrong += image.at(x, y) != expected;
            }
        EXPECT_EQ(wrong, 0u) << z;
    }
}

// Where three bodies meet no place is left without a label, halfway between two layers of voxels too.
TEST(SliceLabels, ThatMeetLeaveNoGap) {
    const auto at = [](const glm::dvec3& mm) {
        const double turn = std::atan2(mm.y - 60.3, mm.x - 4.2) / glm::two_pi<double>() + 0.5 + 0.01 * mm.z;
        return 1 + static_cast<std::uint32_t>(3 * (turn - std::floor(turn)));
    };
    SlicedScan scan(at);
    for (const double z : {54.0, 54.31, 55.0}) {
        Scene scene = scan.scene(0.4, {200, 200});
        scene.slice.positionMm = z;
        scene.volumes[0].labels.each = {{"1", {}, {}, glm::dvec3(1, 0, 0)},
                                        {"2", {}, {}, glm::dvec3(0, 1, 0)},
                                        {"3", {}, {}, glm::dvec3(0, 0, 1)}};
        const Image image = scan.draw(scene).image;
        for (const glm::vec4& pixel : image.pixels)
            ASSERT_NEAR(pixel.r + pixel.g + pixel.b, pixel.a, 1e-5f) << z;
        // Outlines of neighbours lie side by side, each in its own colour.
        scene.volumes[0].labels.fill = 0;
        scene.volumes[0].labels.outline = 1;
        const RenderResult outlines = scan.draw(scene);
        glm::vec3 sums(0);
        for (const glm::vec4& pixel : outlines.image.pixels)
            sums += glm::vec3(pixel);
        for (int c = 0; c < 3; ++c) // two borders of some 130 pixels; halfway between layers they are rough
            EXPECT_NEAR(sums[c], 270, 60) << c << ", " << z;
        ASSERT_TRUE(outlines.labels);
        EXPECT_EQ(outlines.labels->countOnSlice(), 3u);
    }
}

// A layer of voxels is there from face to face, also where another layer has the same share.
TEST(SliceLabels, OfOneLayerAreSeenFromFaceToFace) {
    SlicedScan scan([](const glm::dvec3& mm) { return mm.z == 56 && std::abs(mm.x) < 20 ? 1u : 0u; });
    Scene scene = scan.scene(0.5, {240, 240});
    for (const double z : {55.0, 55.3, 56.0, 57.0}) {
        scene.slice.positionMm = z;
        EXPECT_GE(redOf(scan.draw(scene).image), 39 * 96 * 4 - 1) << z; // its end rounded off
        scene.slice.positionMm = z < 56 ? 54.9 : 57.1;
        EXPECT_EQ(redOf(scan.draw(scene).image), 0) << z;
    }
}

/// Two layers that overlap, and values that are not even.
SlicedScan& overlapping() {
    static SlicedScan scan(
        ballAt(kCentre, 25),
        [](const glm::dvec3& p) { return 300 + 200 * std::sin(0.4 * p.x) * std::cos(0.3 * p.y + 0.2 * p.z); },
        [](const glm::dvec3& mm) {
            return glm::distance(mm, kCentre + glm::dvec3(15, 6, 3)) < 22 ? 2u : mm.x < -20 ? 3u : 0u;
        });
    return scan;
}

Scene overlappingScene() {
    Scene scene = overlapping().scene(0.6, {160, 160});
    Labels& labels = scene.volumes[0].labels;
    labels.fill = 0.4;
    labels.outline = 1.5;
    labels.each = {{"2", LabelLook::tint, 0.7, glm::dvec3(0, 1, 0.5)},
                   {.of = "3", .fill = 0.9, .outline = 0.0}};
    return scene;
}

TEST(SliceLabels, AreTheSameOnEveryEngine) {
    SlicedScan& scan = overlapping();
    Scene scene = overlappingScene(), bare = scene;
    bare.volumes[0].labels = {};
    const Image native = scan.draw(scene).image;
    EXPECT_EQ(differing(scan.draw(scene, EngineKind::mirror).image, native), 0u);
    for (const EngineKind engine : {EngineKind::gpu, EngineKind::reference}) {
        const double apart = compare(scan.draw(bare, engine).image, scan.draw(bare).image).maxAbs;
        EXPECT_LE(compare(scan.draw(scene, engine).image, native).maxAbs, apart + 1e-6) << name(engine);
    }
    EXPECT_GT(compare(native, scan.draw(bare).image).maxAbs, 0.2);
    // Threads and tiles decide about nothing.
    EXPECT_EQ(differing(scan.draw(scene, EngineKind::native, [](RenderOptions& o) { o.threads = 1; }).image,
                        native),
              0u);
}

// Each look by its formula, over the values that a picture without labels has.
TEST(SliceLabels, FillByTheirLooks) {
    SlicedScan& scan = overlapping();
    Scene scene = overlappingScene();
    Labels& labels = scene.volumes[0].labels;
    labels.outline = 0;
    const glm::vec3 red(1, 0.25f, 0), green(0, 1, 0.5f);
    labels.each = {{"1", LabelLook::solid, 0.3, glm::dvec3(red)},
                   {"2", LabelLook::tint, 0.7, glm::dvec3(green), {}, {}},
                   {"3", LabelLook::plain, {}, {}, {}, {}}};
    labels.fill.reset();
    Scene bare = scene;
    bare.volumes[0].labels = {};
    scene.slice.positionMm = bare.slice.positionMm = kCentre.z;
    const RenderResult drawn = scan.draw(scene), values = scan.draw(bare);
    const auto at = [&](const glm::dvec3& mm) {
        const glm::dvec2 offMm(mm.x - scan.centre().x, mm.y - scan.centre().y);
        const glm::ivec2 pixel(glm::floor(80.0 + offMm / 0.6));
        return std::pair(glm::vec3(drawn.image.at(pixel.x, pixel.y)),
                         glm::vec3(values.image.at(pixel.x, pixel.y)));
    };
    const auto expectNear = [](const glm::vec3& found, const glm::vec3& expected) {
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], expected[c], 1e-5f) << c;
    };
    const auto solid = [&](const glm::vec3& c) { return 0.7f * c + 0.3f * red; };
    const auto tinted = [&](const glm::vec3& c) { return 0.3f * c + 0.7f * c * green; };
    const auto [one, underOne] = at(kCentre - glm::dvec3(15, 0, 0));
    expectNear(one, solid(underOne));
    const auto [two, underTwo] = at(kCentre + glm::dvec3(30, 8, 0));
    expectNear(two, tinted(underTwo));
    const auto [both, underBoth] = at(kCentre + glm::dvec3(10, 3, 0));
    expectNear(both, 0.5f * (solid(underBoth) + tinted(underBoth)));
    const auto [plain, underPlain] = at({-30, 60, 0});
    EXPECT_EQ(plain, underPlain);
    EXPECT_GT(underPlain.r, 0);
}

TEST(SliceLabels, ThatAreHiddenChangeNothing) {
    SlicedScan& scan = overlapping();
    Scene scene = overlappingScene(), bare = scene;
    bare.volumes[0].labels = {};
    Labels& labels = scene.volumes[0].labels;
    const Image values = scan.draw(bare).image;
    labels.hide = {"*"};
    EXPECT_EQ(differing(scan.draw(scene).image, values), 0u);
    labels.hide.clear();
    labels.fill = 0;
    labels.outline = 0;
    labels.each.clear();
    EXPECT_EQ(differing(scan.draw(scene).image, values), 0u);
    // One of them hidden is a file that never had it.
    SlicedScan without(ballAt(kCentre, 25), [](const glm::dvec3& p) {
        return 300 + 200 * std::sin(0.4 * p.x) * std::cos(0.3 * p.y + 0.2 * p.z);
    });
    scene = overlappingScene();
    Scene alone = without.scene(0.6, {160, 160});
    alone.volumes[0].labels = scene.volumes[0].labels;
    alone.volumes[0].labels.path = alone.volumes[0].labels.store = without.labels;
    alone.volumes[0].labels.each.clear();
    scene.volumes[0].labels.hide = {"2", "3"};
    scene.volumes[0].labels.each.clear();
    EXPECT_EQ(differing(scan.draw(scene).image, without.draw(alone).image), 0u);
}

// Labels that hide all values leave no error, however wrong those are; others some.
TEST(SliceLabels, AreInTheTruthThatErrorsAreMeasuredAgainst) {
    SlicedScan scan(
        [](const glm::dvec3& mm) {
            return 1 +
                   (static_cast<std::uint32_t>(mm.x + 100) / 7 + static_cast<std::uint32_t>(mm.y) / 9) % 2;
        },
        [](const glm::dvec3& p) { return std::fmod(p.x, 2) < 1 ? 0.0 : 900.0; });
    Scene scene = scan.scene(1.1, {70, 70}); // a pixel alone has the labels that it has in a tile
    scene.quality.pixels.samples = 1;
    scene.volumes[0].labels.each = {{"1", {}, {}, glm::dvec3(0.5, 0.1, 0)},
                                    {"2", LabelLook::solid, {}, glm::dvec3(0, 0.2, 0.9)}};
    const auto errorOf = [&](double fill, double outline = 0) {
        scene.volumes[0].labels.fill = fill;
        scene.volumes[0].labels.outline = outline;
        const RenderResult result =
            scan.draw(scene, EngineKind::native, [](RenderOptions& o) { o.verify = Verify::full; });
        EXPECT_TRUE(result.measured && result.measured->whyNot.empty() && result.measured->all.rms);
        return result.measured->all.rms->value;
    };
    const double bare = errorOf(0), half = errorOf(0.5);
    EXPECT_LE(errorOf(1), 1e-6);
    EXPECT_LE(errorOf(1, 1.5), 1e-6);
    const double outlined = errorOf(0, 1.5);
    EXPECT_TRUE(outlined > 0 && outlined < bare);
    EXPECT_GT(bare, 0.02);
    EXPECT_NEAR(half, 0.5 * bare, 0.15 * bare);
}

// A plate of one voxel stays where 8 voxels are a pixel.
TEST(SliceLabels, ThatAreThinStayFromAfar) {
    SlicedScan scan([](const glm::dvec3& mm) { return std::floor(mm.x) == 3 ? 1u : 0u; });
    Scene scene = scan.scene(8, {12, 12});
    scene.volumes[0].labels.outline = 1;
    const RenderResult result = scan.draw(scene);
    ASSERT_TRUE(result.labels);
    EXPECT_EQ(result.labels->level, 2);
    EXPECT_NEAR(redOf(result.image), 12 * 5 / 8.0, 12 * 2 / 8.0) << "four voxels wide, met by 2 or 3 places";
    // So does a rod, while its voxels are met.
    SlicedScan rod(
        [](const glm::dvec3& mm) { return std::floor(mm.x) == 3 && std::floor(mm.y) == 40 ? 1u : 0u; });
    scene = rod.scene(2.9, {33, 33});
    EXPECT_NEAR(redOf(rod.draw(scene).image), 0.61 / (2.9 * 2.9), 0.03) << "its corners are rounded";
}

// Cuts cut labels too; nothing is drawn beside the volume.
TEST(SliceLabels, EndWhereValuesDo) {
    SlicedScan scan([](const glm::dvec3&) { return 1u; });
    Scene scene = scan.scene(0.5, {300, 300});
    scene.volumes[0].labels.outline = 2;
    EXPECT_NEAR(redOf(scan.draw(scene).image), 90 * 96 * 4, 4 * (90 + 96));
    scene.volumes[0].labels.fill = 0; // and have no outline there
    EXPECT_EQ(redOf(scan.draw(scene).image), 0);
    scene.volumes[0].labels.fill = 1;
    scene.cuts.planes = {{scan.centre(), {1, 0, 0}}};
    const RenderResult cut = scan.draw(scene);
    EXPECT_NEAR(redOf(cut.image), 45 * 96 * 4, 4 * (90 + 96));
    for (const glm::vec4& pixel : cut.image.pixels)
        ASSERT_NEAR(pixel.r, pixel.a, 1e-6f);
}

TEST(SliceLabels, OfAFurtherVolumeLieOverItsOwnValues) {
    SlicedScan first(ballAt(kCentre, 10)), second(ballAt(kCentre + glm::dvec3(30, 0, 0), 12));
    Scene scene = first.scene(0.5, {200, 200});
    scene.slice.positionMm = kCentre.z;
    scene.volumes.push_back(second.scene(0.5, {200, 200}).volumes[0]);
    scene.volumes[1].labels.each = {{"*", {}, {}, glm::dvec3(0, 1, 0)}};
    scene.volumes[1].valueColour = ValueColour::transferFunction; // shows nothing of such values
    scene.fusion = Fusion::over;
    const StoreReader a(first.store, first.ram), b(second.store, first.ram);
    const StoreReader* const stores[] = {&a, &b};
    RenderOptions options;
    options.engine = EngineKind::native;
    const RenderResult result = renderScene(scene, stores, first.ram, first.gpu, options);
    double green = 0;
    for (const glm::vec4& pixel : result.image.pixels)
        green += static_cast<double>(pixel.g);
    EXPECT_NEAR(redOf(result.image), glm::pi<double>() * 100 * 4, 40);
    EXPECT_NEAR(green, glm::pi<double>() * 144 * 4, 40);
    ASSERT_TRUE(result.labels);
    EXPECT_EQ(result.labels->countOnSlice(), 2u);
}

TEST(SliceLabels, ThatCannotBeReadAreNamed) {
    SlicedScan scan(ballAt(kCentre));
    const Scene scene = scan.scene(0.5, {100, 100});
    MemoryBudget small("RAM", "--ram", std::size_t{400} << 10);
    const std::string refusal =
        refusalOf([&] { SliceLabels(scene.volumes[0].labels, scan.info, small, 2, "labels"); });
    EXPECT_NE(refusal.find("--ram"), std::string::npos) << refusal;
    EXPECT_EQ(small.usedBytes(), 0u);
    const std::filesystem::path chunks = scan.labels / "0/c/0/0/0";
    std::fstream file(chunks, std::ios::in | std::ios::out | std::ios::binary);
    ASSERT_TRUE(file);
    for (std::uintmax_t at = 0; at + 4096 < std::filesystem::file_size(chunks); at += 64)
        file.seekp(static_cast<std::streamoff>(at)).put('\x5A');
    file.seekp(8).write("damaged by a test", 17);
    file.close();
    const std::string damage = refusalOf([&] { scan.draw(scene); });
    EXPECT_NE(damage.find(scan.labels.string()), std::string::npos) << damage;
}

} // namespace
} // namespace tessera
