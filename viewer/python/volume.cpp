// viewer/python/volume.cpp: see volume.h.
#include "viewer/python/volume.h"

#include "bricking/export/box_source.h"
#include "bricking/export/exported_values.h"
#include "bricking/import/importer.h"
#include "bricking/statistics/statistics.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/program_folders.h"
#include "datasets/phantom.h"
#include "viewer/cli/input/phase_input.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/options/command.h"
#include "viewer/cli/options/command_table.h"
#include "viewer/python/array_source.h"
#include "viewer/python/call.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <mutex>
#include <optional>
#include <pybind11/stl.h>
#include <set>
#include <span>
#include <tuple>
#include <unistd.h>
#include <utility>

namespace tessera::python {
namespace {

namespace fs = std::filesystem;

/// The folder of a temporary store. A process that was forked leaves it to the one that made it.
class TemporaryStore {
  public:
    TemporaryStore() : folder_(std::make_unique<ScratchFolder>()), maker_(::getpid()) {
        const std::lock_guard lock(mutex());
        all().insert(this);
    }
    ~TemporaryStore() {
        const std::lock_guard lock(mutex());
        all().erase(this);
        close();
    }
    TemporaryStore(const TemporaryStore&) = delete;
    TemporaryStore& operator=(const TemporaryStore&) = delete;
    fs::path path() const { return *folder_ / "array.zarr"; }

    static void removeAll() {
        const std::lock_guard lock(mutex());
        for (TemporaryStore* each : all())
            each->close();
    }

  private:
    void close() {
        if (::getpid() != maker_)
            static_cast<void>(folder_.release());
        folder_.reset();
    }
    static std::mutex& mutex() {
        static std::mutex one;
        return one;
    }
    static std::set<TemporaryStore*>& all() {
        static std::set<TemporaryStore*> stores;
        return stores;
    }
    std::unique_ptr<ScratchFolder> folder_;
    pid_t maker_;
};

/// Adds the options of source files to a command line, as a command.
Command addOpen(CommandLine& line, std::string& in, InputOptions& input) {
    Command open = line.program().command("open", "");
    open.option("IN", in, "");
    addSelectionOptions(open, input);
    addSpacingOption(open, input);
    return open;
}

std::vector<std::string> optionsOfOpen() {
    InputOptions input;
    std::string in;
    CommandLine line("tessera", TESSERA_VERSION, "");
    return longNames(addOpen(line, in, input).table());
}

/// The options of source files, by the words of a command line.
InputOptions inputOf(std::vector<std::string> words) {
    InputOptions input;
    std::string in;
    CommandLine line("tessera", TESSERA_VERSION, "");
    addOpen(line, in, input);
    words.insert(words.begin(), {"tessera", "open"});
    std::vector<char*> pointers;
    for (std::string& word : words)
        pointers.push_back(word.data());
    line.parse(static_cast<int>(pointers.size()), pointers.data());
    return input;
}

/// Labels of the phases of what the words choose; empty: it has one.
std::vector<std::string> phasesOfPath(const std::string& path, const std::vector<std::string>& words) {
    std::vector<std::string> labels;
    Call((py::none())).run([&] { labels = phasesOf(path, inputOf(words)).labels; });
    return labels;
}

/// @param unit  of values whose source says none; "": as the source says
std::unique_ptr<Volume> openPath(const std::string& path, const std::vector<std::string>& words,
                                 const std::string& unit, const std::string& ram, py::object progress) {
    Call call(std::move(progress));
    const InputOptions input = inputOf(words);
    const std::size_t bytes = budgetBytes(ram, "ram", call.common());
    std::unique_ptr<Volume> volume;
    call.run([&] {
        fs::path store;
        { // the import's memory is free again before the reader takes its own
            MemoryBudget budget("RAM", "ram", bytes);
            store = storeFor(path, input, budget, call.common());
        }
        volume = std::make_unique<Volume>(store, bytes, *call.common().kept);
        if (!unit.empty())
            volume->setUnit(unit);
    });
    volume->notes = call.notes();
    return volume;
}

/// A source's import in a temporary store.
std::unique_ptr<Volume> openTemporary(Call& call, const std::string& stage, const std::string& ram,
                                      const std::function<std::unique_ptr<SlabSource>()>& open) {
    const std::size_t bytes = budgetBytes(ram, "ram", call.common());
    std::unique_ptr<Volume> volume;
    call.run([&] {
        const std::unique_ptr<SlabSource> source = open();
        const auto place = std::make_shared<TemporaryStore>();
        call.common().progress->stage(stage);
        {
            MemoryBudget budget("RAM", "ram", bytes);
            ImportOptions options;
            options.durable = false;
            options.progress = call.common().progress.get();
            const ImportReport report = importToStore(*source, place->path(), budget, options);
            for (const std::string& line : report.notes)
                call.common().note(line);
            for (const std::string& line : sayChanges(report.info))
                call.common().note(line);
        }
        volume = std::make_unique<Volume>(place->path(), bytes, std::vector<std::shared_ptr<void>>{place});
    });
    volume->notes = call.notes();
    return volume;
}

/// The type of an array's numbers.
void setType(const py::array& array, ArrayVoxels& voxels) {
    const py::dtype type = array.dtype();
    const char kind = type.kind();
    const auto bytes = static_cast<int>(type.itemsize());
    const std::string order = py::str(type.attr("byteorder"));
    voxels.bigEndian = order == ">";
    if (kind == 'b' && bytes == 1)
        voxels.type = FileType::u8;
    else if (kind == 'f' && bytes == 2)
        voxels.type = FileType::f32, voxels.isHalf = true;
    else if (const char* const word = kind == 'i'   ? "int"
                                      : kind == 'u' ? "uint"
                                      : kind == 'f' ? "float"
                                                    : nullptr;
             word && fileTypeOf(word + std::to_string(8 * bytes)))
        voxels.type = *fileTypeOf(word + std::to_string(8 * bytes));
    else
        throw badFile("array", "numbers: bool, int8 to int64, uint8 to uint64, float16, float32 or float64",
                      py::str(static_cast<const py::object&>(type)).cast<std::string>());
}

/// @param affine  patient space from the index of a voxel, mm, row by row
std::unique_ptr<Volume> openArray(const py::array& array, const std::array<double, 16>& affine, bool oriented,
                                  const std::string& unit, double slope, double intercept,
                                  const std::string& ram, py::object progress) {
    Call call(std::move(progress));
    ArrayVoxels voxels;
    setType(array, voxels);
    if (array.ndim() != 3)
        throw badFile("array", "three axes, [z, y, x]", std::to_string(array.ndim()));
    for (int axis = 0; axis < 3; ++axis) {
        const py::ssize_t extent = array.shape(2 - axis);
        if (extent < 1 || extent > std::numeric_limits<int>::max())
            throw badFile("array", "at least one voxel along each axis", std::to_string(extent));
        voxels.extent[axis] = static_cast<int>(extent);
        voxels.strides[static_cast<std::size_t>(axis)] = array.strides(2 - axis);
    }
    constexpr std::size_t kLongestUnit = 16;
    if (unit.size() > kLongestUnit)
        throw badFile("unit", "at most 16 characters", std::to_string(unit.size()));
    voxels.first = static_cast<const std::byte*>(array.data());
    const auto column = [&](std::size_t n) { return glm::dvec3(affine[n], affine[4 + n], affine[8 + n]); };
    voxels.patientFromVoxel = patientFromVoxelOf(column(3), column(0), column(1), column(2));
    voxels.orientationKnown = oriented;
    voxels.slope = slope;
    voxels.intercept = intercept;
    voxels.unit = unit;
    return openTemporary(call, "importing the array", ram, [&] { return makeArraySource(voxels); });
}

std::unique_ptr<Volume> openPhantom(const std::string& name, const std::array<int, 3>& size,
                                    const std::string& ram, py::object progress) {
    Call call(std::move(progress));
    for (const int extent : size)
        if (extent < 1)
            throw badFile("size", "at least one voxel along each axis", std::to_string(extent));
    return openTemporary(call, "making the phantom", ram, [&] {
        return makePhantom(name, {size[0], size[1], size[2]});
    });
}

py::dtype typeOf(ValueType type) {
    return py::dtype(std::string(name(type)));
}

/// A box of a level, [z][y][x]: physical values, or numbers as they are stored.
/// @param low, high  samples of the level, x, y, z
py::array readBox(Volume& volume, int level, const std::array<int, 3>& low, const std::array<int, 3>& high,
                  bool stored, py::object progress) {
    Call call(std::move(progress));
    const VolumeInfo& info = volume.info();
    LevelBox box = wholeLevel(info, level);
    for (int axis = 0; axis < 3; ++axis) {
        const auto n = static_cast<std::size_t>(axis);
        if (low[n] < 0 || high[n] > box.high[axis] || low[n] >= high[n])
            throw badFile("box",
                          std::string("a range within 0 to ") + std::to_string(box.high[axis]) + " along " +
                              "xyz"[axis],
                          std::to_string(low[n]) + " to " + std::to_string(high[n]));
        box.low[axis] = low[n];
        box.high[axis] = high[n];
    }
    const ExportedValues values{FileType::f32, info.rescaleSlope, info.rescaleIntercept};
    const bool converts = !stored && !values.isStored();
    const glm::ivec3 extent = box.extent();
    py::array out(converts ? py::dtype::of<float>() : typeOf(info.type),
                  std::vector<py::ssize_t>{extent.z, extent.y, extent.x});
    auto* const to = static_cast<std::byte*>(out.mutable_data());
    const auto bytesOut = static_cast<std::size_t>(out.nbytes());
    call.run([&] {
        call.common().progress->stage("reading the volume");
        BoxSource source(volume.store(), box, volume.ram());
        const std::size_t sliceIn = sliceBytesOf(source.info()),
                          sliceOut = bytesOut / static_cast<std::size_t>(extent.z);
        std::vector<std::byte> buffer;
        Charge charge;
        while (const int count = source.slicesOfChunks()) {
            checkInterrupted();
            const auto first = static_cast<std::size_t>(source.nextSlice());
            const std::span<std::byte> slices(to + first * sliceOut,
                                              sliceOut * static_cast<std::size_t>(count));
            if (!converts) {
                source.readSlices(count, slices);
            } else {
                const std::size_t bytes = sliceIn * static_cast<std::size_t>(count);
                if (bytes > buffer.size()) {
                    charge = volume.ram().charge(bytes, "slices of the volume");
                    buffer.resize(bytes);
                }
                const std::span<std::byte> numbers = std::span(buffer).first(bytes);
                source.readSlices(count, numbers);
                convertValues(info.type, numbers, values, slices);
            }
            call.common().progress->update(static_cast<double>(source.nextSlice()) / extent.z);
        }
    });
    return out;
}

/// Counts, and the physical values at the bins' edges.
std::pair<std::vector<std::uint64_t>, std::vector<double>> histogramOf(Volume& volume) {
    Call call((py::none()));
    std::vector<std::uint64_t> counts;
    std::vector<double> edges;
    call.run([&] {
        Statistics statistics = loadStatistics(volume.store(), volume.ram(), 0);
        counts = std::move(statistics.histogram);
        const VolumeInfo& info = volume.info();
        const double low = statistics.lowest, high = statistics.highest;
        for (std::size_t n = 0; n <= counts.size(); ++n)
            edges.push_back(info.rescaleSlope * (low + (high - low) * static_cast<double>(n) /
                                                           static_cast<double>(counts.size())) +
                            info.rescaleIntercept);
    });
    return {counts, edges};
}

/// Patient space from the index of a voxel's centre, row by row.
std::array<double, 16> affineOf(const Volume& volume) {
    glm::dmat4 affine = volume.info().patientFromVoxel;
    affine[3] = glm::dvec4(firstVoxelCentreMm(volume.info()), 1);
    const glm::dmat4 rows = glm::transpose(affine);
    std::array<double, 16> out{};
    std::copy_n(glm::value_ptr(rows), out.size(), out.begin());
    return out;
}

py::dict factsOf(const Volume& volume) {
    const VolumeInfo& info = volume.info();
    py::dict facts;
    facts["type"] = name(info.type);
    facts["unit"] = info.unit;
    facts["slope"] = info.rescaleSlope;
    facts["intercept"] = info.rescaleIntercept;
    facts["oriented"] = info.orientationKnown;
    facts["modality"] = info.acquisition.modality;
    facts["affine"] = affineOf(volume);
    facts["remarks"] = info.remarks;
    std::vector<std::array<int, 3>> shapes;
    for (int level = 0; level < kLevelCount; ++level) {
        const glm::ivec3 extent = levelExtent(info.extentVoxels, level);
        shapes.push_back({extent.z, extent.y, extent.x});
    }
    facts["shapes"] = shapes;
    const auto [low, high] = volume.store().storedRange();
    facts["range"] = std::pair(info.rescaleSlope * low + info.rescaleIntercept,
                               info.rescaleSlope * high + info.rescaleIntercept);
    return facts;
}

} // namespace

Volume::Volume(const fs::path& store, std::size_t ramBytes, std::vector<std::shared_ptr<void>> kept)
    : kept_(std::move(kept)), ram_("RAM", "ram", ramBytes),
      store_(std::make_unique<StoreReader>(store, ram_)), info_(store_->info()) {}

void Volume::setUnit(const std::string& unit) {
    if (!info_.unit.empty() && info_.unit != unit)
        throw badFile("unit", "that of the volume, " + info_.unit, unit);
    info_.unit = unit;
}

void addVolumes(py::module_& module) {
    py::class_<Volume>(module, "Volume")
        .def_property_readonly("path", [](const Volume& v) { return py::bytes(v.store().path().string()); })
        .def_property_readonly("notes", [](const Volume& v) { return v.notes; })
        .def("facts", &factsOf)
        .def("content_hash",
             [](const Volume& v) {
                 std::string hash;
                 Call((py::none())).run([&] { hash = v.store().contentHash(); });
                 return hash;
             })
        .def("histogram", &histogramOf)
        .def("read", &readBox, py::arg("level"), py::arg("low"), py::arg("high"), py::arg("stored"),
             py::arg("progress"));
    module.def("open_path", &openPath, py::arg("path"), py::arg("words"), py::arg("unit"), py::arg("ram"),
               py::arg("progress"));
    module.def("options_of_open", &optionsOfOpen);
    module.def("likely_option", &likelyOption, py::arg("unknown"), py::arg("known"));
    module.def("phases", &phasesOfPath, py::arg("path"), py::arg("words"));
    module.def("open_array", &openArray, py::arg("array"), py::arg("affine"), py::arg("oriented"),
               py::arg("unit"), py::arg("slope"), py::arg("intercept"), py::arg("ram"), py::arg("progress"));
    module.def("open_phantom", &openPhantom, py::arg("name"), py::arg("size"), py::arg("ram"),
               py::arg("progress"));
    module.def("remove_temporary_stores", &TemporaryStore::removeAll);
}

} // namespace tessera::python
