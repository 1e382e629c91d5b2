// render/picture/unfolded.cpp: see unfolded.h.
#include "render/picture/unfolded.h"

#include "core/base/error.h"
#include "core/base/progress.h"
#include "render/backends/engine_maker.h"
#include "render/exposure/exposed_caster.h"
#include "render/geometry/mesh_caster.h"
#include "render/picture/picture.h"
#include "render/plan/planner.h"
#include "render/renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kCameras = 4; // around a place, a quarter of the columns each
constexpr double kQuarter = std::numbers::pi / 2;
constexpr double kStepVoxels = 0.5;

double angleOf(double column, int columns) {
    return 2 * std::numbers::pi * column / columns;
}

glm::dvec3 outwards(const UnfoldedRow& row, double angle) {
    return std::cos(angle) * row.up + std::sin(angle) * glm::cross(row.along, row.up);
}

/// Faces outwards in the middle of a quarter; its picture is a square, angles grow to the right.
Camera cameraOf(const UnfoldedRow& row, int quarter) {
    Camera camera;
    camera.position = row.at;
    camera.focalPoint = row.at + outwards(row, (quarter + 0.5) * kQuarter);
    camera.viewUp = -row.along;
    camera.viewAngle = 90;
    return camera;
}

/// Columns of a quarter.
int firstColumn(int quarter, int columns) {
    return (quarter * columns + kCameras - 1) / kCameras;
}

/// Places on the camera's picture, of `size` pixels a side, of the quarter's columns: on its horizon, in rows
/// of so many that lie side by side.
constexpr int kSideBySide = 8;
std::vector<glm::vec2> placesOf(int quarter, int columns, int size) {
    std::vector<glm::vec2> places;
    for (int x = firstColumn(quarter, columns); x < firstColumn(quarter + 1, columns); ++x) {
        const double tangent = std::tan(angleOf(x + 0.5, columns) - (quarter + 0.5) * kQuarter);
        places.emplace_back(0.5 * (tangent + 1) * size, 0.5 * size);
    }
    while (!places.empty() && places.size() % kSideBySide != 0)
        places.push_back(places.back());
    return places;
}

} // namespace

glm::dvec3 unfoldedDirection(const UnfoldedRow& row, double column, int columns) {
    return outwards(row, angleOf(column, columns));
}

RenderResult renderUnfolded(const Scene& given, std::span<const UnfoldedRow> rows, const StoreReader& store,
                            MemoryBudget& ram, MemoryBudget& gpu, const RenderOptions& options) {
    Scene scene = asDrawn(given);
    const glm::ivec2 size = scene.imageSize;
    TESSERA_CHECK(rows.size() == static_cast<std::size_t>(size.y) && !rows.empty());
    if (scene.mode == Mode::slice)
        throw InputError(
            "mode: expected one whose rays begin at an eye where a line is unfolded, found slice");
    if (scene.lighting.surfaceOcclusion)
        throw InputError("lighting.surfaceOcclusion: expected none where a line is unfolded, found one");
    if (reflects(scene))
        throw InputError(
            "isosurfaces: expected none with \"reflection\" where a line is unfolded, found one");
    if (scene.lighting.transport)
        throw InputError("lighting.transport: expected none where a line is unfolded, found one");
    scene.camera = cameraOf(rows.front(), 0);
    if (scene.quality.sampling == Sampling::hulls)
        throw badFile("quality.sampling",
                      "full, limited or naive for a picture that is cut open, which has no plane", "hulls");
    scene.quality.maxError.reset();
    scene.quality.pixels.samples = 1;
    if (scene.quality.automaticStep)
        scene.quality.stepVoxels = kStepVoxels;
    scene.quality.automaticStep = false;

    RenderResult result;
    const auto start = Clock::now();
    const EngineMaker maker(options.engine, options.device,
                            options.threads); // its device outlives the engine
    const std::unique_ptr<Engine> engine = maker.make(ram, gpu);
    result.engine = maker.kind();
    result.engineReason = maker.reason();
    result.device = engine->about().device;
    result.glVersion = engine->about().version;
    const FrameContext context(ram, gpu, options.threads, options.progress);
    Progress& progress = context.progress;
    progress.stage("reading statistics");
    // Rays find the bricks that they reach by themselves.
    if (reductionOf(scene) == Reduction::sum && scene.mode != Mode::absorption &&
        !std::holds_alternative<GreyWindow>(scene.window))
        throw InputError("window: expected CENTRE,WIDTH of mode " + nameOf(scene.mode) +
                         " in an unfolded picture, whose rows would have one each, found auto");
    Planner p = planScene(scene, store, engine->limits(), context, LevelChoice::finest,
                          pictureBytesPerPixel(result.engine) + meshBytesPerPixel(scene));
    result.secondsPreparing = secondsSince(start);
    progress.stage("loading bricks");
    const auto loading = Clock::now();
    const bool passes = loadBricks(*engine, p, gpu, result.work);
    const std::unique_ptr<RayCaster> caster =
        casterOf(*engine, p, {options.counting, false, passes}, gpu, options.threads);
    result.secondsLoading = secondsSince(loading);

    progress.stage("drawing");
    const auto drawing = Clock::now();
    result.image = Image(size);
    result.pixels.asked = 1;
    std::vector<std::vector<glm::vec2>> places;
    const int side = std::max(1, size.x / kCameras);
    for (int quarter = 0; quarter < kCameras; ++quarter)
        places.push_back(placesOf(quarter, size.x, side));
    p.setImageSize(glm::ivec2(side)); // of each camera; memory is that of all
    for (std::size_t y = 0; y < rows.size(); ++y) {
        for (int quarter = 0; quarter < kCameras; ++quarter) {
            const std::vector<glm::vec2>& here = places[static_cast<std::size_t>(quarter)];
            if (here.empty())
                continue;
            p.look(cameraOf(rows[y], quarter));
            Rays rays{
                p.view.frame, p.strides(), here, {kSideBySide, static_cast<int>(here.size()) / kSideBySide}};
            caster->begin(rays);
            result.passes =
                std::max(result.passes, drawToTheEnd(*caster, *engine, p, options.slicing, result.work));
            const Image part = caster->image();
            const int first = firstColumn(quarter, size.x), end = firstColumn(quarter + 1, size.x);
            std::copy_n(part.pixels.begin(), end - first,
                        result.image.pixels.begin() + static_cast<std::ptrdiff_t>(y) * size.x + first);
        }
        progress.update(static_cast<double>(y + 1) / static_cast<double>(rows.size()));
    }
    result.secondsDrawing = secondsSince(drawing);
    result.features = caster->features();
    reportVolume(p, scene, result);
    reportLevels(p, result);
    result.levelsOnPurpose = true;
    if (const std::string fault = engine->fault(); !fault.empty())
        throw Error(fault);
    engine->close();
    return result;
}

} // namespace tessera
