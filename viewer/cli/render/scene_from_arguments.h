// viewer/cli/render/scene_from_arguments.h: the scene to draw: the named one, changed by the options. Options
// win over the scene.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/animation/path.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"   // Verify, EngineKind
#include "viewer/cli/input/volume_input.h" // InputOptions
#include "viewer/cli/options/options.h"
#include "viewer/cli/options/scene_options.h"

#include <optional>
#include <string>
#include <vector>

namespace tessera {

// The arguments of `tessera render` as the user gave them. They are checked and interpreted elsewhere
// (run_render.h).

/// Empty texts, and numbers that no option takes, were not said: then the scene decides, or the path
/// of a film.
struct RenderArguments {
    std::string in, out, engine = "auto", ram, gpuMemory, preset, view, fit, projection;
    std::optional<Scene> scene; // in place of `in`, which messages then name
    int threads = 0;            // that draw; 0: all processors
    bool tellsRequest = false;  // the manifest tells requestOf() (asked_options.h)
    std::string device = "auto";
    double mmPerPixel = 0;                    // 0: as the scene says
    std::vector<std::string> add, addPresets; // further volumes, and their presets
    std::vector<std::string> labelPresets;    // "LABELS=PRESET"
    KeyOptions keys;                          // those that set one key of the scene
    std::string first, light;
    std::vector<std::string> surfaces;
    std::vector<std::string> meshes, meshColours, meshOpacities; // n-th of the n-th; the last for the rest
    std::string meshSpace, meshContours;
    std::string verify;
    std::vector<std::string> layers; // in an EXR picture, besides the colour
    std::string keepState;           // file of sums of samples
    std::string path, frames;        // of films
    std::optional<Path> givenPath;   // in place of the file `path`, which messages then name
    double framesPerSecond = 0, speed = 0, seconds = 0; // 0: as the path says
    std::optional<double> turn;                         // degrees, not 0; of turntables
    std::vector<std::string> panels;                    // of a figure of several pictures
    int columns = 0, gap = 8;  // of its panels; 0: by their number; pixels between them
    bool fitEach = false;      // every panel is fitted for itself
    bool panelLetters = false; // A, B, C
    int tiles = 0;             // pixels along a side; 0: the picture is drawn as a whole
    bool ranks = false;        // the picture is drawn by the processes of mpirun
    bool unfold = false, mayLeak = false;
    bool straighten = false, curved = false; // reformations of a path's line
    std::optional<double> angle;             // degrees, of a straightened picture and of cross-sections
    int angles = 0;                          // of as many straightened ones; 0: one
    int sections = 0;                        // cross-sections of a path's line
    std::string direction;                   // "X,Y,Z", of a curved one
    double widthMm = 0;                      // 0: by the line
    bool noCheck = false, explain = false, json = false;
    bool allowDamaged = false; // a coarser level stands in for what is damaged
    ModeOptions mode;
    InputOptions input;

    /// A camera by side was asked for.
    bool isSideNamed() const { return !fit.empty() || !projection.empty(); }
    bool reforms() const { return straighten || curved || sections > 0; }
    /// The option that makes one picture of a path; "": none.
    std::string pathPicture() const {
        return unfold         ? "--unfold"
               : straighten   ? "--straighten"
               : curved       ? "--curved"
               : sections > 0 ? "--sections"
                              : "";
    }
    /// A picture's size, and no other that would follow from its line.
    bool isSized() const { return givenPath || keys.says("image.size"); }
    bool isFilm() const { return (!path.empty() && pathPicture().empty()) || turn || input.allPhases; }
};

/// Applies the options to the scene. Notes settings of a foreign preset that no scene has. Throws InputError
/// naming the option for invalid values, and for options without effect beside the scene or one another;
/// those of slices stay where a volume of one slice would be shown as one: see facesThinVolume()
/// (viewer/cli/input/named_scene.h), and then refusalByMode().
void applyArguments(const RenderArguments& arguments, Scene& scene, const CommonOptions& common);

/// `--no-check` is `--verify none`. Without either, films are not checked. Throws InputError naming the
/// option for other words, and for both with different meanings.
Verify verifyOf(const RenderArguments& arguments);

/// Throws InputError naming --engine for an unknown engine.
EngineKind engineOf(const RenderArguments& arguments);

// `--crop body`: the box of the patient, added to the scene like any other box.

/// Adds the box of bricking/analysis/body/body_box.h to the scene's cuts and notes it. A camera by side is
/// fitted to what is shown within the cuts, unless --fit says otherwise. Of several volumes the box holds the
/// bodies of all that are visible and in HU. Throws InputError naming --crop where none is in HU, and as
/// findBody() does.
void cropToBody(const RenderArguments& arguments, Stores stores, Scene& scene, MemoryBudget& ram,
                const CommonOptions& common);

/// True for values in HU, as the store or unit says, or that look like HU.
bool inHu(const StoreReader& store, const std::string& unit, MemoryBudget& ram);

} // namespace tessera
