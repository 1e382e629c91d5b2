// tests/core/scene/plain_values_test.cpp: what values are while nobody says more: no transform, no light
// taken or added, nothing counted, and what headers call unknown or none.
#include "core/animation/flight.h"
#include "core/animation/path.h"
#include "core/base/brick.h"
#include "core/base/coverage.h"
#include "core/base/volume.h"
#include "core/base/work.h"
#include "core/image/image_metrics.h"
#include "core/scene/colour_legend.h"
#include "core/scene/measurement.h"
#include "core/scene/scene.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

const glm::dvec3 kZero(0), kOne(1), kUpwards(0, 0, 1);

TEST(PlainValues, OfVolumesAreUnknownAndLeaveStoredValues) {
    const VolumeInfo info;
    EXPECT_EQ(info.extentVoxels, glm::ivec3(0));
    EXPECT_EQ(info.type, ValueType::i16);
    EXPECT_EQ(info.rescaleSlope, 1);
    EXPECT_EQ(info.rescaleIntercept, 0);
    EXPECT_EQ(info.fillStored, 0);
    EXPECT_EQ(info.patientFromVoxel, glm::dmat4(1));
    EXPECT_TRUE(info.orientationKnown);
    EXPECT_EQ(info.originalOrder.sourceAxis, (std::array<int, 3>{0, 1, 2}));
    EXPECT_EQ(info.originalOrder.flipped, (std::array<bool, 3>{false, false, false}));
    EXPECT_EQ(info.acquisition.tubeVoltageKv, 0);
    EXPECT_EQ(info.acquisition.sliceThicknessMm, 0);
    EXPECT_FALSE(info.lossy);
    EXPECT_EQ(info.lossyRatio, 0);
    EXPECT_EQ(info.nonFiniteVoxels, 0u);
    EXPECT_EQ(info.absentStored, 0);
    EXPECT_EQ(info.clampedVoxels, 0u);
    EXPECT_EQ(info.suvPerValue, 0);
    const PatientBox box;
    EXPECT_EQ(box.low, kZero);
    EXPECT_EQ(box.high, kZero);
    EXPECT_EQ(BrickId{}, (BrickId{0, 0, 0}));
    EXPECT_EQ(ChunkKey{}, (ChunkKey{0, 0, 0, 0}));
    for (const ValueType type : {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32})
        EXPECT_EQ(withValueType(type, [](auto v) { return sizeof v; }), bytesPerValue(type));
}

// A brick is four cells of eight voxels, and one sample at the coarsest level; chunks are as many samples.
TEST(PlainValues, OfLevelsHalveABrickToOneSample) {
    EXPECT_EQ(kBrickExtent, 32);
    EXPECT_EQ(kChunkExtent, 32);
    EXPECT_EQ(kCellExtent * kCellsPerBrick, kBrickExtent);
    EXPECT_EQ(kCellsPerBrick, 4);
    EXPECT_EQ(kBrickExtent >> (kLevelCount - 1), 1);
    const glm::ivec3 extent(67, 33, 1);
    EXPECT_EQ(brickGrid(extent), glm::ivec3(3, 2, 1));
    EXPECT_EQ(cellGrid(extent), glm::ivec3(9, 5, 1));
    const glm::ivec3 levels[] = {{67, 33, 1}, {34, 17, 1}, {17, 9, 1}, {9, 5, 1}, {5, 3, 1}, {3, 2, 1}};
    for (int level = 0; level < kLevelCount; ++level) {
        EXPECT_EQ(levelExtent(extent, level), levels[level]) << level;
        EXPECT_EQ(chunkGrid(extent, level), (levels[level] + glm::ivec3(31)) / glm::ivec3(32)) << level;
    }
    const glm::ivec3 grid(3, 5, 7);
    std::size_t n = 0;
    for (int z = 0; z < 7; ++z)
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 3; ++x, ++n) {
                EXPECT_EQ(linearIndex({x, y, z}, grid), n);
                EXPECT_EQ(gridPosition(n, grid), glm::ivec3(x, y, z));
            }
    EXPECT_EQ(cellCount(grid), n);
    const glm::ivec3 far(2000000, 2000000, 2000000); // beyond 32 bits
    EXPECT_EQ(linearIndex({1, 2, 3}, far), (3ull * 2000000 + 2) * 2000000 + 1);
}

/// Every count of a work, those of paths last.
std::vector<std::uint64_t> countsOf(const Work& w) {
    return {w.iterations,    w.segments,       w.samples,
            w.fetches,       w.blended,        w.paths.paths,
            w.paths.bounces, w.paths.lookUps,  w.paths.nullCollisions,
            w.paths.cells,   w.paths.exceeded, w.paths.alone};
}

TEST(PlainValues, OfWorkAreNothingAndAddUp) {
    EXPECT_EQ(countsOf(Work()), std::vector<std::uint64_t>(12, 0));
    EXPECT_EQ(Work().dispatches + Work().bricksUploaded + Work().bytesUploaded, 0u);
    EXPECT_EQ(Work().longestDispatchMs, 0);
    EXPECT_EQ(Work().marchMs, 0);
    Work a, b;
    a.iterations = 1, a.segments = 2, a.samples = 3, a.fetches = 4, a.blended = 5;
    a.paths = {6, 7, 8, 9, 10, 11, 12};
    b.iterations = 100, b.segments = 200, b.samples = 300, b.fetches = 400, b.blended = 500;
    b.paths = {600, 700, 800, 900, 1000, 1100, 1200};
    a += b;
    for (std::size_t n = 0; n < 12; ++n)
        EXPECT_EQ(countsOf(a)[n], 101 * (n + 1)) << n;
}

TEST(PlainValues, OfCamerasAndPlanes) {
    const Camera camera;
    EXPECT_EQ(camera.position, glm::dvec3(0, -1000, 0)) << "in front of the patient";
    EXPECT_EQ(camera.focalPoint, kZero);
    EXPECT_EQ(camera.viewUp, kUpwards);
    EXPECT_EQ(camera.viewAngle, 30);
    EXPECT_EQ(camera.parallelScale, 100);
    EXPECT_EQ(ViewAngles{}, (ViewAngles{0, 0}));
    EXPECT_EQ(PatientRay().minT, 0);
    EXPECT_TRUE(RayPlane().perspective);
    EXPECT_EQ(FittedView().mmPerPixel, 0) << "fitted";
    EXPECT_EQ(FittedView().fit, Fit::shown);
    EXPECT_EQ(FittedView().view, View::anterior);
    EXPECT_FALSE(FittedView().named);
    EXPECT_EQ(CropBox{}, (CropBox{kZero, kZero, CropBox::Space::patient, Keep::inside}));
    EXPECT_EQ(CutPlane{}, (CutPlane{kZero, kUpwards, Keep::inside}));
    EXPECT_EQ(Scissors().aspect, 1);
    EXPECT_FALSE(Cuts().any());
    EXPECT_EQ(SlicePlane().normal, kUpwards);
    EXPECT_EQ(SlicePlane().point, kZero);
    EXPECT_EQ(SlicePlane().thicknessMm, 0) << "the plane alone";
    EXPECT_EQ(SlicePlane().reduction, Reduction::average);
    EXPECT_EQ(SlicePlane().orientation, Orientation::axial);
    const SlicePose pose;
    EXPECT_EQ(pose.normal, kUpwards);
    EXPECT_EQ(glm::cross(pose.right, pose.up), pose.normal);
    EXPECT_EQ(GreyWindow{}, (GreyWindow{0, 1}));
    EXPECT_EQ(GreyWindow{}.low(), -0.5);
    EXPECT_EQ(GreyWindow{}.high(), 0.5);
    EXPECT_EQ(ScaleBar().mm, 1);
    EXPECT_EQ(ScaleBar().pixels, 1);
    EXPECT_TRUE(ScaleBar().everywhere);
    EXPECT_EQ(LegendBar().low, 0);
    EXPECT_EQ(LegendBar().high, 1);
}

TEST(PlainValues, OfLightAreWhatScenesMeanWithoutThem) {
    const Light light;
    EXPECT_EQ(light.direction, kUpwards);
    EXPECT_EQ(light.position, kZero);
    EXPECT_EQ(light.attenuation, glm::dvec3(1, 0, 0)) << "none";
    EXPECT_EQ(light.colour, kOne);
    EXPECT_EQ(light.softness, 0);
    EXPECT_EQ(light.scatter, 0);
    EXPECT_FALSE(light.shadow);
    EXPECT_EQ(Occlusion{}, (Occlusion{OcclusionMethod::local, 32, 16, 0, 0.1, 0.6, 0, 0}));
    EXPECT_EQ(SurfaceOcclusion{}, (SurfaceOcclusion{16, 16, true}));
    EXPECT_EQ(Lighting().scatterRadiusMm, 2);
    EXPECT_EQ(Lighting().finestLevel, 0);
    EXPECT_EQ(Phase{}, (Phase{PhaseKind::henyeyGreenstein, 0, 0, 0})) << "evenly";
    const Environment sky;
    EXPECT_EQ(sky.intensity, 1);
    EXPECT_EQ(sky.colour, kOne);
    EXPECT_EQ(sky.below, glm::dvec3(0.25));
    EXPECT_EQ(sky.up, kUpwards);
    EXPECT_EQ(sky.rotation, 0);
    EXPECT_EQ(GradientWeight{}, (GradientWeight{0, 0}));
    EXPECT_EQ(SurfaceFinish{}, (SurfaceFinish{0.028, 0.35, 0, 10}));
    EXPECT_EQ(Transport().bounces, 8);
    EXPECT_EQ(Tissue{}, (Tissue{0, 0, {}, {}}));
    EXPECT_EQ(MaterialResponse{}, (MaterialResponse{0.2, 0.8, 0.25, 20}));
    EXPECT_EQ(Material{}, (Material{0, 0, 0.2, 0.8, 0.25, 20, kZero}));
    EXPECT_EQ(Shading().ambient, 0.2);
    EXPECT_EQ(Shading().diffuse, 0.8);
    EXPECT_EQ(Shading().specular, 0.25);
    EXPECT_EQ(Shading().specularPower, 20);
    EXPECT_TRUE(Shading().on);
    EXPECT_EQ(Isosurface{}, (Isosurface{0, kOne, 1, {}}));
    EXPECT_EQ(GradientPoint{}, (GradientPoint{0, 1}));
    EXPECT_EQ(OpacityPoint{}, (OpacityPoint{0, 0}));
    EXPECT_EQ(ColourPoint{}, (ColourPoint{0, kOne}));
    EXPECT_EQ(TransferFunction().referenceLengthMm(), 1);
    EXPECT_EQ(SurfaceValue().value, 0);
    EXPECT_EQ(SurfaceValue().opacity, 1);
    EXPECT_EQ(SurfaceValue().colour, glm::vec3(1));
    EXPECT_EQ(TransferTable().relativeError, 0);
}

TEST(PlainValues, OfScenesAreOneRayAPixelOnBlack) {
    const Scene scene;
    EXPECT_EQ(scene.imageSize, glm::ivec2(512));
    EXPECT_EQ(scene.background, glm::vec3(0));
    EXPECT_EQ(scene.quality.stepVoxels, 0.5);
    EXPECT_EQ(scene.quality.terminationTransmittance, 1.0 / 510);
    EXPECT_TRUE(scene.quality.skipping);
    EXPECT_FALSE(scene.quality.automaticStep);
    EXPECT_FALSE(scene.quality.maxError);
    const PixelSampling& pixels = scene.quality.pixels;
    EXPECT_EQ(pixels.samples, 1);
    EXPECT_EQ(pixels.seed, 0u);
    EXPECT_EQ(pixels.noise, 0);
    EXPECT_FALSE(pixels.denoise || pixels.named);
    const SceneVolume volume;
    EXPECT_EQ(volume.opacity, 1);
    EXPECT_EQ(volume.transform, glm::dmat4(1));
    EXPECT_EQ(std::get<std::string>(volume.transferFunction), "bone-1");
    EXPECT_EQ(volume.labels.outline, 1);
    EXPECT_EQ(volume.source.series, 0);
    EXPECT_EQ(volume.source.phase, 0);
    const SceneMesh mesh;
    EXPECT_EQ(mesh.lineRadiusMm, 0.5);
    EXPECT_EQ(mesh.surfaceStepMm, 0);
    EXPECT_EQ(mesh.surfaceGapMm, 0);
    EXPECT_EQ(mesh.opacity, 1);
    EXPECT_EQ(Tube().radiusMm, 1);
    EXPECT_TRUE(mesh.isDrawn());
    const ValueSummary values;
    EXPECT_EQ(values.lowest, 0);
    EXPECT_EQ(values.highest, 0);
    EXPECT_EQ(values.spacingMm, 1);
}

TEST(PlainValues, OfPathsAndPicturesAreNothing) {
    const CentreLine line;
    EXPECT_EQ(line.spacingMm, 0);
    EXPECT_EQ(line.leavesAtMm, 0);
    EXPECT_EQ(Lumen{}, (Lumen{0, Lumen::Side::below, 0, false}));
    EXPECT_EQ(PathVolume().extentVoxels, glm::ivec3(0));
    EXPECT_EQ(LookAround{}, (LookAround{0, 0, {0, 0}}));
    EXPECT_EQ(Keyframe().easing, Easing::through);
    EXPECT_EQ(RoutePoint().at, kZero);
    EXPECT_EQ(RoutePoint().radiusMm + RoutePoint().alongMm, 0);
    EXPECT_EQ(LinesExtent().lengthMm + LinesExtent().narrowestMm + LinesExtent().widestMm, 0);
    const Pose pose;
    EXPECT_EQ(pose.at, kZero);
    EXPECT_EQ(pose.direction, kUpwards);
    EXPECT_EQ(pose.up, glm::dvec3(0, 1, 0));
    EXPECT_EQ(pose.freeMm, 0);
    const UnseenPatch patch;
    EXPECT_EQ(patch.middleMm, kZero);
    EXPECT_EQ(patch.areaMm2 + patch.alongMm + patch.fromMm + patch.toMm, 0);
    EXPECT_EQ(WallCoverage().wallMm2 + WallCoverage().seenMm2, 0);
    EXPECT_EQ(Image().size, glm::ivec2(0));
    EXPECT_EQ(LayerChannel().stride, 1u);
    const ImageDifference none;
    EXPECT_EQ(none.rms + none.maxAbs + none.bias + none.luvMean + none.luvP99, 0);
    EXPECT_EQ(none.maskedPixels + none.valuesAbove004 + none.valuesAbove012 + none.values + none.nonFinite,
              0u);
}

// A picture measured against a truth that shows nothing: no error, no pixel, and as alike as can be.
TEST(PlainValues, OfErrorsAgainstNothing) {
    const Image empty(glm::ivec2(7, 5));
    const ImageError error = measureError(empty, empty);
    EXPECT_EQ(error.maskedPixels + error.nanCount, 0u);
    EXPECT_EQ(error.rmse + error.bias + error.maxAbs + error.p999 + error.fracAbove1Of255 + error.luvMean +
                  error.luvP99,
              0);
    EXPECT_EQ(error.ssim, 1);
    const ImageError unmeasured;
    EXPECT_EQ(unmeasured.psnr, 0);
    EXPECT_EQ(unmeasured.ssim, 1);
    EXPECT_EQ(unmeasured.maskedPixels + unmeasured.nanCount, 0u);
}

} // namespace
} // namespace tessera
