// render/light/light_plane.cpp: see light_plane.h.
#include "render/light/light_plane.h"

#include "core/base/error.h"
#include "core/base/progress.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <mutex>
#include <set>
#include <tuple>
#include <utility>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kEntryValue = 0x80000000u, kEntryAbsent = 0x40000000u; // brick_residency.h
constexpr std::size_t kBricksAtATime = 8; // between two checks of the clock
constexpr float kUnseen = 1e-3f;          // of a brick's light: low priority

} // namespace

LightPlane::LightPlane(SceneLight& light, const FramePlan& scene, std::vector<Plane*> channels, bool together)
    : light_(light), scene_(scene), channels_(std::move(channels)), together_(together),
      entries_(cellCount(brickGrid(scene.info().extentVoxels)), BrickEntry(kEntryAbsent, 0)),
      slots_(entries_.size()) {
    lit_.fill(Levels(entries_.size(), kNone));
}

void LightPlane::put(const AtlasSlot& slot, const BrickSamples& samples, Work&) {
    slots_[samples.brick] = slot;
    for (Levels& lit : lit_)
        lit[samples.brick] = kNone;
    lookAgain();
}

void LightPlane::publish(std::span<const BrickEntry> entries) {
    std::copy(entries.begin(), entries.end(), entries_.begin());
    published_ = true;
    lookAgain();
}

/// The queue of refinement must be computed again.
void LightPlane::lookAgain() {
    queueLevel_ = -1;
    ambientDone_ = SceneLight::kCoarseLevel;
    expectedFinest_ = -1;
}

bool LightPlane::isHere(std::size_t brick) const {
    return (entries_[brick].x & (kEntryValue | kEntryAbsent)) == 0;
}

int LightPlane::wholeLevel(std::size_t brick) const {
    return std::max(slots_[brick]->level, light_.voxels().finestLevel());
}

/// Parts of a brick's light that are coarser than a level, or outdated.
LightParts LightPlane::lacking(std::size_t brick, int finest) const {
    LightParts parts = 0;
    for (std::size_t part = 0; part < kLightParts; ++part)
        if (light_.voxels().channelsOf(part) > 0 && lit_[part][brick] > std::max(wholeLevel(brick), finest))
            parts |= 1u << part;
    return parts;
}

/// Of some brick.
bool LightPlane::lacksAnything(LightParts parts) const {
    for (std::size_t b = 0; b < entries_.size(); ++b)
        for (std::size_t part = 0; part < kLightParts; ++part)
            if ((parts >> part & 1u) != 0 && lit_[part][b] == kNone && isHere(b))
                return true;
    return false;
}

void LightPlane::forget(LightParts parts, std::uint8_t as) {
    if (parts == 0)
        return;
    standingIsOld_ |= parts;
    if (together_)
        parts = kAllLight;
    for (std::size_t part = 0; part < kLightParts; ++part)
        if ((parts >> part & 1u) != 0)
            for (std::uint8_t& level : lit_[part])
                level = std::max(level, as);
    lookAgain();
}

void LightPlane::lightingChanged() {
    forget(light_.lightingChanged(), kNone);
}

/// @param parts  of all of these
void LightPlane::lightBricks(std::vector<BrickToLight> bricks, int finest, LightParts parts, Work& work) {
    if (together_)
        parts = kAllLight;
    for (const BrickToLight& b : bricks)
        for (std::size_t part = 0; part < kLightParts; ++part)
            if ((parts >> part & 1u) != 0)
                lit_[part][b.brick] = static_cast<std::uint8_t>(b.lightLevel);
    if (expectedFinest_ != finest) {
        expectedFinest_ = finest;
        expected_.assign(entries_.size(), kNone);
        for (std::size_t b = 0; b < entries_.size(); ++b)
            if (isHere(b))
                expected_[b] = static_cast<std::uint8_t>(std::max(wholeLevel(b), finest));
    }
    const bool manyAtOnce = std::all_of(channels_.begin(), channels_.end(),
                                        [](const Plane* channel) { return channel->takesManyAtOnce(); });
    std::mutex mutex;
    light_.voxels().light(
        std::move(bricks), expected_, parts, *scene_.layer().cache,
        [&](const BrickToLight& b, int channel, const Chunk& samples, int edge) {
            Work mine;
            channels_[static_cast<std::size_t>(channel)]->put(*slots_[b.brick],
                                                              {samples, glm::ivec3(0), edge, b.brick}, mine);
            const std::lock_guard lock(mutex);
            work.bytesUploaded += mine.bytesUploaded;
        },
        manyAtOnce);
    published_ = true;
}

/// Parts that have whole light at once. Where channels come together, all have or none.
LightParts LightPlane::quickParts() const {
    const VoxelLight& voxels = light_.voxels();
    const LightParts quick = voxels.quickParts(), all = (voxels.channelsOf(0) > 0 ? kAmbientLight : 0) |
                                                        (voxels.channelsOf(1) > 0 ? kShadowLight : 0);
    return together_ && quick != all ? 0 : quick;
}

/// Computes parts of the light of all bricks that lack them, by samples of a level or coarser.
void LightPlane::lightAll(int finest, LightParts considered, Work& work) {
    std::array<std::vector<BrickToLight>, kAllLight + 1> bricks; // by the parts that they lack
    for (std::size_t b = 0; b < entries_.size(); ++b) {
        if (!isHere(b))
            continue;
        LightParts lacks = 0;
        for (std::size_t part = 0; part < kLightParts; ++part)
            if ((considered >> part & 1u) != 0 && light_.voxels().channelsOf(part) > 0 &&
                lit_[part][b] == kNone)
                lacks |= 1u << part;
        bricks[lacks].push_back({b, slots_[b]->level, std::max(wholeLevel(b), finest)});
    }
    for (LightParts parts = 1; parts <= kAllLight; ++parts)
        if (!bricks[parts].empty())
            lightBricks(std::move(bricks[parts]), finest, parts, work);
}

/// Light of bricks drawn as one value.
void LightPlane::lightStanding() {
    VoxelLight& voxels = light_.voxels();
    for (std::size_t part = 0; part < kLightParts; ++part) {
        const auto channels = static_cast<std::size_t>(voxels.channelsOf(part));
        if ((standingIsOld_ >> part & 1u) == 0 || channels == 0)
            continue;
        standing_[part].resize(entries_.size() * channels);
        for (std::size_t b = 0; b < entries_.size(); ++b)
            for (std::size_t n = 0; n < channels; ++n)
                standing_[part][b * channels + n] =
                    voxels.standing(b, part, static_cast<int>(n), *scene_.layer().cache);
        published_ = true;
    }
    standingIsOld_ = 0;
}

void LightPlane::publishAll() {
    if (!std::exchange(published_, false))
        return;
    const VoxelLight& voxels = light_.voxels();
    std::vector<BrickEntry> entries = entries_;
    for (std::size_t part = 0; part < kLightParts; ++part) {
        const auto channels = static_cast<std::size_t>(voxels.channelsOf(part));
        for (std::size_t n = 0; n < channels; ++n) {
            for (std::size_t b = 0; b < entries.size(); ++b)
                if ((entries_[b].x & kEntryValue) != 0)
                    entries[b].y =
                        std::bit_cast<std::uint32_t>(static_cast<float>(standing_[part][b * channels + n]));
            Plane& channel = *channels_[static_cast<std::size_t>(voxels.firstChannelOf(part)) + n];
            channel.finish();
            channel.publish(entries);
        }
    }
}

void LightPlane::makeMaps() {
    const auto start = Clock::now();
    forget(light_.takeChanges(), kNone);
    if (light_.makeMaps())
        forget(light_.voxels().partsByMaps(), kNone);
    light_.took(secondsSince(start));
}

void LightPlane::shadedBy(std::span<SceneLight* const> others) {
    forget(light_.shadedBy(others), kNone);
}

void LightPlane::settle(Work& work) {
    const auto start = Clock::now();
    forget(light_.takeChanges(), kNone);
    if (!coarseFirst_) {
        if (light_.makeMaps())
            forget(light_.voxels().partsByMaps(), kNone);
        lightAll(0, kAllLight, work);
    } else {
        const LightParts byMaps = light_.voxels().partsByMaps();
        if (light_.viewIsNew() && !hasty_)
            forget(byMaps, kNone);
        // Continues maps in progress, if the existing ones are not needed.
        if ((standingIsOld_ & byMaps) != 0 || lacksAnything(byMaps))
            light_.makeCoarseMaps(!hasty_);
        const LightParts quick = quickParts();
        if (quick != 0)
            lightAll(0, quick, work);
        lightAll(SceneLight::kCoarseLevel, kAllLight & ~quick, work);
    }
    lightStanding();
    publishAll();
    light_.took(secondsSince(start));
}

bool LightPlane::isWhole() const {
    if (!light_.mapsAreWhole() || standingIsOld_ != 0)
        return false;
    for (std::size_t b = 0; b < entries_.size(); ++b)
        if (isHere(b) && lacking(b, 0) != 0)
            return false;
    return true;
}

/// First those that are computed together with visible ones.
void LightPlane::sortQueue(std::span<const float> seen) {
    using Place = std::pair<int, std::uint64_t>;
    const glm::ivec3 grid = brickGrid(scene_.info().extentVoxels);
    std::set<Place> seenPlaces;
    for (const BrickToLight& b : queue_)
        if (seen.empty() || seen[b.brick] >= kUnseen)
            seenPlaces.insert(VoxelLight::placeInOrder(b, grid));
    std::vector<std::pair<std::tuple<bool, Place, std::size_t>, BrickToLight>> ordered;
    for (const BrickToLight& b : queue_) {
        const Place place = VoxelLight::placeInOrder(b, grid);
        ordered.push_back({{!seenPlaces.contains(place), place, b.brick}, b});
    }
    std::sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return b.first < a.first; });
    std::transform(ordered.begin(), ordered.end(), queue_.begin(), [](const auto& o) { return o.second; });
}

/// Bricks that lack exactly these parts, of the examined ones.
bool LightPlane::refineTo(int finest, LightParts considered, LightParts parts, std::span<const float> seen,
                          SceneLight::Deadline deadline, Work& work) {
    if (queueLevel_ != finest || queueParts_ != parts) {
        queue_.clear();
        for (std::size_t b = 0; b < entries_.size(); ++b)
            if (isHere(b) && (lacking(b, finest) & considered) == parts)
                queue_.push_back({b, slots_[b]->level, std::max(wholeLevel(b), finest)});
        sortQueue(seen);
        queueLevel_ = finest;
        queueParts_ = parts;
    }
    while (!queue_.empty()) {
        const std::size_t count = std::min(kBricksAtATime, queue_.size());
        const auto from = queue_.end() - static_cast<std::ptrdiff_t>(count);
        std::vector<BrickToLight> bricks(from, queue_.end());
        queue_.erase(from, queue_.end());
        lightBricks(std::move(bricks), finest, parts, work);
        if (Clock::now() >= deadline)
            return false;
    }
    queueLevel_ = -1;
    return true;
}

/// Occlusion to all but the finest samples, then shadow maps, then all of it.
void LightPlane::refineAll(std::span<const float> seen, SceneLight::Deadline deadline, Work& work) {
    const int finest = light_.voxels().finestLevel();
    const bool ambientFirst = (light_.voxels().partsByMaps() & kAmbientLight) == 0;
    for (; ambientFirst && ambientDone_ > finest + 1; --ambientDone_)
        if (!refineTo(ambientDone_ - 1, kAmbientLight, kAmbientLight, seen, deadline, work))
            return;
    if (!light_.mapsAreWhole()) {
        if (!light_.makeMapsUntil(deadline))
            return;
        forget(light_.voxels().partsByMaps(), kOld);
        lightStanding();
    }
    for (LightParts parts = kAllLight; parts > 0; --parts)
        if (!refineTo(finest, kAllLight, parts, seen, deadline, work))
            return;
}

void LightPlane::refine(std::span<const float> seen, SceneLight::Deadline deadline, Work& work) {
    const auto start = Clock::now();
    refineAll(seen, deadline, work);
    light_.took(secondsSince(start));
}

} // namespace tessera
