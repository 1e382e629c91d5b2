// tests/bench/papers/hulls.cpp: sampling hulls beside slices and the march: figures 1 and 8 to 11 and table 1
// of Imagire, Johan, Tamura and Nishita, The Visual Computer 2007. The slicer lives here alone.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "datasets/phantom.h"
#include "render/backends/mirror/mirror.h"
#include "render/picture/render_scene.h"
#include "tests/bench/papers/papers.h"
#include "tests/bench/papers/studied_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tessera::bench {
namespace {

constexpr int kVoxels = 128; // along an axis, as in the paper's figures
constexpr glm::ivec2 kPixels(180, 180);
constexpr int kTruth = 1024; // hulls, a sample each

/// An opaque ball in the medium, voxels.
constexpr glm::dvec3 kBallCentre(64, 50, 70);
constexpr double kBallRadius = 22;

Scene mediumScene(const VolumeInfo& info, const TransferFunction& function) {
    Scene scene = studiedScene(function, kPixels.x);
    scene.shading.on = false;
    Camera camera = fitCamera(info, View::anterior, Projection::perspective, kPixels);
    const double away = glm::length(camera.position - camera.focalPoint);
    camera.position = camera.focalPoint + 0.9 * away * glm::normalize(glm::dvec3(0.5, -1, 0.35));
    scene.camera = camera;
    scene.quality.sampling = Sampling::hulls;
    scene.quality.hulls = {1, 1};
    scene.quality.terminationTransmittance = 0;
    return scene;
}

/// A medium around a ball, drawn by hulls, slices or segments of one length: what the eye sees of it before
/// the ball.
class MediumBench {
  public:
    MediumBench(const std::filesystem::path& store, const TransferFunction& function)
        : ram_("RAM", "--ram", std::size_t{512} << 20),
          gpu_("GPU memory", "--gpu-memory", std::size_t{512} << 20), store_(store, ram_),
          plan_(planScene(mediumScene(store_.info(), function), store_, TextureLimits{}, {ram_, gpu_, 0},
                          LevelChoice::finest)) {
        const RayFrame<double> frame = plan_.view.frame;
        for (std::size_t n = 0; n < rayCount(kPixels); ++n) {
            const RayLine<double> line = pixelLine(frame, placeOf(n));
            const glm::dvec3 from = line.base - kBallCentre;
            const double b = glm::dot(from, line.direction);
            const double inside = b * b - glm::dot(from, from) + kBallRadius * kBallRadius;
            ends_.push_back({-std::numeric_limits<double>::max(),
                             inside > 0 ? -b - std::sqrt(inside) : std::numeric_limits<double>::max()});
        }
    }

    Image hulls(int count, int samples) {
        RayFrame<double> frame = plan_.view.frame;
        frame.hulls.count = count, frame.hulls.samples = samples;
        return drawCut(frame);
    }
    /// Segments of one length, so many on the longest ray.
    Image segments(int most) {
        RayFrame<double> frame = plan_.view.frame;
        double longest = 0;
        for (std::size_t n = 0; n < ends_.size(); ++n) {
            const SegmentedRay<double> ray = segmentedRay(frame, placeOf(n));
            longest = std::max(longest, (ray.count - 1 + ray.tail) * frame.segmentVoxels);
        }
        frame.hulls = {};
        frame.segmentVoxels = longest / most;
        return drawCut(frame);
    }
    /// Planes parallel to the picture, at the far end of as many parts of its depth. A plane is drawn where
    /// it is in the box and before the ball; the medium between two planes is taken for that at the farther.
    Image slices(int count) {
        const RayFrame<double>& frame = plan_.view.frame;
        const RayHulls planes = frame.hulls;
        const double thick = (planes.farthest - planes.nearest) / count;
        std::vector<SegmentedRay<float>> rays;
        for (std::size_t n = 0; n < ends_.size(); ++n) {
            const RayLine<double> line = pixelLine(frame, placeOf(n));
            double t0 = 0, t1 = 0;
            SegmentedRay<float> ray;
            if (drawnPartOf(frame, line, t0, t1)) {
                t1 = std::min(t1, ends_[n].to);
                const double at = glm::dot(planes.normal, line.base) + planes.offset - planes.nearest;
                const double along = glm::dot(planes.normal, line.direction), step = thick / along;
                const int first = static_cast<int>(std::ceil((at + t0 * along) / thick));
                const int last = static_cast<int>(std::floor((at + t1 * along) / thick));
                const double middle = (first * thick - at) / along;
                ray.entry = glm::vec3(line.base + (middle - 0.5 * step) * line.direction);
                ray.direction = glm::vec3(line.direction);
                ray.step = glm::vec3(step * line.direction);
                ray.segmentMm = static_cast<float>(step * line.mmPerVoxel);
                ray.count = std::max(last - first + 1, 0);
            }
            rays.push_back(ray);
        }
        return draw(mirrorInput(plan_, false), [&](std::size_t n) { return rays[n]; });
    }
    /// Pixels within so many pixels of where rays meet the ball's outline, or the box's edges.
    std::vector<bool> nearEdges(bool ball) const {
        std::vector<bool> isEdge(ends_.size());
        const auto key = [&](int x, int y) {
            const std::size_t n = static_cast<std::size_t>(y * kPixels.x + x);
            if (ball)
                return ends_[n].to < 1e300 ? 1 : 0;
            const RayLine<double> line = pixelLine(plan_.view.frame, placeOf(n));
            double t0 = 0, t1 = 0;
            return drawnPartOf(plan_.view.frame, line, t0, t1) && t1 - t0 > 12 ? 1 : 0;
        };
        constexpr int kNear = 6;
        for (int y = 0; y < kPixels.y; ++y)
            for (int x = 0; x < kPixels.x; ++x) {
                int sum = 0, all = 0;
                for (int dy = -kNear; dy <= kNear; dy += kNear)
                    for (int dx = -kNear; dx <= kNear; dx += kNear, ++all)
                        sum +=
                            key(std::clamp(x + dx, 0, kPixels.x - 1), std::clamp(y + dy, 0, kPixels.y - 1));
                isEdge[static_cast<std::size_t>(y * kPixels.x + x)] = sum > 0 && sum < all;
            }
        return isEdge;
    }

  private:
    glm::dvec2 placeOf(std::size_t n) const {
        const auto width = static_cast<std::size_t>(kPixels.x);
        return glm::dvec2(static_cast<double>(n % width), static_cast<double>(n / width)) + 0.5;
    }
    Image drawCut(RayFrame<double> frame) {
        frame.ends = ends_;
        const CutRays cuts = cutRays(frame, {}, 0);
        MirrorInput input = mirrorInput(plan_, false);
        input.cuts = &cuts;
        input.segmentVoxels = frame.segmentVoxels;
        input.hullSamples = frame.hullSamples();
        const RayFrame<float> rays = cast<float>(frame);
        return draw(std::move(input),
                    [&](std::size_t n) { return segmentedRay(rays, glm::vec2(placeOf(n))); });
    }
    Image draw(MirrorInput input, const RaySource<float>& rays) {
        input.strides = plan_.strides();
        Image image(kPixels);
        Work work;
        image.pixels = mirrorRays<float>(input, image.pixels.size(), rays, 0, work);
        return image;
    }

    MemoryBudget ram_, gpu_;
    StoreReader store_;
    Planner plan_;
    std::vector<RayPart> ends_; // before the ball
};

/// Of opacity, in steps of 255, over some pixels: rms and 99th percentile.
std::pair<double, double> errorsOf(const Image& image, const Image& truth, const std::vector<bool>& of) {
    std::vector<double> all;
    double squares = 0;
    for (std::size_t n = 0; n < of.size(); ++n)
        if (of[n]) {
            const double e = 255 * std::abs(double{image.pixels[n].a} - double{truth.pixels[n].a});
            all.push_back(e), squares += e * e;
        }
    if (all.empty())
        return {0, 0};
    const auto p99 = all.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(all.size() - 1));
    std::nth_element(all.begin(), p99, all.end());
    return {std::sqrt(squares / static_cast<double>(all.size())), *p99};
}

/// A ball of even density in voxels, and fog that fills the box.
struct Medium {
    const char* name;
    TransferFunction function;
};
std::vector<Medium> media() {
    const std::vector<ColourPoint> white = {{0, {1, 1, 1}}};
    return {{"sphere", TransferFunction::fromExtinction({{-20, 0}, {20, 0.02}}, white)},
            {"fog", TransferFunction::fromExtinction({{-3000, 0.008}, {3000, 0.008}}, white)},
            {"uneven fog", TransferFunction::fromExtinction({{-1000, 0.002}, {1000, 0.02}}, white)}};
}

void addAliasing(const Workbench& bench, Report& report) {
    const ScratchFolder scratch;
    MemoryBudget ram("RAM", "--ram", bench.ramBytes);
    ImportOptions options;
    options.durable = false;
    importToStore(*makePhantom("sphere", glm::ivec3(kVoxels)), scratch / "sphere.zarr", ram, options);
    Table table{
        "hulls-aliasing",
        "Errors of opacity, in steps of 255, against " + std::to_string(kTruth) +
            " hulls of one sample; *at the ball* and *at the box* are pixels within 6 of their outlines:",
        {"medium", "how", "samples a ray", "rms", "p99", "rms at the ball", "p99 at the ball",
         "rms at the box", "p99 at the box"},
        {},
        true};
    Figure figure{"Fog with an opaque ball: 4 slices, 32 slices, 2 hulls of 4 samples, and the truth "
                  "(figures 1 and 8).",
                  {"4 slices", "32 slices", "2 x 4", "truth"},
                  {}};
    for (const Medium& medium : media()) {
        MediumBench scene(scratch / "sphere.zarr", medium.function);
        const Image truth = scene.hulls(kTruth, 1);
        const std::vector<bool> all(truth.pixels.size(), true), ball = scene.nearEdges(true),
                                                                box = scene.nearEdges(false);
        const auto add = [&](const std::string& how, int samples, const Image& image) {
            std::vector<Cell> row = {medium.name, how, static_cast<double>(samples)};
            for (const std::vector<bool>* of : {&all, &ball, &box}) {
                const auto [rms, p99] = errorsOf(image, truth, *of);
                row.insert(row.end(), {rms, p99});
            }
            table.rows.push_back(std::move(row));
        };
        for (const int count : {4, 32, 64, 128, 512})
            add("slices", count, scene.slices(count));
        for (const auto& [count, samples] : {std::pair(1, 4), std::pair(2, 4), std::pair(2, 8),
                                             std::pair(4, 4), std::pair(4, 8), std::pair(8, 8)})
            add(std::to_string(count) + " x " + std::to_string(samples) + " hulls", count * samples,
                scene.hulls(count, samples));
        for (const int most : {4, 32, 64})
            add("segments of one length", most, scene.segments(most));
        figure.rows.push_back({medium.name,
                               {Panel{std::string("hulls-") + medium.name[0] + "-4", scene.slices(4)},
                                Panel{std::string("hulls-") + medium.name[0] + "-32", scene.slices(32)},
                                Panel{std::string("hulls-") + medium.name[0] + "-2x4", scene.hulls(2, 4)},
                                Panel{std::string("hulls-") + medium.name[0] + "-truth", truth}}});
        bench.done(medium.name);
    }
    report.tables.push_back(std::move(table));
    report.figures.push_back(std::move(figure));
}

/// A dense ball in fog, which casts a shadow across it: figures 10 and 11. The paper interpolates the light
/// of a sample from three places half a step apart, 2 N + 1 look-ups in a hull; twice the samples are as
/// many.
void addShadows(const Workbench& bench, Report& report) {
    const ScratchFolder scratch;
    MemoryBudget importing("RAM", "--ram", bench.ramBytes);
    ImportOptions options;
    options.durable = false;
    importToStore(*makePhantom("sphere", glm::ivec3(kVoxels)), scratch / "sphere.zarr", importing, options);
    const auto picture = [&](int count, int samples) {
        MemoryBudget ram("RAM", "--ram", bench.ramBytes),
            gpu("GPU memory", "--gpu-memory", std::size_t{512} << 20);
        const StoreReader store(scratch / "sphere.zarr", ram);
        Scene scene = mediumScene(
            store.info(),
            TransferFunction::fromExtinction({{-1000, 0.006}, {500, 0.006}, {520, 1}}, {{0, {1, 1, 1}}}));
        scene.shading.on = true;
        scene.shading.ambient = 0.1, scene.shading.diffuse = 0.9;
        Light light;
        light.kind = LightKind::directional;
        light.direction = {1, 0.6, 0.2};
        light.shadow = true;
        scene.lighting.lights = {light};
        scene.quality.hulls = {count, samples};
        RenderOptions drawing;
        drawing.engine = EngineKind::native;
        return renderScene(scene, store, ram, gpu, drawing).image;
    };
    Table table{"hulls-shadows",
                "A shadow across fog, against " + std::to_string(Hulls::kMost) +
                    " hulls of 32 samples; light per voxel, interpolated:",
                {"hulls", "samples", "rms", "L*u*v* mean", "p99"},
                {},
                true};
    const Image truth = picture(Hulls::kMost, 32);
    for (const auto& [count, samples] :
         {std::pair(4, 4), std::pair(4, 8), std::pair(8, 8), std::pair(8, 16), std::pair(16, 16)}) {
        const ImageDifference d = compare(picture(count, samples), truth);
        table.rows.push_back(
            {static_cast<double>(count), static_cast<double>(samples), d.rms, d.luvMean, d.luvP99});
    }
    report.tables.push_back(std::move(table));
}

struct DrawnScan {
    RenderResult result;
    double ms = std::numeric_limits<double>::infinity();
};

DrawnScan drawnBy(const Workbench& bench, const BenchVolume& volume, const std::string& preset,
                  const Quality& quality, int repeats, Verify verify) {
    DrawnScan drawn;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        MemoryBudget ram("RAM", "--ram", bench.ramBytes),
            gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
        const StoreReader store(volume.store, ram);
        Scene scene = studiedScene(preset, bench.fewerPixels());
        scene.quality = quality;
        RenderOptions options;
        options.engine = EngineKind::native;
        options.checking = options.searching = true;
        options.verify = repeat == 0 ? verify : Verify::none;
        RenderResult result = renderScene(scene, store, ram, gpu, options);
        drawn.ms = std::min(drawn.ms, result.work.marchMs);
        if (repeat == 0)
            drawn.result = std::move(result);
    }
    return drawn;
}

Quality hullsOf(int count, int samples) {
    Quality quality;
    quality.sampling = Sampling::hulls;
    quality.hulls = {count, samples};
    return quality;
}

void addTimes(const Workbench& bench, Report& report) {
    const int repeats = bench.quick ? 1 : 3;
    Table table{
        "hulls-times",
        "Table 1 of the paper: M hulls of N samples each, M N = 32; the march alone:",
        {"scene", "hulls", "samples", "ms", "pictures a second, of the best", "in the paper, of the best"},
        {},
        true};
    constexpr double kPaper[] = {50, 59, 64, 62, 55, 47};
    for (const BenchVolume& volume : bench.volumes) {
        if (volume.name != "torso" && volume.name != "abdomen")
            continue;
        std::vector<double> ms;
        for (int count = 1; count <= 32; count *= 2)
            ms.push_back(
                drawnBy(bench, volume, "soft-tissue", hullsOf(count, 32 / count), repeats, Verify::none).ms);
        const double best = *std::min_element(ms.begin(), ms.end());
        for (std::size_t n = 0; n < ms.size(); ++n)
            table.rows.push_back({volume.name, static_cast<double>(1 << n), static_cast<double>(32 >> n),
                                  ms[n], best / ms[n], kPaper[n] / 64});
    }
    report.tables.push_back(std::move(table));
}

double rmsOf(const DrawnScan& drawn) {
    const auto& m = drawn.result.measured;
    return m && m->rays.rms ? m->rays.rms->value : std::numeric_limits<double>::infinity();
}

/// The fewest samples in one hull that are as near to the truth as the march is, by the same integrator.
void addEqualError(const Workbench& bench, Report& report) {
    Table table{
        "hulls-equal",
        "The march with the step that it chooses, and one hull of the fewest samples (a power of two) whose "
        "measured error is not greater; the time of the rays alone:",
        {"scene", "step, voxels", "samples of the hull", "march, rms", "hull, rms", "march, ms", "hull, ms",
         "times"},
        {},
        true};
    const int repeats = bench.quick ? 1 : 3;
    int won = 0, all = 0;
    for (const BenchVolume& volume : bench.volumes)
        for (const std::string& preset : volume.presets) {
            Quality quality;
            quality.automaticStep = true;
            quality.integrator = Integrator::preintegrated; // which segments of any length can take
            const DrawnScan march = drawnBy(bench, volume, preset, quality, repeats, Verify::full);
            quality.sampling = Sampling::hulls;
            std::optional<DrawnScan> hull;
            for (int samples = 64; samples <= Hulls::kMostSamples && !hull; samples *= 2) {
                quality.hulls = {1, samples};
                const DrawnScan trial = drawnBy(bench, volume, preset, quality, 1, Verify::full);
                if (rmsOf(trial) <= rmsOf(march))
                    hull = drawnBy(bench, volume, preset, quality, repeats, Verify::full);
            }
            const auto of = [&](auto number) {
                return hull ? Cell(static_cast<double>(number(*hull))) : Cell("none");
            };
            table.rows.push_back({volume.name + ", " + preset, march.result.stepVoxels,
                                  of([](const DrawnScan& d) { return d.result.hulls.samples; }), rmsOf(march),
                                  of(rmsOf), march.ms, of([](const DrawnScan& d) { return d.ms; }),
                                  of([&](const DrawnScan& d) { return d.ms / march.ms; })});
            ++all, won += hull && hull->ms < march.ms;
            bench.done(volume.name + ", " + preset);
        }
    report.tables.push_back(std::move(table));
    report.after.push_back("Hulls were quicker than the march at an equal measured error in " +
                           std::to_string(won) + " of " + std::to_string(all) + " scenes.");
}

} // namespace

Report hullsReport(const Workbench& bench) {
    bench.expect(bench.scenes() + media().size());
    Report report;
    report.name = "hulls";
    report.title = "Sampling hulls (Imagire et al. 2007)";
    report.text = {
        "Hulls cut the volume by planes parallel to the picture; a ray takes N samples in each of M "
        "(`--sampling hulls`). Slices are drawn by a slicer of this study alone. The paper names four kinds "
        "of "
        "aliasing: too few slices for the medium (a), steps where slices meet the box (b) and opaque objects "
        "(c), and "
        "steps in shadows (d). Light per voxel is interpolated between voxels in Tessera; the table of "
        "shadows says what is left of (d). "
        "Samples are in the "
        "middle of segments; the paper takes their far end."};
    addAliasing(bench, report);
    addShadows(bench, report);
    addTimes(bench, report);
    addEqualError(bench, report);
    return report;
}

} // namespace tessera::bench
