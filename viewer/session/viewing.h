// viewer/session/viewing.h: Viewing, the interface between a window and a volume: requests and results.
// Windows need nothing of engines, stores and threads.
#pragma once

#include "core/animation/path.h"
#include "core/base/coverage.h"
#include "core/base/volume.h"
#include "core/image/image.h"
#include "core/scene/preset.h" // ValueSummary
#include "core/scene/scene.h"
#include "viewer/session/slice_frame.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// Which of the volumes at a path, where there are several.
struct VolumePick {
    int series = 0, phase = 0; // 0: none is named
    bool resampleZ = false, allowMissing = false;
    bool operator==(const VolumePick&) const = default;
};

/// One of several volumes that a folder offers.
struct VolumeOffer {
    std::filesystem::path path;      // to open,
    VolumePick pick;                 // with this
    std::string title, about;        // "series 2, CT"; slices, voxels, kernel
    std::string problem;             // why it cannot be opened; else empty
    std::vector<std::string> phases; // labels, where one of several is to be chosen: pick.phase counts from 1
};
struct VolumeOffers {
    std::filesystem::path path; // that was to be opened
    std::vector<VolumeOffer> offers;
    std::string passedOver; // files that are in none, counted by reason; empty: none
};

/// A small picture of an offer, as a screen shows it.
struct Thumbnail {
    glm::ivec2 size{0};
    std::vector<std::uint32_t> display;
};

/// How good a picture is.
enum class Stage {
    moving,  // fewer pixels, longer steps: something moves
    loading, // all pixels; bricks are still on their way, or light becomes finer
    whole,   // all pixels, through their middles, bricks as chosen, and all light
    still    // what `tessera render` draws
};

struct ShownPicture {
    Image image; // linear, premultiplied, on nothing; of fewer pixels than the scene's where something moves
    glm::ivec2 displaySize{0};
    /// The same on the scene's background, as large as the scene's picture, as displayPixels() makes it.
    std::vector<std::uint32_t> display;
    std::optional<glm::vec3> background; // the scene's: linear; none: transparent
    Stage stage = Stage::moving;
    Camera camera;
    std::uint64_t asked = 0; // the number of the wish that it answers
    double drawingMs = 0;    // from its begin to its end
    std::string manifest;    // of a still, JSON; else empty
};

/// A place in the volume under a place of the picture.
struct PickedPlace {
    std::uint64_t number = 0; // of the question
    bool hit = false;
    glm::dvec3 mm{0};    // patient space
    glm::dvec3 voxel{0}; // level-0 voxels
    double value = 0;    // physical units
    int level = 0;       // that place and value were read at: not 0 means that they are coarse
};

/// The values on a disc that a measured circle holds, physical units.
struct DiscValues {
    std::uint64_t number = 0; // of the question
    std::size_t samples = 0;  // 0: it has none, or they cannot be read
    double mean = 0, deviation = 0, least = 0, most = 0;
};

struct VolumeSeen {
    VolumeInfo info;
    ValueSummary values;
    /// Counts of values over equal bins of [values.lowest, values.highest], of a coarse level; 256 or fewer.
    std::vector<double> histogram;
    Scene scene; // as opened: camera and function spelled out
    /// Where the scene's camera was by side: what it was fitted for.
    std::optional<FittedView> fitted;
    std::filesystem::path path; // as it was named
};

struct ViewingState {
    enum class Kind { nothing, opening, open, choosing, failed } kind = Kind::nothing;
    std::string what;    // opening: what is done; failed: why; choosing: among what
    double share = 0;    // opening: of it, [0,1]; 0: not known
    std::string problem; // the last that went wrong with an open volume; empty: nothing
    std::string engine;  // that draws
    std::size_t ramUsed = 0, ramLimit = 0, gpuUsed = 0, gpuLimit = 0;
    std::size_t bricks = 0, bricksShown = 0, bricksAsWanted = 0;
    std::uint64_t chunksThere = 0, chunksMissed = 0; // that bricks asked the cache for, so far
    std::size_t movesLeft = 0;
    bool choosing = false;
    bool lightIsCoarse = false;             // light of voxels becomes finer yet
    int finestLevel = 0, coarsestLevel = 0; // of what is drawn
    bool atRest = false;                    // nothing more will come until something is asked
    bool drawingStill = false;
    bool noStills = false; // for want of RAM: pictures have one ray a pixel at rest, too
    std::string measured;  // the still's measured error as a sentence; empty: none yet
    std::uint64_t pictures = 0;
    std::size_t damagedChunks = 0; // that cannot be read: what they hold is drawn from coarser levels
    std::uint64_t refused = 0;     // the number of the last wish that cannot be drawn: `problem` said why
    /// Where showLevels() asked for it: the level of each brick, [z][y][x]; Selection's numbers.
    std::shared_ptr<const std::vector<std::uint8_t>> levels;
    glm::ivec3 brickGrid{0}; // of the grid
};

/// A centre-line that somebody wants (bricking/analysis/lumen/centreline.h).
struct LineWish {
    std::vector<glm::dvec3> places;  // patient space, mm: its beginning, places on the way, its end
    std::optional<double> threshold; // physical units; none: from what lies around the places
    bool tree = false;               // all branches beyond the first place, the only one
    /// Where given, what is wanted is no line but what of the wall a flight along this one sees
    /// (bricking/analysis/lumen/wall_coverage.h).
    std::shared_ptr<const Path> seenAlong;
    double aspect = 4.0 / 3; // seenAlong: of its pictures, width / height
    bool bothWays = false;   // seenAlong: there and back
};

/// What has come of the last one.
struct LineState {
    std::uint64_t number = 0; // of the wish that what follows is of; 0: none yet
    bool searching = false;
    std::string what;           // searching: what is done
    double share = 0;           // searching: of it, [0,1]; 0: not known
    std::string problem, about; // sentences
    std::shared_ptr<const Path> path;
    std::shared_ptr<const WallCoverage> coverage;
};

class Viewing {
  public:
    virtual ~Viewing() = default;

    /// Opens a store, a scene, a folder or file; what is open is let go once the new one is there.
    /// Where a choice is needed and none is named, offers() has it, and what is open stays.
    /// @param pictureSize  of the first pictures, pixels, in place of the scene's
    virtual void open(const std::filesystem::path& path, const glm::ivec2& pictureSize,
                      const VolumePick& pick = {}) = 0;
    /// What the last path offers, until another is opened; null: nothing is to be chosen.
    virtual std::shared_ptr<const VolumeOffers> offers() const = 0;
    /// Of an offer, by its number; null: not yet, or there is none.
    virtual std::shared_ptr<const Thumbnail> thumbnail(std::size_t offer) const = 0;
    /// The last that was opened; null before. Another pointer for another volume.
    virtual std::shared_ptr<const VolumeSeen> volume() const = 0;

    /// What to draw from now on. The latest wish counts; those before it that were not drawn yet never are.
    /// A camera by side is fitted to what is shown, in the scene's size of picture: the picture that answers
    /// says where it is.
    /// @param moving  more of the kind is about to come: pictures have to come in time
    /// Returns the wish's number.
    virtual std::uint64_t show(const Scene& scene, bool moving) = 0;
    /// The newest picture, null before there is one. Another pointer for another picture.
    virtual std::shared_ptr<const ShownPicture> picture() const = 0;
    virtual ViewingState state() const = 0;

    /// Whether state() tells the level of every brick.
    virtual void showLevels(bool shown) = 0;

    /// The three planes that are wanted from now on; until then none is drawn.
    virtual void showSlices(const SliceWish& wish) = 0;
    /// The newest, null before there is one. Another pointer for others.
    virtual std::shared_ptr<const ShownSlices> slices() const = 0;

    /// Asks what is under a place of the picture, in pixels of the scene's picture. Returns
    /// the question's number.
    virtual std::uint64_t pick(const glm::dvec2& place) = 0;
    /// The last answer.
    virtual std::optional<PickedPlace> picked() const = 0;

    /// Asks what values a circle holds. Returns the question's number; of questions that follow one another
    /// sooner than answers the last counts.
    virtual std::uint64_t askValues(const Measurement& circle) = 0;
    /// The last answer.
    virtual std::optional<DiscValues> discValues() const = 0;

    /// Looks for a centre-line, or along one; what was looked for before is called off. Stills wait
    /// meanwhile: the line has their memory. Returns the wish's number.
    virtual std::uint64_t findLine(const LineWish& wish) = 0;
    virtual void callOffLine() = 0;
    virtual LineState line() const = 0;
    /// Where the camera will be next, in order: bricks are read ahead.
    virtual void lookAhead(std::vector<Camera> next) = 0;

    /// Writes the newest picture with its manifest. Throws Error or InputError.
    /// @param scaleBar  drawn into it (core/scene/scale_bar.h); the manifest says so
    virtual void saveScreenshot(const std::filesystem::path& path, bool scaleBar) const = 0;
    /// Draws the still of a scene, of any size of picture, beside all else, and writes it with its manifest.
    /// Of several requests before it is written the last counts. takeNotice() or state() tell what came of
    /// it.
    /// @param scene  of the open volume, its camera spelled out
    virtual void saveStill(const Scene& scene, const std::filesystem::path& path, bool scaleBar) = 0;
    /// A sentence on something that was finished, once; empty: nothing new.
    virtual std::string takeNotice() = 0;
    /// Forgets the problem that state() tells.
    virtual void problemSeen() = 0;
};

} // namespace tessera
