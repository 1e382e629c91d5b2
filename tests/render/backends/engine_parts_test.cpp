// tests/render/backends/engine_parts_test.cpp: parts of engines without a picture: what each says of itself,
// the pace of dispatches, features by optics, and what a device must have.
#include "core/base/error.h"
#include "render/backends/engine_maker.h"
#include "render/backends/gpu/composition.h"
#include "render/backends/gpu/gpu_engine.h"
#include "render/backends/gpu/skipping_binding.h"
#include "render/backends/mirror/mirror_engine.h"
#include "render/backends/mirror/mirror_input.h"
#include "render/backends/native/fine_blocks.h"
#include "render/backends/native/native_engine.h"
#include "render/backends/reference/reference.h"
#include "render/backends/reference/reference_engine.h"
#include "render/backends/reference/reference_proof.h"
#include "render/interactive/interactive_renderer.h"
#include "render/residency/transition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using testing::HasSubstr;

struct SaidOfEngine {
    EngineKind kind;
    const char* name;
    bool onContext, quick, exact, countsAlways, followsPaths, singleRays;
};

TEST(EngineTable, EveryEngineIsWhatItsHeaderSays) {
    const SaidOfEngine rows[] = {{EngineKind::gpu, "gpu", true, true, false, false, false, false},
                                 {EngineKind::native, "native", false, true, false, true, true, false},
                                 {EngineKind::mirror, "mirror", false, false, false, false, true, true},
                                 {EngineKind::reference, "reference", false, false, true, false, true, true},
                                 {EngineKind::splat, "splat", false, false, false, false, false, true}};
    ASSERT_EQ(engineTraits().size(), std::size(rows));
    for (std::size_t n = 0; n < std::size(rows); ++n) {
        const SaidOfEngine& row = rows[n];
        SCOPED_TRACE(row.name);
        const EngineTraits& traits = engineTraits()[n];
        EXPECT_EQ(traits.kind, row.kind) << "in the order of the kinds";
        EXPECT_EQ(&traitsOf(row.kind), &traits);
        EXPECT_EQ(traits.name, row.name);
        EXPECT_EQ(name(row.kind), row.name);
        EXPECT_EQ(traits.device.substr(0, 3), "CPU");
        EXPECT_EQ(traits.onContext, row.onContext);
        EXPECT_EQ(traits.quick, row.quick);
        EXPECT_EQ(traits.exact, row.exact);
        EXPECT_EQ(traits.countsAlways, row.countsAlways);
        EXPECT_EQ(traits.followsPaths, row.followsPaths);
        EXPECT_EQ(traits.singleRays, row.singleRays);
        EXPECT_EQ(traits.fuses, row.kind != EngineKind::splat);
        EXPECT_EQ(traits.refuses != nullptr, row.onContext);
        EXPECT_EQ(traits.bytesPerPixel, kPictureBytesPerPixel);
        EXPECT_EQ(traits.make != nullptr, row.kind != EngineKind::splat);
        EXPECT_EQ(traits.renderer != nullptr, row.kind == EngineKind::splat);
        EXPECT_EQ(traits.declines != nullptr, row.kind == EngineKind::splat);
        EXPECT_EQ(engineNamed(row.name, "--engine"), row.kind);
    }
    EXPECT_THAT(engineNames(), testing::ElementsAre("auto", "gpu", "native", "mirror", "reference", "splat"));
    EXPECT_THAT(engineNames(true), testing::ElementsAre("auto", "gpu", "native"));
    EXPECT_EQ(engineNamed("auto", "--engine"), EngineKind::automatic);
    EXPECT_EQ(name(EngineKind::automatic), "auto");
    EXPECT_THROW(engineNamed("mirror", "--engine", true), InputError);
    EXPECT_EQ(EngineTraits().device, "CPU");
}

TEST(EngineTable, EnginesSayWhatTheyCanDo) {
    MemoryBudget ram("RAM", "--ram", 1 << 20), gpu("GPU memory", "--gpu-memory", 1 << 20);
    NativeEngine native(1, gpu, ram);
    EXPECT_EQ(native.about().device, traitsOf(EngineKind::native).device);
    EXPECT_TRUE(native.about().choosesSteps && native.about().measures && native.about().followsPaths);
    EXPECT_FALSE(native.about().compiles || native.about().filters);
    EXPECT_TRUE(native.limits().readsOnce);
    EXPECT_EQ(native.limits().pageEdge, 35) << "a layer before, and two behind";
    EXPECT_EQ(native.limits().indexEntryBytes, sizeof(native::PacketBrick) + 3 * 8);
    // As many samples of two bytes as 31 bits number, in a box of pages that is no limit of its own.
    EXPECT_EQ(native.limits().maxBytes, std::size_t{1} << 32);
    EXPECT_EQ(native.limits().maxExtent, 32768);
    EXPECT_EQ(native.bricks(), nullptr);
    EXPECT_EQ(native.light(), nullptr);
    EXPECT_FALSE(native.lightReport());

    const Engine::About mirror = MirrorEngine(1).about(), reference = ReferenceEngine(1).about();
    EXPECT_TRUE(mirror.choosesSteps);
    EXPECT_FALSE(mirror.measures || mirror.followsPaths || mirror.compiles || mirror.filters);
    EXPECT_FALSE(reference.choosesSteps || reference.measures || reference.followsPaths ||
                 reference.compiles || reference.filters);
    EXPECT_EQ(mirror.device, "CPU");
    EXPECT_EQ(ReferenceEngine(1).counter(gpu), nullptr);

    const GpuEngine anywhere(gpu, ram); // within limits that every device has
    EXPECT_EQ(anywhere.limits().maxExtent, 2048);
    EXPECT_EQ(anywhere.limits().maxBytes, std::size_t{1} << 30);
    EXPECT_EQ(anywhere.limits().pageEdge, kBrickExtent);
    EXPECT_TRUE(anywhere.limits().readsOnce);
    EXPECT_EQ(anywhere.about().device, "OpenGL");
    EXPECT_EQ(anywhere.about().version, "");
    EXPECT_TRUE(anywhere.about().choosesSteps && anywhere.about().measures && anywhere.about().compiles &&
                anywhere.about().filters);
    EXPECT_FALSE(anywhere.about().followsPaths);
}

TEST(EngineMakers, TakeWhatIsAskedFor) {
    MemoryBudget ram("RAM", "--ram", 1 << 20), gpu("GPU memory", "--gpu-memory", 1 << 20);
    for (const EngineKind kind : {EngineKind::native, EngineKind::mirror, EngineKind::reference}) {
        const EngineMaker maker(kind, {}, 3);
        EXPECT_EQ(maker.kind(), kind);
        EXPECT_EQ(maker.reason(), "") << "it was asked for";
        EXPECT_EQ(maker.fault(), "");
        const EngineInput input = maker.input(ram, gpu);
        EXPECT_EQ(input.context, nullptr) << "no OpenGL for " << name(kind);
        EXPECT_EQ(input.threads, 3);
        EXPECT_EQ(input.ram, &ram);
        EXPECT_EQ(input.gpu, &gpu);
        EXPECT_EQ(maker.about(), name(kind) + " engine, " + traitsOf(kind).device);
        EXPECT_TRUE(maker.make(ram, gpu));
    }
    const EngineMaker device(EngineKind::automatic, {"software"});
    EXPECT_EQ(device.kind(), EngineKind::gpu);
    EXPECT_EQ(device.reason(), "an OpenGL device was requested");
    EXPECT_THAT(device.about(), testing::StartsWith("gpu engine, llvmpipe"));
    EXPECT_NE(device.input(ram, gpu).context, nullptr);
}

// A dispatch holds what fits its time at the cost of iterations so far, which falls by three tenths at most.
TEST(DispatchPaces, LearnFromDispatchesThatTell) {
    DispatchPace pace;
    EXPECT_EQ(pace.iterationsPerDispatch(50), 50000u) << "a microsecond each, at first";
    EXPECT_EQ(pace.iterationsPerDispatch(16), 16384u);
    EXPECT_EQ(pace.iterationsPerDispatch(0), 16384u);
    EXPECT_EQ(pace.iterationsPerDispatch(17), 17000u);
    EXPECT_EQ(pace.iterationsPerDispatch(1e12), 4000000000u);
    pace.observe(1000, 4095); // tells nothing
    EXPECT_EQ(pace.iterationsPerDispatch(50), 50000u);
    pace.observe(8.192, 4096); // two microseconds
    EXPECT_NEAR(static_cast<double>(pace.iterationsPerDispatch(50)), 25000, 1);
    pace.observe(0.5 * 1.6, 1000000); // much quicker
    EXPECT_NEAR(static_cast<double>(pace.iterationsPerDispatch(50)), 50 / (0.7 * 2e-3), 1);
    pace.observe(1.2 * 8.192, 8192); // a little quicker
    EXPECT_NEAR(static_cast<double>(pace.iterationsPerDispatch(50)), 50 / 1.2e-3, 1);
}

TEST(OpticsFeatures, AreThoseOfTheirIntegratorAndGradient) {
    EXPECT_EQ(integratorFeatures(Integrator::midpoint), 0u);
    EXPECT_EQ(integratorFeatures(Integrator::linear), kFeatureLinear);
    EXPECT_EQ(integratorFeatures(Integrator::preintegrated), kFeaturePreintegrated);
    EXPECT_EQ(integratorFeatures(Integrator::preintegrated2d),
              kFeaturePreintegrated | kFeaturePreintegration2d);
    EXPECT_EQ(gradientFeature(Gradient::central), 0u);
    EXPECT_EQ(gradientFeature(Gradient::centralHalf), kFeatureHalfCentralGradient);
    EXPECT_EQ(gradientFeature(Gradient::forward), kFeatureForwardGradient);
    EXPECT_EQ(gradientFeature(Gradient::sobel), kFeatureSobelGradient);
    EXPECT_EQ(gradientFeature(Gradient::analytic), kFeatureAnalyticGradient);
    EXPECT_EQ(gradientFeature(Gradient::cubic), kFeatureCubicGradient);
    ASSERT_EQ(featureNames().size(), static_cast<std::size_t>(features::kCount));
    for (std::size_t n = 0; n < featureNames().size(); ++n) {
        EXPECT_EQ(featureNames()[n].bit, 1u << n);
        EXPECT_STREQ(featureNames()[n].define, featureModules()[n].define);
    }
    EXPECT_THAT(featureDefines(kFeatureShading), testing::StartsWith("#define FEATURE_SHADING 1\n"));
    EXPECT_THAT(featureDefines(kFeatureShading), HasSubstr("#define FEATURE_SKIPPING 0\n"));
}

// Lights of the scene's own are features where there is shading, and what they bring where they bring it.
TEST(OpticsFeatures, OfLightFollowTheLights) {
    constexpr std::uint32_t kOfLights =
        kFeatureLights | kFeatureMaterials | kFeatureVoxelLight | kFeatureEmission;
    Optics optics;
    EXPECT_EQ(withLights(kFeatureShading | kOfLights | kFeatureMixed, optics),
              kFeatureShading | kFeatureMixed);
    optics.hasLights = true;
    EXPECT_EQ(withLights(kOfLights | kFeatureMixed, optics), kFeatureMixed) << "nothing is shaded";
    EXPECT_EQ(withLights(kFeatureShading, optics), kFeatureShading | kFeatureLights);
    optics.materials.resize(1);
    EXPECT_EQ(withLights(kFeatureShading, optics), kFeatureShading | kFeatureLights | kFeatureMaterials);
    optics.materials.clear();
    optics.lighting.channels = 1;
    EXPECT_EQ(withLights(kFeatureShading, optics), kFeatureShading | kFeatureLights | kFeatureVoxelLight);
    optics.lighting.ambientChannels = 1;
    EXPECT_EQ(withLights(kFeatureShading, optics), kFeatureShading | kFeatureLights | kFeatureVoxelLight);
    optics.lighting.ambientChannels = 2;
    EXPECT_EQ(withLights(kFeatureShading, optics),
              kFeatureShading | kFeatureLights | kFeatureVoxelLight | kFeatureEmission);
    optics.lighting.ambientChannels = 0;
    optics.lighting.emits = true;
    optics.lighting.channels = 0;
    EXPECT_EQ(withLights(kFeatureShading, optics), kFeatureShading | kFeatureLights | kFeatureEmission);
}

// Gradient opacity takes the operator of the optics along; without it, one that nothing else needs goes.
TEST(OpticsFeatures, OfGradientOpacityFollowTheFunction) {
    Optics optics;
    optics.gradient = Gradient::sobel;
    const std::uint32_t graded = kFeatureGradientOpacity, forward = kFeatureForwardGradient;
    EXPECT_EQ(withGradientOpacity(kFeatureMixed | forward, optics), kFeatureMixed | forward);
    EXPECT_EQ(withGradientOpacity(kFeatureMixed | graded | forward, optics), kFeatureMixed);
    EXPECT_EQ(withGradientOpacity(kFeatureShading | graded | forward, optics), kFeatureShading | forward);
    EXPECT_EQ(withGradientOpacity(kFeatureSurfaces | graded | forward, optics), kFeatureSurfaces | forward);
    optics.gradientOpacity.count = 1;
    EXPECT_EQ(withGradientOpacity(kFeatureMixed | forward, optics),
              kFeatureMixed | graded | kFeatureSobelGradient);
}

// Each limit of a device is met exactly and missed by one; messages say what is needed and what there is.
TEST(FusedLimits, AreMetExactly) {
    Scene scene;
    const auto why = [&](int textures, int units, int components) {
        return cannotFuse(scene, {textures, units, components});
    };
    scene.volumes.resize(1);
    EXPECT_EQ(why(0, 0, 0), "") << "one volume needs no more than any device has";
    scene.volumes.resize(3);
    // Six textures, fifteen units and 360 numbers a volume; 128 numbers of the rays.
    EXPECT_EQ(why(18, 45, 1208), "");
    EXPECT_EQ(why(17, 45, 1208),
              "the scene's 3 volumes need 18 textures in a shader, and this device allows 17");
    EXPECT_EQ(why(18, 44, 1208), "the scene's 3 volumes need 45 texture units, and this device allows 44");
    EXPECT_EQ(why(18, 45, 1207),
              "the scene's 3 volumes need 1208 numbers of uniforms, and this device allows 1207");
    scene.lighting.occlusion.emplace(); // two textures more of each
    EXPECT_EQ(why(24, 45, 1208), "");
    EXPECT_NE(why(23, 45, 1208), "");
    scene.volumes[2].labels.path = "labels"; // four more of each
    EXPECT_EQ(why(36, 45, 1208), "");
    EXPECT_NE(why(35, 45, 1208), "");
    scene.volumes[0].cuts.boxes.resize(4); // three slabs each
    scene.volumes[1].cuts.planes.resize(36);
    EXPECT_EQ(why(36, 45, 1208 + 48 * 12), "") << "as many slabs as shaders take";
    EXPECT_NE(why(36, 45, 1207 + 48 * 12), "");
    scene.volumes[1].cuts.planes.resize(37);
    EXPECT_EQ(why(99, 99, 9999), "the cuts of single volumes have 49 sides, and shaders take 48");
}

/// A module that takes so many turns of loops.
std::vector<FeatureModule> turning(int turns) {
    return {{.define = "FEATURE_TURNING", .meaning = "turns", .turns = turns, .bit = kFeatureShading}};
}

TEST(Compositions, CountTheTurnsOfASample) {
    EXPECT_EQ(Composition({}, kFeatureShading, turning(70)).turns(), 70);
    EXPECT_EQ(Composition({}, kFeatureShading, turning(70), 3).turns(), 70) << "one volume at a time";
    EXPECT_EQ(Composition({}, 0, turning(70)).turns(), 0);
    EXPECT_EQ(Composition({}, kFeatureShading | kFeatureFused, turning(70), 3).turns(), 3 * (600 + 70));
    const GlContext context({"software"});
    EXPECT_THAT(Composition({}, kFeatureShading, turning(70)).defines(),
                HasSubstr("#define SAMPLE_TURNS 70\n"));
    const EmbeddedFiles files = {{"none.comp", "layout(local_size_x = 1) in;\nvoid main() {}\n"}};
    // llvmpipe ends loops after 65535 turns; sixteen samples of so many, and 464 besides, are below.
    EXPECT_NO_THROW(Composition({}, kFeatureShading, turning(65535 / 16 - 464)).program("none.comp", files));
    EXPECT_THROW(Composition({}, kFeatureShading, turning(65535 / 16 - 463)).program("none.comp", files),
                 InputError);
    const ComposeAsFor other(false);
    EXPECT_NO_THROW(Composition({}, kFeatureShading, turning(60000)).program("none.comp", files));
    const std::vector<StorageBuffer> many(static_cast<std::size_t>(1000), {"ONE", "one"});
    EXPECT_THROW(Composition(many, 0).program("none.comp", files), Error) << "more than any device has";
    EXPECT_EQ(Composition({{"ONE", "one"}, {"TWO", "two"}}, 0).binding("TWO"), 1u);
}

TEST(Devices, AreTakenByTheirWordsAndNumbers) {
    EXPECT_TRUE(isSoftwareRenderer("llvmpipe (LLVM 15.0.6, 256 bits)"));
    EXPECT_TRUE(isSoftwareRenderer("softpipe"));
    EXPECT_FALSE(isSoftwareRenderer("NVIDIA H200/PCIe/SSE2"));
    const std::vector<GlDevice> devices = listGlDevices();
    for (std::size_t n = 0; n < devices.size(); ++n)
        EXPECT_EQ(devices[n].number, static_cast<int>(n));
    for (const char* word : {"auto", "software"})
        EXPECT_NO_THROW(checkGlDevice({word}));
    for (const std::string& bad : {std::to_string(devices.size()), std::string("-1"), std::string("0x"),
                                   std::string("1 "), std::string(), std::string("fast")})
        EXPECT_THROW(checkGlDevice({bad}), InputError) << bad;
    if (!devices.empty()) {
        EXPECT_NO_THROW(checkGlDevice({std::to_string(devices.size() - 1)}));
    }
    const GlContext context({"software"});
    EXPECT_TRUE(context.software());
    EXPECT_GE(context.max3dTextureSize(), 2048) << "as OpenGL 4.5 has them";
    EXPECT_TRUE(context.errors().empty());
}

TEST(ShaderLogs, NameFilesThatThereAre) {
    const std::vector<std::string> files = {"a.comp", "b.glsl"};
    EXPECT_EQ(mapShaderLog("0:7(3): error: x", files), "a.comp:7: error: x\n");
    EXPECT_EQ(mapShaderLog("1(12) : error C0: y", files), "b.glsl:12 : error C0: y\n");
    EXPECT_EQ(mapShaderLog("1:3: z", files), "b.glsl:3: z\n");
    EXPECT_EQ(mapShaderLog("2:7(3): error: x", files), "2:7(3): error: x\n") << "there is no such file";
    EXPECT_EQ(mapShaderLog("99999999999999999999:7: x", files), "99999999999999999999:7: x\n");
    EXPECT_EQ(mapShaderLog("", files), "");
}

TEST(Refining, TakesTheTablesAndAListOfCells) {
    EXPECT_EQ(refiningBytes(1000), 1000u * 4 + 16384 * 4);
    EXPECT_EQ(refiningBytes(0), 16384u * 4);
}

/// True if each of these is 0 or null.
template <typename... Numbers> bool areZero(Numbers... numbers) {
    return (... && (numbers == Numbers{}));
}

// What is not set is off, takes nothing and moves nothing.
TEST(PlainPackets, HoldNothing) {
    const native::PacketBrick brick;
    EXPECT_TRUE(areZero(brick.base, brick.low, brick.high, brick.mean));
    EXPECT_LT(native::PacketBrick::kValue, native::PacketBrick::kAbsent);
    EXPECT_GE(native::PacketBrick::kValue, static_cast<std::uint32_t>(kLevelCount)) << "no level";
    const native::PacketField field;
    EXPECT_TRUE(areZero(field.samples, field.bricks, field.level, field.corners, field.facts,
                        field.edgeFunction, field.finest, field.mostStride));
    EXPECT_FALSE(field.mixed || field.naive);
    EXPECT_EQ(field.uniformSegments, 1);
    EXPECT_EQ(field.segmentVoxels, 1);
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_TRUE(
            areZero(field.grid[axis], field.extentVoxels[axis], field.lastVoxel[axis], field.last[axis]));
    const native::PacketOptics optics;
    EXPECT_TRUE(areZero(optics.table, optics.scale, optics.offset, optics.last, optics.lastEntry,
                        optics.lastPlace, optics.termination, optics.bins, optics.sums, optics.colours,
                        optics.preintegrationScale, optics.preintegrationEdge, optics.firstLayer));
    EXPECT_TRUE(areZero(optics.ambient, optics.diffuse, optics.specular, optics.materialCount));
    EXPECT_EQ(optics.power, 1);
    EXPECT_FALSE(optics.keepsOn || optics.lit || optics.hasLights);
    EXPECT_TRUE(areZero(optics.labels.count, optics.gradientOpacity.count, optics.lighting.channels));
    const native::PacketEmptySpace space;
    EXPECT_TRUE(areZero(space.map, space.finer, space.grid[0], space.grid[1], space.grid[2]));
    EXPECT_EQ(1 << space.shift, kCellExtent);
    const native::PacketBounds bounds;
    EXPECT_TRUE(areZero(bounds.brick, bounds.cell, bounds.cells[0], bounds.cells[1], bounds.cells[2]));
    EXPECT_FALSE(bounds.least);
    const native::PacketSurfaces surfaces;
    EXPECT_EQ(surfaces.count, 0);
    EXPECT_TRUE(surfaces.volumeShows);
    EXPECT_FALSE(surfaces.showsDistances);
    const native::PacketFusion fusion;
    EXPECT_TRUE(areZero(fusion.count, fusion.rule, fusion.cutCount[0], fusion.unitMm[0]));
    EXPECT_EQ(fusion.segments, 1);
    native::PacketJob job;
    EXPECT_TRUE(areZero(job.waiting, job.turns, job.iterations, job.segments, job.values, job.gradients,
                        job.turnsTaken));
    EXPECT_EQ(job.hits, nullptr);
    const native::PacketFrame frame{};
    EXPECT_EQ(frame.segmentVoxels, 1);
    EXPECT_TRUE(frame.perspective);
    EXPECT_EQ(frame.slabCount, 0);
    const native::CellRows rows{};
    EXPECT_TRUE(areZero(rows.firstY, rows.endY, rows.firstZ, rows.endZ, rows.first, rows.last, rows.offset));
    EXPECT_TRUE(rows.alone);
    EXPECT_EQ(rows.scale, 1);
    const native::OcclusionPath path;
    EXPECT_TRUE(areZero(path.count, path.strideA, path.strideB, path.share, native::OcclusionStep().offset));
    native::PacketShadows shadows;
    EXPECT_TRUE(areZero(shadows.dark, shadows.written[0], shadows.written[native::kMostLanes - 1]));
    const native::PacketExtinction extinction;
    EXPECT_TRUE(areZero(extinction.limit, extinction.grid[0], extinction.grid[1], extinction.grid[2]));
    const native::PacketWays ways;
    EXPECT_TRUE(areZero(ways.count, ways.lookUps, ways.nullCollisions, ways.cells, ways.exceeded));
    native::PacketSeen seen;
    EXPECT_TRUE(areZero(seen.shows, seen.found, seen.segments));
    EXPECT_EQ(native::PacketSamples().count, 0);
    EXPECT_EQ(native::PacketTarget().lanes(), 0);
}

// Every instruction set has packets of whole rows, whose edges divide a tile of 32 rays.
TEST(PlainPackets, OfEveryInstructionSetFillTiles) {
    const native::PacketTargets targets = native::packetTargets();
    ASSERT_GE(targets.count, 1);
    EXPECT_STREQ(targets.all[0]->name, "baseline");
    const std::pair<const char*, int> lanes[] = {{"baseline", 8}, {"avx2", 16}, {"avx512", 32}};
    for (int n = 0; n < targets.count; ++n) {
        const native::PacketTarget& target = *targets.all[n];
        EXPECT_STREQ(target.name, lanes[n].first);
        EXPECT_EQ(target.lanes(), lanes[n].second) << "two registers of lanes";
        EXPECT_LE(target.lanes(), native::kMostLanes);
        EXPECT_EQ(32 % target.columns, 0);
        EXPECT_EQ(32 % target.rows, 0);
        EXPECT_EQ(target.columns, target.lanes() == 32 ? 8 : 4);
    }
}

TEST(PlainValues, OfEnginesAreNone) {
    const MirrorInput mirror;
    EXPECT_EQ(mirror.firstRay, 0u);
    EXPECT_EQ(mirror.segmentVoxels, 1);
    EXPECT_EQ(mirror.unitMm, 1);
    EXPECT_EQ(mirror.fromLattice, glm::dmat4(1));
    EXPECT_FALSE(mirror.showsDistances);
    const ReferenceInput reference;
    EXPECT_EQ(reference.panels, 1);
    EXPECT_EQ(reference.lightTolerance, 1e-3);
    EXPECT_EQ(reference.fromLattice, glm::dmat4(1));
    EXPECT_FALSE(reference.flat);
    const ReferenceRay ray;
    EXPECT_EQ(ray.tMin, 0);
    EXPECT_EQ(ray.base, glm::dvec3(0));
    EXPECT_EQ(ray.direction, glm::dvec3(0));
    const RayProof proof;
    EXPECT_TRUE(proof.holds());
    EXPECT_EQ(proof.error(), 0);
    EXPECT_EQ(proof.rays, 0u);
    const VolumeToMarch march;
    EXPECT_EQ(march.unitMm, 1);
    EXPECT_EQ(march.fromLattice, glm::dmat4(1));
    const FuseLimits limits;
    EXPECT_EQ(limits.textures + limits.units + limits.components, 0);
    EXPECT_EQ(FieldSource().level, 0);
    const FeatureModule module{};
    EXPECT_EQ(module.needs + module.excludes + module.bit, 0u);
    EXPECT_EQ(module.turns, 0);
    EXPECT_EQ(Move().brick, 0u);
    EXPECT_EQ(Move().level, 0);
    EXPECT_EQ(AtlasSlot().originTexels(), glm::ivec3(0));
    EXPECT_EQ((AtlasSlot{{1, 2, 3}, {4, 5, 6}, 2}.originTexels()), glm::ivec3(64, 104, 144));
    const InteractiveOptions options; // as windows have them
    EXPECT_EQ(options.threads, 0);
    EXPECT_EQ(options.uploadBytes, std::size_t{16} << 20);
    EXPECT_EQ(options.dispatchMs, 20);
    EXPECT_EQ(options.spareShare, 1.0 / 16);
    EXPECT_EQ(options.firstPatience, std::chrono::seconds(2));
    EXPECT_TRUE(options.coarseLightFirst);
    EXPECT_FALSE(options.counting || options.firstAlone);
    EXPECT_EQ(InteractiveRenderer::Haste().stepVoxels, 0.5);
    const InteractiveRenderer::Progress progress;
    EXPECT_EQ(progress.movesLeft, 0u);
    EXPECT_FALSE(progress.newPicture || progress.converged || progress.lightIsCoarse || progress.choosing);
}

// A proof holds up to its limits; its error is the larger of both.
TEST(RayProofs, HoldUpToTheirLimits) {
    RayProof proof;
    proof.halving = 1e-10;
    proof.independent = 1e-7;
    EXPECT_TRUE(proof.holds());
    EXPECT_EQ(proof.error(), 1e-7);
    proof.halving = 1.01e-10;
    EXPECT_FALSE(proof.holds());
    proof.halving = 1e-10, proof.independent = 1.01e-7;
    EXPECT_FALSE(proof.holds());
    proof.halving = 2e-7;
    EXPECT_EQ(proof.error(), 2e-7);
}

} // namespace
} // namespace tessera
