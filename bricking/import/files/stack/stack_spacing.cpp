// bricking/import/files/stack/stack_spacing.cpp: see stack_spacing.h.
#include "bricking/import/files/stack/stack_spacing.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/files/stack/imagej_lines.h"
#include "bricking/import/source/plausible.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace tessera {
namespace {

/// Millimetres; 0: no unit of length that is known.
double millimetresOf(std::string_view unit) {
    struct Unit {
        std::string_view name;
        double mm;
    };
    static constexpr std::array kUnits = {
        Unit{"mm", 1},          Unit{"millimeter", 1}, Unit{"cm", 10},          Unit{"m", 1000},
        Unit{"um", 1e-3},       Unit{"micron", 1e-3},  Unit{"microns", 1e-3},   Unit{"micrometer", 1e-3},
        Unit{"\\u00B5m", 1e-3}, Unit{"\xb5m", 1e-3},   Unit{"\xc2\xb5m", 1e-3}, Unit{"\xce\xbcm", 1e-3},
        Unit{"nm", 1e-6},       Unit{"inch", 25.4},    Unit{"in", 25.4}};
    for (const Unit& row : kUnits)
        if (unit == row.name)
            return row.mm;
    return 0;
}

bool isLength(double mm) {
    return mm >= kLeastSpacingMm && mm <= kMostSpacingMm; // false for NaN
}

/// Of key="value" in an XML element.
std::string attributeOf(std::string_view element, const std::string& key) {
    const std::string begin = " " + key + "=\"";
    const std::size_t at = element.find(begin);
    if (at == std::string_view::npos)
        return "";
    const std::string_view rest = element.substr(at + begin.size());
    return std::string(rest.substr(0, rest.find('"')));
}

std::uint64_t countOf(const std::string& text, std::uint64_t fallback) {
    constexpr std::int64_t kMost = std::int64_t{1} << 31;
    const std::optional<std::int64_t> count = wholeNumberOf(text);
    return count && *count >= 1 && *count <= kMost ? static_cast<std::uint64_t>(*count) : fallback;
}

void takeImageJ(const PictureHead& head, StackLattice& lattice) {
    const std::string& text = head.description;
    lattice.images = countOf(imageJLine(text, "images"), 0);
    lattice.others = countOf(imageJLine(text, "channels"), 1) * countOf(imageJLine(text, "frames"), 1);
    const std::string unit = imageJLine(text, "unit"), yUnit = imageJLine(text, "yunit"),
                      zUnit = imageJLine(text, "zunit"), spacing = imageJLine(text, "spacing");
    const double mm = unit.empty() ? head.unitMm : millimetresOf(unit),
                 yMm = yUnit.empty() ? mm : millimetresOf(yUnit),
                 zMm = zUnit.empty() ? mm : millimetresOf(zUnit);
    lattice.pixelMm.reset(); // the tag's unit gives way to the description's
    if (head.perUnit && isLength(mm / head.perUnit->x) && isLength(yMm / head.perUnit->y))
        lattice.pixelMm = glm::dvec2(mm, yMm) / *head.perUnit;
    // ImageJ leaves out a spacing of 1.
    const bool isOne = spacing.empty() && !(unit.empty() && zUnit.empty()) &&
                       std::max(lattice.images, countOf(imageJLine(text, "slices"), 1)) > 1;
    const double between = zMm * (isOne ? 1 : realNumberOf(spacing).value_or(0));
    if (isLength(between))
        lattice.sliceMm = between;
}

void takeOme(const PictureHead& head, StackLattice& lattice) {
    const std::size_t begin = head.description.find("<Pixels ");
    if (begin == std::string::npos)
        return;
    const std::string_view rest = std::string_view(head.description).substr(begin),
                           pixels = rest.substr(0, rest.find('>'));
    lattice.others = countOf(attributeOf(pixels, "SizeC"), 1) * countOf(attributeOf(pixels, "SizeT"), 1);
    lattice.images = lattice.others * countOf(attributeOf(pixels, "SizeZ"), 1);
    const auto size = [&](const std::string& axis) {
        const std::string unit = attributeOf(pixels, "PhysicalSize" + axis + "Unit");
        constexpr double kMicrometre = 1e-3; // the format's own unit
        return (unit.empty() ? kMicrometre : millimetresOf(unit)) *
               realNumberOf(attributeOf(pixels, "PhysicalSize" + axis)).value_or(0);
    };
    lattice.pixelMm.reset();
    if (isLength(size("X")) && isLength(size("Y")))
        lattice.pixelMm = glm::dvec2(size("X"), size("Y"));
    if (isLength(size("Z")))
        lattice.sliceMm = size("Z");
}

} // namespace

std::string StackLattice::said() const {
    const std::string within =
        pixelMm ? numberText(pixelMm->x) + " x " + numberText(pixelMm->y) + " mm within slices" : "";
    const std::string between = sliceMm ? numberText(*sliceMm) + " mm between slices" : "";
    if (within.empty() && between.empty())
        return "no spacing";
    return within.empty()    ? between + ", nothing within them"
           : between.empty() ? within + ", nothing between them"
                             : within + ", " + between;
}

StackLattice latticeOf(const PictureHead& head) {
    StackLattice lattice;
    if (head.perUnit && head.unitMm > 0 && isLength(head.unitMm / head.perUnit->x) &&
        isLength(head.unitMm / head.perUnit->y))
        lattice.pixelMm = head.unitMm / *head.perUnit;
    if (isOfImageJ(head.description))
        takeImageJ(head, lattice);
    else if (head.description.find("<OME") != std::string::npos)
        takeOme(head, lattice);
    return lattice;
}

} // namespace tessera
