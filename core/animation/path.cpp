// core/animation/path.cpp: see path.h.
#include "core/animation/path.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {

// What a path must be, whoever made it. Reading and writing is path_json.cpp.

namespace {

std::string number(double value) {
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.')
        text.pop_back();
    return text;
}

std::string nameOf(const std::string& where, const char* list, std::size_t i) {
    return where + ": $." + list + "[" + std::to_string(i) + "]";
}

/// Limits of the chord, in spacings, of an evenly spaced line. Bends shorten the chord; rounding lengthens
/// it.
constexpr double kShortestChord = 0.5, kLongestChord = 1.001;

void checkLine(const CentreLine& line, const std::string& where) {
    if (line.points.size() < CentreLine::kFewestPoints)
        throw badFile(where + ".points", "at least " + std::to_string(CentreLine::kFewestPoints) + " points",
                      std::to_string(line.points.size()));
    if (line.radiusMm.size() != line.points.size())
        throw badFile(where + ".radius",
                      "a radius for each of " + std::to_string(line.points.size()) + " points",
                      std::to_string(line.radiusMm.size()));
    if (!(line.spacingMm > 0 && std::isfinite(line.spacingMm)))
        throw badFile(where + ".spacing", "a positive number of mm", number(line.spacingMm));
    for (std::size_t i = 0; i < line.points.size(); ++i) {
        const std::string at = "[" + std::to_string(i) + "]";
        for (int axis = 0; axis < 3; ++axis)
            if (!std::isfinite(line.points[i][axis]))
                throw badFile(where + ".points" + at, "finite numbers", "one that is not");
        if (!(line.radiusMm[i] >= 0 && std::isfinite(line.radiusMm[i])))
            throw badFile(where + ".radius" + at, "a number of mm from 0 on", number(line.radiusMm[i]));
        if (i == 0)
            continue;
        const double chord = glm::length(line.points[i] - line.points[i - 1]);
        if (!(chord >= kShortestChord * line.spacingMm && chord <= kLongestChord * line.spacingMm))
            throw badFile(where + ".points" + at,
                          "about " + number(line.spacingMm) +
                              " mm from the point before, as \"spacing\" says",
                          number(chord) + " mm");
    }
}

void checkParent(const Path& path, std::size_t i, const std::string& where) {
    const CentreLine& line = path.lines[i];
    if (!line.parent)
        return;
    if (*line.parent >= i)
        throw badFile(where + ".parent", "the number of an earlier line", std::to_string(*line.parent));
    const CentreLine& parent = path.lines[*line.parent];
    if (!(line.leavesAtMm >= 0 && line.leavesAtMm <= parent.lengthMm() * (1 + 1e-9)))
        throw badFile(where + ".leavesAt", "a place on its parent, 0 to " + number(parent.lengthMm()) + " mm",
                      number(line.leavesAtMm));
    const auto nearest = std::min(static_cast<std::size_t>(std::lround(line.leavesAtMm / parent.spacingMm)),
                                  parent.points.size() - 1);
    const double away = glm::length(line.points.front() - parent.points[nearest]);
    const double reach = std::max(parent.radiusMm[nearest], line.spacingMm) + parent.spacingMm;
    if (away > reach)
        throw badFile(where + ".points[0]",
                      "a place inside its parent's lumen at \"leavesAt\", within " + number(reach) + " mm",
                      number(away) + " mm away");
}

void checkFlight(const Path& path, const std::string& where) {
    const Flight& flight = *path.flight;
    const std::string at = where + ": $.flight";
    if (flight.route.empty())
        throw badFile(at + ".route", "at least one line", "none");
    for (std::size_t k = 0; k < flight.route.size(); ++k) {
        const std::size_t line = flight.route[k];
        if (line >= path.lines.size())
            throw badFile(at + ".route", "numbers of lines, below " + std::to_string(path.lines.size()),
                          std::to_string(line));
        if (k > 0 && path.lines[line].parent != flight.route[k - 1])
            throw badFile(at + ".route",
                          "each line a child of the one before, line " + std::to_string(flight.route[k - 1]),
                          "line " + std::to_string(line));
    }
    const double length = routeOf(path.lines, flight.route).back().alongMm;
    const double to = flight.toMm.value_or(length);
    if (!(flight.fromMm >= 0 && flight.fromMm < to && to <= length * (1 + 1e-9)))
        throw badFile(at, "\"from\" below \"to\", both on the route, 0 to " + number(length) + " mm",
                      number(flight.fromMm) + " and " + number(to));
}

void checkKeyframes(const Path& path, const std::string& where) {
    double before = -1, from = 0, to = 0, speed = 1;
    if (path.flight) {
        from = path.flight->fromMm;
        to = path.flight->toMm.value_or(routeOf(path.lines, path.flight->route).back().alongMm);
        speed = path.flight->speedMmPerS;
    }
    for (std::size_t i = 0; i < path.keyframes.size(); ++i) {
        const Keyframe& key = path.keyframes[i];
        const std::string at = nameOf(where, "keyframes", i);
        if (key.timeS.has_value() == key.placeMm.has_value())
            throw badFile(at, "one of \"time\" and \"place\"", key.timeS ? "both" : "neither");
        if (key.placeMm && !path.flight)
            throw badFile(at, "\"time\": places are along the line of a \"flight\"",
                          "\"place\" and no flight");
        if (key.camera && path.flight)
            throw badFile(at, "\"look\" where a line is flown", "\"camera\"");
        if (key.look && !path.flight)
            throw badFile(at, "\"camera\" where no line is flown", "\"look\"");
        if (!key.camera && !key.look && !key.transferFunction && !key.lighting && !key.cuts)
            throw badFile(at, "a camera, a look, a transferFunction, lighting or cuts", "none");
        double moment = key.timeS.value_or(0);
        if (key.placeMm) {
            if (!(*key.placeMm >= from && *key.placeMm <= to))
                throw badFile(at + ".place",
                              "a place that is flown over, " + number(from) + " to " + number(to) + " mm",
                              number(*key.placeMm));
            moment = (path.flight->backwards ? to - *key.placeMm : *key.placeMm - from) / speed;
        }
        if (!(moment >= 0 && moment > before))
            throw badFile(at, "a moment after the keyframe before it", number(moment) + " s");
        before = moment;
    }
}

} // namespace

Path flightAlone(const Path& path) {
    Path alone;
    alone.volume = path.volume;
    alone.flight = path.flight.value();
    alone.flight->route.clear();
    for (const std::size_t number : path.flight->route) {
        const std::size_t n = alone.lines.size();
        alone.lines.push_back(path.lines.at(number));
        CentreLine& line = alone.lines.back();
        line.name.clear();
        line.parent.reset();
        if (n > 0)
            line.parent = n - 1;
        else
            line.leavesAtMm = 0;
        alone.flight->route.push_back(n);
    }
    return alone;
}

std::vector<RoutePoint> routeOf(const std::vector<CentreLine>& lines, const std::vector<std::size_t>& route) {
    TESSERA_CHECK(!route.empty());
    std::vector<RoutePoint> points;
    for (std::size_t k = 0; k < route.size(); ++k) {
        const CentreLine& line = lines.at(route[k]);
        const bool goesOn = k + 1 < route.size();
        const double end = goesOn ? lines.at(route[k + 1]).leavesAtMm : line.lengthMm();
        // A point within half a spacing of where the next one begins would make a kink.
        const double last = goesOn ? end - 0.5 * line.spacingMm : end * (1 + 1e-9);
        bool begun = false;
        for (std::size_t i = 0; i < line.points.size(); ++i) {
            if (line.spacingMm * static_cast<double>(i) > last && !points.empty())
                break;
            RoutePoint p{line.points[i], line.radiusMm[i], 0};
            if (!points.empty()) {
                const double step = begun ? line.spacingMm : glm::length(p.at - points.back().at);
                if (!(step > 0.25 * line.spacingMm)) // the branch's first point is the parent's last
                    continue;
                p.alongMm = points.back().alongMm + step;
            }
            begun = true;
            points.push_back(p);
        }
    }
    return points;
}

void checkPath(const Path& path, const std::string& where) {
    if (path.lines.empty() && path.keyframes.empty())
        throw badFile(where, "\"lines\" or \"keyframes\"", "neither");
    for (std::size_t i = 0; i < path.lines.size(); ++i) {
        const std::string at = nameOf(where, "lines", i);
        checkLine(path.lines[i], at);
        checkParent(path, i, at);
    }
    if (path.flight)
        checkFlight(path, where);
    checkKeyframes(path, where);
}

LinesExtent extentOf(const std::vector<CentreLine>& lines) {
    LinesExtent extent;
    for (const CentreLine& line : lines) {
        extent.lengthMm += line.lengthMm();
        for (const double radius : line.radiusMm) {
            if (radius > 0 && (extent.narrowestMm == 0 || radius < extent.narrowestMm))
                extent.narrowestMm = radius;
            extent.widestMm = std::max(extent.widestMm, radius);
        }
    }
    return extent;
}

std::string linesText(const std::vector<CentreLine>& lines) {
    const LinesExtent extent = extentOf(lines);
    return (lines.size() == 1 ? "a line" : std::to_string(lines.size()) + " branches") + " of " +
           mmText(extent.lengthMm) + ", " + mmText(extent.narrowestMm) + " to " + mmText(extent.widestMm) +
           " from the wall";
}

std::string doubtText(const Lumen& lumen) {
    if (lumen.leaks)
        return "this line may have left the lumen" +
               (lumen.leavesAtMm ? " at " + mmText(*lumen.leavesAtMm) : "") + ": it leaks at its threshold";
    if (lumen.unsure)
        return "this line may lie outside of the lumen: its threshold hardly differs from the noise in it";
    return {};
}

} // namespace tessera
