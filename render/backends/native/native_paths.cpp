// render/backends/native/native_paths.cpp: see native_paths.h.
#include "render/backends/native/native_paths.h"

#include "core/base/interrupt.h"
#include "render/backends/native/native_scene.h"

#include <algorithm>

namespace tessera {
namespace {

/// What packets know: the midpoint rule, gradients by differences, no isosurfaces.
bool goInPackets(const PathScene& scene) {
    const Optics& o = *scene.optics;
    return scene.transport.response == TransportResponse::physical && o.integrator == Integrator::midpoint &&
           o.gradient != Gradient::analytic && o.gradient != Gradient::cubic && o.surfaces.empty();
}

} // namespace

NativePaths::NativePaths(const PathScene& scene, const MirrorInput& input, NativeField& field,
                         const native::PacketScene& packets, const native::PacketTarget& target)
    : scene_(scene), input_(input), field_(field), packets_(packets), target_(target) {
    if (!goInPackets(scene))
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
    places_ = target.places(packets);
}

void NativePaths::add(std::span<const SegmentedRay<float>> parts, const PathStart& start, glm::vec4& colour,
                      PathBeginning* beginning, Work& work) {
    if (free_) {
        paths_.push_back({rays_.size(),
                          parts.size(),
                          TracedPath(scene_, start.place, start.number),
                          {},
                          &colour,
                          beginning});
        rays_.insert(rays_.end(), parts.begin(), parts.end());
    } else {
        colour = pathColour(parts, field_, input_, scene_, start, colour.a, work, beginning);
        ++work.paths.alone;
    }
}

NativePaths::List NativePaths::seek(Work& work) {
    const auto lanes = static_cast<std::size_t>(target_.lanes());
    native::PacketJob job;
    native::PacketSeen seen{};
    List found;
    glm::vec3 colours[native::kMostLanes];
    for (std::size_t first = 0; first < paths_.size(); first += lanes) {
        const std::size_t count = std::min(lanes, paths_.size() - first);
        seen.shows = 0;
        for (std::size_t lane = 0; lane < count; ++lane) {
            Going& going = paths_[first + lane];
            seen.sought[lane] = going.path.numbers.pair(0).x * going.colour->a;
            seen.alpha[lane] = 0;
        }
        std::uint32_t left = count < 32 ? (1u << count) - 1u : ~0u; // that have another part
        for (std::size_t part = 0; left != 0; ++part) {
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const Going& going = paths_[first + std::min(lane, count - 1)];
                if ((left >> lane & 1u) != 0 &&
                    (part == going.count || isOpaque(*scene_.optics, glm::vec4(0, 0, 0, seen.alpha[lane]))))
                    left &= ~(1u << lane);
                const SegmentedRay<float>& ray = rays_[going.first + std::min(part, going.count - 1)];
                for (int axis = 0; axis < 3; ++axis) {
                    job.entry[axis][lane] = ray.entry[axis];
                    job.step[axis][lane] = ray.step[axis];
                }
                job.segmentMm[lane] = ray.segmentMm;
                job.tail[lane] = ray.tail;
                job.count[lane] = (left >> lane & 1u) != 0 ? ray.count : 0;
            }
            if (left == 0)
                break;
            seen.found = 0;
            places_.seek(packets_, job, seen);
            left &= ~seen.found;
        }
        List here;
        for (std::size_t lane = 0; lane < count; ++lane)
            if (Going& going = paths_[first + lane]; (seen.shows >> lane & 1u) != 0) {
                going.path.p = {seen.place[0][lane], seen.place[1][lane], seen.place[2][lane]};
                colours[here.size()] = {seen.colour[0][lane], seen.colour[1][lane], seen.colour[2][lane]};
                here.push_back(&going);
            }
        const bool asked = !here.empty() && here.front()->beginning;
        sample(here, asked);
        PathTracer<NativeField> tracer(scene_, field_, work.paths);
        for (std::size_t n = 0; n < here.size(); ++n) {
            tracer.start(here[n]->path, here[n]->path.p, colours[n], rays_[here[n]->first].direction,
                         result_[n]);
            if (asked)
                *here[n]->beginning =
                    beginningOf(scene_, here[n]->path, {gradient_[0][n], gradient_[1][n], gradient_[2][n]});
            tracer.begin(here[n]->path);
        }
        found.insert(found.end(), here.begin(), here.end());
    }
    work.segments += seen.segments;
    work.samples += seen.segments;
    return found;
}

void NativePaths::sample(const List& of, bool gradients) {
    const std::size_t room = of.size() + native::kMostLanes;
    native::PacketSamples samples;
    samples.count = static_cast<std::int32_t>(of.size());
    for (int axis = 0; axis < 3; ++axis) {
        from_[axis].assign(room, 0);
        for (std::size_t n = 0; n < of.size(); ++n)
            from_[axis][n] = of[n]->path.p[axis];
        samples.at[axis] = from_[axis].data();
        gradient_[axis].resize(room);
        samples.gradient[axis] = gradients ? gradient_[axis].data() : nullptr;
    }
    result_.resize(room);
    samples.value = result_.data();
    samples.kind = packetGradient(scene_.normals);
    places_.samples(packets_, samples);
}

const std::vector<float>& NativePaths::follow(bool free, const List& of, Work& work) {
    ways_.clear();
    if (!scene_.cuts) {
        for (const Going* g : of)
            ways_.push_back(g->way);
        followWhole(free, of, ways_, work);
        return result_;
    }
    parts_.resize(std::max(parts_.size(), of.size()));
    whole_.assign(of.size(), free ? -1.0f : 1.0f);
    for (std::size_t n = 0; n < of.size(); ++n)
        keptParts(*scene_.cuts, of[n]->way, parts_[n]);
    List here;
    std::vector<std::size_t> numbers;
    for (std::size_t part = 0;; ++part) {
        ways_.clear(), here.clear(), numbers.clear();
        for (std::size_t n = 0; n < of.size(); ++n)
            if (part < parts_[n].size() && (free ? whole_[n] < 0.0f : whole_[n] > 0.0f)) {
                ways_.push_back(partOf(of[n]->way, parts_[n][part]));
                here.push_back(of[n]);
                numbers.push_back(n);
            }
        if (here.empty())
            return whole_;
        followWhole(free, here, ways_, work);
        for (std::size_t k = 0; k < here.size(); ++k) {
            float& whole = whole_[numbers[k]];
            if (!free)
                whole *= result_[k];
            else if (result_[k] >= 0.0f)
                whole = static_cast<float>(parts_[numbers[k]][part].from) + result_[k];
        }
    }
}

void NativePaths::followWhole(bool free, const List& of, const std::vector<Way>& along, Work& work) {
    const std::size_t count = of.size();
    for (int axis = 0; axis < 3; ++axis)
        from_[axis].resize(count), perMm_[axis].resize(count);
    mm_.resize(count), result_.resize(count);
    first_.resize(count), second_.resize(count), draws_.resize(count);
    for (std::size_t n = 0; n < count; ++n) {
        const Way& way = along[n];
        for (int axis = 0; axis < 3; ++axis)
            from_[axis][n] = way.from[axis], perMm_[axis][n] = way.perMm[axis];
        mm_[n] = way.mm;
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
    List going = paths_.empty() ? List() : seek(work), ways;
    while (!going.empty()) {
        checkInterrupted();
        const bool gradients = tracer.takesGradients();
        if (gradients)
            sample(going, true);
        ways.clear();
        for (std::size_t n = 0; n < going.size(); ++n) {
            const glm::vec3 gradient =
                gradients ? glm::vec3(gradient_[0][n], gradient_[1][n], gradient_[2][n]) : glm::vec3(0);
            if (tracer.aim(going[n]->path, gradient, going[n]->way))
                ways.push_back(going[n]);
        }
        const bool squared = isSquared(scene_, going.front()->path); // all have scattered as often
        const auto bring = [&](auto&& take) {
            const std::vector<float>* left = squared ? nullptr : &follow(false, ways, work);
            for (std::size_t n = 0; n < ways.size(); ++n)
                take(ways[n]->path, left ? (*left)[n] : ways[n]->path.passed);
        };
        bring(Tracer::shineBy);
        ways.clear();
        for (Going* g : going)
            if (tracer.turn(g->path, g->way))
                ways.push_back(g);
        if (isLast(scene_, going.front()->path)) {
            bring([&](TracedPath& path, float left) { tracer.leave(path, left); });
            break;
        }
        const std::vector<float>& collisions = follow(true, ways, work);
        List reached;
        for (std::size_t n = 0; n < ways.size(); ++n)
            if (tracer.reach(ways[n]->path, ways[n]->way, collisions[n])) {
                ways[n]->way.mm = collisions[n];
                reached.push_back(ways[n]);
            }
        if (asksWhatPassed(scene_, going.front()->path)) {
            const std::vector<float>& passed = follow(false, reached, work);
            for (std::size_t n = 0; n < reached.size(); ++n)
                reached[n]->path.passed = passed[n];
        }
        sample(reached, false);
        going.clear();
        for (std::size_t n = 0; n < reached.size(); ++n)
            if (tracer.settle(reached[n]->path, result_[n]))
                going.push_back(reached[n]);
    }
    for (const Going& g : paths_)
        *g.colour = {g.colour->a * g.path.sum, g.colour->a};
    paths_.clear();
    rays_.clear();
}

} // namespace tessera
