// tests/bench/papers/object_order.cpp: starts and ends of rays from the bricks that show something (course
// notes on advanced volume ray casting, 2.2 and 2.3), beside rays that leap by the distance map alone.
#include "core/scene/camera.h"
#include "render/picture/picture.h"
#include "tests/bench/papers/papers.h"
#include "tests/bench/papers/studied_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

namespace tessera::bench {
namespace {

constexpr int kPatchX = 8, kPatchY = 4; // pixels of a packet

/// Depths along the view, mm, of what shows in each patch; none: first > second.
std::vector<std::pair<double, double>> patchDepths(const FramePlan& plan, const glm::ivec2& patches) {
    const VolumeInfo& info = plan.info();
    const Camera& camera = plan.view.camera;
    const glm::dmat3 axes = glm::transpose(patientFromCamera(camera));
    const glm::dvec2 size(plan.view.imageSize);
    const bool perspective = camera.projection == Projection::perspective;
    const double slope = std::tan(glm::radians(camera.viewAngle) / 2);
    std::vector<std::pair<double, double>> depths(cellCount(glm::ivec3(patches, 1)),
                                                  {std::numeric_limits<double>::max(), -1});
    const Selection& selection = plan.layer().selection;
    for (int k = 0; k < selection.bricks.z; ++k)
        for (int j = 0; j < selection.bricks.y; ++j)
            for (int i = 0; i < selection.bricks.x; ++i) {
                if (selection.levels[linearIndex({i, j, k}, selection.bricks)] == Selection::kEmpty)
                    continue;
                glm::dvec2 low(1e300), high(-1e300);
                double near = 1e300, far = -1e300;
                for (int n = 0; n < 8; ++n) {
                    const glm::ivec3 at =
                        glm::min((glm::ivec3(i, j, k) + glm::ivec3(n & 1, n >> 1 & 1, n >> 2)) * kBrickExtent,
                                 info.extentVoxels);
                    const glm::dvec3 c =
                        axes *
                        (glm::dvec3(info.patientFromVoxel * glm::dvec4(glm::dvec3(at), 1)) - camera.position);
                    const double depth = -c.z, half = perspective ? depth * slope : camera.parallelScale;
                    near = std::min(near, depth), far = std::max(far, depth);
                    if (perspective && depth <= 0)
                        continue;
                    const glm::dvec2 place(size.x / 2 + size.y / 2 * c.x / half,
                                           size.y / 2 * (1 - c.y / half));
                    low = glm::min(low, place), high = glm::max(high, place);
                }
                if (perspective && near <= 0) // the eye's plane cuts it: it may be anywhere
                    low = glm::dvec2(0), high = size, near = 0;
                const glm::ivec2 from(glm::clamp(glm::floor((low - 1.0) / glm::dvec2(kPatchX, kPatchY)),
                                                 glm::dvec2(0), glm::dvec2(patches))),
                    to(glm::clamp(glm::floor((high + 1.0) / glm::dvec2(kPatchX, kPatchY)) + 1.0,
                                  glm::dvec2(0), glm::dvec2(patches)));
                for (int y = from.y; y < to.y; ++y)
                    for (int x = from.x; x < to.x; ++x) {
                        auto& patch = depths[linearIndex({x, y, 0}, {patches, 1})];
                        patch = {std::min(patch.first, near), std::max(patch.second, far)};
                    }
            }
    return depths;
}

std::vector<RayPart> endsOfRays(const FramePlan& plan) {
    const glm::ivec2 size = plan.view.imageSize;
    const glm::ivec2 patches((size.x + kPatchX - 1) / kPatchX, (size.y + kPatchY - 1) / kPatchY);
    const auto depths = patchDepths(plan, patches);
    const RayHulls along = rayHulls(plan.view.camera, plan.info(), 1, 1);
    std::vector<RayPart> ends;
    ends.reserve(rayCount(size));
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const RayLine<double> line = pixelLine(plan.view.frame, glm::dvec2(x, y) + 0.5);
            const auto& [near, far] = depths[linearIndex({x / kPatchX, y / kPatchY, 0}, {patches, 1})];
            const double at = glm::dot(along.normal, line.base) + along.offset;
            const double step = glm::dot(along.normal, line.direction);
            ends.push_back(near > far ? RayPart{1, 0} : RayPart{(near - at) / step, (far - at) / step});
        }
    return ends;
}

double millisecondsOf(const std::function<void()>& run) {
    const auto start = std::chrono::steady_clock::now();
    run();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

Report objectOrderReport(const Workbench& bench) {
    Report report;
    report.name = "object-order";
    report.title = "Starts and ends of rays in object order (course notes, 2.2 and 2.3)";
    report.text = {
        "The notes rasterise faces between bricks that show something and bricks that do not, so that rays "
        "begin at the first and end at "
        "the last. Here both come in closed form from the boxes of such bricks, for patches of 8 x 4 pixels, "
        "the size of a packet. *Leaps* are "
        "looks at the map of empty space. The time of starts and ends is counted with the rays' own."};
    Table table{"object-order",
                "Pictures by the native engine, leaping, without and with starts and ends:",
                {"scene", "leaps a ray", "with ends", "segments a ray", "ms", "ms with ends",
                 "of them the ends", "times"},
                {},
                true};
    const int repeats = bench.quick ? 1 : 7;
    double logs = 0;
    int scenes = 0;
    const RayCuts none;
    for (const BenchVolume& volume : bench.volumes)
        for (const std::string& preset : volume.presets) {
            for (const char* camera : {"anterior", "near", "inside"}) {
                MemoryBudget ram("RAM", "--ram", bench.ramBytes),
                    gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
                const StoreReader store(volume.store, ram);
                Scene scene = studiedScene(preset, bench.pixels());
                scene.camera = cameraNamed(camera, store.info(), scene.imageSize);
                const EngineMaker maker(EngineKind::native, {"auto"});
                const std::unique_ptr<Engine> engine = maker.make(ram, gpu);
                Planner plan =
                    planScene(scene, store, engine->limits(), {ram, gpu, 0}, LevelChoice::oneForAll);
                Work loading;
                loadBricks(*engine, plan, gpu, loading);
                std::vector<RayPart> ends;
                const auto draw = [&](bool counting, bool cut) {
                    Rays rays = raysOf(plan);
                    if (cut)
                        rays.frame.cuts = &none, rays.frame.ends = ends;
                    Work work;
                    const auto caster = engine->caster({counting, false, false}, gpu);
                    caster->begin(rays);
                    drawToTheEnd(*caster, *engine, plan, Slicing{}, work);
                    return work;
                };
                double making = 1e300, plainMs = 1e300, cutMs = 1e300;
                for (int repeat = 0; repeat < repeats; ++repeat) {
                    making = std::min(making, millisecondsOf([&] { ends = endsOfRays(plan); }));
                    plainMs = std::min(plainMs, draw(false, false).marchMs);
                    cutMs = std::min(cutMs, millisecondsOf([&] { draw(false, true); }));
                }
                plainMs = std::min(plainMs, millisecondsOf([&] { draw(false, false); }));
                const Work plain = draw(true, false), cut = draw(true, true);
                const double rays = static_cast<double>(rayCount(scene.imageSize));
                const auto leaps = [&](const Work& w) {
                    return static_cast<double>(w.iterations - w.segments) / rays;
                };
                const double times = (cutMs + making) / plainMs;
                logs += std::log(times), ++scenes;
                table.rows.push_back({volume.name + ", " + preset + ", " + camera, leaps(plain), leaps(cut),
                                      static_cast<double>(plain.segments) / rays, plainMs, cutMs + making,
                                      making, times});
            }
            bench.done(volume.name + ", " + preset);
        }
    report.tables.push_back(std::move(table));
    if (scenes > 0)
        report.after = {"Geometric mean of the times: " + formatCell(std::exp(logs / scenes)) +
                        " (below 0.95 starts and ends would be worth their code)."};
    return report;
}

} // namespace tessera::bench
