// core/scene/scene.h: the scene: everything a picture depends on, as one value and as one JSON file
// (docs/scene.schema.json). Keys follow VTK and 3D Slicer where they have one.
#pragma once

#include "core/base/names.h"
#include "core/base/volume.h"
#include "core/scene/annotations.h"
#include "core/scene/camera.h"
#include "core/scene/cuts.h"
#include "core/scene/labels.h"
#include "core/scene/lighting.h"
#include "core/scene/measurement.h"
#include "core/scene/mesh.h"
#include "core/scene/mode.h"
#include "core/scene/reflection.h"
#include "core/scene/transfer_function.h"

#include <filesystem>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace tessera {

/// The choice of one volume among source files, and the options to open it.
struct SourceChoice {
    int series = 0;            // DICOM: number in the table of series; 0: none chosen
    bool resampleZ = false;    // uneven slices are interpolated
    bool largest = false;      // a folder's largest CT, or its largest volume if there is no CT
    int phase = 0;             // of a series with several images at each position; 0: none chosen
    bool allowMissing = false; // files that could be slices and cannot be read are left out
    /// Of files that do not say it: distances of voxels' centres along the file's x, y, z, mm.
    std::optional<glm::dvec3> spacingMm = {};
    /// Of a file that has its volume at several resolutions: 0 is the finest. Auto: the finest that the cache
    /// of imports has room for. None: the finest, or as auto where the cache has no room for that.
    static constexpr int kAutoLevel = -1;
    std::optional<int> fileLevel = {};
    std::optional<FileBox> fileBox = {}; // of that level's voxels; none: all
    bool operator==(const SourceChoice&) const = default;
};
/// What a user types: auto or a whole number, and X0,X1,Y0,Y1,Z0,Z1. Throws InputError naming `where` for
/// anything else.
int parseFileLevel(const std::string& text, const std::string& where);
FileBox parseFileBox(const std::string& text, const std::string& where);

/// The gradient operator (docs/sampling.md, "Value"). In order: differences to one side, over a pitch to both
/// sides, and of Sobel. Then the derivative of trilinear interpolation, differences over half a pitch to both
/// sides, and the derivative of the cubic B-spline. The last two are Sobel's over two and four pitches to
/// either side, for normals alone.
enum class Gradient { forward, central, sobel, analytic, centralHalf, cubic, sobel2, sobel4 };
/// Pitches that an operator reaches to either side beyond those of others, for normals; 1 but for the last
/// two.
constexpr int reachOf(Gradient gradient) {
    return gradient == Gradient::sobel4 ? 4 : gradient == Gradient::sobel2 ? 2 : 1;
}
/// The operator of all that needs a gradient's length: opacity by gradient.
constexpr Gradient operatorOfLengths(Gradient gradient) {
    return reachOf(gradient) > 1 ? Gradient::sobel : gradient;
}

/// Highlights by the mirrored light direction, or by the direction halfway between light and viewer.
enum class ShadingModel { phong, blinnPhong };

/// With a head light: colour * (ambient + diffuse * |n.v|) + specular * max(0, r.v)^specularPower,
/// the specular part white. Off: the transfer function's colour.
struct Shading {
    bool on = true;
    double ambient = 0.2, diffuse = 0.8, specular = 0.25, specularPower = 20;
    Gradient gradient = Gradient::central;
    ShadingModel model = ShadingModel::phong;
    std::optional<GradientWeight> gradientWeight = {}; // none: every gradient is a surface
    bool operator==(const Shading&) const = default;
};

/// Upper bound on the components of a lit colour, for colours in [0,1]; at least 1, because colours are unlit
/// where the field has no gradient. Ending rays at transmittance t leaves out at most t times this.
double brightest(const Shading& shading, const Lighting& lighting = {},
                 const std::vector<Material>& materials = {});

/// A surface of one value, drawn where rays cross it, in one pass with the volume. Lit like the volume.
struct Isosurface {
    double value = 0;       // physical units
    glm::dvec3 colour{1.0}; // linear light, [0,1], not premultiplied
    double opacity = 1;     // [0,1], of the surface itself, at any angle and step
    /// To light along paths; none: as lighting.transport.surface has it.
    std::optional<SurfaceFinish> finish = {};
    std::optional<Reflection> reflection = {};
    /// What rays of the eye meet: nothing shines straight through a surface that refracts.
    bool transmits() const { return reflection && reflection->transmits; }
    double drawnOpacity() const { return transmits() ? 1 : opacity; }
    glm::dvec3 drawnColour() const { return transmits() ? opacity * colour : colour; }
    bool operator==(const Isosurface&) const = default;
};

enum class Fetch { hardware, exact };

/// Blending of samples of neighbouring bricks (docs/sampling.md, "Value"; course notes 2.10.2): nearest brick
/// only, over the smaller half sample, over each side's own, or over the larger.
enum class EdgeFunction { nearest, minimum, split, maximum };
/// Samples along a ray. In coarse bricks (course notes 2.11.1): every segment; as in the finest brick that
/// can have weight there; as in the current brick. hulls: by sampling hulls, whatever the bricks.
enum class Sampling { full, limited, naive, hulls };

/// Sampling hulls (Imagire et al. 2007; docs/sampling.md): the volume between planes parallel to the picture.
/// A ray takes the same number of samples in each, however long its way there is.
struct Hulls {
    static constexpr int kAutomatic = 0, kMost = 64, kMostSamples = 4096;
    int count = kAutomatic;   // automatic: 4 where lights cast shadows, else 1
    int samples = kAutomatic; // of a ray in each; automatic: as many as an error within 1/255 needs
    bool operator==(const Hulls&) const = default;
};

/// Integration of a ray's segment (docs/sampling.md, "Integrators").
enum class Integrator { automatic, midpoint, linear, preintegrated, preintegrated2d };

/// The filter of a pixel (docs/sampling.md, "Pixels").
enum class PixelFilter { box, gaussian };

struct PixelSampling {
    static constexpr int kAutomatic = 0, kMost = 65536;
    static constexpr int kMostDecided = 256;   // where pixels decide, for an error bound
    static constexpr int kMostForNoise = 4096; // where a noise is asked for and no number named
    /// Rays through each pixel. 1: through its centre; filter and seed then have no effect. kAutomatic: more
    /// where pixels need them.
    int samples = 1;
    PixelFilter filter = PixelFilter::box; // box: the pixel's own area
    std::uint32_t seed = 0;                // of the positions in a pixel
    /// Above 0: samples double until the standard error of the picture's means (rms, linear light) is at most
    /// this, or until there are so many samples.
    double noise = 0;
    /// Of paths of light: the noise that is left is taken out by a filter, which has a bias.
    bool denoise = false;
    /// True if samples were requested; else the program chooses by engine.
    bool named = false;
};

struct Quality {
    double stepVoxels = 0.5; // q of docs/sampling.md: a segment, in level-0 voxels, [1/64,16]
    /// Instead the longest step, in halves from 2, whose estimated error is within 1/255 (rms over visible
    /// pixels). Set for scene files that name no step.
    bool automaticStep = false;
    Integrator integrator = Integrator::automatic; // automatic: by the transfer function's sharpness
    Fetch fetch = Fetch::hardware; // exact: texel fetches and float arithmetic, for equality tests
    double terminationTransmittance = 1.0 / 510; // a ray stops below it; 0: off
    bool skipping = true;                        // empty-space skipping; never changes the picture
    EdgeFunction edgeFunction =
        EdgeFunction::split; // the least error on scans: docs/measurements/level-of-detail.md
    Sampling sampling = Sampling::limited;
    Hulls hulls; // of Sampling::hulls
    /// Bound of the predicted error (CIE L*u*v*, 99th percentile over pixels), in as many passes as the
    /// budget needs. 0: the finest level that a pixel can show. None: the best picture of one pass.
    std::optional<double> maxError;
    PixelSampling pixels;
};

/// The table under the patient in a CT: drawn, or left out of pictures but slices where it is found
/// (bricking/analysis/body/table_mask.h).
enum class HideTable { no, automatic };

/// Several volumes in one picture (docs/sampling.md, "Several volumes"). mix: extinctions add up, colours mix
/// by their shares. over: the same extinctions, and each volume lies over those before it. maximum: the
/// greatest of every component.
enum class Fusion { mix, over, maximum };

struct SceneVolume {
    std::filesystem::path path; // store or source; absolute once a scene is loaded
    TransferChoice transferFunction = std::string("bone-1");
    std::string unit = {};    // "HU": overrides the volume's unit; "": the volume's unit
    SourceChoice source = {}; // of source files
    HideTable hideTable = HideTable::no;
    Labels labels = {};
    double opacity = 1;                      // [0,1], times the extinction; of single values, of their colour
    glm::dmat4 transform{1};                 // moves the volume: patient space (LPS, mm) from the file's
    Cuts cuts = {};                          // of this volume alone, besides the scene's
    std::optional<WindowChoice> window = {}; // of single values; none: the scene's
    std::optional<ValueColour> valueColour = {}; // likewise
};

/// The target of a fitted camera: all that the transfer function and the isosurfaces show, the volume's box,
/// or what is shown within the cuts.
enum class Fit { shown, volume, kept };

/// A camera by side, which is fitted once the volume is known.
struct FittedView {
    View view = View::anterior;
    Projection projection = Projection::perspective;
    Fit fit = Fit::shown;
    /// True if a side was requested; else a slice is seen along its normal, in parallel projection.
    bool named = false;
    /// Any direction in place of the side and of angles, for windows. Not in files.
    std::optional<ViewAxes> axes = {};
    std::optional<ViewAngles> angles = {}; // in place of `view`
    double mmPerPixel = 0;                 // of a parallel picture; 0: fitted
};
ViewAxes axesOf(const FittedView& view);
/// Half the height of a parallel picture whose pixels have this edge, mm.
inline double parallelScaleOf(double mmPerPixel, const glm::ivec2& imageSize) {
    return 0.5 * mmPerPixel * imageSize.y;
}
constexpr double kLeastMmPerPixel = 1e-5, kMostMmPerPixel = 1e4;
using CameraChoice = std::variant<FittedView, Camera>;

struct Scene {
    static constexpr int kVersion = 1;
    std::vector<SceneVolume> volumes; // 1 to kMaxVolumes
    Fusion fusion = Fusion::mix;      // of several
    CameraChoice camera = FittedView{};
    Shading shading;
    Lighting lighting;
    std::vector<Isosurface> surfaces; // at most kMaxSurfaces
    std::vector<SceneMesh> meshes;    // at most SceneMesh::kMost
    Mode mode = Mode::composite;
    WindowChoice window = std::string("auto"); // of modes that show single values, as is the next member
    ValueColour valueColour = ValueColour::window;
    SlicePlane slice; // of mode slice
    Cuts cuts;
    std::vector<Measurement> measurements;
    Annotations annotations; // over the picture
    Quality quality;
    glm::ivec2 imageSize{512, 512};
    std::optional<glm::vec3> background = glm::vec3(0); // linear rgb in [0,1]; none: transparent

    static constexpr std::size_t kMaxVolumes = 8;
    static constexpr std::size_t kMaxSurfaces = 8;
    static constexpr int kMaxImageExtent = 32768; // pixels an axis: products of two fit an int
};

/// The scene of one of its volumes alone, as the picture of all shows it.
Scene sceneOfVolume(const Scene& scene, std::size_t number);

/// The reduction of the scene's rays: a plane has one value per ray, as `maximum`.
Reduction reductionOf(const Scene& scene);
/// The scene without what its mode does not draw, as engines get it: single values and sums have no light,
/// isosurfaces, meshes or integrator. Throws InputError for a mode that has nothing to draw.
Scene asDrawn(const Scene& scene);

/// True if an isosurface mirrors or refracts rays.
bool reflects(const Scene& scene);
/// The scene with isosurfaces as if they had no reflection; glass has an opacity of 0.1 at least.
Scene withoutReflections(Scene scene);

/// The meshes that are drawn.
std::vector<SceneMesh> drawnMeshes(const Scene& scene);
/// True if there are any.
bool drawsMeshes(const Scene& scene);

/// True if path is a JSON file with the key "tesseraScene", "volumes" or "camera". True also for invalid
/// JSON, so that loadScene() reports the fault. False for folders and other files.
bool isSceneFile(const std::filesystem::path& path);
/// Parses a scene file. Relative paths are taken from the file's folder.
/// Throws InputError naming the file and the JSON path for: no JSON, wrong version, unknown key (with the
/// nearest known one), wrong type, value out of range.
Scene loadScene(const std::filesystem::path& file);
Scene parseScene(const std::string& text, const std::filesystem::path& folder, const std::string& where);
/// The scene as JSON text that parseScene reads back to the same scene; ASCII, one line. A transfer function
/// must hold opacities: one made from extinctions is for tests and has no JSON.
std::string sceneJson(const Scene& scene);

/// Names in scenes and options (core/base/names.h).
template <> const NameTable<View>& namesOf<View>();
template <> const NameTable<Projection>& namesOf<Projection>();
template <> const NameTable<Fit>& namesOf<Fit>();
template <> const NameTable<Fetch>& namesOf<Fetch>();
template <> const NameTable<EdgeFunction>& namesOf<EdgeFunction>();
template <> const NameTable<Sampling>& namesOf<Sampling>();
template <> const NameTable<Integrator>& namesOf<Integrator>();
template <> const NameTable<Gradient>& namesOf<Gradient>();
template <> const NameTable<PixelFilter>& namesOf<PixelFilter>();
template <> const NameTable<HideTable>& namesOf<HideTable>();
template <> const NameTable<Fusion>& namesOf<Fusion>();
template <> const NameTable<ShadingModel>& namesOf<ShadingModel>();
/// In the order of the enums.
inline const std::vector<std::string>& viewNames() {
    return namesOf<View>().all();
}
inline const std::vector<std::string>& fitNames() {
    return namesOf<Fit>().all();
}
inline const std::vector<std::string>& fetchNames() {
    return namesOf<Fetch>().all();
}
inline const std::vector<std::string>& edgeFunctionNames() {
    return namesOf<EdgeFunction>().all();
}
inline const std::vector<std::string>& samplingNames() {
    return namesOf<Sampling>().all();
}
inline const std::vector<std::string>& integratorNames() {
    return namesOf<Integrator>().all();
}
inline const std::vector<std::string>& gradientNames() {
    return namesOf<Gradient>().all();
}
inline const std::vector<std::string>& pixelFilterNames() {
    return namesOf<PixelFilter>().all();
}
inline const std::vector<std::string>& shadingModelNames() {
    return namesOf<ShadingModel>().all();
}
/// Throws InputError naming where for a turn beyond 360 degrees either way, or a rise beyond 90.
ViewAngles checkedAngles(double turn, double rise, const std::string& where);

/// A colour by findColour(); nullopt for "transparent". Throws InputError naming where.
std::optional<glm::vec3> parseBackground(const std::string& text, const std::string& where);
/// The same without "transparent".
/// @param others  further words for the message: "transparent, "
glm::vec3 parseColour(const std::string& text, const std::string& where, const std::string& others = "");

} // namespace tessera
