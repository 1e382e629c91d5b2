// tests/bench/path_baselines.cpp: see path_baselines.h.
#include "tests/bench/path_baselines.h"

#include "core/base/threads.h"
#include "render/picture/picture.h"
#include "render/transport/path.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <mutex>

namespace tessera::bench {
namespace {

float greatestOf(const ExtinctionBounds& bounds) {
    float most = 0;
    for (const std::uint32_t range : bounds.ranges())
        most = std::max(most, ExtinctionBounds::unpacked(range).most);
    return most;
}

/// Distances to the next collision on a way, mm; below 0: there is none.
class Tracker {
  public:
    Tracker(const PathScene& scene, NativeField& field, PathTracer<NativeField>& tracer, PathWork& work,
            Tracking tracking, float majorant, float stepMm)
        : scene_(scene), field_(field), tracer_(tracer), work_(work), tracking_(tracking),
          majorant_(majorant), stepMm_(stepMm) {}

    float collision(const Way& way, PathNumbers& numbers) {
        return tracking_ == Tracking::marching ? march(way, numbers) : track(way, numbers);
    }

    /// The light of one path from a pixel's ray; colour is premultiplied.
    glm::vec4 sample(const SegmentedRay<float>& ray, const glm::vec2& place) {
        TracedPath path(scene_, place);
        if (ray.count == 0)
            return glm::vec4(0);
        const glm::vec3 mm = scene_.optics->patientFromVoxel * ray.direction;
        Way way = wayFrom(scene_, ray.entry, mm / std::sqrt(glm::dot(mm, mm)));
        float at = collision(way, path.numbers);
        if (at < 0)
            return glm::vec4(0);
        const glm::vec3 p = way.from + at * way.perMm;
        const float value = field_.value(p);
        tracer_.start(path, p, tracer_.tissueAt(p, value).albedo, ray.direction, value);
        tracer_.begin(path);
        do {
            const glm::vec3 gradient = tracer_.takesGradients() ? field_.gradient(path.p) : glm::vec3(0);
            if (tracer_.aim(path, gradient, way))
                tracer_.shineBy(path, collision(way, path.numbers) < 0 ? 1.0f : 0.0f);
            if (!tracer_.turn(path, way))
                break;
            at = collision(way, path.numbers);
        } while (tracer_.reach(path, way, at) && tracer_.settle(path, field_.value(path.p)));
        return {path.sum, 1};
    }

  private:
    float track(const Way& way, PathNumbers& numbers) {
        if (!(majorant_ > 0))
            return -1;
        for (float mm = 0;;) {
            mm += exponentialOf(numbers.next()) / majorant_;
            if (!(mm < way.mm))
                return -1;
            ++work_.lookUps;
            if (numbers.next() * majorant_ < tracer_.extinctionAt(way.from + mm * way.perMm))
                return mm;
            ++work_.nullCollisions;
        }
    }
    float march(const Way& way, PathNumbers& numbers) {
        const float sought = exponentialOf(numbers.next());
        float sum = 0;
        for (float mm = numbers.next() * stepMm_; mm < way.mm; mm += stepMm_) {
            ++work_.lookUps;
            sum += tracer_.extinctionAt(way.from + mm * way.perMm) * stepMm_;
            if (!(sum < sought))
                return mm;
        }
        return -1;
    }

    const PathScene& scene_;
    NativeField& field_;
    PathTracer<NativeField>& tracer_;
    PathWork& work_;
    Tracking tracking_;
    float majorant_, stepMm_;
};

} // namespace

double cpuSeconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

PathBaseline::PathBaseline(const Scene& scene, const StoreReader& store, Budgets& budgets, int threads)
    : size_(scene.imageSize), threads_(threads), engine_(threads, budgets.gpu, budgets.ram),
      plan_(planScene(scene, store, engine_.limits(), {budgets.ram, budgets.gpu, threads},
                      LevelChoice::finest)) {
    loadBricks(engine_, plan_, budgets.gpu, loaded_);
    engine_.settled();
}

NativeField PathBaseline::field() const {
    const Layer& layer = plan_.layer();
    NativeField field(engine_.plane(), layer.mixed() ? &layer.levels : nullptr, layer.selection.finest(),
                      layer.optics.gradient);
    field.setLabels(engine_.labelChannels(), layer.optics.labels);
    return field;
}

std::vector<float> PathBaseline::extinctions(const glm::ivec3& grid) const {
    const PathScene scene = pathSceneOf(plan_, nullptr);
    const glm::vec3 pitch = glm::vec3(plan_.info().extentVoxels) / glm::vec3(grid);
    std::vector<float> values(cellCount(grid));
    parallelFor(static_cast<std::size_t>(grid.z), threads_, [&](std::size_t z) {
        NativeField bricks = field();
        PathWork work;
        PathTracer<NativeField> tracer(scene, bricks, work);
        for (glm::ivec3 at(0, 0, static_cast<int>(z)); at.y < grid.y; ++at.y)
            for (at.x = 0; at.x < grid.x; ++at.x)
                values[linearIndex(at, grid)] = tracer.extinctionAt(pitch * (glm::vec3(at) + 0.5f));
    });
    return values;
}

Image PathBaseline::draw(Tracking tracking, int samples, std::uint32_t seed, double stepVoxels,
                         PathWork& work) const {
    PathScene scene = pathSceneOf(plan_, nullptr);
    scene.seed = seed;
    const float majorant = greatestOf(plan_.layer().extinction);
    const auto stepMm = static_cast<float>(
        stepVoxels * std::cbrt(std::abs(glm::determinant(glm::dmat3(plan_.info().patientFromVoxel)))));
    const RayFrame<float> frame = cast<float>(raysOf(plan_).frame);
    Image image(size_);
    std::mutex mutex;
    parallelFor(static_cast<std::size_t>(size_.y), threads_, [&](std::size_t row) {
        NativeField bricks = field();
        PathWork mine;
        PathTracer<NativeField> tracer(scene, bricks, mine);
        Tracker tracker(scene, bricks, tracer, mine, tracking, majorant, stepMm);
        for (int x = 0; x < size_.x; ++x) {
            const glm::vec2 pixel(static_cast<float>(x), static_cast<float>(row));
            glm::vec4 sum(0);
            for (int n = 0; n < samples; ++n) {
                // Its own numbers: those of the path follow from the place.
                PathNumbers shift(pixel + 0.25f, seed + 0x1000u * static_cast<std::uint32_t>(n + 1));
                const float right = shift.next(), down = shift.next();
                const glm::vec2 place = pixel + glm::vec2(right, down);
                sum += tracker.sample(segmentedRay(frame, place), place);
            }
            image.at(x, static_cast<int>(row)) = sum / static_cast<float>(samples);
        }
        const std::lock_guard lock(mutex);
        work += mine;
    });
    return image;
}

} // namespace tessera::bench
