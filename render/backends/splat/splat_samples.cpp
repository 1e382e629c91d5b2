// render/backends/splat/splat_samples.cpp: see splat_samples.h.
#include "render/backends/splat/splat_samples.h"

#include "core/base/brick.h"
#include "render/contract/integrators.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace tessera {

/// A brick's samples with one more on every side, stored units.
struct SampleLister::Values {
    glm::ivec3 first{0}, count{0}; // of its level's samples, those inside of the volume
    int level = 0;
    std::vector<float> values;

    explicit Values(int ofLevel) : level(ofLevel), row_((kBrickExtent >> ofLevel) + 2) {
        values.resize(static_cast<std::size_t>(row_ * row_ * row_));
    }
    /// @param i  from (-1,-1,-1) on
    float& at(const glm::ivec3& i) {
        return values[static_cast<std::size_t>(((i.z + 1) * row_ + i.y + 1) * row_ + i.x + 1)];
    }
    float at(const glm::ivec3& i) const { return const_cast<Values*>(this)->at(i); }

  private:
    int row_;
};

std::vector<std::pair<SliceOrder, double>> SliceOrder::of(const SplatView& view, const VolumeInfo& info,
                                                          double fade) {
    // The normals of slices are the rows of voxel-from-patient; the middle of the volume is looked at.
    const glm::dmat3 normals = glm::transpose(glm::inverse(glm::dmat3(info.patientFromVoxel)));
    std::vector<std::pair<SliceOrder, double>> orders;
    for (int axis = 0; axis < 3; ++axis) {
        const double along = glm::dot(glm::normalize(normals[axis]), view.forward);
        orders.push_back({{axis, along < 0}, glm::degrees(std::acos(std::min(std::abs(along), 1.0)))});
    }
    std::stable_sort(orders.begin(), orders.end(),
                     [](const auto& a, const auto& b) { return a.second < b.second; });
    if (!(fade > 0))
        orders.resize(1);
    const double best = orders.front().second;
    double sum = 0;
    for (auto& [order, share] : orders) {
        share = share > best ? std::max(0.0, 1 - (share - best) / fade) : 1;
        sum += share;
    }
    for (auto& [order, share] : orders)
        share /= sum;
    std::erase_if(orders, [](const auto& one) { return !(one.second > 0); });
    return orders;
}

SampleLister::SampleLister(const FramePlan& plan, const SplatView& view, const SliceOrder& order)
    : plan_(plan), view_(view), order_(order),
      voxelMm3_(std::abs(glm::determinant(glm::dmat3(plan.info().patientFromVoxel)))),
      parallel_(glm::normalize(glm::inverse(view.axes)[2])),
      brightest_(static_cast<float>(
          tessera::brightest(plan.view.shading, plan.view.lighting, plan.layer().function.materials()))),
      gradients_(plan.layer().optics.takesGradients()) {}

SampleLister::Values SampleLister::read(const glm::ivec3& brick, int level) const {
    const Layer& layer = plan_.layer();
    const VolumeInfo& info = plan_.info();
    const int edge = kBrickExtent >> level;
    Values v(level);
    v.first = brick * edge;
    v.count = glm::min(glm::ivec3(edge), levelExtent(info.extentVoxels, level) - v.first);
    if (level == kLevelCount - 1) {
        v.at(glm::ivec3(0)) = layer.selection.means[linearIndex(brick, layer.selection.bricks)];
        return v;
    }
    const glm::ivec3 chunk = v.first >> 5;
    const ChunkPointer data = layer.cache->get({level, chunk.x, chunk.y, chunk.z});
    const std::size_t bytes = bytesPerValue(info.type);
    withValueType(info.type, [&](auto typed) {
        for (int z = 0; z < v.count.z; ++z)
            for (int y = 0; y < v.count.y; ++y) {
                const glm::ivec3 start = (v.first & (kChunkExtent - 1)) + glm::ivec3(0, y, z);
                const std::byte* from =
                    data->bytes.get() + linearIndex(start, glm::ivec3(kChunkExtent)) * bytes;
                float* to = &v.at({0, y, z});
                for (int x = 0; x < v.count.x; ++x, from += bytes) {
                    std::memcpy(&typed, from, sizeof typed);
                    to[x] = static_cast<float>(typed);
                }
            }
    });
    return v;
}

/// The samples beyond a brick's faces, as the field has them there.
void SampleLister::readFaces(const glm::ivec3& brick, Values& v) const {
    const Layer& layer = plan_.layer();
    const Selection& selection = layer.selection;
    const glm::ivec3 last = levelExtent(plan_.info().extentVoxels, v.level) - 1;
    MixedReader reader(*layer.cache, plan_.info(), selection, layer.levels);
    const auto valueAt = [&](const glm::ivec3& i) {
        const glm::ivec3 held = glm::clamp(v.first + i, glm::ivec3(0), last), of = held >> (5 - v.level);
        if (of == brick)
            return v.at(held - v.first);
        const std::size_t other = linearIndex(of, selection.bricks);
        if (selection.levels[other] == Selection::kEmpty)
            return selection.means[other];
        if (selection.levels[other] == v.level)
            return v.level == kLevelCount - 1 ? selection.means[other]
                                              : static_cast<float>(reader.at(v.level, held));
        return interblockValue<float>(reader, (glm::vec3(held) + 0.5f) * static_cast<float>(1 << v.level));
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, v.count[axis]}) {
            glm::ivec3 i;
            i[axis] = side;
            const int a = (axis + 1) % 3, b = (axis + 2) % 3;
            for (i[b] = 0; i[b] < v.count[b]; ++i[b])
                for (i[a] = 0; i[a] < v.count[a]; ++i[a])
                    v.at(i) = valueAt(i);
        }
}

/// False where the sample shows nothing.
bool SampleLister::classify(const Values& v, const glm::ivec3& at, ShownSample& sample) const {
    const Optics& optics = plan_.layer().optics;
    const float value = v.at(at);
    const glm::vec4 entry = lookUp<float>(optics, value);
    float extinction = entry.a;
    if (!(extinction > 0))
        return false;
    const auto pitch = static_cast<float>(1 << v.level);
    const glm::dvec3 low = glm::dvec3(v.first + at) * double{pitch};
    const glm::dvec3 place = low + 0.5 * double{pitch};
    if (plan_.view.part.any() && !plan_.view.part.keeps(place, 0))
        return false;
    glm::vec3 gradient(0);
    if (gradients_)
        for (int axis = 0; axis < 3; ++axis) {
            glm::ivec3 step(0);
            step[axis] = 1;
            gradient[axis] = (v.at(at + step) - v.at(at - step)) / (2 * pitch);
        }
    if (optics.grades())
        extinction *= gradientFactor(optics, gradient);
    const glm::dvec3 inside = glm::min(low + double{pitch}, glm::dvec3(plan_.info().extentVoxels)) - low;
    sample.mass = extinction * static_cast<float>(voxelMm3_ * inside.x * inside.y * inside.z);
    if (!(sample.mass > 0))
        return false;
    glm::vec3 colour(entry);
    if (view_.perspective && place == view_.eye)
        return false; // it would be too near
    if (optics.shading) {
        const glm::vec3 direction =
            view_.perspective ? glm::vec3(glm::normalize(place - view_.eye)) : parallel_;
        colour = optics.hasLights ? shade(optics, colour, gradient, direction, glm::vec3(place),
                                          materialAt(optics, placeOf(optics, value)))
                                  : shade(optics, colour, gradient, direction);
    }
    // A light that is very near makes the brightest colour far brighter than most: each has a unit of its
    // own.
    constexpr float kMost = 65535;
    constexpr int kMostHalvings = 63;
    const glm::vec3 of = glm::clamp(colour / brightest_, 0.0f, 1.0f);
    const float most = std::max({of.x, of.y, of.z});
    int exponent = 0;
    std::frexp(most, &exponent);
    const int halvings = most > 0 ? std::clamp(-exponent, 0, kMostHalvings) : 0;
    const glm::vec3 stored = glm::min(of * std::ldexp(kMost, halvings), kMost) + 0.5f;
    sample.halvings = static_cast<std::uint16_t>(halvings) & kMostHalvings;
    sample.red = static_cast<std::uint16_t>(stored.r);
    sample.green = static_cast<std::uint16_t>(stored.g);
    sample.blue = static_cast<std::uint16_t>(stored.b);
    return true;
}

BrickList SampleLister::list(const glm::ivec3& brick, int firstSlice, int slices) const {
    const Selection& selection = plan_.layer().selection;
    BrickList list;
    list.brick = brick;
    list.level = selection.levels[linearIndex(brick, selection.bricks)];
    list.firstSlice = firstSlice;
    Values v = read(brick, list.level);
    if (gradients_)
        readFaces(brick, v);
    const auto [across, along] = order_.others();
    list.samples.reserve(static_cast<std::size_t>(v.count[across] * v.count[along] * slices));
    for (int slice = firstSlice; slice < firstSlice + slices; ++slice) {
        if (slice < v.count[order_.axis])
            for (int b = 0; b < v.count[along]; ++b)
                for (int a = 0; a < v.count[across]; ++a) {
                    const int place = a | b << 5;
                    ShownSample sample;
                    sample.place = static_cast<std::uint16_t>(place) & 1023;
                    if (classify(v, order_.sample(slice, place), sample))
                        list.samples.push_back(sample);
                }
        list.ends[static_cast<std::size_t>(slice - firstSlice)] =
            static_cast<std::uint16_t>(list.samples.size());
    }
    return list;
}

} // namespace tessera
