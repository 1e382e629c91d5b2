// render/backends/native/native_volumes.cpp: see native_volumes.h.
#include "render/backends/native/native_volumes.h"

#include "core/base/interrupt.h"
#include "render/backends/native/native_scene.h"
#include "render/contract/integrators.h"
#include "render/plan/fusion.h"

#include <utility>

namespace tessera {
namespace {

/// A place of rays' lattice in a volume's voxels.
glm::vec3 placeIn(const native::PacketFusion& fusion, int volume, const SegmentedRay<float>& ray, float at) {
    const float(&m)[9] = fusion.linear[volume];
    const glm::mat3 linear(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
    const float(&o)[3] = fusion.offset[volume];
    const glm::vec3 entry = leaf::transformed(linear, ray.entry) + glm::vec3(o[0], o[1], o[2]);
    return leaf::placeAlong(entry, leaf::transformed(linear, ray.step), at);
}
bool isIn(const native::PacketField& field, const glm::vec3& p) {
    bool in = true;
    for (int axis = 0; axis < 3; ++axis)
        in = in && 0 <= p[axis] && p[axis] < static_cast<float>(field.extentVoxels[axis]);
    return in;
}

/// Reads all that a sample needs beside values.
void readBeside(NativeField& field, const Optics& optics, const glm::vec3& middle) {
    if (optics.takesGradients())
        field.gradient(middle);
    if (optics.shading && optics.smooths())
        field.gradient(middle, optics.normals);
    if (optics.labels.count > 0)
        field.labels(middle);
    if (optics.shading && optics.labels.solid >= 0)
        field.mediumGradient(middle);
}

} // namespace

const FramePlan& planOfVolume(const FramePlan& plan, std::size_t number) {
    return number == 0 ? plan : plan.further[number - 1].plan;
}

NativeEngine& engineOfVolume(NativeEngine& engine, std::size_t number) {
    return number == 0 ? engine : *engine.further(number - 1);
}

native::PacketHelp NativeVolumes::helpOf(const Context& context) {
    native::PacketHelp help;
    help.context = &context;
    help.gradient = [](const void* c, const float* p, float* g, bool* missing) {
        NativeField& field = static_cast<const Context*>(c)->field;
        const glm::vec3 gradient = field.gradient({p[0], p[1], p[2]});
        g[0] = gradient.x, g[1] = gradient.y, g[2] = gradient.z;
        *missing = field.takeMissing();
    };
    help.expired = [](const void* c) {
        checkInterrupted();
        const auto& context = *static_cast<const Context*>(c);
        if (context.late.load(std::memory_order_relaxed))
            return true;
        if (context.deadline == Clock::time_point::max() || Clock::now() < context.deadline)
            return false;
        context.late.store(true, std::memory_order_relaxed);
        return true;
    };
    return help;
}

NativeVolumes::NativeVolumes(const FramePlan& plan, NativeEngine& engine, const Strides& strides,
                             std::vector<native::PacketScene> scenes, Clock::time_point deadline,
                             std::atomic<bool>& late)
    : plan_(plan), strides_(strides), scenes_(std::move(scenes)) {
    fields_.reserve(scenes_.size());
    contexts_.reserve(scenes_.size());
    for (std::size_t n = 0; n < scenes_.size(); ++n) {
        const Layer& volume = planOfVolume(plan, n).layer();
        const NativeEngine& own = engineOfVolume(engine, n);
        NativeField& field = fields_.emplace_back(own.plane(), volume.mixed() ? &volume.levels : nullptr,
                                                  volume.selection.finest(), volume.optics.gradient);
        field.setLight(own.lightChannels());
        field.setLabels(own.labelChannels(), volume.optics.labels);
        contexts_.push_back({field, deadline, late});
        scenes_[n].help = helpOf(contexts_.back());
    }
    if (plan.fused) {
        fusion_ = packetFusionOf(plan, strides);
        for (std::size_t n = 0; n < scenes_.size(); ++n)
            fusion_.volumes[n] = &scenes_[n];
        scenes_.front().fusion = &fusion_;
    }
}

bool NativeVolumes::expired() const {
    return scenes_.front().help.expired(&contexts_.front());
}

void NativeVolumes::name(std::vector<WantedBricks>* wanted, std::uint32_t ray) {
    for (std::size_t n = 0; n < fields_.size(); ++n) {
        fields_[n].name(wanted ? &(*wanted)[n] : nullptr, ray);
        if (!wanted)
            fields_[n].takeMissing();
    }
}

void NativeVolumes::readSample(const SegmentedRay<float>& ray, int i) {
    const Optics& optics = plan_.layer().optics;
    NativeField& first = fields_.front();
    const int n = strideAt(strides_, ray, i);
    const float length = strideLength(ray, i, n);
    if (plan_.fused) {
        const float at = leaf::strideMiddle(static_cast<float>(i), length);
        for (std::size_t v = 0; v < fields_.size(); ++v) {
            const glm::vec3 p = placeIn(fusion_, static_cast<int>(v), ray, at);
            if (!isIn(scenes_[v].field, p))
                continue;
            fields_[v].value(p);
            readBeside(fields_[v], planOfVolume(plan_, v).layer().optics, p);
        }
        return;
    }
    const glm::vec3 middle = stridePosition(ray, i, length);
    if (needsEnds(optics.integrator)) {
        first.value(segmentStart(ray, i));
        first.value(strideEnd(ray, i, length));
    } else {
        first.value(middle);
    }
    readBeside(first, optics, middle);
}

} // namespace tessera
