// render/light/occlusion.cpp: see occlusion.h.
#include "render/light/occlusion.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace tessera {
namespace {

int roundedUp(int n, int to) {
    return (n + to - 1) / to * to;
}

/// Layers of a chunk's samples, and what a step reads beside the last.
std::size_t ownSamples(const glm::ivec3& size) {
    return cellCount({size.x, size.y, kChunkExtent + 2});
}

} // namespace

OcclusionRoom::OcclusionRoom(const glm::ivec3& reach, bool emits, bool surfaces, bool meshes)
    : reach(glm::max(reach, glm::ivec3(OcclusionRoom::kAround))), size(kChunkExtent + 2 * this->reach) {
    size.x = roundedUp(size.x + 1, OcclusionRoom::kRun); // a step reads a sample further
    const std::size_t samples = cellCount(size + glm::ivec3(0, 1, 1));
    extinction.resize(samples);
    const std::size_t own = meshes ? ownSamples(size) : 0;
    opacity.resize(samples + own);
    ofMeshes.resize(meshes ? samples : 0);
    rowShows.resize(samples / static_cast<std::size_t>(size.x));
    rowIsSet.resize(rowShows.size());
    constexpr int kEdge = kChunkExtent + 2 * OcclusionRoom::kAround;
    low.resize(static_cast<std::size_t>(kEdge * kEdge * OcclusionRoom::kRunsPerRow));
    high.resize(low.size());
    light.resize(cellCount(glm::ivec3(kChunkExtent)));
    for (std::size_t c = 0; c < 3 && emits; ++c) {
        emission[c].resize(samples + own);
        shine[c].resize(light.size());
    }
    if (surfaces)
        for (std::vector<float>* of : {&normal[0], &normal[1], &normal[2], &rest, &weights})
            of->resize(light.size());
}

std::size_t OcclusionRoom::bytes(const glm::ivec3& reach, bool emits, bool surfaces, bool meshes) {
    glm::ivec3 size = kChunkExtent + 2 * glm::max(reach, glm::ivec3(OcclusionRoom::kAround));
    size.x = roundedUp(size.x + 1, OcclusionRoom::kRun);
    constexpr int kEdge = kChunkExtent + 2 * OcclusionRoom::kAround;
    const std::size_t colours = emits ? 3 : 0;
    return sizeof(float) * ((2 + colours + (meshes ? 1 : 0)) * cellCount(size + glm::ivec3(0, 1, 1)) +
                            (1 + colours + (surfaces ? 5 : 0)) * cellCount(glm::ivec3(kChunkExtent)) +
                            std::size_t{2} * kEdge * kEdge * OcclusionRoom::kRunsPerRow +
                            (meshes ? (1 + colours) * ownSamples(size) : 0));
}

Occluder::Occluder(const VolumeInfo& info, const Statistics& statistics,
                   const std::optional<Occlusion>& occlusion, const native::PacketTarget* target)
    : info_(info), statistics_(statistics), target_(target ? *target : native::packetTarget()),
      finest_(occlusion ? occlusionLevel(*occlusion, info) : 0),
      strength_(occlusion ? occlusion->emission : 0),
      surfaces_(occlusion && occlusion->directions == OcclusionDirections::hemisphere) {
    if (occlusion && occlusion->method != OcclusionMethod::local)
        sum_ = occlusion->method == OcclusionMethod::positional ? native::OcclusionSum::positional
                                                                : native::OcclusionSum::rejecting;
    for (int level = finest_; occlusion && level < kLevelCount; ++level)
        rays_[static_cast<std::size_t>(level)] = occlusionRays(*occlusion, info, level);
}

void Occluder::setFunction(const TransferTable& table, const Optics& optics) {
    table_ = &table;
    optics_ = &optics;
    extinctions_->clear();
    if (withOthers_)
        withOthers_->clear();
    extinctionOf_.clear();
    emissionOf_.clear();
    const auto fill = [&](int lowest, int highest) {
        for (int stored = lowest; stored <= highest; ++stored) {
            extinctionOf_.push_back(occlusionExtinction(optics, static_cast<float>(stored)));
            if (gathersEmission())
                emissionOf_.push_back(sentBy(static_cast<float>(stored)));
        }
    };
    if (info_.type == ValueType::u8)
        fill(0, 255);
    else if (info_.type == ValueType::i16)
        fill(-32768, 32767);
    else if (info_.type == ValueType::u16)
        fill(0, 65535);
}

/// Light that tissue of a value sends, or its share of the light that it scatters.
glm::vec3 Occluder::sentBy(float stored) const {
    return static_cast<float>(strength_) *
           (scattered_ ? occlusionAlbedo(*optics_, stored) : occlusionEmission(*optics_, stored));
}

glm::ivec3 Occluder::mostReach() const {
    glm::ivec3 most(0);
    for (const OcclusionRays& rays : rays_)
        most = glm::max(most, rays.reach);
    return most;
}

void Occluder::occlude(const ChunkKey& chunk, const OcclusionRoom& found, BrickCache& cache,
                       OcclusionRoom& room) const {
    room.runs = found.runs;
    for (OcclusionRoom::Run& run : room.runs)
        run.from = linearIndex(run.at + room.reach, room.size);
    read(chunk, true, cache, room);
    occlude(chunk, room);
}

/// Of the runs' samples, from differences of the extinctions beside them.
void Occluder::findNormals(OcclusionRoom& room) const {
    const glm::mat3 toPatient(glm::transpose(glm::inverse(glm::dmat3(info_.patientFromVoxel))));
    const std::size_t pitch[3] = {1, static_cast<std::size_t>(room.size.x),
                                  static_cast<std::size_t>(room.size.x * room.size.y)};
    for (const OcclusionRoom::Run& run : room.runs)
        for (std::size_t n = 0; n < OcclusionRoom::kRun; ++n) {
            const float* const at = room.extinction.data() + run.from + n;
            glm::vec3 rise(0);
            float sum = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const float before = *(at - pitch[axis]), behind = *(at + pitch[axis]);
                rise[axis] = 0.5f * (behind - before);
                sum += before + behind;
            }
            const SurfaceAround surface = surfaceAround(rise, sum / 6, toPatient);
            for (int axis = 0; axis < 3; ++axis)
                room.normal[static_cast<std::size_t>(axis)][run.to + n] =
                    4 * surface.share * surface.normal[axis];
            room.rest[run.to + n] = 1 - surface.share;
            room.weights[run.to + n] = 0;
        }
}

namespace {

/// Extinctions of a row of samples, with those of meshes: in the place of its opacities.
const float* withMeshes(OcclusionRoom& room, std::size_t row) {
    const float* const extinction = room.extinction.data() + row;
    if (room.ofMeshes.empty())
        return extinction;
    float* const all = room.opacity.data() + row;
    std::transform(extinction, extinction + room.size.x, room.ofMeshes.data() + row, all, std::plus<>());
    return all;
}

/// Of the chunk's samples, where rays begin: without meshes, behind those of all samples.
void setOwnOpacities(OcclusionRoom& room, const native::PacketTarget& target, float stepMm) {
    for (int z = room.reach.z; z < room.reach.z + kChunkExtent; ++z)
        for (int y = room.reach.y; y < room.reach.y + kChunkExtent; ++y) {
            const std::size_t row = linearIndex({0, y, z}, room.size);
            target.opacities(room.extinction.data() + row, room.size.x, stepMm,
                             room.opacity.data() + row + room.toOwn());
        }
}

} // namespace

void Occluder::occlude(const ChunkKey& chunk, OcclusionRoom& room) const {
    const OcclusionRays& rays = rays_[static_cast<std::size_t>(chunk.level)];
    TESSERA_CHECK(!rays.rays.empty() && glm::all(glm::lessThanEqual(rays.reach, room.reach)));
    std::fill(room.light.begin(), room.light.end(), 1.0f);
    for (const OcclusionRoom::Run& run : room.runs)
        std::fill_n(room.light.begin() + static_cast<std::ptrdiff_t>(run.to), OcclusionRoom::kRun, 0.0f);
    for (std::vector<float>& got : room.shine)
        std::fill(got.begin(), got.end(), 0.0f);
    if (room.runs.empty())
        return;
    if (surfaces_)
        findNormals(room);

    const auto shareOf = [&](const OcclusionRay& ray) {
        return ray.part * (sum_ == native::OcclusionSum::local ? 0.5 / ray.steps : 1.0);
    };
    // Rays of one length of step read the same opacities.
    const std::int32_t pitch[3] = {1, room.size.x, room.size.x * room.size.y};
    std::vector<native::OcclusionStep> steps;
    std::vector<native::OcclusionPath> paths;
    for (std::size_t first = 0; first < rays.rays.size();) {
        std::size_t end = first;
        while (end < rays.rays.size() && rays.rays[end].stepMm <= rays.rays[first].stepMm * (1 + 1e-9))
            ++end;
        steps.clear();
        paths.clear();
        for (std::size_t r = first; r < end; ++r)
            for (int n = 0; n <= rays.rays[r].steps; ++n) {
                const OcclusionRay& ray = rays.rays[r];
                const glm::dvec3 at = ray.step * double(ray.skipped + n);
                const int a = (ray.axis + 1) % 3, b = (ray.axis + 2) % 3;
                glm::ivec3 whole(glm::floor(at));
                whole[ray.axis] = static_cast<int>(std::lround(at[ray.axis]));
                const auto fa = static_cast<float>(at[a] - whole[a]),
                           fb = static_cast<float>(at[b] - whole[b]);
                const std::int32_t own = ray.skipped + n == 0 && !room.ofMeshes.empty()
                                             ? static_cast<std::int32_t>(room.toOwn())
                                             : 0;
                steps.push_back({own + whole.x * pitch[0] + whole.y * pitch[1] + whole.z * pitch[2],
                                 {(1 - fa) * (1 - fb), fa * (1 - fb), (1 - fa) * fb, fa * fb}});
            }
        const native::OcclusionStep* next = steps.data();
        for (std::size_t r = first; r < end; ++r) {
            const OcclusionRay& ray = rays.rays[r];
            const glm::vec3 to(ray.direction);
            paths.push_back({next,
                             ray.steps + 1,
                             pitch[(ray.axis + 1) % 3],
                             pitch[(ray.axis + 2) % 3],
                             static_cast<float>(shareOf(ray)),
                             static_cast<float>(ray.part),
                             {to.x, to.y, to.z}});
            next += ray.steps + 1;
        }
        const auto stepMm = static_cast<float>(rays.rays[first].stepMm);
        for (std::size_t row = 0; row < room.rowShows.size(); ++row) {
            const std::size_t at = row * static_cast<std::size_t>(room.size.x);
            if (room.rowShows[row] != 0)
                target_.opacities(withMeshes(room, at), room.size.x, stepMm, room.opacity.data() + at);
            else if (room.rowIsSet[row] != 0)
                std::fill_n(room.opacity.begin() + static_cast<std::ptrdiff_t>(at), room.size.x, 0.0f);
            room.rowIsSet[row] = room.rowShows[row];
        }
        if (!room.ofMeshes.empty())
            setOwnOpacities(room, target_, stepMm);
        const auto count = static_cast<int>(paths.size());
        for (const OcclusionRoom::Run& run : room.runs) {
            const float* const opacity = room.opacity.data() + run.from;
            float* const light = room.light.data() + run.to;
            if (!gathersEmission()) {
                const native::OcclusionNormals normals =
                    surfaces_ ? native::OcclusionNormals{{room.normal[0].data() + run.to,
                                                          room.normal[1].data() + run.to,
                                                          room.normal[2].data() + run.to},
                                                         room.rest.data() + run.to,
                                                         room.weights.data() + run.to}
                              : native::OcclusionNormals{};
                target_.occlude(opacity, paths.data(), count, sum_, surfaces_ ? &normals : nullptr, light);
                continue;
            }
            const float* const sent[3] = {room.emission[0].data() + run.from,
                                          room.emission[1].data() + run.from,
                                          room.emission[2].data() + run.from};
            float* const got[3] = {room.shine[0].data() + run.to, room.shine[1].data() + run.to,
                                   room.shine[2].data() + run.to};
            target_.occludeAndShine(opacity, sent, paths.data(), count, light, got);
        }
        first = end;
    }
    for (const OcclusionRoom::Run& run : room.runs)
        for (std::size_t n = run.to; surfaces_ && n < run.to + OcclusionRoom::kRun; ++n)
            room.light[n] = room.weights[n] > 0 ? room.light[n] / room.weights[n] : 1;
}

} // namespace tessera
