// bricking/import/files/stack/stack_spacing.cpp: see stack_spacing.h.
#include "bricking/import/files/stack/stack_spacing.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/files/stack/imagej_lines.h"
#include "bricking/import/source/length_units.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace tessera {
namespace {

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
                       countOf(imageJLine(text, "slices"), lattice.images / lattice.others) > 1;
    const double between = zMm * (isOne ? 1 : realNumberOf(spacing).value_or(0));
    if (isLength(between))
        lattice.sliceMm = between;
}

void takeOme(const OmeTiffImage& image, StackLattice& lattice) {
    lattice.others = static_cast<std::uint64_t>(image.volumes());
    lattice.pixelMm = image.pixelMm;
    lattice.sliceMm = image.sliceMm;
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
    else if (isOfOme(head.description))
        if (const OmeText text = readOmeText(head.description); !text.images.empty())
            takeOme(text.images.front(), lattice);
    return lattice;
}

StackLattice latticeOf(const OmeTiffImage& image) {
    StackLattice lattice;
    takeOme(image, lattice);
    lattice.others = 1; // one of its volumes
    return lattice;
}

} // namespace tessera
