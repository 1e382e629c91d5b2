// viewer/cli/render/reformed_marks.cpp: see reformed_marks.h.
#include "viewer/cli/render/reformed_marks.h"

#include "core/base/shown_text.h"
#include "viewer/session/patient_letters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <utility>

namespace tessera {
namespace {

/// Whole mm, or as many decimals as tell one section from the next.
std::string placeText(double mm, double distanceMm) {
    constexpr double kWhole = 10, kTenths = 1;
    char text[32];
    std::snprintf(text, sizeof text, "%.*f mm", distanceMm >= kWhole ? 0 : distanceMm >= kTenths ? 1 : 2, mm);
    return text;
}

/// From the upper edge to the row that goes through the line there, pixels.
double heightOf(const Reformation& picture, double mm) {
    const auto nearest = std::ranges::min_element(
        picture.rows, {}, [mm](const ReformedRow& row) { return std::abs(row.alongMm - mm); });
    return (static_cast<double>(nearest - picture.rows.begin()) + 0.5) / picture.samples;
}

} // namespace

std::vector<InnerPicture> innerPictures(const std::vector<Reformation>& pictures, bool straight,
                                        const ReformedWords& words) {
    const double distanceMm =
        words.lineMm / static_cast<double>(std::max<std::size_t>(1, words.sectionMm.size()));
    std::vector<InnerPicture> all;
    std::size_t section = 0;
    for (std::size_t n = 0; n < pictures.size(); ++n) {
        const Reformation& picture = pictures[n];
        InnerPicture inner;
        inner.from = picture.from;
        inner.size = picture.size();
        const ReformedRow& first = picture.rows.front();
        if (words.letters) {
            inner.left = directionLetters(-first.across);
            inner.right = directionLetters(first.across);
        }
        if (picture.isSection) {
            inner.words = placeText(words.sectionMm.at(section++), distanceMm);
            if (words.letters) {
                const glm::dvec3 up = glm::cross(first.towards, first.across);
                inner.top = directionLetters(up);
                inner.bottom = directionLetters(-up);
            }
        } else {
            inner.lettersOnTop = straight;
            if (n < words.angles.size())
                inner.words = numberText(words.angles[n]) + "\u00b0";
            for (const double mm : words.sectionMm)
                inner.ticks.push_back({heightOf(picture, mm), n == 0 ? placeText(mm, distanceMm) : ""});
        }
        all.push_back(std::move(inner));
    }
    return all;
}

} // namespace tessera
