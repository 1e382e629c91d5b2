// core/scene/scene_fields.cpp: the keys of a scene, of its volume, its slice, its quality and its image: see
// scene_fields.h.
#include "core/scene/scene_fields.h"

#include "core/base/error.h"
#include "core/base/magnitude.h"

#include <cmath>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr int kMostInt = std::numeric_limits<int>::max();
constexpr double kLeastScaling = 1e-6; // of a transform: the volume of a voxel
constexpr double kLeastNoise = 1e-6;   // of a picture: below the rounding of its floats

/// The first three rows, one after another.
Kind<glm::dmat4> affineKind() {
    constexpr std::size_t kRows = 3, kColumns = 4;
    return {[](const JsonValue& value) {
                const std::vector<double> numbers = value.numbers(kRows * kColumns);
                glm::dmat4 matrix(1);
                for (std::size_t n = 0; n < numbers.size(); ++n)
                    matrix[static_cast<int>(n % kColumns)][static_cast<int>(n / kColumns)] = numbers[n];
                const double volume = std::abs(glm::determinant(glm::dmat3(matrix)));
                if (!(volume >= kLeastScaling && volume <= 1 / kLeastScaling))
                    value.refuse("12 numbers of a matrix that can be inverted");
                return matrix;
            },
            [](const glm::dmat4& matrix) {
                nlohmann::json numbers = nlohmann::json::array();
                for (std::size_t n = 0; n < kRows * kColumns; ++n)
                    numbers.push_back(matrix[static_cast<int>(n % kColumns)][static_cast<int>(n / kColumns)]);
                return numbers;
            },
            [](Schema&) {
                return Schema{{"type", "array"},
                              {"items", {{"type", "number"}}},
                              {"minItems", kRows * kColumns},
                              {"maxItems", kRows * kColumns}};
            }};
}

const Fields<SceneVolume>& volumeFields() {
    static const Fields<SceneVolume> fields = [] {
        Fields<SceneVolume> f("volume");
        f.add("path", &SceneVolume::path,
              anyText()
                  .checked([](const std::string& path, const JsonValue& value) {
                      if (path.empty())
                          value.refuse("the path of a store or source");
                  })
                  .described({{"minLength", 1}}),
              "Path of a store or of source files, relative to the scene's file.")
            .required();
        f.add(
             "unit", &SceneVolume::unit, unitKind(),
             "Unit of the values where the volume does not state it (NIfTI cannot); empty: the volume's own.")
            .setBy("--unit",
                   "HU: the values of the first volume are in HU, though the file cannot say so (NIfTI)");
        f.add(
             "hideTable", &SceneVolume::hideTable, named<HideTable>(),
             "The table under the patient: auto leaves it out of pictures but slices, where values are in HU "
             "and a table is found.")
            .unlessDefault()
            .setBy("--hide-table",
                   "the table under the patient, in every volume: {names}; auto leaves it out where one is "
                   "found, but of slices (default: auto; no with a scene that does not say)");
        // Written only where something was chosen: a store has nothing to choose.
        const auto source = [&](const char* key, int SourceChoice::*member, const char* about) {
            f.add(
                 key, [=](auto& v) -> auto& { return v.source.*member; }, wholeIn(1, kMostInt), about)
                .writtenIf([=](const SceneVolume& v) { return v.source.*member > 0; });
        };
        const auto choice = [&](const char* key, bool SourceChoice::*member, const char* about) {
            f.add(
                 key, [=](auto& v) -> auto& { return v.source.*member; }, trueOrFalse(), about)
                .unlessDefault();
        };
        source("series", &SourceChoice::series,
               "Source files: number of the DICOM series, channel or grid, as listed.");
        source("phase", &SourceChoice::phase,
               "Source files: number of the phase or time, where a series or a file has several images at "
               "each position.");
        choice("largest", &SourceChoice::largest,
               "Source files: the largest CT of a folder with several volumes.");
        choice("resampleZ", &SourceChoice::resampleZ,
               "Source files: uneven slices are interpolated to even spacing.");
        choice("allowMissing", &SourceChoice::allowMissing,
               "Source files: files that could be slices and cannot be read are left out.");
        f.add(
             "spacing", [](auto& v) -> auto& { return v.source.spacingMm; },
             numbersWithin<glm::dvec3>(1e-6, 1e6, "[x, y, z], mm from 1e-6 to 1e6", &glm::dvec3::x,
                                       &glm::dvec3::y, &glm::dvec3::z),
             "Source files that do not say it: distances of voxels along the file's axes, mm.")
            .unlessDefault();
        f.add(
             "fileLevel", [](auto& v) -> auto& { return v.source.fileLevel; }, fileLevelKind(),
             "Source files that have the volume at several resolutions: the level that is the volume, 0 the "
             "finest; auto: the finest that the cache of imports has room for.")
            .unlessDefault();
        f.add(
             "fileBox", [](auto& v) -> auto& { return v.source.fileBox; }, fileBoxKind(),
             "Source files: the box of that level that is the volume, [x0, x1, y0, y1, z0, z1] in its voxels "
             "along the volume's axes, half open.")
            .unlessDefault();
        f.add(
            "transferFunction", &SceneVolume::transferFunction, transferKind(),
            "The name of a preset (auto, bone, lung, skin, soft-tissue, vessels and others), or the points.");
        f.add("labels", &SceneVolume::labels, objectOf(labelsFields())).unlessDefault();
        f.add("opacity", &SceneVolume::opacity, numberIn(0, 1),
              "Times the extinction; in modes of single values, opacity over the volumes before.")
            .unlessDefault();
        f.add("transform", &SceneVolume::transform, affineKind(),
              "Moves the volume: the first three rows, one after another, of the matrix from the file's "
              "patient space (LPS, mm) to that of the picture.")
            .unlessDefault();
        f.add("cuts", &SceneVolume::cuts, objectOf(cutsFields()),
              "Cuts through this volume alone, besides those of the scene; scissors where each volume "
              "is drawn alone.")
            .unlessDefault();
        f.add("window", &SceneVolume::window, windowKind(),
              "Grey of this volume's values in modes that show single values; without it: the scene's.")
            .unlessDefault();
        f.add("valueColour", &SceneVolume::valueColour, named<ValueColour>(),
              "Colour of this volume's single values; without it: the scene's.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

const Fields<Isosurface>& surfaceFields() {
    static const Fields<Isosurface> fields = [] {
        Fields<Isosurface> f("isosurface");
        f.add("value", &Isosurface::value, anyNumber().checked([](double value, const JsonValue& where) {
             checkValue(value, "a value", where.place());
         }),
              "In physical units.")
            .required();
        f.add("opacity", &Isosurface::opacity, numberIn(0, 1), "Opacity of the surface.");
        f.add("rgb", &Isosurface::colour, colourKind(), "Colour, linear light.");
        f.add("finish", &Isosurface::finish, objectOf(finishFields()));
        f.add("reflection", &Isosurface::reflection, objectOf(reflectionFields()));
        return f;
    }();
    return fields;
}

const Fields<SlicePlane>& sliceFields() {
    static const Fields<SlicePlane> fields = [] {
        Fields<SlicePlane> f(
            "slice",
            "A plane, or a slab around it. Without a camera it is seen along its normal, in parallel "
            "projection: axial from the feet, coronal from the front, sagittal from the patient's left.");
        const auto isOblique = [](const SlicePlane& s) { return s.orientation == Orientation::oblique; };
        const auto ofOblique = [=](const std::string& key, bool oblique) {
            return [=](const SlicePlane& slice, const JsonValue& whole) {
                if (isOblique(slice) != oblique)
                    throw badFile(whole.place(),
                                  oblique ? "\"position\"" : "\"point\" and \"normal\" of an oblique plane",
                                  "\"" + key + "\"");
            };
        };
        f.add("plane", &SlicePlane::orientation, named<Orientation>(), "Orientation of the plane.");
        f.add("position", &SlicePlane::positionMm, anyNumber(),
              "Position along the plane's axis, mm: z (axial), y (coronal), x (sagittal). Without it: the "
              "volume's middle.")
            .allowedBy(ofOblique("position", false))
            .writtenIf(std::not_fn(isOblique));
        f.add("point", &SlicePlane::point, vectorKind(), "A point of an oblique plane.")
            .allowedBy(ofOblique("point", true))
            .writtenIf(isOblique);
        f.add("normal", &SlicePlane::normal, vectorKind(), "Normal of an oblique plane, towards the viewer.")
            .allowedBy(ofOblique("normal", true))
            .writtenIf(isOblique);
        f.add("thickness", &SlicePlane::thicknessMm, anyNumber().described({{"minimum", 0}}),
              "Thickness of the slab, mm; 0: a plane.")
            .unlessDefault();
        f.add("reduction", &SlicePlane::reduction, named<Reduction>(),
              "Reduction over a slab (default: average).")
            .writtenIf([](const SlicePlane& slice) { return slice.thicknessMm > 0; });
        f.rule([=](const JsonValue& whole, const SlicePlane& slice) {
            for (const char* key : {"point", "normal"})
                if (isOblique(slice) && !whole.has(key))
                    whole.at(key); // throws that it is missing
            checkSlice(slice, whole.place());
        });
        return f;
    }();
    return fields;
}

const Fields<Hulls>& hullFields() {
    static const Fields<Hulls> fields = [] {
        Fields<Hulls> f("hulls");
        f.add("count", &Hulls::count, numberOrAuto(Hulls::kMost),
              "Parts of the volume; auto: 4 where lights cast shadows, else 1.");
        f.add("samples", &Hulls::samples, numberOrAuto(Hulls::kMostSamples),
              "Samples of a ray in each part; auto: as many as an error within 1/255 needs.");
        return f;
    }();
    return fields;
}

Quality qualityOfNoWord() {
    Quality quality;
    quality.automaticStep = true;
    return quality;
}

const Fields<Quality>& qualityFields() {
    static const Fields<Quality> fields = [] {
        Fields<Quality> f("quality", {}, qualityOfNoWord());
        // 1/64 voxel: finer ones come near to what float positions along a ray can tell apart
        Field<Quality>& step = f.add("stepVoxels", &Quality::stepVoxels, numberIn(1.0 / 64, 16),
                                     "Distance between samples along a ray at the finest level, voxels. "
                                     "Without it: the longest of 2, 1, 1/2, ... 1/16 whose estimated error "
                                     "is within 1/255. With maxError the step is chosen for that error.")
                                   .writtenIf([](const Quality& q) { return !q.automaticStep; })
                                   .setBy("--step",
                                          "distance of samples at the finest level, voxels (default: the "
                                          "longest with an estimated error within 1/255)",
                                          "voxels from 1/64 to 16");
        step.read = [read = step.read](const JsonValue& value, Quality& quality) {
            read(value, quality);
            quality.automaticStep = false;
        };
        f.add("integrator", &Quality::integrator, named<Integrator>(),
              "Integration of a ray's segment; auto: by the sharpness of the transfer function.")
            .setBy("--integrator",
                   "integration of a ray's segment: {names} (default: {default}, by the transfer function)");
        f.add("fetch", &Quality::fetch, named<Fetch>(),
              "hardware: filtered texture fetches; exact: float arithmetic.")
            .setBy("--fetch", "{names}");
        f.add("edgeFunction", &Quality::edgeFunction, named<EdgeFunction>(),
              "Blending between bricks of different levels: none, over the smaller half sample, over each "
              "side's own, over the larger.")
            .setBy("--edge-function",
                   "blending between bricks of different levels: {names} (default: {default})");
        f.add("sampling", &Quality::sampling, named<Sampling>(),
              "Sampling in coarse bricks. full: at the finest step; limited: as fine as the finest brick "
              "with weight there needs; naive: as fine as the current brick needs; hulls: as many samples in "
              "each of some parts between planes parallel to the picture.")
            .setBy("--sampling", "step in coarse bricks: {names} (default: {default})");
        f.add("hulls", &Quality::hulls, objectOf(hullFields()), "Sampling hulls, of sampling \"hulls\".")
            .writtenIf([](const Quality& q) { return q.sampling == Sampling::hulls; });
        f.add("maxError", &Quality::maxError, numberFrom(0),
              "Bound of the predicted error (CIE L*u*v*, 99th percentile over pixels), met in as many passes "
              "as the budget needs. 0: the finest level that a pixel can show. Without it: the best picture "
              "within one pass.")
            .setBy("--max-error",
                   "error bound (L*u*v*, 99th percentile; measured, or with --verify none predicted), met at "
                   "least cost in as many passes as the budget needs; 0: the finest levels that a pixel can "
                   "show (default: the best picture of one pass)",
                   "a number from 0 on");
        f.add("terminationTransmittance", &Quality::terminationTransmittance, numberIn(0, 0.5),
              "Transmittance below which a ray stops; 0: never.");
        f.add("skipping", &Quality::skipping, trueOrFalse(),
              "Empty-space skipping; the picture is the same, unless automatic samples take other rays.")
            .setBy("--no-skipping", "disable empty-space skipping; slower, and may change --samples auto, "
                                    "else the same picture");
        Field<Quality>& samples =
            f.add(
                 "samples", [](auto& q) -> auto& { return q.pixels.samples; },
                 numberOrAuto(PixelSampling::kMost),
                 "Rays per pixel, whose mean the pixel shows. 1: one through its centre; auto: more where "
                 "the pixel needs them, up to 64 (default: 1).")
                .setBy("--samples",
                       "rays per pixel, 1 to " + std::to_string(PixelSampling::kMost) +
                           ", whose mean it shows, or auto: more where they are needed; 1: one through its "
                           "centre (default: auto; 1 with --engine {single-ray engines})")
                .writtenIf([](const Quality& q) {
                    return q.pixels.named || q.pixels.samples != PixelSampling{}.samples;
                });
        samples.read = [read = samples.read](const JsonValue& value, Quality& quality) {
            read(value, quality);
            quality.pixels.named = true;
        };
        f.add(
             "noise", [](auto& q) -> auto& { return q.pixels.noise; }, numberIn(kLeastNoise, 1),
             "Samples double until the standard error of the picture (rms, linear light) is at most this, or "
             "until there are as many as samples says (default: as many as samples says).")
            .unlessDefault()
            .setBy("--noise",
                   "samples double until the picture's standard error is at most this (rms, linear "
                   "light), at most --samples, or 4096 without it");
        f.add(
             "denoise", [](auto& q) -> auto& { return q.pixels.denoise; }, trueOrFalse(),
             "Paths of light (lighting.transport): a filter takes noise out of the picture. It has a bias, "
             "which measured errors count.")
            .unlessDefault()
            .setBy("--denoise", "paths of light: a filter takes noise out of the picture; measured errors "
                                "count what it blurs");
        f.add(
             "pixelFilter", [](auto& q) -> auto& { return q.pixels.filter; }, named<PixelFilter>(),
             "Filter of a pixel with several samples: its own area, or a Gaussian with a standard deviation "
             "of half a pixel.")
            .unlessDefault()
            .setBy("--pixel-filter", "filter of a pixel with several samples, its area or a wider Gaussian: "
                                     "{names} (default: {default})");
        f.add(
             "seed", [](auto& q) -> auto& { return q.pixels.seed; }, wholeIn(0, kMostInt),
             "Seed of the positions of samples in a pixel.")
            .unlessDefault()
            .setBy("--seed", "seed of the positions of samples in a pixel (default: {default})");
        f.rule([](const JsonValue& whole, const Quality& q) {
            for (const auto& [key, isAsked] :
                 {std::pair("noise", q.pixels.noise > 0), std::pair("denoise", q.pixels.denoise)})
                if (isAsked && q.pixels.named && q.pixels.samples == 1)
                    whole.refuse(std::string("\"samples\" from 2 on beside \"") + key + "\"");
        });
        return f;
    }();
    return fields;
}

const Fields<Scene>& imageFields() {
    static const Fields<Scene> fields = [] {
        Fields<Scene> f("image");
        f.add("size", &Scene::imageSize, sizeKind(), "[width, height] in pixels.")
            .setBy("--size", "size in pixels, WIDTHxHEIGHT (default: 512x512)");
        f.add("background", &Scene::background, backgroundKind(),
              "transparent, a CSS colour name (red, grey), an sRGB colour, or linear [r, g, b].")
            .setBy("--background", "a colour (black, red, #rrggbb), or transparent (default: black)");
        return f;
    }();
    return fields;
}

Scene sceneOfNoWord() {
    Scene scene;
    scene.quality = qualityOfNoWord();
    return scene;
}

/// A slice without a named camera is seen along its normal.
nlohmann::json cameraJson(const Scene& scene) {
    const auto* const view = std::get_if<FittedView>(&scene.camera);
    if (!(scene.mode == Mode::slice && view && !view->named))
        return cameraKind().write(scene.camera);
    if (view->mmPerPixel > 0)
        return {{"parallelProjection", true}, {"mmPerPixel", view->mmPerPixel}};
    return {};
}

} // namespace

const Fields<Scene>& sceneFields() {
    static const Fields<Scene> fields = [] {
        Fields<Scene> f("scene", {}, sceneOfNoWord());
        f.add({"tesseraScene", "Version of this format.",
               [](const JsonValue& value, Scene&) { value.integer(Scene::kVersion, Scene::kVersion); },
               [](const Scene&) { return nlohmann::json(Scene::kVersion); },
               [](Schema&) {
                   return Schema{{"const", Scene::kVersion}};
               }})
            .required();
        f.add("volumes", &Scene::volumes,
              listOf(objectOf(volumeFields()), 1, Scene::kMaxVolumes,
                     "a list of 1 to " + std::to_string(Scene::kMaxVolumes) + " volumes"),
              "Volumes to draw, each at its place in patient space.")
            .required();
        f.add("fusion", &Scene::fusion, named<Fusion>(),
              "Several volumes at one place: mix adds extinctions and mixes colours by their shares; over "
              "lays each volume over those before it; maximum takes the greatest of every component.")
            .unlessDefault()
            .setBy("--fusion", "several volumes at one place: {names} (default: {default})");
        f.add(
             "camera", &Scene::camera, cameraKind(),
             "A side of the patient, fitted to what is shown or to the volume, or a camera in patient space. "
             "Without it: anterior.")
            .write = cameraJson;
        f.add("shading", &Scene::shading, objectOf(shadingFields()));
        f.add("lighting", &Scene::lighting, objectOf(lightingFields())).unlessDefault();
        f.add("isosurfaces", &Scene::surfaces,
              listOf(objectOf(surfaceFields()), Scene::kMaxSurfaces, "isosurfaces"),
              "Surfaces of one value each, drawn in one pass with the volume and lit like it.");
        f.add("meshes", &Scene::meshes, listOf(objectOf(meshFields()), SceneMesh::kMost, "meshes"),
              "Surfaces besides the volume, drawn in one picture with it and lit like it; modes that show "
              "single values leave them out.")
            .unlessDefault();
        f.add("mode", &Scene::mode, named<Mode>(),
              "Kind of picture: compositing by the transfer function; the maximum, minimum or mean value "
              "along rays; the isosurfaces alone; the values of a plane; light that all tissue sends, or "
              "takes, where nothing hides anything; or a radiograph.")
            .unlessDefault()
            .setBy("--mode", "what a ray shows: {names} (default: {default})");
        f.add("window", &Scene::window, windowKind(),
              "Grey of a value in modes that show single values, as [centre, width] or by name. Black is at "
              "centre - width/2, white at centre + width/2. auto, where values are in HU: abdomen, in mode "
              "maximum 350, 1100; else all values but fill values and a few of the highest. Of a radiograph "
              "mm of water, of mode emission the light "
              "summed along a ray; auto: from 0 to the greatest of some rays.")
            .unlessDefault()
            .setBy("--window",
                   "grey of single values, CENTRE,WIDTH or {names} (default: {default}: abdomen for "
                   "HU, in mode maximum 350,1100; else all values but few outliers)");
        f.add("valueColour", &Scene::valueColour, named<ValueColour>(),
              "Colour of a single value: the window's grey, the transfer function's colour, or a grey from "
              "white to black over the window.")
            .unlessDefault()
            .setBy("--value-colour",
                   "colour of a single value: the window's grey, the preset's colour or grey "
                   "from white to black: {names} (default: {default})");
        f.add("slice", &Scene::slice, objectOf(sliceFields())).writtenIf([](const Scene& scene) {
            return scene.mode == Mode::slice || !(scene.slice == SlicePlane{});
        });
        f.add("cuts", &Scene::cuts, objectOf(cutsFields())).unlessDefault();
        f.add("measurements", &Scene::measurements,
              listOf(objectOf(measurementFields()), 0, kMaxMeasurements,
                     "a list of at most 1000 measurements"),
              "Lengths, angles and circles between points; windows draw them, and pictures with "
              "annotations.measurements.")
            .unlessDefault();
        f.add("annotations", &Scene::annotations, objectOf(annotationFields())).unlessDefault();
        f.add("quality", &Scene::quality, objectOf(qualityFields()));
        f.part("image", imageFields());
        return f;
    }();
    return fields;
}

} // namespace tessera
