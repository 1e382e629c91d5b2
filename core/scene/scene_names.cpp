// core/scene/scene_names.cpp: words of scenes and options: the part of scene.h that spells and understands
// them.
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/image/colour.h"
#include "core/scene/scene.h"

#include <cmath>

namespace tessera {

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
    static const NameTable<Sampling> names{
        {{Sampling::full, "full"}, {Sampling::limited, "limited"}, {Sampling::naive, "naive"}}};
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
                                            {Gradient::cubic, "cubic"}}};
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
