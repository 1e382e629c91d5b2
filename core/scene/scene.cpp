// core/scene/scene.cpp: see scene.h. Rules across the parts of a scene, and its words. Reading and writing is
// scene_json.cpp.
#include "core/scene/scene.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tessera {

double brightest(const Shading& shading, const Lighting& lighting, const std::vector<Material>& materials) {
    if (!shading.on)
        return 1;
    const double light = maxIncidentLight(lighting.lights);
    double most = std::max(1.0, shading.ambient + light * (shading.diffuse + shading.specular));
    for (const Material& m : materials)
        most = std::max(most, m.ambient + light * (m.diffuse + m.specular) +
                                  std::max({m.emission.r, m.emission.g, m.emission.b}));
    return most;
}

Scene sceneOfVolume(const Scene& scene, std::size_t number) {
    Scene alone = scene;
    const SceneVolume& volume = scene.volumes.at(number);
    alone.volumes = {volume};
    if (Labels& labels = alone.volumes.front().labels; number > 0 && !labels.ofVolume)
        labels.ofVolume = number;
    alone.window = volume.window.value_or(scene.window);
    alone.valueColour = volume.valueColour.value_or(scene.valueColour);
    return alone;
}

Reduction reductionOf(const Scene& scene) {
    switch (scene.mode) {
    case Mode::maximum:
        return Reduction::maximum;
    case Mode::minimum:
        return Reduction::minimum;
    case Mode::average:
        return Reduction::average;
    case Mode::slice:
        return scene.slice.thicknessMm > 0 ? scene.slice.reduction : Reduction::maximum;
    case Mode::emission:
    case Mode::absorption:
    case Mode::radiograph:
        return Reduction::sum;
    case Mode::composite:
    case Mode::isosurface:
        break;
    }
    return Reduction::composite;
}

Scene asDrawn(const Scene& scene) {
    Scene drawn = scene;
    if (scene.mode == Mode::isosurface) {
        if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
                         [](const Isosurface& s) { return s.drawnOpacity() > 0; }))
            throw InputError("mode isosurface: expected an isosurface that is not wholly transparent "
                             "(--isosurface VALUE), found none");
        return reflects(scene) ? drawn : withoutReflections(std::move(drawn));
    }
    if (reductionOf(scene) == Reduction::composite)
        return reflects(scene) ? drawn : withoutReflections(std::move(drawn));
    drawn.shading.on = false;
    drawn.lighting = {};
    drawn.quality.pixels.denoise = false;
    drawn.surfaces.clear();
    drawn.meshes.clear();
    drawn.quality.integrator = Integrator::midpoint;
    if (reductionOf(scene) == Reduction::sum)
        drawn.quality.terminationTransmittance = 0; // every part of a ray counts alike
    return drawn;
}

bool reflects(const Scene& scene) {
    return scene.lighting.reflectionOrder > 0 && reductionOf(scene) == Reduction::composite &&
           std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [](const Isosurface& surface) {
               return surface.reflection && surface.drawnOpacity() > 0;
           });
}
Scene withoutReflections(Scene scene) {
    constexpr double kLeastSeen = 0.1; // of glass
    for (Isosurface& surface : scene.surfaces) {
        if (surface.transmits())
            surface.opacity = std::max(surface.opacity, kLeastSeen);
        surface.reflection.reset();
    }
    return scene;
}

std::vector<SceneMesh> drawnMeshes(const Scene& scene) {
    std::vector<SceneMesh> drawn;
    std::copy_if(scene.meshes.begin(), scene.meshes.end(), std::back_inserter(drawn),
                 [](const SceneMesh& mesh) { return mesh.isDrawn(); });
    return drawn;
}
bool drawsMeshes(const Scene& scene) {
    return std::any_of(scene.meshes.begin(), scene.meshes.end(),
                       [](const SceneMesh& mesh) { return mesh.isDrawn(); });
}

template <> const NameTable<View>& namesOf<View>() {
    static const NameTable<View> names{{{View::anterior, "anterior"},
                                        {View::posterior, "posterior"},
                                        {View::left, "left"},
                                        {View::right, "right"},
                                        {View::superior, "superior"},
                                        {View::inferior, "inferior"}},
                                       {{View::anterior, "front"},
                                        {View::anterior, "ventral"},
                                        {View::posterior, "back"},
                                        {View::posterior, "dorsal"},
                                        {View::superior, "top"},
                                        {View::superior, "cranial"},
                                        {View::inferior, "bottom"},
                                        {View::inferior, "caudal"}}};
    return names;
}
template <> const NameTable<Projection>& namesOf<Projection>() {
    static const NameTable<Projection> names{
        {{Projection::perspective, "perspective"}, {Projection::parallel, "parallel"}}};
    return names;
}
template <> const NameTable<Fit>& namesOf<Fit>() {
    static const NameTable<Fit> names{{{Fit::shown, "shown"}, {Fit::volume, "volume"}, {Fit::kept, "kept"}}};
    return names;
}
template <> const NameTable<Fetch>& namesOf<Fetch>() {
    static const NameTable<Fetch> names{{{Fetch::hardware, "hardware"}, {Fetch::exact, "exact"}}};
    return names;
}
template <> const NameTable<EdgeFunction>& namesOf<EdgeFunction>() {
    static const NameTable<EdgeFunction> names{{{EdgeFunction::nearest, "nearest"},
                                                {EdgeFunction::minimum, "minimum"},
                                                {EdgeFunction::split, "split"},
                                                {EdgeFunction::maximum, "maximum"}}};
    return names;
}
template <> const NameTable<Sampling>& namesOf<Sampling>() {
    static const NameTable<Sampling> names{{{Sampling::full, "full"},
                                            {Sampling::limited, "limited"},
                                            {Sampling::naive, "naive"},
                                            {Sampling::hulls, "hulls"}}};
    return names;
}
template <> const NameTable<Integrator>& namesOf<Integrator>() {
    static const NameTable<Integrator> names{{{Integrator::automatic, "auto"},
                                              {Integrator::midpoint, "midpoint"},
                                              {Integrator::linear, "linear"},
                                              {Integrator::preintegrated, "pre-integrated"},
                                              {Integrator::preintegrated2d, "pre-integrated-2d"}}};
    return names;
}
template <> const NameTable<Gradient>& namesOf<Gradient>() {
    static const NameTable<Gradient> names{{{Gradient::forward, "forward"},
                                            {Gradient::central, "central"},
                                            {Gradient::sobel, "sobel"},
                                            {Gradient::analytic, "analytic"},
                                            {Gradient::centralHalf, "central-half"},
                                            {Gradient::cubic, "cubic"},
                                            {Gradient::sobel2, "sobel-2"},
                                            {Gradient::sobel4, "sobel-4"}}};
    return names;
}
template <> const NameTable<HideTable>& namesOf<HideTable>() {
    static const NameTable<HideTable> names{{{HideTable::no, "no"}, {HideTable::automatic, "auto"}}};
    return names;
}
template <> const NameTable<Fusion>& namesOf<Fusion>() {
    static const NameTable<Fusion> names{
        {{Fusion::mix, "mix"}, {Fusion::over, "over"}, {Fusion::maximum, "maximum"}}};
    return names;
}
template <> const NameTable<PixelFilter>& namesOf<PixelFilter>() {
    static const NameTable<PixelFilter> names{
        {{PixelFilter::box, "box"}, {PixelFilter::gaussian, "gaussian"}}};
    return names;
}
template <> const NameTable<ShadingModel>& namesOf<ShadingModel>() {
    static const NameTable<ShadingModel> names{
        {{ShadingModel::phong, "phong"}, {ShadingModel::blinnPhong, "blinn-phong"}}};
    return names;
}

ViewAngles checkedAngles(double turn, double rise, const std::string& where) {
    if (!(std::abs(turn) <= 360 && std::abs(rise) <= 90))
        throw badFile(where, "degrees about the patient's axis, from -360 to 360, and up, from -90 to 90",
                      std::to_string(turn) + "," + std::to_string(rise));
    return {turn, rise};
}
ViewAxes axesOf(const FittedView& view) {
    if (view.axes)
        return *view.axes;
    return view.angles ? viewAxes(*view.angles) : viewAxes(view.view);
}

std::optional<glm::vec3> parseBackground(const std::string& text, const std::string& where) {
    if (text == "transparent")
        return std::nullopt;
    return parseColour(text, where, "transparent, ");
}

glm::vec3 parseColour(const std::string& text, const std::string& where, const std::string& others) {
    const std::optional<glm::vec3> colour = findColour(text);
    if (!colour)
        throw badFile(where,
                      others + "#rrggbb or a colour's name (black, white, red, grey and the others of CSS)",
                      "\"" + text.substr(0, 40) + "\"; nearest: \"" + nearestColour(text) + "\"");
    return *colour;
}

} // namespace tessera
