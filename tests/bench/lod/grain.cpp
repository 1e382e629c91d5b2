// tests/bench/lod/grain.cpp: the experiment "grain": how far the shading normals are from the surfaces' own,
// by the kind of gradient. They are compared with the formula on a phantom's bones, and with Sobel's smooth
// normal on a scan's skin.
#include "bricking/store/store_reader.h"
#include "datasets/phantom.h"
#include "render/backends/mirror/mirror.h"
#include "render/contract/sampler.h"
#include "render/picture/render_scene.h"
#include "render/plan/planner.h"
#include "tests/bench/lod/experiments.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <optional>

namespace tessera::bench {
namespace {

constexpr Gradient kSideBySide[] = {Gradient::centralHalf, Gradient::central, Gradient::sobel,
                                    Gradient::cubic};
constexpr Gradient kKinds[] = {Gradient::centralHalf, Gradient::central, Gradient::sobel,
                               Gradient::analytic,    Gradient::forward, Gradient::cubic};

/// The subject of a picture: a surface of a volume, and the normals that it truly has.
struct Subject {
    const char* volume;
    double isovalueHu;
    const char* about;
};
constexpr Subject kSubjects[] = {{"torso", 500, "bones at 500 HU, against the phantom's formula"},
                                 {"torso", -300, "skin at -300 HU, against the phantom's formula"},
                                 {"abdomen", -300, "skin at -300 HU, against Sobel's gradient"},
                                 {"abdomen", 300, "bones and vessels at 300 HU, against Sobel's gradient"}};

struct Angles {
    double mean = 0, p95 = 0; // to the surface's own normal
    double grain = 0;         // change of this angle from a pixel to the next
};
Angles anglesOf(std::vector<double> degrees) {
    Angles a;
    if (degrees.empty())
        return a;
    std::sort(degrees.begin(), degrees.end());
    for (const double d : degrees)
        a.mean += d / static_cast<double>(degrees.size());
    a.p95 = degrees[degrees.size() * 95 / 100];
    return a;
}

/// Patient space, mm -> a vector along the value's rise there.
using Normals = std::function<glm::dvec3(const glm::dvec3&)>;

Normals formulaNormals(const glm::ivec3& extentVoxels) {
    const std::function<double(const glm::dvec3&)> valueHu = torsoFormulaHu(extentVoxels);
    return [valueHu](const glm::dvec3& p) {
        constexpr double kStepMm = 0.05; // far below the width of its surfaces, far above what floats lose
        glm::dvec3 rise(0);
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 side(0);
            side[axis] = kStepMm;
            rise[axis] = valueHu(p + side) - valueHu(p - side);
        }
        return rise;
    };
}

double degreesBetween(const glm::dvec3& a, const glm::dvec3& b) { // two-sided, as light is
    return std::atan2(glm::length(glm::cross(a, b)), std::abs(glm::dot(a, b))) * 57.29577951308232;
}

/// Mean change of the normals' error, degrees, between pixels side by side that show one surface.
double grainOf(const std::vector<std::optional<glm::dvec3>>& off, const std::vector<SurfaceHit>& hits,
               const glm::ivec2& size) {
    constexpr float kOneSurface = 3; // voxels apart at most
    double sum = 0;
    std::size_t pairs = 0, i = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x, ++i)
            for (const std::size_t next :
                 {x + 1 < size.x ? i + 1 : i, y + 1 < size.y ? i + static_cast<std::size_t>(size.x) : i}) {
                if (next == i || !off[i] || !off[next] ||
                    glm::distance(hits[i].position, hits[next].position) > kOneSurface)
                    continue;
                sum += glm::distance(*off[i], *off[next]) * 57.29577951308232;
                ++pairs;
            }
    return pairs > 0 ? sum / static_cast<double>(pairs) : 0;
}

/// Mean and 95th percentile of the angle, and the grain, per kind, over the places where a picture's rays
/// meet a surface.
std::vector<Angles> measure(const Workbench& bench, const BenchVolume& volume, const Subject& subject,
                            std::size_t& places) {
    MemoryBudget ram("RAM", "--ram", bench.ramBytes), gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader store(volume.store, ram);
    const VolumeInfo& info = store.info();
    Scene scene;
    SceneVolume shown;
    shown.transferFunction = TransferFunction::fromOpacity({}, {}, 1);
    scene.volumes = {shown};
    scene.surfaces = {{subject.isovalueHu}};
    scene.imageSize = glm::ivec2(bench.pixels());
    scene.camera = FittedView{};
    const Planner p =
        planScene(scene, store, TextureLimits{}, {ram, gpu, 0}, LevelChoice::oneForAllNothingCulled);
    const auto pixels =
        static_cast<std::size_t>(scene.imageSize.x) * static_cast<std::size_t>(scene.imageSize.y);
    const std::vector<SurfaceHit> hits =
        mirrorHits<double>(mirrorInput(p, true), pixels, frameRays(p.view.frame), 0);
    const bool formula = subject.volume == std::string("torso");
    const Normals normals = formula ? formulaNormals(info.extentVoxels) : Normals();
    const glm::dmat3 toPatient = glm::transpose(glm::inverse(glm::dmat3(info.patientFromVoxel)));
    LatticeReader samples(*p.layer().cache, info, p.layer().selection.finest(), nullptr);
    places = 0;
    std::vector<std::vector<double>> degrees(std::size(kKinds));
    // By pixel, how far the unit normal is from the true one; none where nothing was met.
    std::vector<std::vector<std::optional<glm::dvec3>>> off(std::size(kKinds));
    for (auto& of : off)
        of.resize(hits.size());
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (hits[i].surface == 0)
            continue;
        const glm::dvec3 at(hits[i].position);
        const auto shaded = [&](Gradient kind) { return toPatient * fieldGradient(samples, at, 1.0, kind); };
        const glm::dvec3 truth = formula ? normals(glm::dvec3(info.patientFromVoxel * glm::dvec4(at, 1)))
                                         : shaded(Gradient::sobel);
        if (!(glm::length(truth) > 0))
            continue;
        ++places;
        for (std::size_t k = 0; k < std::size(kKinds); ++k) {
            const glm::dvec3 normal = shaded(kKinds[k]);
            degrees[k].push_back(degreesBetween(normal, truth));
            if (glm::length(normal) > 0)
                off[k][i] = glm::normalize(normal) * (glm::dot(normal, truth) < 0 ? -1.0 : 1.0) -
                            glm::normalize(truth);
        }
    }
    std::vector<Angles> angles;
    for (std::size_t k = 0; k < std::size(kKinds); ++k) {
        angles.push_back(anglesOf(std::move(degrees[k])));
        angles.back().grain = grainOf(off[k], hits, scene.imageSize);
    }
    return angles;
}

/// A part of a picture, lit by gradients of one kind.
Image closeUp(const Workbench& bench, const BenchVolume& volume, const std::string& preset, Gradient kind) {
    MemoryBudget ram("RAM", "--ram", bench.ramBytes), gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader store(volume.store, ram);
    Scene scene;
    scene.volumes = {{volume.store, preset}};
    scene.imageSize = glm::ivec2(bench.fewerPixels());
    scene.shading.gradient = kind;
    Camera camera = cameraNamed("anterior", store.info(), scene.imageSize);
    camera.viewAngle /= 3;
    scene.camera = camera;
    RenderOptions options;
    options.engine = bench.engine;
    options.device.text = bench.device;
    return renderScene(scene, store, ram, gpu, options).image;
}

} // namespace

Report grainReport(const Workbench& bench) {
    Report report;
    report.name = "grain";
    report.title = "How smooth surfaces look";
    report.text = {
        "Normals that light is taken with, where the rays of a picture first meet a surface: their angle, in "
        "degrees, to the surface's own normal, in the mean and at the 95th percentile; and *grain*: by how "
        "much "
        "that error changes from a pixel to the next, in the mean, which is what the eye takes for the grain "
        "of "
        "wood. `central` is the default. `central-half` takes differences over half as much: nearer to the "
        "truth on edges as sharp as the phantom's (1.75 voxels), and grainier everywhere. `cubic` is of the "
        "samples' cubic B-spline, which smooths alike wherever a place lies between samples. Where the truth "
        "is "
        "Sobel's gradient, a smooth estimate itself that shows the lattice a little, angles tell how far "
        "from "
        "it a kind is, not how wrong."};
    Table table{"grain", "Angle to the surface's normal, degrees:", {"surface", "places"}, {}, true};
    for (const Gradient kind : kKinds) {
        const std::string& name = gradientNames()[static_cast<std::size_t>(kind)];
        table.columns.insert(table.columns.end(), {name + ", mean", "95 %", "grain"});
    }
    const auto find = [&](const std::string& name) {
        return std::find_if(bench.volumes.begin(), bench.volumes.end(),
                            [&](const BenchVolume& v) { return v.name == name; });
    };
    for (const Subject& subject : kSubjects) {
        const auto volume = find(subject.volume);
        if (volume == bench.volumes.end())
            continue;
        std::size_t places = 0;
        const std::vector<Angles> angles = measure(bench, *volume, subject, places);
        std::vector<Cell> row = {volume->name + ": " + subject.about, static_cast<double>(places)};
        for (const Angles& a : angles)
            row.insert(row.end(), {a.mean, a.p95, a.grain});
        table.rows.push_back(std::move(row));
        bench.done(volume->name + ", " + subject.about);
    }
    Figure figure;
    figure.caption = "Side by side:";
    for (const Gradient kind : kSideBySide)
        figure.columns.push_back(gradientNames()[static_cast<std::size_t>(kind)]);
    for (const auto& [name, preset] : {std::pair("torso", "bone-1"), std::pair("abdomen", "skin-1")}) {
        const auto volume = find(name);
        if (volume == bench.volumes.end())
            continue;
        std::vector<Panel> panels;
        for (const Gradient kind : kSideBySide)
            panels.push_back(
                {std::string("grain-") + name + "-" + gradientNames()[static_cast<std::size_t>(kind)],
                 closeUp(bench, *volume, preset, kind)});
        figure.rows.emplace_back(std::string(name) + ", " + preset, std::move(panels));
    }
    report.tables = {std::move(table)};
    report.figures = {std::move(figure)};
    return report;
}

} // namespace tessera::bench
