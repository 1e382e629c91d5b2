// tests/render/plain_values_test.cpp: what parts of a picture are while nobody says more, and numbers that
// docs/sampling.md, the guide and headers name.
#include "render/contract/integrators.h"
#include "render/contract/level_map.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"
#include "render/contract/ray_state.h"
#include "render/contract/sampler.h"
#include "render/contract/strides.h"
#include "render/empty_space/distance_map.h"
#include "render/empty_space/occupancy.h"
#include "render/labels/drawn_labels.h"
#include "render/labels/label_looks.h"
#include "render/labels/plane_places.h"
#include "render/light/histogram_light.h"
#include "render/light/scatter_light.h"
#include "render/light/scene_light.h"
#include "render/light/surface_light.h"
#include "render/pixels/area_picture.h"
#include "render/pixels/pixel_places.h"
#include "render/pixels/pixel_sums.h"
#include "render/plan/choose_levels.h"
#include "render/plan/frame_plan.h"
#include "render/plan/framing.h"
#include "render/plan/step_search.h"
#include "render/renderer.h"
#include "render/transport/path_scene.h"
#include "render/transport/traced_path.h"
#include "render/verify/error_goal.h"
#include "render/verify/measured_errors.h"
#include "render/verify/pixel_sample.h"
#include "render/verify/verify_plan.h"

#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <gtest/gtest.h>
#include <limits>

namespace tessera {
namespace {

TEST(PlainValues, OfLight) {
    EXPECT_EQ(LightLeft().mm, 0);
    EXPECT_EQ(LightLeft().light, 1) << "nothing is in the way";
    EXPECT_EQ(DeepShadowMap::kLayers, 8);
    EXPECT_EQ(DeepShadowMap::kDark, 1.0f / 1024);
    EXPECT_EQ(kMostOcclusionSteps, 32);
    EXPECT_EQ(OcclusionRay().steps, 1) << "at least one";
    EXPECT_EQ(OcclusionRay().skipped, 0);
    EXPECT_EQ(OcclusionRay().stepMm, 0);
    EXPECT_EQ(OcclusionRays().reach, glm::ivec3(0));
    EXPECT_EQ(HistogramLight::Row().open, 1);
    EXPECT_EQ(HistogramLight::Row().colour, glm::vec3(0));
    EXPECT_EQ(kChunkTexels, std::size_t{32} * 32 * 32);
    EXPECT_EQ(ChunkExtinctions::kMost, 128u);
    EXPECT_EQ(ScatterLight::kRays, 32);
    EXPECT_EQ(SceneLight::kCoarseLevel, 3) << "one for 8^3 voxels";
    const LightReport report;
    EXPECT_EQ(report.channels, 0);
    EXPECT_FALSE(report.emission);
    EXPECT_EQ(report.planeBytes + report.mapBytes + report.maps, 0u);
    EXPECT_EQ(report.mapSize, 0);
    EXPECT_EQ(report.mapError, 0);
    EXPECT_EQ(report.shareOfMore, 0);
    EXPECT_EQ(report.seconds, 0);
    const PlacedLight light;
    EXPECT_FALSE(light.isPoint);
    EXPECT_EQ(light.towards, glm::dvec3(0, 0, 1));
    EXPECT_EQ(light.position, glm::dvec3(0));
    EXPECT_EQ(light.softness, 0);
    const ShadowQuality quality;
    EXPECT_EQ(quality.mapSize, 512);
    EXPECT_EQ(quality.stepVoxels, 1);
    EXPECT_EQ(quality.error, 1.0f / 128);
    EXPECT_EQ(quality.layers, 8);
    EXPECT_EQ(quality.offset, 2);
    EXPECT_EQ(ShadowQuality::kMapsOfSoftLight, 4);
    const LightPath path;
    EXPECT_FALSE(path.cache || path.info || path.selection || path.levels || path.optics || path.occupancy ||
                 path.rays || path.labels);
    EXPECT_TRUE(path.meshes.empty());
    const LightWay way;
    EXPECT_EQ(way.from, glm::dvec3(0));
    EXPECT_EQ(way.direction, glm::dvec3(0));
    EXPECT_EQ(way.voxels, 0);
    EXPECT_EQ(way.mmPerVoxel, 1);
    EXPECT_EQ(LightTaken().taken, 0);
    EXPECT_EQ(LightTaken().mm, 0);
    EXPECT_EQ(SurfaceLight::kSegmentVoxels, 1);
    const SurfaceLight::Report surfaces;
    EXPECT_EQ(surfaces.rays, 0);
    EXPECT_EQ(surfaces.radiusMm + surfaces.seconds, 0);
    EXPECT_EQ(surfaces.places + surfaces.alone + surfaces.bytes, 0u);
    EXPECT_EQ(kAmbientLight, 1u);
    EXPECT_EQ(kShadowLight, 2u);
    EXPECT_EQ(kAllLight, 3u);
    const BrickToLight brick;
    EXPECT_EQ(brick.brick, 0u);
    EXPECT_EQ(brick.level, 0);
    EXPECT_EQ(brick.lightLevel, 0);
}

TEST(PlainValues, OfRays) {
    EXPECT_EQ(kMostSlabs, 8);
    EXPECT_EQ(kPhases, 8);
    EXPECT_EQ(kMostReach, 16) << "half a brick";
    EXPECT_EQ(kMostCubicPitch, 8);
    const RaySlab<double> slab;
    EXPECT_EQ(slab.normal, glm::dvec3(0));
    EXPECT_EQ(slab.low, 0);
    EXPECT_EQ(slab.high, 0);
    EXPECT_EQ(RayPart().from, 0);
    EXPECT_EQ(RayPart().to, 0);
    const RayFrame<double> frame;
    for (const glm::dvec3& v : {frame.centre, frame.right, frame.up, frame.toCentre, frame.extent})
        EXPECT_EQ(v, glm::dvec3(0));
    EXPECT_EQ(frame.patientFromVoxel, glm::dmat3(1));
    EXPECT_EQ(frame.imageSize, glm::dvec2(1));
    EXPECT_EQ(frame.segmentVoxels, 1);
    EXPECT_FALSE(frame.phased);
    EXPECT_TRUE(frame.perspective);
    EXPECT_EQ(frame.slabCount, 0);
    EXPECT_FALSE(frame.flat);
    EXPECT_EQ(frame.cuts, nullptr);
    const SegmentedRay<double> ray;
    for (const glm::dvec3& v : {ray.entry, ray.step, ray.direction})
        EXPECT_EQ(v, glm::dvec3(0));
    EXPECT_EQ(ray.segmentMm, 0);
    EXPECT_EQ(ray.tail, 1);
    EXPECT_EQ(ray.count, 0) << "it misses the drawn part";
    const RayLine<double> line;
    EXPECT_EQ(line.base, glm::dvec3(0));
    EXPECT_EQ(line.direction, glm::dvec3(0));
    EXPECT_EQ(line.nearest, 0);
    EXPECT_EQ(line.mmPerVoxel, 0);
    const Strides strides;
    EXPECT_EQ(strides.map, nullptr);
    EXPECT_EQ(strides.uniformSegments, 1);
    EXPECT_EQ(strides.sampling, Sampling::limited);
    EXPECT_EQ(strides.segmentVoxels, 1);
    const SurfaceHit hit;
    EXPECT_EQ(hit.position, glm::vec3(0));
    EXPECT_EQ(hit.depthMm, 0);
    EXPECT_EQ(hit.normal, glm::vec3(0));
    EXPECT_EQ(hit.surface, 0) << "none was met";
    const Slicing slicing;
    EXPECT_EQ(slicing.targetMs, 80);
    EXPECT_EQ(slicing.fixedTile, 0);
    EXPECT_EQ(slicing.fixedIterations, 0);
    EXPECT_FALSE(slicing.progress);
    EXPECT_EQ(BrickCorner::kOutside, 7u);
    EXPECT_EQ(BrickCorner::kNoReach, 15u);
    EXPECT_EQ(BrickCorner::kAgreeBit, 1u << 12);
    EXPECT_EQ(BrickCorner().codes, 0u);
    EXPECT_EQ(BrickCorner().facts, 0u);
    const LevelMap map;
    EXPECT_EQ(map.extentVoxels, glm::ivec3(0));
    EXPECT_EQ(map.bricks, glm::ivec3(0));
    EXPECT_EQ(map.edgeFunction, EdgeFunction::split);
    EXPECT_EQ(map.finest, 0u);
    EXPECT_EQ(map.mostStride, 0);
}

TEST(PlainValues, OfOptics) {
    const SurfaceLook look;
    EXPECT_EQ(look.isovalue, 0);
    EXPECT_EQ(look.colour, glm::vec3(1));
    EXPECT_EQ(look.opacity, 1);
    EXPECT_EQ(look.occlusion, 0);
    EXPECT_FALSE(look.finish);
    const Optics optics;
    EXPECT_EQ(optics.scale, 0);
    EXPECT_EQ(optics.offset, 0);
    EXPECT_FALSE(optics.shading);
    EXPECT_EQ(optics.gradient, Gradient::central);
    EXPECT_EQ(optics.phong, glm::vec3(0));
    EXPECT_EQ(optics.specularPower, 1);
    EXPECT_FALSE(optics.hasLights);
    EXPECT_EQ(optics.voxelFromPatientTransposed, glm::mat3(1));
    EXPECT_EQ(optics.patientFromVoxel, glm::mat3(1));
    EXPECT_EQ(optics.reduction, Reduction::composite);
    EXPECT_EQ(optics.termination, 0) << "no ray ends";
    EXPECT_EQ(optics.integrator, Integrator::midpoint);
    EXPECT_EQ(optics.preintegrationScale, 0);
    EXPECT_TRUE(optics.volumeShows);
    EXPECT_EQ(Preintegration2d::kEdge, 256);
    EXPECT_EQ(leaf::kMostLights, 4);
    EXPECT_EQ(leaf::kMostMaterials, 8);
    EXPECT_EQ(leaf::kLightOne, 16384);
    EXPECT_EQ(leaf::kMostLightChannels, 4);
    EXPECT_EQ(leaf::kMostLabelChannels, 7);
    EXPECT_EQ(leaf::kMostGradientPoints, 16);
    EXPECT_EQ(leaf::kWayOverlap, 1.0f / 512);
    EXPECT_EQ(leaf::kLittleLight, 0.25f);
    EXPECT_EQ(leaf::kDarkDepth, 24);
    EXPECT_EQ(leaf::kLabelBorder, 0.42f);
    EXPECT_EQ(leaf::kLabelReach, 2);
    EXPECT_EQ(leaf::kLabelSteepness, 1e4f);
    const leaf::LightNumbers light;
    EXPECT_EQ(light.sort, leaf::LightSort::head);
    EXPECT_EQ(light.channel, -1) << "all of it gets there";
    const leaf::LightingNumbers lights;
    EXPECT_EQ(lights.count, 0);
    EXPECT_EQ(lights.channels, 0);
    EXPECT_EQ(lights.occlusionChannel, -1);
    EXPECT_EQ(lights.ambientChannels, 1);
    EXPECT_FALSE(lights.emits);
    const leaf::CutSlab slab;
    EXPECT_EQ(slab.normal[0] + slab.normal[1] + slab.normal[2], 0);
    EXPECT_EQ(slab.low, 0);
    EXPECT_EQ(slab.high, 0);
    EXPECT_TRUE(slab.endsBody);
    EXPECT_FALSE(slab.keepsOutside);
    const leaf::LabelNumbers labels;
    EXPECT_EQ(labels.count, 0);
    for (const std::int32_t channel :
         {labels.plain, labels.tinted, labels.solid, labels.dense, labels.colour})
        EXPECT_EQ(channel, -1);
    EXPECT_EQ(labels.density, 0);
    EXPECT_FALSE(labels.nearest);
    const leaf::MaterialNumbers material;
    EXPECT_EQ(material.from + material.to + material.ambient + material.diffuse + material.specular, 0);
    EXPECT_EQ(material.power, 1);
    EXPECT_EQ(material.emission[0] + material.emission[1] + material.emission[2], 0);
    EXPECT_EQ(leaf::GradientNumbers<double>().count, 0);
}

TEST(PlainValues, OfLabels) {
    const LabelFactors factors;
    EXPECT_EQ(factors.plain, 1);
    EXPECT_EQ(factors.tinted, 0);
    EXPECT_EQ(factors.solid, 0);
    EXPECT_EQ(factors.colour, glm::vec3(0));
    EXPECT_TRUE(factors.shows());
    EXPECT_FALSE((LabelFactors{0, 0, 0, glm::vec3(1)}).shows());
    EXPECT_TRUE((LabelFactors{0, 0.1f, 0, {}}).shows());
    EXPECT_TRUE((LabelFactors{0, 0, 0.1f, {}}).shows());
    EXPECT_EQ(LabelMedium().density, 0);
    EXPECT_EQ(SliceLooks().widest, 0);
    const SliceLooks::OneLabel label;
    EXPECT_EQ(label.colour, glm::vec3(1));
    EXPECT_EQ(label.outline, 0);
    const SliceLooks::Set set;
    EXPECT_EQ(set.keep, glm::vec3(1));
    EXPECT_EQ(set.add, glm::vec3(0));
    EXPECT_EQ(set.cover, 0);
    const PlanePlaces places;
    EXPECT_EQ(places.size, glm::ivec2(0));
    EXPECT_EQ(places.toW, glm::dvec3(0, 0, 1));
    EXPECT_TRUE(places.isMet);
    EXPECT_FALSE(places.perspective);
    EXPECT_EQ(kBrickTexels, std::size_t{32768});
}

TEST(PlainValues, OfPixels) {
    EXPECT_EQ(kMostInSet, 128);
    EXPECT_EQ(kFilterDeviation, 0.5);
    EXPECT_EQ(kFilterReach, 1.5);
    EXPECT_EQ(kPatchRays, 16u);
    EXPECT_EQ(kPatchesAcross, 16u);
    EXPECT_EQ(PixelSums::kManySamples, 1024);
    const StandardError none;
    EXPECT_EQ(none.rms + none.luvMean + none.luvP99, 0);
    const PixelTarget target;
    EXPECT_EQ(target.linear, 1.0 / 255);
    EXPECT_EQ(target.lightness, 1.2);
    const PixelReport report;
    EXPECT_EQ(report.asked, 1);
    EXPECT_EQ(report.taken, 1);
    EXPECT_EQ(report.most, 1);
    EXPECT_EQ(report.ofEarlierRuns, 0);
    EXPECT_FALSE(report.error);
    const PixelGoal goal;
    EXPECT_EQ(goal.rays, std::size_t{1} << 17);
    EXPECT_EQ(goal.most, 64);
}

TEST(PlainValues, OfMeasurements) {
    EXPECT_EQ(kFewestForP99, 299);
    EXPECT_EQ(kFewestForMeans, 100);
    EXPECT_EQ(kFewestClusters, 48);
    EXPECT_EQ(kTailShare, 0.99);
    EXPECT_EQ(kMostNoise, 0.5);
    EXPECT_EQ(kMostQuickCost, 0.25);
    EXPECT_EQ(ErrorGoal::kMostRounds, 6);
    const Estimate estimate;
    EXPECT_EQ(estimate.value + estimate.low + estimate.high, 0);
    const MeasuredErrors errors;
    EXPECT_EQ(errors.pixels + errors.shown + errors.clusters, 0);
    EXPECT_FALSE(errors.rms || errors.luvMean || errors.luvP99 || errors.luvP99Bound);
    EXPECT_EQ(errors.whyNoP99, NotMeasured::no);
    EXPECT_EQ(errors.tailDesignEffect, 1);
    EXPECT_EQ(errors.noiseShare, 0);
    const SampleDesign design;
    EXPECT_EQ(design.perCluster, 1);
    EXPECT_EQ(design.tile, 4);
    const PixelPairs pairs;
    EXPECT_EQ(pairs.replicates, 0);
    const PixelError error;
    EXPECT_EQ(error.cluster, 0);
    EXPECT_FALSE(error.shown);
    EXPECT_EQ(error.square + error.luv + error.luvNoisier, 0);
    const VerifyInput input;
    EXPECT_EQ(input.size, glm::ivec2(0));
    EXPECT_EQ(input.shown, 0u);
    EXPECT_EQ(input.samplesPerPixel, 1);
    EXPECT_EQ(input.costOfTruthRay, 4);
    EXPECT_EQ(input.brickPixels, 0);
    EXPECT_EQ(input.costTaken, 0);
    EXPECT_EQ(input.mode, Verify::quick);
    EXPECT_EQ(input.seed, 0u);
    const VerifyPlan plan;
    EXPECT_EQ(plan.replicates, 0);
    EXPECT_EQ(plan.samples, 0);
    EXPECT_EQ(plan.cost, 0);
    EXPECT_FALSE(plan.tellsP99);
    const PictureMeasurement measured;
    EXPECT_EQ(measured.mode, Verify::none);
    EXPECT_FALSE(measured.keptLight || measured.keptRays || measured.singleRays);
    EXPECT_EQ(measured.samples + measured.mostSamples, 0);
    EXPECT_EQ(measured.bytesRead, 0u);
    EXPECT_EQ(measured.seconds, 0);
}

TEST(PlainValues, OfPlans) {
    EXPECT_EQ(kLeastOpacityFramed, 0.015);
    EXPECT_EQ(PixelGrid::kMostPixels, 48);
    EXPECT_EQ(StepSearch::kFinestStep, 1.0 / 16);
    EXPECT_EQ(StepSearch::kLuvOfLonger, 2);
    EXPECT_EQ(kPictureBytesPerPixel, 40u) << "two colours of 16 bytes, and four halves";
    const ChosenLevels chosen;
    EXPECT_EQ(chosen.atlasPages + chosen.unseenBricks, 0u);
    EXPECT_FALSE(chosen.predicted);
    const PlanRevisions revisions;
    EXPECT_EQ(revisions.function + revisions.tables + revisions.levels + revisions.emptySpace, 0u);
    const Layer layer;
    EXPECT_EQ(layer.hidden, 0u);
    EXPECT_EQ(layer.pageEdge, kBrickExtent);
    EXPECT_EQ(layer.mapScale, MapScale::bricks);
    EXPECT_FALSE(layer.mapsSurfaces);
    EXPECT_EQ(FusedLattice().rule, Fusion::mix);
    EXPECT_EQ(FusedLattice().fromLattice, glm::dmat4(1));
    EXPECT_EQ(FramePlan().mayTake, Integrator::midpoint);
    const ViewState view;
    EXPECT_EQ(view.imageSize, glm::ivec2(0));
    EXPECT_TRUE(view.meshesShade);
    EXPECT_FALSE(view.amongOthers);
    const EstimatedError error;
    EXPECT_EQ(error.rms + error.largest + error.luvMean + error.luvP99, 0);
    EXPECT_EQ(StepError().order, 0);
    const PictureErrors errors;
    EXPECT_EQ(errors.pixels, 0);
    EXPECT_EQ(errors.terminationBound + errors.tableRelativeError, 0);
    EXPECT_EQ(kFarthest, 127);
    EXPECT_EQ(kLeapMargin, 1.0 / 64);
    EXPECT_EQ(boxShift(MapScale::cells), 3);
    EXPECT_EQ(boxShift(MapScale::bricks), 5);
    EXPECT_EQ(Occupancy().version(), 0u);
    EXPECT_FALSE(Occupancy().exists());
}

TEST(PlainValues, OfPictures) {
    const RenderOptions options;
    EXPECT_EQ(options.engine, EngineKind::automatic);
    EXPECT_EQ(options.threads, 0);
    EXPECT_TRUE(options.counting);
    EXPECT_EQ(options.levels, LevelChoice::perBrick);
    EXPECT_EQ(options.shadowLayers, 8);
    EXPECT_FALSE(options.searching || options.checking);
    EXPECT_EQ(options.verify, Verify::none);
    EXPECT_EQ(options.progress, nullptr);
    EXPECT_EQ(options.kept, nullptr);
    EXPECT_EQ(options.shares, nullptr);
    const RenderResult result;
    EXPECT_EQ(result.engine, EngineKind::automatic);
    EXPECT_EQ(result.level, 0);
    EXPECT_EQ(result.residentBricks + result.emptyBricks + result.unseenBricks, 0u);
    EXPECT_EQ(result.selectionPages + result.atlasPages, 0u);
    EXPECT_EQ(result.passes, 0);
    EXPECT_FALSE(result.levelsOnPurpose || result.takenAsHu);
    EXPECT_EQ(result.cells + result.occupiedCells + result.refinedCells, 0u);
    EXPECT_EQ(result.features, 0u);
    EXPECT_EQ(result.tableRelativeError, 0);
    EXPECT_EQ(result.integrator, Integrator::midpoint);
    EXPECT_EQ(result.stepVoxels, 0);
    EXPECT_EQ(result.rounds, 1);
    EXPECT_EQ(result.secondsChecking, 0);
    EXPECT_EQ(result.lowest + result.highest, 0);
    EXPECT_EQ(result.rayExtent, glm::ivec3(0));
    EXPECT_EQ(result.secondsPreparing + result.secondsLoading + result.secondsDrawing, 0);
    EXPECT_EQ(RenderResult::Labels().all + RenderResult::Labels().shown, 0u);
    EXPECT_EQ(RenderResult::Labels().channels + RenderResult::Labels().level, 0);
    const RenderResult::Further further;
    EXPECT_EQ(further.level, 0);
    EXPECT_EQ(further.ramBytes + further.ramPeakBytes + further.gpuBytes + further.gpuPeakBytes, 0u);
    EXPECT_EQ(Round().number, 0);
    EXPECT_FALSE(FrameReuse().kept || FrameReuse().first);
    EXPECT_EQ(FrameReuse().pages, 0u);
    EXPECT_FALSE(PixelSource::About().finest || PixelSource::About().passes);
    EXPECT_EQ(PixelSource::About().brickPixels, 1);
}

TEST(PlainValues, OfPaths) {
    const SurfaceResponse response;
    EXPECT_EQ(response.mirrored, 0.028f);
    EXPECT_EQ(response.width, 0.1225f) << "0.35 squared";
    EXPECT_EQ(response.translucent, 0);
    EXPECT_EQ(response.power, 10);
    const Way way;
    EXPECT_EQ(way.from, glm::vec3(0));
    EXPECT_EQ(way.perMm, glm::vec3(0));
    EXPECT_EQ(way.mm, 0);
    const PathTissue tissue;
    EXPECT_EQ(tissue.albedo, glm::vec3(0));
    EXPECT_EQ(tissue.emission, glm::vec3(0));
    EXPECT_EQ(tissue.number, 0u);
    EXPECT_EQ(PathStart().place, glm::vec2(0));
    EXPECT_FALSE(PathStart().number);
    const PathScene scene;
    const TracedPath path(scene, {3, 4});
    EXPECT_EQ(path.p, glm::vec3(0));
    EXPECT_EQ(path.travel, glm::vec3(0));
    EXPECT_EQ(path.sum, glm::vec3(0));
    EXPECT_EQ(path.throughput, glm::vec3(1));
    EXPECT_EQ(path.bounce, 0);
    EXPECT_FALSE(path.isSurface);
    EXPECT_EQ(path.isosurface, -1);
    EXPECT_EQ(path.normal, glm::vec3(0));
    EXPECT_EQ(path.albedo, glm::vec3(0));
    EXPECT_EQ(path.shine, glm::vec3(0));
    EXPECT_EQ(path.density, 1);
    EXPECT_EQ(path.passed, 1);
    EXPECT_FALSE(ToLight().any);
    EXPECT_EQ(ToLight().towards, glm::vec3(0));
    EXPECT_EQ(ToLight().mm, std::numeric_limits<float>::max());
}

} // namespace
} // namespace tessera
