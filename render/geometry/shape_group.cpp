// render/geometry/shape_group.cpp: see shape_group.h.
#include "render/geometry/shape_group.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tessera {
namespace {

/// Behind which of its own hits those of a member count.
HitOrder behindOf(const HitOrder& after, std::uint32_t first, std::uint32_t last) {
    constexpr std::uint32_t kLastPart = std::numeric_limits<std::uint32_t>::max();
    if (after.part < first) // those of equal t, too
        return {std::nextafter(after.t, -std::numeric_limits<double>::max()), kLastPart};
    return {after.t, after.part < last ? after.part - first : kLastPart};
}

} // namespace

ShapeGroup::ShapeGroup(std::vector<Member> members) : members_(std::move(members)) {
    TESSERA_CHECK(!members_.empty());
    std::uint64_t parts = 0;
    for (const Member& member : members_) {
        firstPart_.push_back(static_cast<std::uint32_t>(parts));
        parts += member.shape->parts();
        TESSERA_CHECK(parts <= std::numeric_limits<std::uint32_t>::max());
        box_.add(member.shape->box().low);
        box_.add(member.shape->box().high);
    }
    firstPart_.push_back(static_cast<std::uint32_t>(parts));
}

bool ShapeGroup::next(const ShapeRay& ray, const HitOrder& after, double most, const HitFilter& filter,
                      ShapeHit& hit) const {
    bool found = false;
    for (std::size_t n = 0; n < members_.size(); ++n) {
        const HitOrder behind = behindOf(after, firstPart_[n], firstPart_[n + 1]);
        if (!members_[n].shape->next(ray, behind, most, filter, hit))
            continue;
        found = true;
        most = hit.at.t; // of equal ones the first member's
        hit.at.part += firstPart_[n];
        hit.colour = members_[n].colour ? &*members_[n].colour : nullptr;
    }
    return found;
}

void ShapeGroup::forEachBall(const std::function<void(const glm::dvec3&, double)>& visit) const {
    for (const Member& member : members_)
        member.shape->forEachBall(visit);
}

void ShapeGroup::forEachTriangle(std::size_t from, std::size_t to, double within,
                                 const VisitTriangle& visit) const {
    for (std::size_t n = 0; n < members_.size(); ++n) {
        const std::size_t first = std::max<std::size_t>(from, firstPart_[n]),
                          end = std::min<std::size_t>(to, firstPart_[n + 1]);
        if (first < end)
            members_[n].shape->forEachTriangle(first - firstPart_[n], end - firstPart_[n], within, visit);
    }
}

std::size_t ShapeGroup::bytes() const {
    std::size_t bytes = 0;
    for (const Member& member : members_)
        bytes += member.shape->bytes();
    return bytes;
}

} // namespace tessera
