// core/scene/mode.cpp: see mode.h.
#include "core/scene/mode.h"

#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/names.h"
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <numeric>
#include <sstream>
#include <utility>

namespace tessera {
namespace {

using Names = std::vector<std::string>;

const std::vector<std::pair<std::string, GreyWindow>>& namedWindows() {
    static const std::vector<std::pair<std::string, GreyWindow>> windows = {
        {"brain", {40, 80}},    {"subdural", {75, 215}}, {"lung", {-600, 1500}}, {"mediastinum", {50, 350}},
        {"abdomen", {50, 400}}, {"liver", {30, 150}},    {"bone", {400, 1800}}};
    return windows;
}

/// Of maxima through a body in HU: soft tissue lies in every ray and is dark grey, vessels with contrast (200
/// to 450 HU) are the middle greys, dense bone is white.
constexpr GreyWindow kVesselsAndBone{350, 1100};

/// The highest value that a window should show. If a thousandth of the voxels takes more than half of the
/// range, it is the maximum of the other voxels.
double mostOf(const ValueSummary& values) {
    constexpr double kFew = 1e-3, kMuch = 0.5;
    const double voxels = std::accumulate(values.histogram.begin(), values.histogram.end(), 0.0);
    const auto bins = static_cast<double>(values.histogram.size());
    double above = 0;
    for (std::size_t bin = values.histogram.size(); bin-- > 0;) {
        const double here = values.histogram[bin];
        if (above + here <= kFew * voxels) {
            above += here;
            continue;
        }
        const double part = (static_cast<double>(bin) + 1 - (kFew * voxels - above) / here) / bins;
        return part < kMuch ? values.lowest + part * (values.highest - values.lowest) : values.highest;
    }
    return values.highest;
}

} // namespace

SlicePose poseOf(const SlicePlane& slice, const glm::dvec3& middle) {
    SlicePose pose;
    pose.point = middle;
    const auto along = [&](int axis) { pose.point[axis] = slice.positionMm.value_or(middle[axis]); };
    switch (slice.orientation) {
    case Orientation::axial:
        pose.normal = {0, 0, -1};
        along(2);
        break;
    case Orientation::coronal:
        pose.normal = {0, -1, 0};
        along(1);
        break;
    case Orientation::sagittal:
        pose.normal = {1, 0, 0};
        along(0);
        break;
    case Orientation::oblique:
        pose.normal = glm::normalize(slice.normal);
        pose.point = slice.point;
        break;
    }
    constexpr double kOneDegree = 0.99985; // its cosine
    const glm::dvec3 up = std::abs(pose.normal.z) > kOneDegree ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1);
    pose.right = glm::normalize(glm::cross(-pose.normal, up));
    pose.up = glm::cross(pose.right, -pose.normal);
    return pose;
}

GreyWindow windowOf(const WindowChoice& choice, const ValueSummary& values, Mode mode) {
    if (const auto* window = std::get_if<GreyWindow>(&choice))
        return *window;
    const auto& name = std::get<std::string>(choice);
    const auto named = [](const std::string& text) {
        for (const auto& [key, window] : namedWindows())
            if (key == text)
                return window;
        throw InputError("window: expected one of " + joinNames(windowNames()) + ", found \"" + text + "\"");
    };
    if (name != "auto")
        return named(name);
    if (values.isHu || looksLikeHu(values))
        return mode == Mode::maximum ? kVesselsAndBone : named("abdomen");
    const ValueSummary measured = withoutFills(values);
    const double lowest = measured.lowest, width = mostOf(measured) - lowest;
    return width > 0 ? GreyWindow{lowest + 0.5 * width, width} : GreyWindow{lowest, 1};
}

template <> const NameTable<Mode>& namesOf<Mode>() {
    static const NameTable<Mode> names{{{Mode::composite, "composite"},
                                        {Mode::maximum, "maximum"},
                                        {Mode::minimum, "minimum"},
                                        {Mode::average, "average"},
                                        {Mode::isosurface, "isosurface"},
                                        {Mode::slice, "slice"},
                                        {Mode::emission, "emission"},
                                        {Mode::absorption, "absorption"},
                                        {Mode::radiograph, "radiograph"}},
                                       {{Mode::maximum, "mip"},
                                        {Mode::minimum, "minip"},
                                        {Mode::average, "mean"},
                                        {Mode::radiograph, "drr"},
                                        {Mode::radiograph, "x-ray"}}};
    return names;
}
template <> const NameTable<Reduction>& namesOf<Reduction>() {
    static const NameTable<Reduction> names{
        {{Reduction::maximum, "maximum"}, {Reduction::minimum, "minimum"}, {Reduction::average, "average"}},
        {{Reduction::average, "mean"}}};
    return names;
}
template <> const NameTable<Orientation>& namesOf<Orientation>() {
    static const NameTable<Orientation> names{{{Orientation::axial, "axial"},
                                               {Orientation::coronal, "coronal"},
                                               {Orientation::sagittal, "sagittal"},
                                               {Orientation::oblique, "oblique"}}};
    return names;
}
template <> const NameTable<ValueColour>& namesOf<ValueColour>() {
    static const NameTable<ValueColour> names{
        {{ValueColour::window, "window"},
         {ValueColour::transferFunction, "transferFunction"},
         {ValueColour::inverse, "inverse"}},
        {{ValueColour::transferFunction, "transfer-function"}, {ValueColour::transferFunction, "preset"}}};
    return names;
}
const Names& windowNames() {
    static const Names names = [] {
        Names all = {"auto"};
        for (const auto& [name, window] : namedWindows())
            all.push_back(name);
        return all;
    }();
    return names;
}

GreyWindow checkedWindow(double centre, double width, const std::string& where) {
    if (!std::isfinite(centre) || !std::isfinite(width) || !(width > 0))
        throw badFile(where, "CENTRE,WIDTH with a width above 0",
                      shownNumber(centre) + "," + shownNumber(width));
    const GreyWindow window{centre, width};
    checkValue(window.low(), "CENTRE,WIDTH whose ends lie", where);
    checkValue(window.high(), "CENTRE,WIDTH whose ends lie", where);
    return window;
}

WindowChoice parseWindow(const std::string& text, const std::string& where) {
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos) {
        if (std::find(windowNames().begin(), windowNames().end(), text) == windowNames().end())
            throw badFile(where, "CENTRE,WIDTH or one of " + joinNames(windowNames()),
                          "\"" + text.substr(0, 40) + "\"");
        return text;
    }
    const std::string words[] = {text.substr(0, comma), text.substr(comma + 1)};
    double numbers[2] = {};
    for (int i = 0; i < 2; ++i) {
        char* end = nullptr;
        numbers[i] = std::strtod(words[i].c_str(), &end);
        if (words[i].empty() || *end != '\0')
            throw badFile(where, "CENTRE,WIDTH or one of " + joinNames(windowNames()),
                          "\"" + text.substr(0, 40) + "\"");
    }
    return checkedWindow(numbers[0], numbers[1], where);
}

void checkSlice(const SlicePlane& slice, const std::string& where) {
    checkLength(slice.thicknessMm, "a thickness", where);
    if (!(slice.thicknessMm >= 0))
        throw badFile(where, "a thickness of 0 mm or more", shownNumber(slice.thicknessMm));
    checkLength(slice.positionMm.value_or(0), "a position", where);
    checkPlace(slice.point, "a point", where);
    checkDirection(slice.normal, "a normal", where);
}

glm::dvec3 colourOfValue(const ValueLook& look, const TransferFunction& function, double value) {
    if (look.colour == ValueColour::transferFunction)
        return function.colour(value);
    const double part = std::clamp((value - look.window.low()) / look.window.width, 0.0, 1.0);
    return glm::dvec3(linearFromSrgb(look.colour == ValueColour::inverse ? 1 - part : part));
}

TransferTable valueTable(const ValueLook& look, const TransferFunction& function, Reduction reduction) {
    TESSERA_CHECK(reduction != Reduction::composite && reduction != Reduction::sum);
    TransferTable table;
    if (look.colour == ValueColour::transferFunction) {
        table = makeTable(function);
        table.gradientOpacity = {};
    } else {
        // Between so many entries the curve of sRGB is off by 5e-8 at most.
        constexpr std::size_t kEntries = 4096;
        table.firstValue = static_cast<float>(look.window.low());
        // A window so narrow, or so far from 0, that floats cannot tell its ends apart is a step.
        const double least = 1e-6 * std::max(std::abs(look.window.low()), std::abs(look.window.high()));
        table.entriesPerValue =
            static_cast<float>((kEntries - 1) / std::max({look.window.width, least, 1e-25}));
        table.entries.resize(kEntries);
        for (std::size_t i = 0; i < kEntries; ++i) {
            const std::size_t grey = look.colour == ValueColour::inverse ? kEntries - 1 - i : i;
            table.entries[i] = glm::vec4(
                glm::vec3(static_cast<float>(linearFromSrgb(static_cast<double>(grey) / (kEntries - 1)))), 1);
        }
    }
    table.relativeError = 0;
    for (glm::vec4& entry : table.entries)
        entry.a = 1;
    if (reduction == Reduction::maximum)
        table.entries.front().a = 0;
    if (reduction == Reduction::minimum)
        table.entries.back().a = 0;
    table.nonZeroUpTo.resize(table.entries.size());
    int shown = 0;
    for (std::size_t i = 0; i < table.entries.size(); ++i)
        table.nonZeroUpTo[i] = shown += table.entries[i].a != 0 ? 1 : 0;
    return table;
}

} // namespace tessera
