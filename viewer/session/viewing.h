// viewer/session/viewing.h: Viewing, the interface between a window and a volume: requests and results.
// Windows do not depend on engines, stores and threads.
#pragma once

#include "core/animation/path.h"
#include "core/base/coverage.h"
#include "core/base/shown_text.h"
#include "core/base/volume.h"
#include "core/image/image.h"
#include "core/scene/colour_legend.h"
#include "core/scene/preset.h" // ValueSummary
#include "core/scene/scene.h"
#include "viewer/annotations/figure.h"
#include "viewer/session/figure_of_stills.h"
#include "viewer/session/label_list.h"
#include "viewer/session/view_geometry.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// The choice among several volumes at a path.
struct VolumePick {
    int series = 0, phase = 0; // 0: none chosen
    bool resampleZ = false, allowMissing = false;
    bool asVolume = false;   // not as labels of the open volume, which the file may be as well
    bool inSameView = false; // the phase alone is another: of the open volume, whose scene stays
    bool operator==(const VolumePick&) const = default;
};

/// One of several volumes of a folder.
struct VolumeOffer {
    std::filesystem::path path;      // to open,
    VolumePick pick;                 // with this
    std::string title, about;        // "series 2, CT"; slices, voxels, kernel
    std::string problem;             // reason if it cannot be opened; else empty
    std::vector<std::string> phases; // labels, if a phase must be chosen: pick.phase counts from 1
};
struct VolumeOffers {
    std::filesystem::path path; // path that was requested
    std::vector<VolumeOffer> offers;
    std::string passedOver; // files in no volume, counted by reason; empty: none
};

/// A small picture of an offer, in display values.
struct Thumbnail {
    glm::ivec2 size{0};
    std::vector<std::uint32_t> display;
};

/// The quality of a picture.
enum class Stage {
    moving,  // fewer pixels, longer steps: during motion
    loading, // all pixels; bricks are still loading, or light is being refined
    whole,   // all pixels, through their centres, with chosen levels and all light
    round,   // where light follows paths: the still with a part of its samples
    still    // the picture of `tessera render`
};

/// Samples of a picture of paths of light.
struct SamplesSeen {
    int taken = 0, asked = 0;    // of a pixel
    std::optional<double> noise; // rms standard error, linear light; none: one sample tells none
};

/// The scene as its still is drawn and as it is saved: where light follows paths, pixels do not choose the
/// number of their samples.
inline Scene asStill(Scene scene) {
    PixelSampling& pixels = scene.quality.pixels;
    pixels.denoise = pixels.denoise && scene.lighting.transport;
    if (scene.lighting.transport && reductionOf(scene) == Reduction::composite &&
        pixels.samples == PixelSampling::kAutomatic)
        pixels.samples = pixels.noise > 0 ? PixelSampling::kMostForNoise : Transport::kSamples;
    return scene;
}

struct ShownPicture {
    Image image; // linear, premultiplied, without background; fewer pixels than the scene's during motion
    glm::ivec2 displaySize{0};
    /// The same on the scene's background, in the scene's size, by displayPixels().
    std::vector<std::uint32_t> display;
    std::optional<glm::vec3> background; // the scene's: linear; none: transparent
    Stage stage = Stage::moving;
    Camera camera;
    std::uint64_t asked = 0;            // the number of the request that it answers
    double drawingMs = 0;               // from its begin to its end
    std::string manifest;               // of a still, JSON; else empty
    std::optional<SamplesSeen> samples; // of rounds and stills where light follows paths
};

/// What is drawn into a saved picture; its manifest says so. Box, camera and background are the picture's.
using PictureMarks = FigurePart;

/// A point in the volume under a point of the picture.
struct PickedPlace {
    std::uint64_t number = 0; // of the question
    bool hit = false;
    glm::dvec3 mm{0};                       // patient space
    glm::dvec3 voxel{0};                    // level-0 voxels
    double value = 0;                       // physical units
    int level = 0;                          // of point and value: coarse if not 0
    std::vector<std::uint32_t> labels = {}; // values of the labels of the voxel there, level 0, ascending
    /// The mesh whose surface it is, which has no value; "": the volume.
    std::string mesh = {};
};

/// The values on the disc of a measured circle, physical units.
struct DiscValues {
    std::uint64_t number = 0; // of the question
    std::size_t samples = 0;  // 0: none, or they cannot be read
    double mean = 0, deviation = 0, least = 0, most = 0;
};
/// "mean 41.2 HU, deviation 8.1"; "" without samples.
inline std::string discText(const DiscValues& values, const std::string& unit) {
    return values.samples == 0
               ? ""
               : "mean " + valueText(values.mean, unit) + ", deviation " + numberText(values.deviation, 3);
}

struct VolumeSeen {
    VolumeInfo info;
    ValueSummary values;
    std::vector<LegendVolume> volumes = {}; // of the scene, that interactive pictures show
    /// Of all values but fill values.
    double lowest() const { return values.fills.empty() ? values.lowest : values.measured.lowest; }
    double highest() const { return values.fills.empty() ? values.highest : values.measured.highest; }
    /// Counts of values over equal bins of [lowest(), highest()], of a coarse level; 256 or fewer.
    std::vector<double> histogram;
    Scene scene; // as opened, with resolved camera and function
    /// If the scene's camera was by side: the view to which it was fitted.
    std::optional<FittedView> fitted;
    std::filesystem::path path;           // path as given
    std::vector<std::string> phases = {}; // labels of its source's phases; empty: it has one
    int phase = 0;                        // that is open, from 1
    /// Of the phase that is open; "": there is none.
    std::string phaseLabel() const {
        const auto number = static_cast<std::size_t>(phase);
        return phase > 0 && number <= phases.size() ? phases[number - 1] : std::string();
    }
    /// The labels of scene.volumes[0].labels, with their names under that scene; null: it has none.
    std::shared_ptr<const LabelList> labels;
    /// The file of the labels, if it may be a volume as well and was taken as labels for its lattice; ""
    /// else.
    std::filesystem::path eitherFile = {};
};

struct ViewingState {
    enum class Kind { nothing, opening, open, choosing, failed } kind = Kind::nothing;
    std::string what;    // opening: the stage; failed: the reason; choosing: the path
    double share = 0;    // opening: share done, [0,1]; 0: unknown
    std::string problem; // the last error of an open volume; empty: none
    std::string engine;  // engine and device
    std::size_t ramUsed = 0, ramLimit = 0, gpuUsed = 0, gpuLimit = 0;
    std::size_t bricks = 0, bricksShown = 0, bricksAsWanted = 0;
    std::uint64_t chunksThere = 0, chunksMissed = 0; // chunks requested from the cache so far
    std::size_t movesLeft = 0;
    bool choosing = false;
    bool lightIsCoarse = false;             // light per voxel is being refined
    int finestLevel = 0, coarsestLevel = 0; // of the drawn selection
    bool atRest = false;                    // nothing more will come without a request
    bool drawingStill = false;
    bool noStills = false; // for lack of RAM: pictures at rest have one ray per pixel, too
    /// Why pictures but stills show the first of several volumes alone, or labels without the functions of
    /// their own; empty: they show all.
    std::string firstAlone;
    std::string measured; // the still's measured error as a sentence; empty: none yet
    std::uint64_t pictures = 0;
    std::size_t damagedChunks = 0; // unreadable chunks, drawn from coarser levels
    std::uint64_t refused =
        0; // the number of the last request that cannot be drawn: `problem` has the reason
    /// If requested by showLevels(): the level of each brick, [z][y][x]; Selection's numbers.
    std::shared_ptr<const std::vector<std::uint8_t>> levels;
    glm::ivec3 brickGrid{0}; // of the grid
};

/// A request for a centre-line (bricking/analysis/lumen/centreline.h).
struct LineWish {
    std::vector<glm::dvec3> places;  // patient space, mm: beginning, points between, end
    std::optional<double> threshold; // physical units; none: from values around the points
    bool tree = false;               // all branches beyond the first and only point
    /// If set, the request is for the wall coverage of a flight along this line
    /// (bricking/analysis/lumen/wall_coverage.h).
    std::shared_ptr<const Path> seenAlong;
    double aspect = 4.0 / 3; // seenAlong: of its pictures, width / height
    bool bothWays = false;   // seenAlong: there and back
};

/// The result of the last request.
struct LineState {
    std::uint64_t number = 0; // number of its request; 0: none yet
    bool searching = false;
    std::string what;           // searching: the stage
    double share = 0;           // searching: share done, [0,1]; 0: unknown
    std::string problem, about; // sentences
    std::shared_ptr<const Path> path;
    std::shared_ptr<const WallCoverage> coverage;
};

class Viewing {
  public:
    virtual ~Viewing() = default;

    /// Opens a store, a scene, a folder or file; the open volume is closed once the new one is ready. If a
    /// choice is needed and none is given, offers() has the list, and the open volume stays.
    /// @param pictureSize  of the first pictures, pixels, in place of the scene's
    virtual void open(const std::filesystem::path& path, const glm::ivec2& pictureSize,
                      const VolumePick& pick = {}) = 0;
    /// The volumes of the last path, until another is opened; null: nothing to choose.
    virtual std::shared_ptr<const VolumeOffers> offers() const = 0;
    /// Of an offer, by its number; null: not ready, or none.
    virtual std::shared_ptr<const Thumbnail> thumbnail(std::size_t offer) const = 0;
    /// The last opened volume; null before. A new pointer for a new volume.
    virtual std::shared_ptr<const VolumeSeen> volume() const = 0;

    /// Sets the scene to draw. The latest request counts; earlier ones that were not drawn yet are dropped. A
    /// camera by side is fitted to what is shown, in the scene's picture size; the picture that answers has
    /// it.
    /// @param moving  more requests follow soon: pictures must be in time
    /// Returns the request's number.
    virtual std::uint64_t show(const Scene& scene, bool moving) = 0;
    /// The newest picture, null before the first. A new pointer for a new picture.
    virtual std::shared_ptr<const ShownPicture> picture() const = 0;
    virtual ViewingState state() const = 0;

    /// Sets whether state() has the level of every brick.
    virtual void showLevels(bool shown) = 0;

    /// Sets the three planes to draw; none is drawn before.
    virtual void showSlices(const SliceWish& wish) = 0;
    /// The newest, null before the first. A new pointer for new planes.
    virtual std::shared_ptr<const ShownSlices> slices() const = 0;

    /// Requests the point under a position on the picture, in pixels of the scene's picture. Returns the
    /// request's number.
    virtual std::uint64_t pick(const glm::dvec2& place) = 0;
    /// The last answer.
    virtual std::optional<PickedPlace> picked() const = 0;

    /// Requests the values in a circle. Returns the request's number; of several unanswered requests the last
    /// counts.
    virtual std::uint64_t askValues(const Measurement& circle) = 0;
    /// The last answer.
    virtual std::optional<DiscValues> discValues() const = 0;

    /// Requests a centre-line, or its coverage; an earlier search is cancelled. Stills wait meanwhile,
    /// because the search uses their memory. Returns the request's number.
    virtual std::uint64_t findLine(const LineWish& wish) = 0;
    virtual void callOffLine() = 0;
    virtual LineState line() const = 0;
    /// The next cameras, in order: bricks are prefetched.
    virtual void lookAhead(std::vector<Camera> next) = 0;

    /// Writes the newest picture with its manifest. Throws Error or InputError.
    /// @param beside  pictures of the same size at its right, panels of one figure
    virtual void saveScreenshot(const std::filesystem::path& path, const PictureMarks& marks,
                                const std::vector<SavedPanel>& beside = {}) const = 0;
    /// Draws the still of a scene, of any picture size, in the background, and writes it with its manifest.
    /// Of several requests before it is written the last counts. takeNotice() or state() report the outcome.
    /// @param scene  of the open volume, with a resolved camera
    /// @param panel  of a figure, which is written instead of the still once all its stills are there
    virtual void saveStill(const Scene& scene, const std::filesystem::path& path, const PictureMarks& marks,
                           PanelOfStills panel = {}) = 0;
    /// A sentence on finished work, once; empty: nothing new.
    virtual std::string takeNotice() = 0;
    /// Clears the problem in state().
    virtual void problemSeen() = 0;
};

} // namespace tessera
