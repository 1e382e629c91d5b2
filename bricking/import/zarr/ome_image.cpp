// bricking/import/zarr/ome_image.cpp: see ome_image.h.
#include "bricking/import/zarr/ome_image.h"

#include "bricking/import/source/length_units.h"
#include "bricking/import/source/time_units.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <string_view>

namespace tessera {
namespace {

constexpr std::size_t kMostDatasets = 64, kMostTransformations = 16, kMostMultiscales = 1000,
                      kMostChannels = 10000;
constexpr double kMostScale = 1e12, kMostTranslation = 1e15;

std::string textOrNone(const JsonValue& object, const char* key) {
    return object.has(key) && object.at(key).isText() ? object.at(key).text() : "";
}

OmeAxis omeAxisOf(const JsonValue& row) {
    if (!row.isObject())
        row.refuse("an axis of OME-Zarr 0.4 or 0.5: an object with a name");
    OmeAxis axis;
    axis.name = row.at("name").text();
    const std::string type = textOrNone(row, "type");
    axis.isOfSpace =
        type == "space" || (type.empty() && (axis.name == "x" || axis.name == "y" || axis.name == "z"));
    axis.unit = textOrNone(row, "unit");
    if (row.has("orientation") && row.at("orientation").isObject())
        axis.orientation = textOrNone(row.at("orientation"), "value");
    return axis;
}

/// Applies transformations in their order.
/// @return true if one of them is a scale
bool transform(std::vector<OmeAxis>& axes, const JsonValue& object) {
    bool saysScale = false;
    if (!object.has("coordinateTransformations"))
        return saysScale;
    for (const JsonValue row :
         object.at("coordinateTransformations").items(kMostTransformations, "transformations")) {
        const std::string type = row.at("type").oneOf({"identity", "scale", "translation"});
        if (type == "identity")
            continue;
        saysScale = saysScale || type == "scale";
        const JsonValue list = row.at(type);
        const std::vector<double> numbers = list.numbers(axes.size());
        for (std::size_t i = 0; i < axes.size(); ++i) {
            if (!axes[i].isOfSpace)
                continue; // times and channels have no place
            if (type == "scale" && !(numbers[i] > 0 && numbers[i] < kMostScale))
                list.refuse("scales above 0, at most 1e12");
            if (type == "translation" && !(numbers[i] > -kMostTranslation && numbers[i] < kMostTranslation))
                list.refuse("translations of at most 1e15");
            if (type == "scale") {
                axes[i].scale *= numbers[i];
                axes[i].translation *= numbers[i];
            } else {
                axes[i].translation += numbers[i];
            }
        }
    }
    return saysScale;
}

double voxelOf(const std::vector<OmeAxis>& axes) {
    double size = 1;
    for (const OmeAxis& axis : axes)
        size *= axis.isOfSpace ? axis.scale : 1;
    return size;
}

void checkVersion(const JsonValue& version) {
    version.oneOf({"0.4", "0.5"});
}

// Places.

/// Why axes do not say their distances in a length: "" they do, or none of them has a unit.
std::string problemOf(const std::array<OmeAxis, 3>& axes, bool saysScale) {
    std::string unnamed, named;
    for (const OmeAxis& axis : axes) {
        const std::string shown = "axis \"" + printable(axis.name) + "\"";
        if (!axis.unit.empty() && millimetresOf(axis.unit) == 0)
            return "the unit \"" + printable(axis.unit.substr(0, 40)) + "\" of " + shown;
        (axis.unit.empty() ? unnamed : named) = shown;
    }
    if (!unnamed.empty() && !named.empty())
        return "no unit of " + unnamed + " beside one of " + named;
    return saysScale ? "" : "no scale among the coordinateTransformations";
}

/// The patient's axis that an orientation runs along, and whether against left, posterior, superior.
std::optional<std::pair<int, bool>> wayOf(const std::string& orientation) {
    static constexpr std::array kWays = {std::array{"right-to-left", "left-to-right"},
                                         std::array{"anterior-to-posterior", "posterior-to-anterior"},
                                         std::array{"inferior-to-superior", "superior-to-inferior"}};
    for (std::size_t axis = 0; axis < kWays.size(); ++axis)
        for (std::size_t way = 0; way < 2; ++way)
            if (orientation == kWays[axis][way])
                return std::pair(static_cast<int>(axis), way == 1);
    return std::nullopt;
}

/// Sets the affine of axes, slowest first.
void placeGrid(OmeGrid& grid, const std::array<OmeAxis, 3>& axes, bool saysScale, const std::string& where) {
    std::array<glm::dvec3, 3> step{};
    glm::dvec3 origin{0};
    std::array<int, 3> patientAxis{};
    unsigned named = 0, told = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t letter = std::string_view("xyz").find(axes[i].name);
        const bool isLetter = axes[i].name.size() == 1 && letter != std::string_view::npos;
        patientAxis[i] = isLetter ? static_cast<int>(letter) : 2 - static_cast<int>(i);
        named |= 1u << patientAxis[i];
        if (const auto way = wayOf(axes[i].orientation))
            told |= 1u << way->first;
    }
    if (named != 7)
        throw badFile(where, "three axes of space with different names", "two of a name");
    grid.info.orientationKnown = told == 7;
    if (!grid.info.orientationKnown)
        grid.notes.emplace_back("the orientation in the patient is not known; axes x, y, z are taken as "
                                "left, posterior, superior");
    grid.spacingProblem = problemOf(axes, saysScale);
    const bool isKnown = grid.spacingProblem.empty(), hasUnit = !axes[0].unit.empty();
    for (std::size_t i = 0; i < 3; ++i) {
        const double mm = hasUnit ? millimetresOf(axes[i].unit) : 1;
        const auto way = told == 7 ? wayOf(axes[i].orientation) : std::nullopt;
        glm::dvec3 unit{0};
        unit[way ? way->first : patientAxis[i]] = (way && way->second ? -1 : 1) * (isKnown ? mm : 1);
        step[i] = (isKnown ? axes[i].scale : 1) * unit;
        origin += (isKnown ? axes[i].translation : 0) * unit;
    }
    if (isKnown && !hasUnit)
        grid.notes.emplace_back("units of axes are not known; they are taken as millimetres");
    grid.info.type = ValueType::u16; // labels have no type
    grid.info.patientFromVoxel = patientFromVoxelOf(origin, step[2], step[1], step[0]);
    grid.info.validate(where);
}

void takeAxes(OmeGrid& grid, const ZarrArray& array, const std::vector<std::size_t>& ofSpace) {
    for (std::size_t i = 0; i < 3; ++i) {
        grid.axes[i] = ofSpace[i];
        grid.info.extentVoxels[2 - static_cast<int>(i)] = static_cast<int>(array.shape[ofSpace[i]]);
    }
}

} // namespace

std::string pathBelow(const std::string& path, const std::string& where) {
    constexpr std::size_t kMostBytes = 1000;
    std::string_view rest = path;
    bool isGood = !path.empty() && path.size() <= kMostBytes;
    while (isGood && !rest.empty()) {
        const std::size_t slash = rest.find('/');
        const std::string_view name = rest.substr(0, slash);
        isGood = !name.empty() && name != "." && name != ".." && name.find('\0') == std::string_view::npos &&
                 slash + 1 != rest.size();
        rest = slash == std::string_view::npos ? "" : rest.substr(slash + 1);
    }
    if (!isGood)
        throw badFile(where, "a path below the group", "\"" + printable(path.substr(0, 80)) + "\"");
    return path;
}

std::optional<JsonValue> omeAttributesOf(const ZarrNode& node) {
    const JsonValue root(*node.attributes, node.attributesFile);
    if (node.version == 2)
        return root;
    if (!root.has("attributes") || !root.at("attributes").isObject() || !root.at("attributes").has("ome"))
        return std::nullopt;
    return root.at("attributes").at("ome");
}

std::optional<OmeImage> omeImageOf(const ZarrNode& group) {
    const std::optional<JsonValue> ome = omeAttributesOf(group);
    if (!ome || !ome->has("multiscales"))
        return std::nullopt;
    if (group.version == 3 && ome->has("version")) // of version 2 anything may be beside "multiscales"
        checkVersion(ome->at("version"));
    const JsonItems scales = ome->at("multiscales").items(kMostMultiscales, "multiscales");
    if (scales.empty())
        ome->at("multiscales").refuse("a multiscale image");
    const JsonValue first = scales.front();
    if (first.has("version"))
        checkVersion(first.at("version"));
    OmeImage image;
    image.notes = group.notes;
    std::vector<OmeAxis> axes;
    for (const JsonValue row : first.at("axes").items(ZarrArray::kMostAxes, "axes"))
        axes.push_back(omeAxisOf(row));
    const JsonItems datasets = first.at("datasets").items(kMostDatasets, "datasets");
    for (const JsonValue row : datasets) {
        OmeLevel level;
        level.path = pathBelow(row.at("path").text(), row.at("path").place());
        level.axes = axes;
        const bool hasScale = transform(level.axes, row);
        const bool haveScale = transform(level.axes, first); // of all datasets, after a dataset's own
        level.saysScale = hasScale || haveScale;
        image.levels.push_back(std::move(level));
    }
    if (image.levels.empty())
        first.at("datasets").refuse("at least one dataset");
    std::ranges::stable_sort(image.levels, {}, [](const OmeLevel& level) { return voxelOf(level.axes); });
    if (ome->has("omero") && ome->at("omero").isObject() && ome->at("omero").has("channels") &&
        ome->at("omero").at("channels").isList())
        for (const JsonValue row : ome->at("omero").at("channels").items(kMostChannels, "channels"))
            image.channels.push_back(row.isObject() ? printable(textOrNone(row, "label")) : "");
    if (scales.size() > 1)
        image.notes.push_back("the first of " + std::to_string(scales.size()) +
                              " multiscale images is taken");
    return image;
}

OmeGrid omeGridOf(const OmeImage& image, const OmeLevel& level, const ZarrArray& array,
                  const std::string& where) {
    if (level.axes.size() != array.shape.size())
        throw badFile(where, "an axis for each of the array's " + std::to_string(array.shape.size()),
                      std::to_string(level.axes.size()));
    OmeGrid grid;
    grid.notes = image.notes;
    std::vector<std::size_t> ofSpace;
    for (std::size_t axis = 0; axis < level.axes.size(); ++axis) {
        if (level.axes[axis].isOfSpace)
            ofSpace.push_back(axis);
        else
            grid.others.push_back(
                {axis, printable(level.axes[axis].name), array.shape[axis],
                 level.saysScale ? stepSecondsOf(level.axes[axis].scale, level.axes[axis].unit) : 0});
    }
    if (ofSpace.size() != 3)
        throw badFile(where, "three axes of space", std::to_string(ofSpace.size()));
    takeAxes(grid, array, ofSpace);
    placeGrid(grid, {level.axes[ofSpace[0]], level.axes[ofSpace[1]], level.axes[ofSpace[2]]}, level.saysScale,
              where);
    return grid;
}

void requireOneVolume(const OmeGrid& grid, const std::string& where) {
    for (const OmeGrid::Other& other : grid.others)
        if (other.length != 1)
            throw badFile(where, "length 1 along axis \"" + other.name + "\"", std::to_string(other.length));
}

OmeGrid bareGridOf(const ZarrArray& array) {
    std::vector<std::size_t> ofSpace;
    OmeGrid grid;
    const std::size_t axes = array.shape.size();
    for (std::size_t axis = 0; axis < axes; ++axis) {
        if (axis + 3 >= axes)
            ofSpace.push_back(axis);
        else
            grid.others.push_back({axis, std::to_string(axis), array.shape[axis]});
    }
    if (ofSpace.size() != 3)
        throw badFile(array.where, "three axes", std::to_string(axes));
    takeAxes(grid, array, ofSpace);
    std::array<OmeAxis, 3> placed;
    for (std::size_t i = 0; i < 3; ++i)
        placed[i].unit = "millimeter";
    placeGrid(grid, placed, true, array.where);
    return grid;
}

} // namespace tessera
