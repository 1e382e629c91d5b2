// core/animation/reformed_line.cpp: see reformed_line.h.
#include "core/animation/reformed_line.h"

#include "core/base/error.h"
#include "core/base/fnv_hash.h"
#include "core/base/magnitude.h"
#include "core/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace tessera {
namespace {

/// Directions and curvatures are those over so much of the line to either side: below it centre-lines carry
/// the noise of the voxels that they were found in, and rows would sway to and fro.
constexpr double kSmoothMm = 4;
/// Places of the line for each row, where the length of its projection is summed.
constexpr double kPlacesPerRow = 2;

/// Pixels of a length, at least 1.
int pixelsOf(double mm, double mmPerPixel) {
    const double pixels = std::max(1.0, mm / mmPerPixel);
    if (!(pixels <= Scene::kMaxImageExtent))
        throw badFile("--mm-per-pixel",
                      "at most " + std::to_string(Scene::kMaxImageExtent) +
                          " pixels along a side of the picture",
                      std::to_string(static_cast<long long>(std::min(pixels, 9e15))));
    return static_cast<int>(pixels + 1e-9);
}

/// Of the line, per mm: towards the centre of curvature.
glm::dvec3 curvature(const FlightCurve& line, double mm) {
    const double from = std::max(0.0, mm - kSmoothMm), to = std::min(line.lengthMm(), mm + kSmoothMm);
    return to > from ? (line.tangent(to) - line.tangent(from)) / (to - from) : glm::dvec3(0);
}

Reformation emptyPicture(double heightMm, double widthMm, const ReformedPixels& pixels) {
    Reformation picture;
    picture.columns = pixelsOf(widthMm + 0.5 * pixels.mmPerPixel, pixels.mmPerPixel);
    picture.samples = std::max(1, pixels.samples);
    picture.mmPerPixel = pixels.mmPerPixel;
    picture.rows.resize(static_cast<std::size_t>(pixelsOf(heightMm, pixels.mmPerPixel)) *
                        static_cast<std::size_t>(picture.samples));
    return picture;
}

/// From one place of the line to another, unit; none where it comes back.
glm::dvec3 chord(const FlightCurve& line, double from, double to) {
    const glm::dvec3 way = line.at(to).at - line.at(from).at;
    const double length = glm::length(way);
    return length > 0 ? way / length : glm::dvec3(0);
}

/// The line's direction there, unit: between places that lie as far to either side; near the ends it goes on
/// as it turns before. Where the line turns sharply in between it is the tangent.
glm::dvec3 smoothTangent(const FlightCurve& line, double mm) {
    constexpr double kLeastCosine = 0.3;
    const double length = line.lengthMm(), reach = std::min(kSmoothMm, 0.25 * length),
                 middle = std::clamp(mm, reach, length - reach), beyond = (mm - middle) / reach;
    glm::dvec3 smooth = chord(line, middle - reach, middle + reach);
    if (beyond != 0) { // the next place inwards tells the turn
        const double next = middle - std::copysign(reach, beyond);
        smooth += std::abs(beyond) * (smooth - chord(line, next - reach, next + reach));
    }
    const glm::dvec3 tangent = line.tangent(mm);
    const double size = glm::length(smooth);
    return glm::dot(smooth, tangent) > kLeastCosine * size ? smooth / size : tangent;
}

/// The row through the line there, of a viewer at an angle about it, from the line's up.
ReformedRow rowAt(const FlightCurve& line, double mm, double degrees) {
    const double angle = glm::radians(degrees);
    const Pose pose = line.at(mm);
    const glm::dvec3 tangent = smoothTangent(line, mm);
    const glm::dvec3 up = glm::normalize(pose.up - glm::dot(pose.up, tangent) * tangent);
    ReformedRow row;
    row.at = pose.at;
    row.towards = std::cos(angle) * up + std::sin(angle) * glm::cross(tangent, up);
    row.across = glm::cross(row.towards, tangent);
    row.alongMm = mm;
    return row;
}

/// From the line's up to its upper side (reformed_line.h), degrees about its beginning.
double upperSide(const FlightCurve& line) {
    constexpr double kAlongPatient = 0.70710678; // cosine of 45 degrees
    constexpr double kRounding = 1e-6;
    const Pose pose = line.at(0);
    if (std::abs(pose.direction.z) < kAlongPatient)
        return 0; // up is the head's side
    const glm::dvec3 front(0, -1, 0);
    const double degrees = glm::degrees(
        std::atan2(glm::dot(front, glm::cross(pose.direction, pose.up)), glm::dot(front, pose.up)));
    return std::abs(degrees) < kRounding ? 0 : degrees;
}

} // namespace

Reformation straightened(const FlightCurve& line, double degrees, const ReformedPixels& pixels) {
    Reformation picture = emptyPicture(line.lengthMm(), pixels.widthMm, pixels);
    const double step = picture.mmPerPixel / picture.samples, angle = upperSide(line) + degrees;
    for (std::size_t y = 0; y < picture.rows.size(); ++y) {
        const double mm = (static_cast<double>(y) + 0.5) * step;
        ReformedRow& row = picture.rows[y];
        row = rowAt(line, mm, angle);
        row.lineMm = 0.5 * picture.columns * picture.mmPerPixel;
        const double bend = glm::dot(curvature(line, mm), row.across);
        if (bend > 0)
            row.highMm = 1 / bend;
        else if (bend < 0)
            row.lowMm = 1 / bend;
    }
    return picture;
}

Stretched stretched(const FlightCurve& line, const glm::dvec3& given, const glm::dvec3& up,
                    const ReformedPixels& pixels) {
    checkDirection(given, "a direction of the columns", "--direction");
    const glm::dvec3 direction = glm::normalize(given);
    const double step = pixels.mmPerPixel / std::max(1, pixels.samples);
    const auto places =
        static_cast<std::size_t>(std::ceil(kPlacesPerRow * line.lengthMm() / step)) + std::size_t{2};
    const auto mmOf = [&](std::size_t n) {
        return line.lengthMm() * static_cast<double>(n) / static_cast<double>(places - 1);
    };
    std::vector<double> projected(places); // length of the projection up to there
    glm::dvec3 before{0};
    double low = 0, high = 0;
    for (std::size_t n = 0; n < places; ++n) {
        const glm::dvec3 at = line.at(mmOf(n)).at;
        const double along = glm::dot(at, direction);
        const glm::dvec3 flat = at - along * direction;
        low = n == 0 ? along : std::min(low, along);
        high = n == 0 ? along : std::max(high, along);
        projected[n] = n == 0 ? 0 : projected[n - 1] + glm::distance(flat, before);
        before = flat;
    }
    if (!(projected.back() >= pixels.mmPerPixel))
        throw badFile("--direction", "one at an angle to the line", "one along it");

    Stretched out;
    out.picture = emptyPicture(projected.back(), high - low + pixels.widthMm, pixels);
    const double left = 0.5 * (low + high) - 0.5 * out.picture.columns * pixels.mmPerPixel;
    out.endOnTop = glm::dot(line.at(line.lengthMm()).at - line.at(0).at, up) > 0;
    glm::dvec3 towards{0};
    std::size_t n = 1;
    for (std::size_t y = 0; y < out.picture.rows.size(); ++y) {
        const double wanted = (static_cast<double>(y) + 0.5) * step;
        while (n + 1 < places && projected[n] < wanted)
            ++n;
        const double part = projected[n] - projected[n - 1];
        const double share = part > 0 ? std::clamp((wanted - projected[n - 1]) / part, 0.0, 1.0) : 0.5;
        const double mm = mmOf(n - 1) + share * (mmOf(n) - mmOf(n - 1));
        const Pose pose = line.at(mm);
        ReformedRow row;
        row.at = pose.at;
        row.across = direction;
        row.alongMm = mm;
        row.lineMm = glm::dot(pose.at, direction) - left;
        // The viewer's side: right and up span the picture, and the line runs down, or up.
        const glm::dvec3 side = glm::cross(line.tangent(mm), direction);
        if (const double length = glm::length(side); length > 1e-6) // else as the row before
            towards = (out.endOnTop ? -side : side) / length;
        row.towards = towards;
        out.picture.rows[y] = row;
    }
    if (out.endOnTop)
        std::reverse(out.picture.rows.begin(), out.picture.rows.end());
    return out;
}

std::vector<double> sectionPlaces(const FlightCurve& line, int count) {
    std::vector<double> places;
    for (int n = 0; n < count; ++n)
        places.push_back(line.lengthMm() * (n + 0.5) / count);
    return places;
}

Reformation crossSection(const FlightCurve& line, double mm, double degrees, const ReformedPixels& pixels) {
    Reformation picture = emptyPicture(pixels.widthMm + 0.5 * pixels.mmPerPixel, pixels.widthMm, pixels);
    picture.isSection = true;
    const double step = picture.mmPerPixel / picture.samples;
    const ReformedRow middle = rowAt(line, mm, upperSide(line) + degrees);
    const glm::dvec3 up = middle.towards;
    const double halfMm = 0.5 * picture.size().y * picture.mmPerPixel;
    for (std::size_t y = 0; y < picture.rows.size(); ++y) {
        ReformedRow& row = picture.rows[y];
        row = middle;
        row.at += (halfMm - (static_cast<double>(y) + 0.5) * step) * up;
        row.towards = glm::cross(middle.across, up);
        row.lineMm = 0.5 * picture.columns * picture.mmPerPixel;
    }
    return picture;
}

std::size_t sectionBytes(const ReformedPixels& pixels) {
    const double rows = (pixels.widthMm / pixels.mmPerPixel + 1) * std::max(1, pixels.samples);
    return static_cast<std::size_t>(std::min(1e15, rows * sizeof(ReformedRow)));
}

std::size_t reformedBytes(const FlightCurve& line, const ReformedPixels& pixels) {
    const double rows = line.lengthMm() / pixels.mmPerPixel * std::max(1, pixels.samples) + 2;
    return static_cast<std::size_t>(
        std::min(1e15, rows * (sizeof(ReformedRow) + (kPlacesPerRow + 1) * sizeof(double))));
}

std::string digestOf(const FlightCurve& line) {
    const int places = static_cast<int>(std::clamp(std::ceil(line.lengthMm()), 256.0, 1e6));
    FnvHash hash;
    const auto add = [&](double mm) {
        auto bits = static_cast<std::uint64_t>(std::llround(1000 * mm)); // micrometres
        for (int byte = 0; byte < 8; ++byte, bits >>= 8)
            hash.add(bits & 0xff);
    };
    for (int n = 0; n <= places; ++n) {
        const glm::dvec3 at = line.at(line.lengthMm() * n / places).at;
        for (int axis = 0; axis < 3; ++axis)
            add(at[axis]);
    }
    add(line.lengthMm());
    return hash.digits();
}

} // namespace tessera
