// viewer/python/parts.cpp: see parts.h.
#include "viewer/python/parts.h"

#include "bricking/analysis/body/body_box.h"
#include "bricking/analysis/body/table_mask.h"
#include "bricking/analysis/surface/surface_lattice.h"
#include "bricking/analysis/surface/surface_mesh.h"
#include "bricking/export/box_source.h"
#include "bricking/labels/label_volume.h"
#include "bricking/statistics/statistics.h"
#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/image/colour.h"
#include "core/scene/labels.h"
#include "viewer/cli/input/label_input.h"
#include "viewer/cli/options/options.h"
#include "viewer/python/call.h"
#include "viewer/python/volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tessera::python {
namespace {

void requireHu(const Volume& volume, const char* what) {
    if (volume.info().unit != "HU")
        throw badFile(what, "values in HU (unit=\"HU\")",
                      volume.info().unit.empty() ? "values without a unit" : volume.info().unit);
}

/// Labels of a file or folder on the volume's lattice: numbers of sets, the labels of every set, and labels.
py::dict labels(Volume& volume, const std::string& path, bool sameFrame, int level, const std::string& ram,
                py::object progress) {
    Call call(std::move(progress));
    const std::size_t bytes = budgetBytes(ram, "ram", call.common());
    const LevelBox box = wholeLevel(volume.info(), level);
    const glm::ivec3 extent = box.extent();
    LabelTable table;
    std::filesystem::path store;
    call.run([&] {
        MemoryBudget budget("RAM", "ram", bytes);
        Labels wanted;
        wanted.path = path;
        wanted.sameFrame = sameFrame;
        importLabelsFor(volume.info(), wanted, budget, call.common());
        const LabelVolume found(wanted.store, budget);
        requireSameGrid(found.voxels(), volume.info());
        table = found.table();
        store = wanted.store;
    });
    py::array sets(labelTypeOf(table) == ValueType::u8 ? py::dtype::of<std::uint8_t>()
                                                       : py::dtype::of<std::uint16_t>(),
                   std::vector<py::ssize_t>{extent.z, extent.y, extent.x});
    const std::span<std::byte> out(static_cast<std::byte*>(sets.mutable_data()),
                                   static_cast<std::size_t>(sets.nbytes()));
    call.run([&] {
        MemoryBudget budget("RAM", "ram", bytes);
        const StoreReader voxels(store, budget);
        BoxSource source(voxels, box, budget);
        const std::size_t slice = sliceBytesOf(source.info());
        while (const int count = source.slicesOfChunks()) {
            checkInterrupted();
            source.readSlices(count, out.subspan(slice * static_cast<std::size_t>(source.nextSlice()),
                                                 slice * static_cast<std::size_t>(count)));
        }
    });
    py::list all;
    for (const Label& label : table.labels) {
        py::dict one;
        one["value"] = label.value;
        one["name"] = label.name;
        one["group"] = label.group;
        one["colour"] = py::none();
        if (label.colour)
            one["colour"] = py::make_tuple(srgbFromLinear(static_cast<double>(label.colour->r)),
                                           srgbFromLinear(static_cast<double>(label.colour->g)),
                                           srgbFromLinear(static_cast<double>(label.colour->b)));
        all.append(one);
    }
    py::dict found;
    found["sets"] = sets;
    found["of_sets"] = table.sets;
    found["labels"] = all;
    found["notes"] = call.notes();
    return found;
}

/// The patient's box, mm, and litres of body, and of what is none.
py::dict body(Volume& volume) {
    requireHu(volume, "body");
    Call call((py::none()));
    BodyBox found;
    call.run([&] { found = findBody(volume.store(), volume.ram()); });
    py::dict out;
    out["low"] = py::make_tuple(found.low.x, found.low.y, found.low.z);
    out["high"] = py::make_tuple(found.high.x, found.high.y, found.high.z);
    out["litres"] = found.litres;
    out["litres_left_out"] = found.litresLeftOut;
    return out;
}

/// The table: shares of a level's samples that are hidden, 0 to 255; none where it is not sure.
py::dict table(Volume& volume) {
    requireHu(volume, "table");
    Call call((py::none()));
    FoundTable found;
    call.run([&] { found = findTable(volume.store(), volume.ram(), 0); });
    py::dict out;
    out["litres"] = found.litres;
    out["why"] = found.why;
    out["mask"] = py::none();
    out["level"] = py::none();
    if (found.mask) {
        const glm::ivec3 extent = levelExtent(volume.info().extentVoxels, found.mask->level());
        py::array_t<std::uint8_t> mask({extent.z, extent.y, extent.x});
        std::copy(found.mask->shares().begin(), found.mask->shares().end(), mask.mutable_data());
        out["mask"] = mask;
        out["level"] = found.mask->level();
    }
    return out;
}

/// A surface's points and triangles: counted, or put into arrays that have room for as many.
class ArraySink final : public MeshSink {
  public:
    /// @param points, triangles  null: nothing is kept
    ArraySink(double* points, std::uint32_t* triangles) : points_(points), triangles_(triangles) {}
    void point(const glm::dvec3& mm) override {
        for (int axis = 0; points_ && axis < 3; ++axis)
            *points_++ = mm[axis];
    }
    void triangle(const std::array<std::uint32_t, 3>& numbers, const std::array<glm::dvec3, 3>&) override {
        if (triangles_)
            triangles_ = std::copy(numbers.begin(), numbers.end(), triangles_);
    }

  private:
    double* points_;
    std::uint32_t* triangles_;
};

/// The closed surface of a value. It is found twice: its size first, so that arrays are made once.
py::dict surface(Volume& volume, double value, int level, py::object progress) {
    Call call(std::move(progress));
    if (!std::isfinite(value))
        throw badFile("value", "a finite number", std::to_string(value));
    SurfaceCounts counts;
    std::optional<Statistics> statistics;
    const auto find = [&](MeshSink& sink) {
        const VolumeInfo& info = volume.info();
        const SurfaceLattice lattice(info, {glm::dvec3(0), glm::dvec3(info.extentVoxels)},
                                     wholeLevel(info, level).level, "volume");
        SurfaceRequest request;
        request.value = value;
        counts = extractSurface(volume.store(), lattice,
                                {statistics->cells, statistics->cellMin, statistics->cellMax, 1}, request,
                                volume.ram(), sink, call.common().progress->shares());
    };
    call.run([&] {
        statistics = loadStatistics(volume.store(), volume.ram(), 0);
        call.common().progress->stage("counting triangles");
        ArraySink nothing(nullptr, nullptr);
        find(nothing);
    });
    py::array_t<double> points({static_cast<py::ssize_t>(counts.points), py::ssize_t{3}});
    py::array_t<std::uint32_t> triangles({static_cast<py::ssize_t>(counts.triangles), py::ssize_t{3}});
    ArraySink arrays(points.mutable_data(), triangles.mutable_data());
    call.run([&] {
        call.common().progress->stage("finding the surface");
        find(arrays);
    });
    py::dict out;
    out["points"] = points;
    out["triangles"] = triangles;
    out["volume_ml"] = counts.volumeMm3 / 1000;
    out["area_cm2"] = counts.areaMm2 / 100;
    return out;
}

} // namespace

void addParts(py::module_& module) {
    module.def("labels", &labels, py::arg("volume"), py::arg("path"), py::arg("same_frame"), py::arg("level"),
               py::arg("ram"), py::arg("progress"));
    module.def("body", &body, py::arg("volume"));
    module.def("table", &table, py::arg("volume"));
    module.def("surface", &surface, py::arg("volume"), py::arg("value"), py::arg("level"),
               py::arg("progress"));
}

} // namespace tessera::python
