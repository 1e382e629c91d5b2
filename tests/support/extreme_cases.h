// tests/support/extreme_cases.h: the nasty cases that pictures must survive, as factors and their levels.
// These are stiff, narrow and degenerate transfer functions, volumes of one voxel and of extreme values, and
// slices 1000 times thicker than pixels. They also are far origins, cameras on faces, edges and corners, and
// every step. A case is one level per factor; it becomes a volume, a scene, and a text that names it
// completely.
#pragma once

#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "tests/support/bricking_test_volumes.h" // HashSource
#include "tests/support/covering_array.h"
#include "tests/support/scene_fixture.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace tessera::test {

/// What is compiled: few combinations, because each costs a third of a second on a software device.
struct Structure {
    Fetch fetch = Fetch::exact;
    bool termination = false, mixed = false, shading = false, skipping = true;
    bool lights = false; // of the scene's own, one where the camera is
    Integrator integrator = Integrator::midpoint;
    Gradient gradient = Gradient::central;
    bool operator==(const Structure&) const = default;
};

/// With exact fetches, which are compared bit by bit, every pair of compile-time choices; with filtered ones
/// each integrator once. Also the one choice that the scene leaves open.
inline const std::vector<Structure>& structures() {
    static const std::vector<Structure> all = [] {
        std::vector<Structure> out;
        const auto gradient = [&] { return static_cast<Gradient>(out.size() % 5); };
        for (const std::vector<int>& r : coveringArray({4, 2, 2, 3, 2}, 1))
            out.push_back({Fetch::exact, r[1] == 1, r[2] == 1, r[3] >= 1, r[4] == 0, r[3] == 2,
                           static_cast<Integrator>(r[0] + 1), gradient()});
        for (int i = 1; i <= 4; ++i)
            out.push_back({Fetch::hardware, i % 2 == 0, i >= 3, i == 1 || i == 4, i != 2, i == 4,
                           static_cast<Integrator>(i), gradient()});
        out.push_back({Fetch::exact, true, false, true, true, false, Integrator::automatic, gradient()});
        return out;
    }();
    return all;
}

enum Factor : std::size_t {
    kStructure,
    kStrength,
    kFunction,
    kVolume,
    kSpacing,
    kOrigin,
    kShear,
    kLens,
    kPlace,
    kDirection,
    kStep,
    kSize,
    kEdge,
    kSampling,
    kVariant, // which of equal faces, edges, corners, signs
    kFactorCount
};

/// Names of the levels of every factor but the first.
inline const std::array<std::vector<std::string>, kFactorCount>& levelNames() {
    static const std::array<std::vector<std::string>, kFactorCount> names = {{
        {},
        {"1e-6 per voxel", "1e-5 per voxel", "1e-4 per voxel", "1e-3 per voxel", "1e-2 per voxel",
         "0.1 per voxel", "1 per voxel", "10 per voxel", "100 per voxel", "1e3 per voxel", "1e4 per voxel",
         "1e5 per voxel", "1e6 per voxel", "opacity 2^-24", "opacity 1e-6", "opacity 0.5", "opacity 1-2^-24",
         "opacity 1"},
        {"tent 1", "tent 1/64", "tent 1/4096", "ramp", "no points", "one point", "all at one value", "steps",
         "box 1/4096"},
        {"waves i16 40x36x34", "noise u16 35x35x35", "-32768 and 32767 33x34x40", "ramp f32 40x33x5",
         "one voxel 1x1x1", "sheet 1x37x33", "rod 40x1x1", "constant u8 36x20x35", "tiny f32 34x33x10",
         "largest floats 33x20x9"},
        {"1:1:1", "1:1:5", "1:1:1000"},
        {"0", "1e3 mm", "1e6 mm"},
        {"straight", "sheared", "oblique, left-handed"},
        {"parallel", "1 degree", "30 degrees", "90 degrees", "170 degrees"},
        {"far", "1 voxel outside", "on a face", "on an edge", "on a corner", "centre"},
        {"axis +", "axis -", "face diagonal", "body diagonal", "random", "almost an axis"},
        {"2", "1", "1/2", "1/4", "1/16"},
        {"12x10", "1x1", "7x5", "2x13", "15x1"},
        edgeFunctionNames(),
        {"full", "limited", "naive"}, // hulls have lattices of their own, and not all integrators
        {"0", "1", "2", "3", "4", "5"},
    }};
    return names;
}
inline std::vector<int> levelCounts() {
    std::vector<int> counts;
    for (const auto& names : levelNames())
        counts.push_back(static_cast<int>(names.size()));
    counts[kStructure] = static_cast<int>(structures().size());
    return counts;
}

struct ExtremeCase {
    std::vector<int> levels; // one per factor
    int operator[](Factor f) const { return levels[f]; }
    const Structure& structure() const { return structures()[static_cast<std::size_t>(levels[kStructure])]; }
    /// The numbers alone: what TESSERA_EXTREME_CASE takes.
    std::string code() const {
        std::string text;
        for (const int level : levels)
            text += (text.empty() ? "" : ",") + std::to_string(level);
        return text;
    }
};
inline std::ostream& operator<<(std::ostream& out, const ExtremeCase& c) {
    const Structure& s = c.structure();
    out << "TESSERA_EXTREME_CASE=" << c.code() << ": "
        << integratorNames()[static_cast<std::size_t>(s.integrator)]
        << (s.fetch == Fetch::exact ? ", exact" : ", hardware") << (s.termination ? ", termination" : "")
        << (s.mixed ? ", mixed levels" : "")
        << (s.shading ? ", lit by gradient " + gradientNames()[static_cast<std::size_t>(s.gradient)] : "")
        << (s.lights ? ", by lights of its own" : "") << (s.skipping ? ", skipping" : "");
    const char* factors[kFactorCount] = {"",       "strength", "function", "volume",   "spacing",
                                         "origin", "axes",     "lens",     "camera",   "direction",
                                         "step",   "picture",  "edge",     "sampling", "variant"};
    for (std::size_t f = 1; f < kFactorCount; ++f)
        out << "; " << factors[f] << " " << levelNames()[f][static_cast<std::size_t>(c.levels[f])];
    return out;
}

inline std::vector<ExtremeCase> pairwiseCases() {
    std::vector<ExtremeCase> cases;
    for (std::vector<int>& row : coveringArray(levelCounts(), 2))
        cases.push_back({std::move(row)});
    return cases;
}
/// Tables of two-dimensional pre-integration take half a second each: one in five of the random cases that
/// draw one keeps it.
inline std::vector<ExtremeCase> randomCases(int count, unsigned seed) {
    std::mt19937 random(seed);
    const std::vector<int> levels = levelCounts();
    std::vector<ExtremeCase> cases(static_cast<std::size_t>(count));
    for (ExtremeCase& c : cases) {
        for (const int n : levels)
            c.levels.push_back(static_cast<int>(random() % static_cast<unsigned>(n)));
        if (random() % 5 != 0)
            while (c.structure().integrator == Integrator::preintegrated2d)
                c.levels[kStructure] = static_cast<int>(random() % structures().size());
    }
    return cases;
}

/// A volume of a case, before it is stored.
struct ExtremeVolume {
    VolumeInfo info;
    HashSource::Formula formula;    // none: noise over the type's whole range
    double lowest = 0, highest = 1; // physical values that functions spread over
    /// Values or their differences are beyond the range or resolution of floats: equality is not expected.
    bool beyondFloat = false;
};

inline ExtremeVolume volumeOf(const ExtremeCase& c) {
    ExtremeVolume v;
    const auto define = [&](const glm::ivec3& extent, ValueType type, double slope, double intercept,
                            double storedLowest, double storedHighest, HashSource::Formula formula) {
        v.info.extentVoxels = extent;
        v.info.type = type;
        v.info.rescaleSlope = slope;
        v.info.rescaleIntercept = intercept;
        v.formula = std::move(formula);
        const double a = slope * storedLowest + intercept, b = slope * storedHighest + intercept;
        v.lowest = std::min(a, b);
        v.highest = std::max(a, b);
    };
    switch (c[kVolume]) {
    case 0:
        define({40, 36, 34}, ValueType::i16, 1, -24, -1000, 1000, [](int x, int y, int z) {
            return std::round(1000 * std::sin(0.31 * x + 0.2) * std::cos(0.23 * y) * std::sin(0.19 * z + 1));
        });
        break;
    case 1:
        define({35, 35, 35}, ValueType::u16, -0.1, 100, 0, 65535, {});
        break;
    case 2:
        define({33, 34, 40}, ValueType::i16, 1, 0, -32768, 32767,
               [](int x, int y, int z) { return ((x / 3 + y / 2 + z) & 1) ? 32767.0 : -32768.0; });
        break;
    case 3:
        define({40, 33, 5}, ValueType::f32, 2, 1, 0, 45,
               [](int x, int y, int z) { return x + 0.125 * y + 0.25 * z; });
        break;
    case 4:
        define({1, 1, 1}, ValueType::i16, 1, 0, 0, 200, [](int, int, int) { return 90.0; });
        break;
    case 5:
        define({1, 37, 33}, ValueType::i16, 0.5, 0, -300, 300,
               [](int, int y, int z) { return std::round(300 * std::sin(0.4 * y) * std::cos(0.3 * z)); });
        break;
    case 6:
        define({40, 1, 1}, ValueType::u8, 1, 0, 0, 255, [](int x, int, int) { return 255.0 - 6 * x; });
        break;
    case 7:
        define({36, 20, 35}, ValueType::u8, 1, 0, 0, 255, [](int, int, int) { return 128.0; });
        break;
    case 8: // denormal beside tiny: a device may flush the former
        define({34, 33, 10}, ValueType::f32, 1, 0, 0, 1e-36, [](int x, int y, int z) {
            return static_cast<double>(static_cast<float>((x + y + z) % 7 ? 1e-37 * ((x + y) % 11) : 1e-40));
        });
        v.beyondFloat = true;
        break;
    default: // differences of voxels are infinite in float
        define({33, 20, 9}, ValueType::f32, 1, 0, -3.4e38, 3.4e38, [](int x, int y, int z) {
            return ((x + y + z) & 1 ? 1.0 : -1.0) * static_cast<double>(std::numeric_limits<float>::max());
        });
        v.beyondFloat = true;
    }
    const double thickness = std::array{1.0, 5.0, 1000.0}[static_cast<std::size_t>(c[kSpacing])];
    glm::dvec3 x(0.5, 0, 0), y(0, 0.5, 0), z(0, 0, 0.5 * thickness);
    if (c[kShear] == 1)
        y = {0.15, 0.5, 0}, z = glm::dvec3(-0.1, 0.2, 0.5) * thickness;
    if (c[kShear] == 2)
        x = {-0.4, 0.3, 0}, y = {0.24, 0.32, 0.3}, z = glm::dvec3(-0.18, -0.24, 0.4) * thickness;
    const double away = std::array{0.0, 1e3, 1e6}[static_cast<std::size_t>(c[kOrigin])];
    v.info.patientFromVoxel = patientFromVoxelOf(away * glm::dvec3(1, -0.7, 0.4), x, y, z);
    return v;
}

inline double voxelMm(const VolumeInfo& info) {
    const glm::dvec3 mm = info.spacingMm();
    return std::cbrt(mm.x * mm.y * mm.z);
}

/// Extinction per voxel at the function's peak.
inline double peakPerVoxel(const ExtremeCase& c) {
    constexpr int kExtinctions = 13;
    if (c[kStrength] < kExtinctions)
        return std::pow(10.0, c[kStrength] - 6);
    const double opacities[] = {0x1p-24, 1e-6, 0.5, 1 - 0x1p-24, 1 - 0x1p-24};
    return -std::log1p(-opacities[c[kStrength] - kExtinctions]);
}
/// Constant wherever it is not transparent, colour too.
inline bool isConstant(const ExtremeCase& c) {
    return c[kFunction] == 4 || c[kFunction] == 5;
}
/// Smooth or piecewise linear over much of the range.
inline bool isWide(const ExtremeCase& c) {
    return c[kFunction] == 0 || c[kFunction] == 3;
}

inline TransferFunction functionOf(const ExtremeCase& c, const ExtremeVolume& volume) {
    constexpr int kExtinctions = 13;
    const bool opacities = c[kStrength] >= kExtinctions;
    const double mm = voxelMm(volume.info);
    const double given[] = {0x1p-24, 1e-6, 0.5, 1 - 0x1p-24, 1};
    const double peak = opacities ? given[c[kStrength] - kExtinctions] : peakPerVoxel(c) / mm;
    const double low = volume.lowest, high = volume.highest, width = high - low,
                 middle = 0.5 * low + 0.5 * high;
    const auto tent = [&](double share) -> std::vector<OpacityPoint> {
        const double half = 0.5 * share * width;
        return {{middle - half, 0}, {middle, peak}, {middle + half, 0}};
    };
    std::vector<OpacityPoint> points;
    std::vector<ColourPoint> colours = {{low, {0.1, 0.9, 0.4}}, {middle, {1, 0.5, 0}}, {high, {0, 0.2, 1}}};
    switch (c[kFunction]) {
    case 0:
        points = tent(1);
        break;
    case 1:
        points = tent(1.0 / 64);
        break;
    case 2:
        points = tent(1.0 / 4096);
        break;
    case 3:
        points = {{low, 0}, {high, peak}};
        colours = {{low, {0, 0.5, 1}}, {high, {1, 0.25, 0}}};
        break;
    case 4:
        break; // shows nothing
    case 5:
        points = {{middle, peak}};
        colours = {{middle, {0.9, 0.5, 0.1}}};
        break;
    case 6:
        points = {{middle, 0}, {middle, 0.3 * peak}, {middle, peak}};
        colours = {{middle, {1, 0, 0}}, {middle, {0, 1, 0}}, {middle, {0, 0, 1}}};
        break;
    case 7:
        for (int i = 0; i < 8; ++i) {
            const double at = low + (i + 0.5) / 8 * width;
            points.push_back({at, i % 2 ? peak : 0});
            points.push_back({at, i % 2 ? 0 : peak});
        }
        break;
    default:
        points = {{middle - width / 8192, 0},
                  {middle - width / 8192, peak},
                  {middle + width / 8192, peak},
                  {middle + width / 8192, 0}};
    }
    return opacities ? TransferFunction::fromOpacity(points, colours, mm)
                     : TransferFunction::fromExtinction(points, colours);
}

inline glm::ivec2 pictureSize(const ExtremeCase& c) {
    return std::array{glm::ivec2(12, 10), glm::ivec2(1, 1), glm::ivec2(7, 5), glm::ivec2(2, 13),
                      glm::ivec2(15, 1)}[static_cast<std::size_t>(c[kSize])];
}

/// Places and directions are those of voxel space, so that axes are the volume's under any affine.
inline Camera cameraOf(const ExtremeCase& c, const VolumeInfo& info) {
    const int variant = c[kVariant], axis = variant % 3;
    const double sign = variant < 3 ? 1 : -1;
    glm::dvec3 along(0);
    switch (c[kDirection]) {
    case 0:
        along[axis] = 1;
        break;
    case 1:
        along[axis] = -1;
        break;
    case 2:
        along[axis] = 1, along[(axis + 1) % 3] = sign;
        break;
    case 3:
        along = {sign, axis == 1 ? -1 : 1, axis == 2 ? -1 : 1};
        break;
    case 4: {
        std::mt19937 random(static_cast<unsigned>(variant + 10 * c[kPlace] + 100 * c[kVolume]));
        std::normal_distribution<double> normal;
        along = {normal(random), normal(random), normal(random)};
        break;
    }
    default: // the other components vanish in float, or are denormal there
        along[axis] = sign, along[(axis + 1) % 3] = 1e-30, along[(axis + 2) % 3] = -1e-42;
    }
    along = glm::normalize(along);
    const glm::dvec3 extent(info.extentVoxels), centre = 0.5 * extent;
    const double angles[] = {30, 1, 30, 90, 170};
    const double angle = angles[c[kLens]], diagonal = glm::length(extent);
    glm::dvec3 at = centre;
    switch (c[kPlace]) {
    case 0:
        at = centre - std::max(3.0, 0.6 / std::tan(glm::radians(angle) / 2)) * (c[kLens] == 0 ? 1e3 : 1) *
                          diagonal * along;
        break;
    case 1: {
        double enter = -std::numeric_limits<double>::max();
        for (int a = 0; a < 3; ++a)
            if (along[a] != 0)
                enter = std::max(enter, -0.5 * extent[a] / std::abs(along[a]));
        at = centre + (enter - 1) * along;
        break;
    }
    case 2:
        at[axis] = sign > 0 ? 0 : extent[axis];
        break;
    case 3:
        at[axis] = sign > 0 ? 0 : extent[axis], at[(axis + 1) % 3] = extent[(axis + 1) % 3];
        break;
    case 4:
        at = {sign > 0 ? 0 : extent.x, axis == 1 ? 0 : extent.y, axis == 2 ? 0 : extent.z};
        break;
    default:
        break;
    }
    Camera camera;
    camera.projection = c[kLens] == 0 ? Projection::parallel : Projection::perspective;
    camera.viewAngle = angle;
    camera.position = glm::dvec3(info.patientFromVoxel * glm::dvec4(at, 1));
    const glm::dvec3 view = glm::dmat3(info.patientFromVoxel) * along;
    camera.focalPoint = camera.position + diagonal * view;
    camera.parallelScale = 0.5 * diagonal * voxelMm(info);
    int least = 0;
    for (int a = 1; a < 3; ++a)
        if (std::abs(view[a]) < std::abs(view[least]))
            least = a;
    camera.viewUp = glm::dvec3(0);
    camera.viewUp[least] = 1;
    return camera;
}

inline Scene sceneOf(const ExtremeCase& c, const ExtremeVolume& volume) {
    const Structure& s = c.structure();
    Scene scene;
    scene.volumes = {{{}, functionOf(c, volume)}};
    scene.imageSize = pictureSize(c);
    scene.camera = cameraOf(c, volume.info);
    scene.shading.on = s.shading;
    scene.shading.gradient = s.gradient;
    if (s.lights) {
        std::vector<Light>& lights = scene.lighting.lights;
        lights.resize(4);
        lights[0].kind = LightKind::point; // at the eye, which may be a sample's place
        lights[0].attenuation = {1, 1e-3, 1e-6};
        lights[1].kind = LightKind::point; // on a corner of the volume, where its origin may be far away
        lights[1].frame = LightFrame::patient;
        lights[1].position = glm::dvec3(volume.info.patientFromVoxel[3]);
        lights[2].kind = LightKind::directional;
        lights[2].direction = glm::dvec3(c[kVariant] == 0 ? 0 : 1, 0, 0);
        lights[3].intensity = 0.25;
        scene.shading.model = c[kVariant] % 2 == 0 ? ShadingModel::phong : ShadingModel::blinnPhong;
        if (c[kVariant] == 2)
            scene.shading.gradientWeight = GradientWeight{0, 100};
    }
    scene.quality.stepVoxels = std::array{2.0, 1.0, 0.5, 0.25, 1.0 / 16}[static_cast<std::size_t>(c[kStep])];
    scene.quality.fetch = s.fetch;
    scene.quality.integrator = s.integrator;
    scene.quality.skipping = s.skipping;
    scene.quality.terminationTransmittance = s.termination ? 1.0 / 510 : 0;
    scene.quality.edgeFunction = static_cast<EdgeFunction>(c[kEdge]);
    // Only the midpoint rule may stand on a field that jumps: other pairs are refused. (And where all bricks
    // have one level, nearest bricks would be one more combination to compile.)
    if (scene.quality.edgeFunction == EdgeFunction::nearest &&
        !(s.mixed && s.integrator == Integrator::midpoint))
        scene.quality.edgeFunction = EdgeFunction::minimum;
    scene.quality.sampling = static_cast<Sampling>(c[kSampling]);
    // Long strides have tables of two-dimensional pre-integration of their own, a tenth of a second each: one
    // case in six makes them.
    if (s.mixed && s.integrator == Integrator::preintegrated2d && c[kVariant] != 0)
        scene.quality.sampling = Sampling::full;
    return scene;
}

/// Volumes in a scratch folder, each stored when it is first asked for; where they lie is not theirs to say.
class ExtremeStores {
  public:
    /// Without ".zarr", as Prepared takes it.
    std::string path(const ExtremeCase& c) {
        const std::filesystem::path path = folder_ / std::to_string(c[kVolume]);
        if (made_.insert(c[kVolume]).second) {
            const ExtremeVolume v = volumeOf(c);
            MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
            ImportOptions options;
            options.durable = false;
            HashSource source(v.info, v.formula);
            importToStore(source, path.string() + ".zarr", ram, options);
        }
        return path.string();
    }

  private:
    ScratchFolder folder_;
    std::set<int> made_;
};

inline std::vector<glm::dvec4> widened(const std::vector<glm::vec4>& pixels) {
    return {pixels.begin(), pixels.end()};
}

/// Finite; alpha in [0,1]; no component above its bound. Colours of transfer functions are at most 1, so
/// premultiplied ones are at most alpha, and lit ones at most alpha times the sum of light's parts. Sums of n
/// rounded terms may exceed this by n/2^24 of themselves: 1e-5 is for 170 segments in one direction.
inline void expectInRange(const std::vector<glm::dvec4>& pixels, const Scene& scene, const char* what) {
    const double brightestHere = brightest(scene.shading, scene.lighting);
    for (std::size_t i = 0; i < pixels.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            const double value = pixels[i][c];
            const double most = c == 3 ? 1 + 1e-6 : pixels[i].a * brightestHere * (1 + 1e-5) + 1e-30;
            ASSERT_TRUE(value >= 0 && value <= most) << what << ": pixel " << i << ", component " << c
                                                     << " is " << value << ", alpha " << pixels[i].a;
        }
}

} // namespace tessera::test
