// render/backends/native/native_scene.cpp: see native_scene.h.
#include "render/backends/native/native_scene.h"

#include "core/base/error.h"
#include "render/contract/leaves.h"
#include "render/plan/fusion.h"

namespace tessera {
namespace {

static_assert(static_cast<int>(native::PacketReduction::average) == static_cast<int>(Reduction::average) &&
              static_cast<int>(native::PacketReduction::minimum) == static_cast<int>(Reduction::minimum));

native::PacketEmptySpace spaceOf(const Occupancy& empty, const FineBlocks* finer) {
    if (finer)
        return finer->space();
    native::PacketEmptySpace space;
    space.map = empty.map().data();
    for (int axis = 0; axis < 3; ++axis)
        space.grid[axis] = empty.grid()[axis];
    space.shift = boxShift(empty.scale());
    return space;
}

} // namespace

native::PacketFrame packetFrameOf(const RayFrame<float>& frame) {
    native::PacketFrame f;
    for (int axis = 0; axis < 3; ++axis) {
        f.centre[axis] = frame.centre[axis];
        f.right[axis] = frame.right[axis];
        f.up[axis] = frame.up[axis];
        f.toCentre[axis] = frame.toCentre[axis];
        f.extent[axis] = frame.extent[axis];
        for (int row = 0; row < 3; ++row)
            f.patientFromVoxel[3 * axis + row] = frame.patientFromVoxel[axis][row];
    }
    f.imageSize[0] = frame.imageSize.x, f.imageSize[1] = frame.imageSize.y;
    f.segmentVoxels = frame.segmentVoxels;
    f.perspective = frame.perspective;
    static_assert(native::kMostPacketSlabs == kMostSlabs);
    f.slabCount = frame.slabCount;
    f.flat = frame.flat;
    for (int n = 0; n < frame.slabCount; ++n) {
        const RaySlab<float>& slab = frame.slabs[static_cast<std::size_t>(n)];
        f.slabs[n] = {{slab.normal.x, slab.normal.y, slab.normal.z}, slab.low, slab.high};
    }
    return f;
}

native::PacketFusion packetFusionOf(const FramePlan& plan, const Strides& strides) {
    static_assert(native::kMostVolumes == Scene::kMaxVolumes);
    static_assert(leaf::kFusionMix == static_cast<int>(Fusion::mix) &&
                  leaf::kFusionOver == static_cast<int>(Fusion::over) &&
                  leaf::kFusionMaximum == static_cast<int>(Fusion::maximum));
    native::PacketFusion fusion;
    fusion.rule = static_cast<std::int32_t>(plan.fused->rule);
    fusion.segments = strides.uniformSegments;
    const auto add = [&](const glm::dmat4& fromLattice, const OwnCuts& cuts, const FramePlan& volume) {
        fusion.cuts[fusion.count] = cuts.slabs.data();
        fusion.cutCount[fusion.count] = static_cast<std::int32_t>(cuts.slabs.size());
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                fusion.linear[fusion.count][3 * column + row] = static_cast<float>(fromLattice[column][row]);
        for (int row = 0; row < 3; ++row)
            fusion.offset[fusion.count][row] = static_cast<float>(fromLattice[3][row]);
        fusion.unitMm[fusion.count++] = static_cast<float>(volume.layer().function.referenceLengthMm());
    };
    add(plan.fused->fromLattice, plan.fused->cuts, plan);
    for (const auto& volume : plan.further)
        add(volume->fromLattice, volume->cuts, volume->plan);
    return fusion;
}

native::PacketGradient packetGradient(Gradient gradient) {
    switch (gradient) {
    case Gradient::central:
        return native::PacketGradient::central;
    case Gradient::centralHalf:
        return native::PacketGradient::centralHalf;
    case Gradient::forward:
        return native::PacketGradient::forward;
    case Gradient::sobel:
    case Gradient::sobel2:
    case Gradient::sobel4:
        return native::PacketGradient::sobel;
    case Gradient::analytic:
        return native::PacketGradient::analytic;
    case Gradient::cubic:
        return native::PacketGradient::cubic;
    }
    return native::PacketGradient::central;
}

native::PacketScene packetSceneOf(const PacketSceneInput& in) {
    const HostPlane& plane = in.plane;
    const Layer& volume = in.plan.layer();
    const VolumeInfo& info = in.plan.info();
    native::PacketScene s;
    native::PacketField& f = s.field;
    f.samples = plane.samples();
    f.kind = plane.kind();
    f.bricks = plane.bricks().data();
    f.mixed = volume.mixed();
    f.level = volume.selection.finest();
    const glm::ivec3 last = levelExtent(info.extentVoxels, f.level) - 1;
    for (int axis = 0; axis < 3; ++axis) {
        f.grid[axis] = plane.grid()[axis];
        f.extentVoxels[axis] = info.extentVoxels[axis];
        f.lastVoxel[axis] = info.extentVoxels[axis] - 1;
        f.last[axis] = last[axis];
    }
    static_assert(sizeof(f.rowPitch) / sizeof(f.rowPitch[0]) == kLevelCount);
    for (int level = 0; level < kLevelCount; ++level) {
        f.rowPitch[level] = plane.rowPitch(level);
        f.slicePitch[level] = plane.slicePitch(level);
    }
    if (f.mixed) {
        f.facts = volume.levels.facts.data();
        static_assert(sizeof(BrickCorner) == 2 * sizeof(std::uint32_t));
        f.corners = &volume.levels.corners.front().codes;
        f.finest = static_cast<std::int32_t>(volume.levels.finest);
        f.edgeFunction = static_cast<std::int32_t>(volume.levels.edgeFunction);
        f.naive = in.strides.sampling == Sampling::naive;
        f.mostStride = volume.levels.mostStride;
    }
    f.uniformSegments = in.strides.uniformSegments;
    f.segmentVoxels = static_cast<float>(in.strides.segmentVoxels);
    const auto beside = [&](const std::vector<std::unique_ptr<HostPlane>>& planes,
                            native::PacketField* fields) { // at the same places
        for (std::size_t n = 0; n < planes.size(); ++n) {
            fields[n] = f;
            fields[n].samples = planes[n]->samples();
            fields[n].kind = planes[n]->kind();
            fields[n].bricks = planes[n]->bricks().data();
        }
    };
    beside(in.light, s.light);
    beside(in.labels, s.labels);
    const Optics& optics = volume.optics;
    native::PacketOptics& o = s.optics;
    o.scale = optics.scale, o.offset = optics.offset;
    o.last = static_cast<std::int32_t>(optics.table.size()) - 1;
    o.lastEntry = o.last - 1;
    o.lastPlace = static_cast<float>(o.last);
    o.termination = optics.termination;
    switch (optics.integrator) {
    case Integrator::linear:
        o.integrator = native::PacketIntegrator::linear;
        break;
    case Integrator::preintegrated:
        o.integrator = native::PacketIntegrator::preintegrated;
        break;
    case Integrator::preintegrated2d:
        o.integrator = native::PacketIntegrator::preintegrated2d;
        break;
    case Integrator::midpoint:
    case Integrator::automatic:
        break;
    }
    o.reduction = static_cast<native::PacketReduction>(optics.reduction);
    o.keepsOn = in.keepsOn;
    if (const ValueBounds& bounds = volume.bounds;
        in.plan.view.quality.skipping && bounds.exists() && !in.flat) { // a plane has one sample
        s.bounds.brick = bounds.brick().data();
        s.bounds.cell = bounds.cell().empty() ? nullptr : bounds.cell().data();
        for (int axis = 0; axis < 3; ++axis)
            s.bounds.cells[axis] = bounds.cells()[axis];
        s.bounds.least = bounds.least();
    }
    const auto floats = [](const std::vector<glm::vec4>& v) { return v.empty() ? nullptr : &v.front().x; };
    o.table = floats(optics.table);
    o.bins = floats(optics.bins);
    o.sums = floats(optics.sums);
    o.colours = floats(optics.seen.colours());
    o.preintegrationScale = optics.preintegrationScale;
    o.preintegrationEdge = Preintegration2d::kEdge;
    o.firstLayer = optics.seen.firstLayer();
    o.lit = optics.shading;
    o.gradient = packetGradient(optics.gradient);
    o.normalReach = static_cast<float>(reachOf(optics.normals));
    o.ambient = optics.phong.x, o.diffuse = optics.phong.y, o.specular = optics.phong.z;
    o.power = optics.specularPower;
    o.hasLights = optics.hasLights;
    o.lighting = optics.lighting;
    o.labels = optics.labels;
    for (leaf::MaterialNumbers m : optics.materials) {
        m.from = tessera::placeOf(optics, m.from), m.to = tessera::placeOf(optics, m.to);
        o.materials[o.materialCount++] = m;
    }
    const leaf::GradientNumbers<double>& byGradient = optics.gradientOpacity;
    o.gradientOpacity.count = byGradient.count;
    for (int i = 0; i < byGradient.count; ++i) {
        o.gradientOpacity.length[i] = static_cast<float>(byGradient.length[i]);
        o.gradientOpacity.factor[i] = static_cast<float>(byGradient.factor[i]);
        o.gradientOpacity.slope[i] = static_cast<float>(byGradient.slope[i]);
    }
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) {
            o.toGradient[3 * column + row] = optics.voxelFromPatientTransposed[column][row];
            o.toPatient[3 * column + row] = optics.patientFromVoxel[column][row];
        }
    if (const Occupancy* const empty = in.occupancy) {
        s.space = spaceOf(*empty, in.blocks);
        if (volume.mapsSurfaces)
            s.surfaces.space = spaceOf(volume.surfaceOccupancy, in.surfaceBlocks);
    }
    native::PacketSurfaces& surfaces = s.surfaces;
    TESSERA_CHECK(optics.surfaces.size() <= native::kMostSurfaces);
    for (const SurfaceLook& look : optics.surfaces) {
        const int n = surfaces.count++;
        surfaces.isovalue[n] = look.isovalue;
        surfaces.red[n] = look.colour.r, surfaces.green[n] = look.colour.g, surfaces.blue[n] = look.colour.b;
        surfaces.opacity[n] = look.opacity;
        surfaces.reports[n] = look.reports ? 1.0f : 0.0f;
    }
    surfaces.volumeShows = optics.volumeShows;
    return s;
}

void setRay(native::PacketJob& job, int lane, const SegmentedRay<float>& ray) {
    for (int axis = 0; axis < 3; ++axis) {
        job.entry[axis][lane] = ray.entry[axis];
        job.step[axis][lane] = ray.step[axis];
        job.direction[axis][lane] = ray.direction[axis];
    }
    job.segmentMm[lane] = ray.segmentMm;
    job.tail[lane] = ray.tail;
    job.count[lane] = ray.count;
}

} // namespace tessera
