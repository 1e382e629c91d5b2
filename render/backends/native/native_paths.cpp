// render/backends/native/native_paths.cpp: see native_paths.h.
#include "render/backends/native/native_paths.h"

#include <algorithm>

namespace tessera {

NativePaths::NativePaths(const PathScene& scene, const MirrorInput& input, NativeField& field,
                         const native::PacketScene& packets, const native::PacketTarget& target)
    : scene_(scene), input_(input), field_(field), packets_(packets) {
    // Lanes know the function alone.
    if (scene.transport.response != TransportResponse::physical || scene.optics->grades() ||
        scene.optics->labels.count > 0)
        return;
    const ExtinctionBounds& bounds = *scene.bounds;
    extinction_.cells = bounds.ranges().data();
    if (!bounds.partRanges().empty()) {
        extinction_.parts = bounds.parts().data();
        extinction_.partRanges = bounds.partRanges().data();
    }
    for (int axis = 0; axis < 3; ++axis)
        extinction_.grid[axis] = bounds.grid()[axis];
    extinction_.limit = bounds.limit();
    free_ = target.ways(packets, true);
    left_ = target.ways(packets, false);
}

void NativePaths::add(const SegmentedRay<float>& ray, const glm::vec2& place, glm::vec4& colour, Work& work) {
    if (!free_) {
        colour = pathColour(ray, field_, input_, scene_, place, colour.a, work);
        return;
    }
    Going going{Path(scene_, place), {}, &colour};
    PathTracer<NativeField> tracer(scene_, field_, work.paths);
    if (beginPath(ray, field_, input_, scene_, colour.a, tracer, going.path, work)) {
        tracer.begin(going.path);
        paths_.push_back(going);
    } else {
        colour = {0, 0, 0, colour.a};
    }
}

void NativePaths::follow(bool free, const std::vector<Going*>& of, Work& work) {
    const std::size_t count = of.size();
    for (int axis = 0; axis < 3; ++axis)
        from_[axis].resize(count), perMm_[axis].resize(count);
    mm_.resize(count), result_.resize(count), first_.resize(count), second_.resize(count),
        draws_.resize(count);
    for (std::size_t n = 0; n < count; ++n) {
        const Flight& flight = of[n]->flight;
        for (int axis = 0; axis < 3; ++axis)
            from_[axis][n] = flight.from[axis], perMm_[axis][n] = flight.perMm[axis];
        mm_[n] = flight.mm;
        const PathNumbers& numbers = of[n]->path.numbers;
        first_[n] = numbers.first(), second_[n] = numbers.second(), draws_[n] = numbers.draws();
    }
    native::PacketWays ways;
    ways.count = static_cast<std::int32_t>(count);
    for (int axis = 0; axis < 3; ++axis)
        ways.from[axis] = from_[axis].data(), ways.perMm[axis] = perMm_[axis].data();
    ways.mm = mm_.data();
    ways.first = first_.data(), ways.second = second_.data(), ways.draws = draws_.data();
    ways.result = result_.data();
    (free ? free_ : left_)(packets_, extinction_, ways);
    for (std::size_t n = 0; n < count; ++n)
        of[n]->path.numbers.setDraws(draws_[n]);
    work.paths.lookUps += ways.lookUps, work.paths.nullCollisions += ways.nullCollisions;
    work.paths.cells += ways.cells, work.paths.exceeded += ways.exceeded;
}

void NativePaths::run(Work& work) {
    using Tracer = PathTracer<NativeField>;
    Tracer tracer(scene_, field_, work.paths);
    std::vector<Going*> going, ways;
    for (Going& path : paths_)
        going.push_back(&path);
    while (!going.empty()) {
        ways.clear();
        for (Going* g : going)
            if (tracer.aim(g->path, g->flight))
                ways.push_back(g);
        follow(false, ways, work);
        for (std::size_t n = 0; n < ways.size(); ++n)
            Tracer::shineBy(ways[n]->path, result_[n]);
        ways.clear();
        for (Going* g : going)
            if (tracer.turn(g->path, g->flight))
                ways.push_back(g);
        follow(true, ways, work);
        going.clear();
        for (std::size_t n = 0; n < ways.size(); ++n)
            if (tracer.arrive(ways[n]->path, ways[n]->flight, result_[n]))
                going.push_back(ways[n]);
    }
    for (const Going& g : paths_)
        *g.colour = {g.colour->a * g.path.sum, g.colour->a};
    paths_.clear();
}

} // namespace tessera
