// tests/bench/flight_study.cpp: a flight through the torso phantom's colon, whose surface is known. It
// measures the camera's distance to the wall, pixels that miss the wall, light that jumps from frame to
// frame, visible polyps, and the visible share of the wall. Some frames are compared with the reference. It
// also measures the errors of successive pictures.
//
//   flight_study --store torso.zarr --scene colon.json --size 320x240x1 --frames 500 --angle 130 --reference
//   20
//
// --draw no leaves out all pictures; --interactive N flies N views by the interactive renderer instead, told
// the path and not.
#include "core/animation/film.h"
#include "core/image/image_metrics.h"
#include "datasets/colon_shape.h"
#include "datasets/phantom.h"
#include "render/backends/native/native_engine.h"
#include "render/interactive/interactive_renderer.h"
#include "render/picture/frame_renderer.h"
#include "tests/bench/bench_tools.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <optional>

namespace tessera::bench {
namespace {

/// The lumen's wall with its folds and the polyps' heads, by signed distance, mm: positive in the lumen.
class Colonoscopy {
  public:
    Colonoscopy()
        : course_(std::make_shared<const ColonCourse>()), grid_(std::make_shared<const ColonGrid>(course_)),
          lumen_(grid_, true), polyps_(torsoColonPolyps()) {
        seen_.assign(static_cast<std::size_t>(rows()) * kColumns, 0);
    }
    CentreLine line() const {
        CentreLine line;
        line.name = "colon";
        line.spacingMm = static_cast<double>(course_->stationMm());
        for (const auto& station : course_->stations()) {
            line.points.emplace_back(station.at);
            line.radiusMm.push_back(std::max(0.0, toWall(glm::dvec3(station.at))));
        }
        return line;
    }
    double toWall(const glm::dvec3& p) const { return -static_cast<double>(lumen_.distance(glm::vec3(p))); }
    double toPolyp(const glm::dvec3& p, std::size_t* which = nullptr) const {
        double nearest = 1e9;
        for (std::size_t k = 0; k < polyps_.size(); ++k)
            if (const double d = glm::length(p - polyps_[k].centreMm) - 0.5 * polyps_[k].diameterMm;
                d < nearest) {
                nearest = d;
                if (which)
                    *which = k;
            }
        return nearest;
    }
    const std::vector<ColonPolyp>& polyps() const { return polyps_; }

    enum class Meets { wall, polyp, nothing };
    /// The end of a ray from the lumen. Distances are of first order: half of them is a safe step.
    Meets trace(const PatientRay& ray, const glm::dvec3& eye, const VolumeInfo& info, std::size_t& polyp,
                glm::dvec3& at) const {
        const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
        double t = 0;
        for (int step = 0; step < 4000; ++step) {
            at = eye + t * ray.direction;
            const glm::dvec3 voxel(voxelFromPatient * glm::dvec4(at, 1));
            if (glm::any(glm::lessThan(voxel, glm::dvec3(1))) ||
                glm::any(glm::greaterThan(voxel, glm::dvec3(info.extentVoxels) - 1.0)))
                return Meets::nothing;
            const double head = toPolyp(at, &polyp), wall = toWall(at);
            if (std::min(head, wall) < 0.02)
                return head < wall ? Meets::polyp : Meets::wall;
            t += std::max(0.03, 0.5 * std::min(head, wall));
        }
        return Meets::nothing;
    }
    /// The wall has one place for every arc length and angle.
    void see(const glm::dvec3& at) {
        ColonGrid::Nearest n{};
        if (!grid_->nearest(glm::vec3(at), n))
            return;
        const auto &a = course_->stations()[n.station], &b = course_->stations()[n.station + 1];
        const glm::vec3 away = glm::vec3(at) - (a.at + n.t * (b.at - a.at));
        const float angle = std::atan2(glm::dot(away, a.binormal), glm::dot(away, a.normal));
        const int column = static_cast<int>(std::floor((angle / 6.2831853F + 1) * kColumns)) % kColumns;
        const int row = std::min(static_cast<int>(n.arcMm / kRowMm), rows() - 1);
        seen_[static_cast<std::size_t>(row * kColumns + column)] = 1;
    }
    /// By area, of the wall along the course from one arc length to another.
    double shareSeen(double from, double to) const {
        double seen = 0, all = 0;
        for (int row = 0; row < rows(); ++row)
            for (int column = 0; column < kColumns; ++column) {
                const float arc = (static_cast<float>(row) + 0.5F) * kRowMm;
                if (static_cast<double>(arc) < from || static_cast<double>(arc) > to)
                    continue;
                const float angle = (static_cast<float>(column) + 0.5F) * 6.2831853F / kColumns;
                const ColonCourse::Lumen l = course_->lumen(arc, std::cos(angle), std::sin(angle), true);
                const auto area = static_cast<double>(l.radiusMm * std::sqrt(1 + l.slope * l.slope));
                all += area;
                seen += seen_[static_cast<std::size_t>(row * kColumns + column)] ? area : 0;
            }
        return all > 0 ? seen / all : 0;
    }

  private:
    static constexpr int kColumns = 72;
    static constexpr float kRowMm = 2;
    int rows() const { return static_cast<int>(course_->lengthMm() / kRowMm) + 1; }
    std::shared_ptr<const ColonCourse> course_;
    std::shared_ptr<const ColonGrid> grid_;
    Colon lumen_;
    std::vector<ColonPolyp> polyps_;
    std::vector<std::uint8_t> seen_;
};

double percentile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void printTimes(const char* what, const std::vector<double>& ms) {
    std::printf("%s: %zu, median %.0f ms, 90 of 100 within %.0f, 99 within %.0f, the longest %.0f\n", what,
                ms.size(), percentile(ms, 0.5), percentile(ms, 0.9), percentile(ms, 0.99), percentile(ms, 1));
}

/// Views one after another, each until it has its levels.
void flyInteractively(const Film& film, const Scene& scene, const StoreReader& store, std::size_t views,
                      const std::string& gpuMemory) {
    constexpr std::size_t kAhead = 8;
    for (const bool told : {false, true}) {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        MemoryBudget gpu("GPU memory", "--gpu-memory", parseBytes(gpuMemory, "--gpu-memory"));
        NativeEngine engine(0, gpu, ram);
        const StoreReader own(scene.volumes.front().path, ram);
        InteractiveOptions options;
        Scene first = scene;
        first.camera = film.cameraAt(0);
        InteractiveRenderer renderer(first, own, engine, ram, gpu, options);
        std::vector<double> firstMs, lastMs, missed;
        for (std::size_t n = 0; n < views; ++n) {
            const auto start = Clock::now();
            const auto misses = renderer.cacheCounters().misses;
            std::uint64_t missedNow = 0;
            renderer.setCamera(film.cameraAt(film.timeOf(n)));
            if (told) {
                std::vector<Camera> next;
                for (std::size_t k = 1; k <= kAhead && n + k < views; ++k)
                    next.push_back(film.cameraAt(film.timeOf(n + k)));
                renderer.setPath(std::move(next));
            }
            bool drawn = false;
            for (;;) {
                const auto progress = renderer.advance(Clock::now() + std::chrono::milliseconds(33));
                if (progress.newPicture && !std::exchange(drawn, true))
                    firstMs.push_back(msSince(start));
                if (drawn && !progress.choosing && progress.movesLeft == 0 && missedNow == 0) {
                    missedNow = renderer.cacheCounters().misses - misses + 1;
                    lastMs.push_back(msSince(start));
                }
                if (progress.converged)
                    break;
            }
            missed.push_back(static_cast<double>(missedNow - 1));
        }
        std::printf("\npath %s, %s of bricks\n", told ? "told" : "not told", gpuMemory.c_str());
        printTimes("first picture of a view", firstMs);
        printTimes("all bricks of a view at their levels", lastMs);
        std::printf("chunks decoded while a view waited for them: %.0f in all, %.1f a view in the mean, %.0f "
                    "at most\n",
                    std::accumulate(missed.begin(), missed.end(), 0.0),
                    std::accumulate(missed.begin(), missed.end(), 0.0) / static_cast<double>(missed.size()),
                    percentile(missed, 1));
        std::fflush(stdout);
    }
    static_cast<void>(store);
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--store", ""},
                                 {"--scene", ""},
                                 {"--size", "320x240x1"},
                                 {"--frames", "500"},
                                 {"--angle", "130"},
                                 {"--reference", "20"},
                                 {"--draw", "yes"},
                                 {"--interactive", "0"},
                                 {"--gpu-memory", "256MiB"}});
    const auto number = [&](const std::string& name) { return std::strtod(options[name].c_str(), nullptr); };
    const glm::ivec2 size(parseExtent(options["--size"], "--size"));
    const auto frames = static_cast<std::size_t>(number("--frames"));
    Colonoscopy colon;
    Path path;
    path.lines = {colon.line()};
    path.flight = Flight{};
    path.flight->viewAngle = number("--angle");
    path.flight->fromMm = 2;
    path.flight->toMm = path.lines[0].lengthMm() - 2;
    path.flight->speedMmPerS =
        (*path.flight->toMm - 2) * path.framesPerSecond / static_cast<double>(frames - 1);
    // The curve is a little shorter than the polygon: the speed that makes so many frames of it.
    path.flight->speedMmPerS *=
        FlightCurve(path.lines, *path.flight).lengthMm() / (*path.flight->toMm - 2) * (1 - 1e-9);

    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30),
        gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader store(options["--store"], ram);
    const VolumeInfo& info = store.info();
    Scene scene = loadScene(options["--scene"]);
    scene.volumes.front().path = options["--store"];
    scene.imageSize = size;
    const Film film(path, scene, {}, "the colon's path");
    std::printf("%zu frames of %d x %d over %.0f mm, %.0f degrees; load %.2f\n", film.frames(), size.x,
                size.y, film.curve()->lengthMm(), number("--angle"), loadAverage());
    if (const auto views = static_cast<std::size_t>(number("--interactive")); views > 0) {
        flyInteractively(film, scene, store, std::min(views, film.frames()), options["--gpu-memory"]);
        return;
    }

    const bool draws = options["--draw"] == "yes";
    RenderOptions render;
    render.engine = EngineKind::native;
    render.searching = true;
    FrameRenderer renderer(store, ram, gpu, render);
    Scene sampled = scene;
    sampled.quality.pixels.samples = PixelSampling::kAutomatic;
    constexpr int kEvery = 4; // rays that are traced through the formula: one of 4 x 4 pixels
    double nearest = 1e9, mostJump = 0, lumaBefore = 0, preparing = 0, loading = 0, drawing = 0;
    std::size_t rays = 0, outOfVolume = 0, holes = 0, edges = 0, framesWithHoles = 0, jumpAt = 0;
    std::vector<std::size_t> mostOfPolyp(colon.polyps().size()), polypAt(colon.polyps().size());
    std::vector<double> ms;
    for (std::size_t n = 0; n < film.frames(); ++n) {
        const Camera camera = film.cameraAt(film.timeOf(n));
        nearest = std::min({nearest, colon.toWall(camera.position), colon.toPolyp(camera.position)});
        Image image;
        if (draws) {
            Scene now = sampled;
            now.camera = camera;
            const auto start = Clock::now();
            RenderResult result = renderer.draw(now);
            ms.push_back(msSince(start));
            preparing += result.secondsPreparing, loading += result.secondsLoading,
                drawing += result.secondsDrawing;
            image = std::move(result.image);
            double luma = 0;
            for (const glm::vec4& p : image.pixels)
                luma += 0.2126 * static_cast<double>(p.r) + 0.7152 * static_cast<double>(p.g) +
                        0.0722 * static_cast<double>(p.b);
            luma /= static_cast<double>(image.pixels.size());
            if (n > 0 && std::abs(luma - lumaBefore) / std::max(luma, lumaBefore) > mostJump) {
                mostJump = std::abs(luma - lumaBefore) / std::max(luma, lumaBefore);
                jumpAt = n;
            }
            lumaBefore = luma;
        }
        const RayPlane plane = rayPlane(camera, info, size);
        std::vector<std::size_t> ofPolyp(colon.polyps().size());
        const std::size_t holesBefore = holes;
        for (int y = kEvery / 2; y < size.y; y += kEvery)
            for (int x = kEvery / 2; x < size.x; x += kEvery) {
                std::size_t polyp = 0;
                glm::dvec3 at(0);
                const auto meets = colon.trace(pixelRay(plane, glm::dvec2(x, y) + 0.5, size), camera.position,
                                               info, polyp, at);
                ++rays;
                outOfVolume += meets == Colonoscopy::Meets::nothing;
                if (meets == Colonoscopy::Meets::polyp)
                    ++ofPolyp[polyp];
                if (meets == Colonoscopy::Meets::wall)
                    colon.see(at);
                if (draws && meets != Colonoscopy::Meets::nothing && image.at(x, y).a < 0.99F) {
                    // A pixel is a mean: all of it must meet the wall.
                    bool whole = true;
                    for (const glm::dvec2& corner :
                         {glm::dvec2(-0.5, -0.5), {1.5, -0.5}, {-0.5, 1.5}, {1.5, 1.5}})
                        whole = whole &&
                                colon.trace(pixelRay(plane, glm::dvec2(x, y) + corner, size), camera.position,
                                            info, polyp, at) != Colonoscopy::Meets::nothing;
                    (whole ? holes : edges) += 1;
                }
            }
        framesWithHoles += holes > holesBefore;
        for (std::size_t k = 0; k < ofPolyp.size(); ++k)
            if (ofPolyp[k] > mostOfPolyp[k]) {
                mostOfPolyp[k] = ofPolyp[k];
                polypAt[k] = n;
            }
    }
    std::printf("nearest to wall or polyp: %.2f mm\n", nearest);
    std::printf("rays traced: %zu; %zu leave the volume through its border\n", rays, outOfVolume);
    if (draws) {
        std::printf(
            "holes (the wall is there, the pixel is not opaque): %zu, in %zu frames; pixels at the volume's "
            "border: %zu\n",
            holes, framesWithHoles, edges);
        std::printf("largest change of mean luminance from a frame to the next: %.1f %%, at frame %zu\n",
                    100 * mostJump, jumpAt);
        printTimes("frames", ms);
        std::printf(
            "seconds: preparing %.1f, loading %.1f, drawing %.1f; %zu frames with bricks of the one before\n",
            preparing, loading, drawing, renderer.kept().goneOn);
    }
    for (std::size_t k = 0; k < mostOfPolyp.size(); ++k)
        std::printf("polyp %zu, %.0f mm%s: about %zu pixels at most, in frame %zu\n", k,
                    colon.polyps()[k].diameterMm, colon.polyps()[k].pedunculated ? " on a stalk" : "",
                    mostOfPolyp[k] * kEvery * kEvery, polypAt[k]);
    std::printf("wall seen: %.1f %% of its area (arc 0 to the end), %.1f %% from 20 mm to 640 mm\n",
                100 * colon.shareSeen(0, 1e9), 100 * colon.shareSeen(20, 640));
    std::fflush(stdout);

    const auto references = static_cast<std::size_t>(number("--reference"));
    double worstP99 = 0, worstMean = 0;
    for (std::size_t k = 0; draws && k < references; ++k) {
        const std::size_t n = references > 1 ? k * (film.frames() - 1) / (references - 1) : 0;
        Scene small = scene;
        small.imageSize = {64, 48};
        small.camera = film.cameraAt(film.timeOf(n));
        RenderOptions truth;
        truth.engine = EngineKind::reference;
        const Image exact = renderScene(small, store, ram, gpu, truth).image;
        const Image drawn = renderScene(small, store, ram, gpu, render).image;
        const ImageError error = measureError(drawn, exact);
        worstP99 = std::max(worstP99, error.luvP99), worstMean = std::max(worstMean, error.luvMean);
        std::size_t open = 0;
        for (std::size_t i = 0; i < exact.pixels.size(); ++i)
            open += (exact.pixels[i].a > 0.99F) != (drawn.pixels[i].a > 0.99F);
        std::printf("frame %zu against the reference: L*u*v* %.3f in the mean, %.2f at the 99th percentile; "
                    "%zu pixels "
                    "opaque in one only\n",
                    n, error.luvMean, error.luvP99, open);
        std::fflush(stdout);
    }
    if (draws && references > 0)
        std::printf("worst: %.3f in the mean, %.2f at the 99th percentile\n", worstMean, worstP99);
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("flight_study", tessera::bench::run, argc, argv);
}
