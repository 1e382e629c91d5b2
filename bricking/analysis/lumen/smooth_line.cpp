// bricking/analysis/lumen/smooth_line.cpp: see smooth_line.h.
#include "bricking/analysis/lumen/smooth_line.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

namespace tessera {

std::vector<double> arcsOf(const std::vector<glm::dvec3>& line) {
    std::vector<double> arcs(line.size(), 0);
    for (std::size_t i = 1; i < line.size(); ++i)
        arcs[i] = arcs[i - 1] + glm::length(line[i] - line[i - 1]);
    return arcs;
}

std::vector<glm::dvec3> blurred(const std::vector<glm::dvec3>& line, const std::vector<double>& deviation) {
    const auto n = static_cast<std::ptrdiff_t>(line.size());
    const auto at = [&](std::ptrdiff_t i) {
        if (i < 0)
            return 2.0 * line.front() - line[static_cast<std::size_t>(std::min(-i, n - 1))];
        if (i >= n)
            return 2.0 * line.back() -
                   line[static_cast<std::size_t>(std::max<std::ptrdiff_t>(2 * (n - 1) - i, 0))];
        return line[static_cast<std::size_t>(i)];
    };
    std::vector<glm::dvec3> out(line.size());
    std::vector<double> weights;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        const double sigma = deviation[static_cast<std::size_t>(i)];
        const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3 * sigma));
        glm::dvec3 sum = line[static_cast<std::size_t>(i)];
        double total = 1;
        for (std::ptrdiff_t d = 1; d <= reach; ++d) {
            const double x = static_cast<double>(d) / sigma, weight = std::exp(-0.5 * x * x);
            sum += weight * (at(i - d) + at(i + d));
            total += 2 * weight;
        }
        out[static_cast<std::size_t>(i)] = sum / total;
    }
    return out;
}

std::vector<glm::dvec3> smoothed(const std::vector<glm::dvec3>& line, const std::vector<double>& deviation) {
    const auto once = blurred(line, deviation), twice = blurred(once, deviation),
               thrice = blurred(twice, deviation);
    std::vector<glm::dvec3> out(line.size());
    for (std::size_t i = 0; i < line.size(); ++i)
        out[i] = 3.0 * once[i] - 3.0 * twice[i] + thrice[i];
    return out;
}

std::vector<double> evenPlaces(const std::vector<glm::dvec3>& line, double spacingMm) {
    const std::vector<double> arcs = arcsOf(line);
    const double pieces = std::max(1.0, std::ceil(arcs.back() / spacingMm - 1e-9));
    std::vector<double> places;
    std::size_t at = 0;
    for (double k = 0; k <= pieces; ++k) {
        const double arc = arcs.back() * k / pieces;
        while (at + 2 < arcs.size() && arcs[at + 1] < arc)
            ++at;
        const double step = arcs[at + 1] - arcs[at];
        places.push_back(static_cast<double>(at) +
                         (step > 0 ? std::clamp((arc - arcs[at]) / step, 0.0, 1.0) : 0.0));
    }
    return places;
}

glm::dvec3 pointAt(const std::vector<glm::dvec3>& line, double place, bool straight) {
    const std::size_t i = std::min(static_cast<std::size_t>(place), line.size() - 2);
    const double t = place - static_cast<double>(i);
    const glm::dvec3 &b = line[i], &c = line[i + 1];
    if (straight)
        return b + t * (c - b);
    const glm::dvec3 a = i > 0 ? line[i - 1] : 2.0 * b - c;
    const glm::dvec3 d = i + 2 < line.size() ? line[i + 2] : 2.0 * c - b;
    return 0.5 *
           (2.0 * b + t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a))));
}

std::vector<glm::dvec3> evenly(const std::vector<glm::dvec3>& line, double spacingMm, bool straight,
                               double& spacing) {
    std::vector<glm::dvec3> fine; // the curve as many short lines, whose lengths sum to its length
    const int parts = straight ? 1 : 8;
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        for (int k = 0; k < parts; ++k)
            fine.push_back(pointAt(line, static_cast<double>(i) + static_cast<double>(k) / parts, straight));
    fine.push_back(line.back());
    const std::vector<double> places = evenPlaces(fine, spacingMm);
    std::vector<glm::dvec3> out;
    for (const double place : places)
        out.push_back(pointAt(fine, place, true));
    spacing = arcsOf(fine).back() / static_cast<double>(out.size() - 1);
    return out;
}

bool stepsHold(const std::vector<glm::dvec3>& points, double spacingMm) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
        if (!(glm::length(points[i + 1] - points[i]) >= kLeastStep * spacingMm))
            return false;
    return true;
}

EvenSteps evenSteps(const std::vector<glm::dvec3>& line, double spacingMm, double leastMm) {
    std::vector<std::size_t> kept(line.size());
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    for (double spacing = spacingMm;;) {
        std::vector<glm::dvec3> points;
        for (const std::size_t i : kept)
            points.push_back(line[i]);
        const std::vector<double> places = evenPlaces(points, spacing);
        EvenSteps out;
        for (const double place : places)
            out.mm.push_back(pointAt(points, place, true));
        out.spacingMm = arcsOf(points).back() / static_cast<double>(places.size() - 1);
        if (kept.size() <= 2 || stepsHold(out.mm, out.spacingMm)) {
            for (const double place : places) {
                const std::size_t i = std::min(static_cast<std::size_t>(place), kept.size() - 2);
                const auto a = static_cast<double>(kept[i]), b = static_cast<double>(kept[i + 1]);
                out.places.push_back(a + (place - static_cast<double>(i)) * (b - a));
            }
            return out;
        }
        if (spacing > leastMm) {
            spacing /= 2;
            continue;
        }
        std::vector<bool> goes(kept.size(), false); // points of the line within a step that turns back
        bool any = false;
        for (std::size_t i = 0; i + 1 < places.size(); ++i)
            if (!(glm::length(out.mm[i + 1] - out.mm[i]) >= kLeastStep * out.spacingMm))
                for (auto k = static_cast<std::size_t>(std::ceil(places[i]));
                     k < kept.size() - 1 && static_cast<double>(k) <= places[i + 1]; ++k)
                    if (k > 0)
                        any = goes[k] = true;
        std::vector<std::size_t> rest;
        for (std::size_t k = 0; k < kept.size(); ++k)
            if (!goes[k] && (any || k == 0 || k + 1 == kept.size()))
                rest.push_back(kept[k]);
        kept = rest;
    }
}

double turnMm(const std::vector<glm::dvec3>& line, std::size_t point, std::size_t reach) {
    if (point < reach || point + reach >= line.size())
        return std::numeric_limits<double>::infinity();
    const glm::dvec3 a = line[point - reach], b = line[point], c = line[point + reach];
    const double area2 = glm::length(glm::cross(b - a, c - a));
    return area2 > 0 ? glm::length(b - a) * glm::length(c - b) * glm::length(c - a) / (2 * area2)
                     : std::numeric_limits<double>::infinity();
}

} // namespace tessera
