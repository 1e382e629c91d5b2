// render/contract/ray_cuts.cpp: see ray_cuts.h.
#include "render/contract/ray_cuts.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

namespace tessera {
namespace {

using Part = RayCuts::Part;

/// By the even-odd rule; a point on an edge is on one side of it, always the same.
bool holds(const std::vector<glm::dvec2>& outline, const glm::dvec2& p) {
    bool inside = false;
    for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
        const glm::dvec2 &a = outline[i], &b = outline[j];
        if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x)
            inside = !inside;
    }
    return inside;
}

/// The intersection of two lists.
void intersect(std::vector<Part>& parts, const std::vector<Part>& with, std::vector<Part>& scratch) {
    scratch.clear();
    for (std::size_t a = 0, b = 0; a < parts.size() && b < with.size();) {
        const Part both{std::max(parts[a].from, with[b].from), std::min(parts[a].to, with[b].to)};
        if (both.to > both.from || (both.to == both.from && parts[a].to == parts[a].from))
            scratch.push_back(both);
        ++(parts[a].to < with[b].to ? a : b);
    }
    parts.swap(scratch);
}

/// The part of [t0, t1] that is in none of them.
std::vector<Part> outsideOf(const std::vector<Part>& parts, double t0, double t1) {
    std::vector<Part> out;
    double from = t0;
    for (const Part& part : parts) {
        if (part.from > from)
            out.push_back({from, part.from});
        from = std::max(from, part.to);
    }
    if (from < t1 || (parts.empty() && t0 == t1))
        out.push_back({from, t1});
    return out;
}

} // namespace

void RayCuts::add(const Scissors& scissors, const VolumeInfo& info) {
    const Camera& camera = scissors.camera;
    const glm::dmat3 axes = patientFromCamera(camera); // right, up, towards the viewer
    const glm::dmat4& m = info.patientFromVoxel;
    // dot(axis, p - position) of a place in voxels.
    const auto row = [&](const glm::dvec3& axis) {
        const glm::dvec3 linear = glm::transpose(glm::dmat3(m)) * axis;
        return glm::dvec4(linear, glm::dot(axis, glm::dvec3(m[3]) - camera.position));
    };
    const bool perspective = camera.projection == Projection::perspective;
    const double half = perspective ? std::tan(glm::radians(camera.viewAngle) / 2) : camera.parallelScale;
    const glm::dvec4 depth = perspective ? -row(axes[2]) : glm::dvec4(0, 0, 0, 1);
    Outline outline;
    outline.rows[0] = 0.5 * (row(axes[0]) / (half * scissors.aspect) + depth);
    outline.rows[1] = 0.5 * (depth - row(axes[1]) / half);
    outline.rows[2] = depth;
    outline.points = scissors.outline;
    outline.keep = scissors.keep;
    outlines_.push_back(std::move(outline));
}

// Of the picture's homogeneous coordinates, which are linear in t, edges of the outline are planes through
// the eye; between two crossings a ray is inside all along or nowhere.
void RayCuts::insideOf(const Outline& outline, const glm::dvec3& base, const glm::dvec3& direction, double t0,
                       double t1, std::vector<Part>& out) const {
    glm::dvec3 at, along;
    for (int n = 0; n < 3; ++n) {
        at[n] = glm::dot(glm::dvec3(outline.rows[n]), base) + outline.rows[n].w;
        along[n] = glm::dot(glm::dvec3(outline.rows[n]), direction);
    }
    const auto inside = [&](double t) {
        const glm::dvec3 h = at + t * along;
        return h.z > 0 && holds(outline.points, glm::dvec2(h) / h.z);
    };
    out.clear();
    if (t0 == t1) {
        if (inside(t0))
            out.push_back({t0, t1});
        return;
    }
    std::vector<double> cuts = {t0, t1};
    const auto cut = [&](double t) {
        if (t > t0 && t < t1)
            cuts.push_back(t);
    };
    if (along.z != 0)
        cut(-at.z / along.z); // the eye's plane
    const std::vector<glm::dvec2>& points = outline.points;
    for (std::size_t i = 0, j = points.size() - 1; i < points.size(); j = i++) {
        const glm::dvec3 edge = glm::cross(glm::dvec3(points[j], 1), glm::dvec3(points[i], 1));
        const double slope = glm::dot(edge, along);
        if (slope == 0)
            continue;
        const double t = -glm::dot(edge, at) / slope;
        if (!(t > t0 && t < t1))
            continue;
        // Beyond its ends an edge's plane cuts nothing; near them it may cut in vain.
        const glm::dvec3 h = at + t * along;
        const glm::dvec2 p = glm::dvec2(h) / h.z, way = points[i] - points[j];
        const double place = glm::dot(p - points[j], way) / glm::dot(way, way);
        if (place > -1e-6 && place < 1 + 1e-6)
            cut(t);
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t n = 0; n + 1 < cuts.size(); ++n) {
        if (!(cuts[n + 1] > cuts[n]) || !inside(0.5 * (cuts[n] + cuts[n + 1])))
            continue;
        if (!out.empty() && out.back().to == cuts[n])
            out.back().to = cuts[n + 1];
        else
            out.push_back({cuts[n], cuts[n + 1]});
    }
}

void RayCuts::parts(const glm::dvec3& base, const glm::dvec3& direction, double t0, double t1,
                    std::vector<Part>& out) const {
    out.assign(1, {t0, t1});
    std::vector<Part> kept, scratch;
    const auto keep = [&](Keep side) {
        intersect(out, side == Keep::inside ? kept : outsideOf(kept, t0, t1), scratch);
    };
    for (const Body& body : bodies_) {
        RayLine<double> line;
        line.base = base, line.direction = direction;
        double a = t0, b = t1;
        bool meets = true;
        for (const RaySlab<double>& slab : body.slabs)
            meets = meets && clipToSlab(line, slab, a, b);
        kept.clear();
        if (meets && (b > a || t0 == t1))
            kept.push_back({a, b});
        keep(body.keep);
    }
    for (const Outline& outline : outlines_) {
        insideOf(outline, base, direction, t0, t1, kept);
        keep(outline.keep);
    }
}

bool RayCuts::mayKeep(const glm::dvec3& low, const glm::dvec3& high) const {
    const glm::dvec3 middle = 0.5 * (low + high), half = 0.5 * (high - low);
    for (const Body& body : bodies_) {
        bool misses = false, within = true; // one slab, all slabs
        for (const RaySlab<double>& slab : body.slabs) {
            const double at = glm::dot(slab.normal, middle), reach = glm::dot(glm::abs(slab.normal), half);
            misses = misses || at + reach < slab.low || at - reach > slab.high;
            within = within && at - reach > slab.low && at + reach < slab.high;
        }
        if (body.keep == Keep::inside ? misses : within)
            return false;
    }
    return true;
}

bool RayCuts::keeps(const glm::dvec3& point, double tolerance) const {
    for (const Body& body : bodies_) {
        bool within = true;
        for (const RaySlab<double>& slab : body.slabs) {
            const double at = glm::dot(slab.normal, point);
            const double reach =
                (body.keep == Keep::inside ? tolerance : -tolerance) * glm::length(slab.normal);
            within = within && at >= slab.low - reach && at <= slab.high + reach;
        }
        if (within != (body.keep == Keep::inside))
            return false;
    }
    for (const Outline& outline : outlines_) {
        glm::dvec3 h;
        for (int n = 0; n < 3; ++n)
            h[n] = glm::dot(glm::dvec3(outline.rows[n]), point) + outline.rows[n].w;
        if ((h.z > 0 && holds(outline.points, glm::dvec2(h) / h.z)) != (outline.keep == Keep::inside))
            return false;
    }
    return true;
}

RayHulls rayHulls(const Camera& camera, const VolumeInfo& info, int count, int samples) {
    const glm::dvec3 forward = -patientFromCamera(camera)[2];
    const glm::dmat4& m = info.patientFromVoxel;
    RayHulls hulls;
    hulls.count = count, hulls.samples = samples;
    hulls.normal = glm::transpose(glm::dmat3(m)) * forward;
    hulls.offset = glm::dot(forward, glm::dvec3(m[3]) - camera.position);
    hulls.nearest = std::numeric_limits<double>::max(), hulls.farthest = -hulls.nearest;
    for (int n = 0; n < 8; ++n) {
        const glm::dvec3 corner = glm::dvec3(info.extentVoxels) * glm::dvec3(n & 1, n >> 1 & 1, n >> 2);
        const double depth = glm::dot(hulls.normal, corner) + hulls.offset;
        hulls.nearest = std::min(hulls.nearest, depth), hulls.farthest = std::max(hulls.farthest, depth);
    }
    if (camera.projection == Projection::perspective)
        hulls.nearest = std::max(hulls.nearest, 0.0);
    return hulls;
}

namespace {

/// The parts of a ray, cut again at the planes of hulls.
void cutAtHulls(const RayHulls& hulls, const RayLine<double>& line, std::vector<Part>& parts,
                std::vector<Part>& scratch) {
    const double at = glm::dot(hulls.normal, line.base) + hulls.offset;
    const double along = glm::dot(hulls.normal, line.direction);
    scratch.clear();
    for (const Part& part : parts) {
        double from = part.from;
        for (int n = 1; n < hulls.count && along > 0; ++n) {
            const double t = (hulls.plane(n) - at) / along;
            if (t > from && t < part.to)
                scratch.push_back({from, t}), from = t;
        }
        scratch.push_back({from, part.to});
    }
    parts.swap(scratch);
}

} // namespace

CutRays cutRays(const RayFrame<double>& frame, std::span<const glm::vec2> places, int threads) {
    TESSERA_CHECK(frame.cuts);
    const glm::ivec2 size(frame.imageSize);
    const std::size_t width = static_cast<std::size_t>(size.x);
    const std::size_t rays = places.empty() ? width * static_cast<std::size_t>(size.y) : places.size();
    TESSERA_CHECK(frame.ends.empty() || frame.ends.size() == rays);
    constexpr std::size_t kStrip = 1024;
    struct Strip {
        std::vector<RayInterval> all;
        std::vector<std::uint32_t> counts;
    };
    std::vector<Strip> strips((rays + kStrip - 1) / kStrip);
    parallelFor(strips.size(), threads, [&](std::size_t number) {
        Strip& strip = strips[number];
        std::vector<RayCuts::Part> parts, scratch;
        for (std::size_t n = number * kStrip; n < std::min(rays, (number + 1) * kStrip); ++n) {
            const glm::dvec2 place =
                places.empty()
                    ? glm::dvec2(static_cast<double>(n % width), static_cast<double>(n / width)) + 0.5
                    : glm::dvec2(places[n]);
            const RayLine<double> line = pixelLine(frame, place);
            double t0 = 0, t1 = 0;
            const std::size_t before = strip.all.size();
            if (drawnPartOf(frame, line, t0, t1)) {
                double from = t0, to = t1;
                if (!frame.ends.empty()) {
                    from = std::max(t0, frame.ends[n].from);
                    to = std::min(t1, frame.ends[n].to);
                }
                parts.clear();
                if (to >= from)
                    frame.cuts->parts(line.base, line.direction, from, to, parts);
                if (frame.hulls.count > 1)
                    cutAtHulls(frame.hulls, line, parts, scratch);
                for (const RayCuts::Part& part : parts) {
                    const RayInterval interval{static_cast<float>(part.from - t0),
                                               static_cast<float>(part.to - t0)};
                    if (interval.to > interval.from || t0 == t1)
                        strip.all.push_back(interval);
                }
            }
            strip.counts.push_back(static_cast<std::uint32_t>(strip.all.size() - before));
        }
    });
    CutRays out;
    out.first.reserve(rays + 1);
    for (const Strip& strip : strips) {
        std::size_t at = out.all.size();
        for (const std::uint32_t count : strip.counts) {
            out.first.push_back(at);
            at += count;
            out.most = std::max<std::size_t>(out.most, count);
        }
        out.all.insert(out.all.end(), strip.all.begin(), strip.all.end());
    }
    out.first.push_back(out.all.size());
    return out;
}

} // namespace tessera
