// viewer/python/lumen.cpp: see lumen.h.
#include "viewer/python/lumen.h"

#include "bricking/analysis/lumen/centreline.h"
#include "bricking/analysis/lumen/wall_coverage.h"
#include "bricking/store/store_reader.h"
#include "core/animation/flight.h"
#include "core/animation/path.h"
#include "core/base/error.h"
#include "viewer/python/call.h"
#include "viewer/python/volume.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <string>
#include <utility>
#include <vector>

namespace tessera::python {
namespace {

using Point = std::array<double, 3>;

py::array_t<double> arrayOf(const std::vector<glm::dvec3>& points) {
    py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
    static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
    std::memcpy(out.mutable_data(), points.data(), points.size() * sizeof(glm::dvec3));
    return out;
}

/// @return lines, the path as JSON text, what is known of the lumen in words, and notes
py::dict centreline(Volume& volume, const Point& from, const std::optional<Point>& to,
                    const std::vector<Point>& through, const std::optional<double>& threshold, bool mayLeak,
                    bool tree, int generations, double spacing, py::object progress) {
    Call call(std::move(progress));
    const auto placeOf = [](const Point& p) { return glm::dvec3(p[0], p[1], p[2]); };
    CentrelineRequest request;
    request.seeds.push_back({placeOf(from), "start"});
    for (const Point& point : through)
        request.seeds.push_back({placeOf(point), "through", true});
    if (to)
        request.seeds.push_back({placeOf(*to), "end"});
    request.threshold = threshold;
    request.mayLeak = mayLeak;
    request.tree = tree;
    request.mostGenerations = generations;
    request.spacingMm = spacing;
    Centrelines found;
    Path path;
    call.run([&] {
        found = findCentrelines(volume.store(), request, volume.ram(), *call.common().progress);
        path.volume = {volume.store().contentHash(), volume.info().extentVoxels};
        path.lumen = found.lumen;
        path.lines = found.lines;
        checkPath(path, "centreline");
    });
    py::list lines;
    for (const CentreLine& line : path.lines) {
        py::dict one;
        one["points"] = arrayOf(line.points);
        one["radii"] =
            py::array_t<double>(static_cast<py::ssize_t>(line.radiusMm.size()), line.radiusMm.data());
        one["parent"] = line.parent;
        one["length"] = line.lengthMm();
        lines.append(one);
    }
    py::dict out;
    out["lines"] = lines;
    out["path"] = pathJson(path);
    out["about"] = lumenText(found, volume.info().unit);
    out["notes"] = call.notes();
    return out;
}

/// The path as the arguments have it, made in this volume.
Path flownPath(const std::string& text, const std::string& where, const StoreReader& store, double viewAngle,
               bool backwards) {
    Path path = parsePath(text, where);
    if (path.lines.empty() || !path.lumen)
        throw badFile(where, "a path with a line and its lumen, as tessera.centreline() has it",
                      path.lines.empty() ? "no line" : "no \"lumen\"");
    if (path.volume && path.volume->contentHash != store.contentHash())
        throw badFile(where, "a path made in this volume", "one made in another volume");
    if (!path.flight)
        path.flight = Flight{};
    if (backwards && !path.flight->backwards)
        path = flownTheOtherWay(std::move(path));
    if (viewAngle > 0)
        path.flight->viewAngle = viewAngle;
    return path;
}

py::dict coverage(Volume& volume, const std::string& text, const std::string& where, double aspect,
                  double viewAngle, double every, bool backwards, bool bothWays, double farthest,
                  double smallest, py::object progress) {
    Call call(std::move(progress));
    WallCoverage found;
    call.run([&] {
        const Path path = flownPath(text, where, volume.store(), viewAngle, backwards);
        CoverageRequest request;
        request.lines = path.lines;
        request.flight = *path.flight;
        request.lumen = *path.lumen;
        request.cameras = flightCameras(path, every, bothWays);
        request.aspect = aspect;
        if (farthest > 0)
            request.farthestMm = farthest;
        request.smallestPatchMm2 = smallest;
        request.where = where;
        found = measureWallCoverage(volume.store(), request, volume.ram(), *call.common().progress);
    });
    py::list patches;
    for (const UnseenPatch& patch : found.patches) {
        py::dict one;
        one["middle"] = py::make_tuple(patch.middleMm.x, patch.middleMm.y, patch.middleMm.z);
        one["area_mm2"] = patch.areaMm2;
        one["along_mm"] = patch.alongMm;
        one["from_mm"] = patch.fromMm;
        one["to_mm"] = patch.toMm;
        patches.append(one);
    }
    py::dict out;
    out["share"] = found.share();
    out["wall_mm2"] = found.wallMm2;
    out["seen_mm2"] = found.seenMm2;
    out["patches"] = patches;
    return out;
}

} // namespace

void addLumen(py::module_& module) {
    module.def("centreline", &centreline, py::arg("volume"), py::arg("start"), py::arg("end"),
               py::arg("through"), py::arg("threshold"), py::arg("may_leak"), py::arg("tree"),
               py::arg("generations"), py::arg("spacing"), py::arg("progress"));
    module.def("coverage", &coverage, py::arg("volume"), py::arg("path"), py::arg("where"), py::arg("aspect"),
               py::arg("view_angle"), py::arg("every"), py::arg("backwards"), py::arg("both_ways"),
               py::arg("farthest"), py::arg("smallest"), py::arg("progress"));
}

} // namespace tessera::python
