// bricking/import/files/nrrd/nrrd_grid.cpp: see nrrd_grid.h.
#include "bricking/import/files/nrrd/nrrd_grid.h"

#include "bricking/import/source/plausible.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <set>
#include <string_view>

namespace tessera {
namespace {

/// Factors from a space's axes to left, posterior, superior; nullopt: the space says nothing of the patient.
std::optional<glm::dvec3> lpsSignsOf(const std::string& space) {
    struct Way {
        std::string_view word;
        int axis;
        double sign;
    };
    static constexpr std::array kWays = {Way{"left", 0, 1},      Way{"right", 0, -1},
                                         Way{"posterior", 1, 1}, Way{"anterior", 1, -1},
                                         Way{"superior", 2, 1},  Way{"inferior", 2, -1}};
    glm::dvec3 signs{0};
    std::string_view rest = space;
    const bool isShort = space.size() == 3;
    for (int axis = 0; axis < 3; ++axis) {
        for (const Way& way : kWays)
            if (way.axis == axis && rest.starts_with(isShort ? way.word.substr(0, 1) : way.word)) {
                signs[axis] = way.sign;
                rest.remove_prefix(isShort ? 1 : way.word.size());
                break;
            }
        if (signs[axis] == 0 || (!isShort && axis < 2 && !rest.starts_with('-')))
            return std::nullopt;
        if (!isShort && axis < 2)
            rest.remove_prefix(1);
    }
    return rest.empty() ? std::optional(signs) : std::nullopt;
}

/// nullopt: a unit that is not known.
std::optional<double> mmOf(const std::string& unit) {
    struct Unit {
        std::string_view name;
        double mm;
    };
    static constexpr std::array kUnits = {
        Unit{"", 1},          Unit{"mm", 1},        Unit{"millimeter", 1}, Unit{"millimeters", 1},
        Unit{"cm", 10},       Unit{"m", 1000},      Unit{"um", 1e-3},      Unit{"\xc2\xb5m", 1e-3},
        Unit{"micron", 1e-3}, Unit{"microns", 1e-3}};
    const auto* const known =
        std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.name == unit; });
    return known == kUnits.end() ? std::nullopt : std::optional(known->mm);
}

/// Of the axes of space, or with directions of those of the patient.
/// @param axes  of space, in the file
std::optional<double> mmPerUnitOf(const NrrdHeader& header, const std::vector<std::size_t>& axes) {
    std::vector<std::string> units = header.spaceUnits;
    if (header.directions.empty()) {
        units.clear();
        for (const std::size_t axis : axes)
            units.push_back(axis < header.units.size() ? header.units[axis] : "");
    }
    if (units.empty())
        return 1;
    const bool isOne = std::adjacent_find(units.begin(), units.end(), std::not_equal_to<>()) == units.end();
    return isOne ? mmOf(units.front()) : std::nullopt;
}

/// The axis of layers, or nullopt where all three are of space.
std::optional<std::size_t> layerAxisOf(const NrrdHeader& header, const std::string& where) {
    const std::size_t axes = header.sizes.size();
    std::vector<std::size_t> found;
    static const std::set<std::string> ofSpace = {"domain", "space", "", "???", "none"};
    for (std::size_t axis = 0; axis < axes; ++axis)
        if (!header.directions.empty() ? !header.directions[axis]
                                       : !header.kinds.empty() && !ofSpace.contains(header.kinds[axis]))
            found.push_back(axis);
    if (axes - found.size() != 3 || found.size() > 1)
        throw badFile(where, "three axes of space, and at most one of layers",
                      std::to_string(axes) + " axes, " + std::to_string(found.size()) +
                          " of them not of space (\"space directions\", \"kinds\")");
    if (found.empty())
        return std::nullopt;
    static const std::set<std::string> ofLayers = {"list", "vector", "none",   "???",
                                                   "",     "stub",   "domain", "time"};
    const std::string kind = header.kinds.empty() ? "" : header.kinds[found.front()];
    if (!ofLayers.contains(kind) && header.sizes[found.front()] != 1)
        throw badFile(where, "an axis of layers of kind \"list\"", "\"" + printable(kind) + "\"");
    return found.front();
}

} // namespace

NrrdGrid nrrdGridOf(const NrrdHeader& header, const std::string& where,
                    const std::optional<glm::dvec3>& spacingMm) {
    NrrdGrid grid;
    const std::optional<std::size_t> layerAxis = layerAxisOf(header, where);
    if (layerAxis) {
        constexpr std::int64_t kMostLayers = 65535;
        if (*layerAxis != 0 && *layerAxis != 3)
            throw badFile(where, "layers along the first axis or the last",
                          "axis " + std::to_string(*layerAxis + 1) + " of 4");
        if (header.sizes[*layerAxis] > kMostLayers)
            throw badFile(where, "at most 65535 layers", std::to_string(header.sizes[*layerAxis]));
        grid.layers = static_cast<int>(header.sizes[*layerAxis]);
        grid.order = grid.layers == 1  ? NrrdGrid::Order::single
                     : *layerAxis == 0 ? NrrdGrid::Order::interleaved
                                       : NrrdGrid::Order::apart;
    }
    std::vector<std::size_t> axes; // of space
    for (std::size_t axis = 0; axis < header.sizes.size(); ++axis)
        if (layerAxis != axis)
            axes.push_back(axis);
    const std::optional<double> unit = mmPerUnitOf(header, axes);
    if (!unit && !spacingMm)
        grid.notes.emplace_back("space units are not known; they are taken as millimetres");
    const double mm = unit.value_or(1);
    std::array<glm::dvec3, 3> step = {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
    const bool hasSpacings = header.directions.empty() && !header.spacings.empty();
    for (std::size_t to = 0; to < 3; ++to) {
        const std::size_t axis = axes[to];
        grid.info.extentVoxels[static_cast<int>(to)] = static_cast<int>(header.sizes[axis]);
        const bool hasSpacing = hasSpacings && !std::isnan(header.spacings[axis]);
        if (!header.directions.empty())
            step[to] = mm * *header.directions[axis];
        else if (hasSpacing)
            step[to] *= mm * header.spacings[axis];
        if (unit && (hasSpacing || !header.directions.empty()))
            continue;
        grid.saysSpacing = false;
        if (spacingMm && glm::length(step[to]) > 0)
            step[to] *= (*spacingMm)[static_cast<int>(to)] / glm::length(step[to]);
        else if (unit)
            grid.notes.push_back("no spacing along axis " + std::to_string(to) + "; it is taken as 1 mm");
    }
    const std::optional<glm::dvec3> signs = lpsSignsOf(header.space);
    grid.info.orientationKnown = signs.has_value() && !header.directions.empty();
    if (!grid.info.orientationKnown)
        grid.notes.emplace_back("the orientation in the patient is not known; axes are taken as left, "
                                "posterior, superior");
    const glm::dvec3 toLps = signs.value_or(glm::dvec3(1));
    const bool hasOrigin = header.origin && (unit || !spacingMm);
    if (header.origin && !hasOrigin)
        grid.notes.emplace_back(
            "\"space origin\" in a unit that is not known; the first voxel is taken to be at "
            "0, 0, 0");
    const glm::dvec3 origin = hasOrigin ? mm * *header.origin : glm::dvec3(0);
    if (grid.info.orientationKnown && !header.origin)
        grid.notes.emplace_back("no \"space origin\"; the first voxel is taken to be at 0, 0, 0");
    grid.info.type = ValueType::u16; // labels have no type
    grid.info.patientFromVoxel =
        patientFromVoxelOf(toLps * origin, toLps * step[0], toLps * step[1], toLps * step[2]);
    const char* const spacing = hasSpacings ? "\"spacings\"" : "\"space directions\"";
    requirePlausibleGeometry(grid.info, {spacing, "\"space directions\"", "\"space origin\""}, where);
    grid.info.validate(where);
    return grid;
}

} // namespace tessera
