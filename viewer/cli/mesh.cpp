// viewer/cli/mesh.cpp: `tessera mesh IN OUT.ply --isosurface 300`: the surface of one value, or of labels, as
// a watertight mesh.
#include "bricking/analysis/surface/label_shares.h"
#include "bricking/analysis/surface/mesh_parts.h"
#include "bricking/analysis/surface/simplify_mesh.h"
#include "bricking/analysis/surface/surface_mesh.h"
#include "bricking/export/meshes/mesh_writer.h"
#include "bricking/labels/label_names.h"
#include "bricking/labels/label_volume.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget_error.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/names.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "core/scene/cuts.h"
#include "core/scene/labels.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/label_input.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/options/scene_options.h" // cropBoxOf

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <memory>
#include <optional>

namespace tessera {
namespace {

struct MeshArguments {
    std::string in, out, ram, labels, names;
    std::optional<double> isovalue, share, error;
    PartsChoice parts;
    std::vector<std::string> label, boxes, boxesInVoxels;
    bool sameFrame = false, force = false;
    int level = 0;
    InputOptions input;
    Existing existing() const { return force ? Existing::isReplaced : Existing::isKept; }
    bool simplifies() const { return share || error; }
    bool needsWhole() const { return simplifies() || parts.any(); }
};

/// The boxes that the options name.
std::vector<CropBox> namedBoxes(const MeshArguments& a) {
    std::vector<CropBox> boxes;
    for (const std::string& text : a.boxes)
        boxes.push_back(cropBoxOf(text, "--crop", CropBox::Space::patient));
    for (const std::string& text : a.boxesInVoxels)
        boxes.push_back(cropBoxOf(text, "--crop-voxels", CropBox::Space::voxels));
    return boxes;
}

/// A box along the patient's axes as one along the volume's.
VoxelBox inVoxels(const CropBox& box, const VolumeInfo& info) {
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const glm::dvec3 spacing = info.spacingMm();
    // An axis may leave the patient's by a tenth of a voxel over the volume.
    for (int column = 0; column < 3; ++column) {
        int along = 0;
        for (int row = 0; row < 3; ++row)
            along += std::abs(info.patientFromVoxel[column][row]) * info.extentVoxels[column] >
                     0.1 * spacing[column];
        if (along != 1)
            throw badFile("--crop", "a volume along the patient's axes",
                          "an oblique one: --crop-voxels takes a box along its own axes");
    }
    const glm::dvec3 a(voxelFromPatient * glm::dvec4(box.low, 1)),
        b(voxelFromPatient * glm::dvec4(box.high, 1));
    return {glm::min(a, b), glm::max(a, b)};
}

VoxelBox regionOf(const std::vector<CropBox>& boxes, const VolumeInfo& info) {
    VoxelBox region{glm::dvec3(0), glm::dvec3(info.extentVoxels)};
    for (const CropBox& named : boxes) {
        const VoxelBox box =
            named.space == CropBox::Space::patient ? inVoxels(named, info) : VoxelBox{named.low, named.high};
        region.low = glm::max(region.low, box.low), region.high = glm::min(region.high, box.high);
    }
    return region;
}

std::string regionOption(const MeshArguments& a) {
    return !a.boxes.empty() ? "--crop" : !a.boxesInVoxels.empty() ? "--crop-voxels" : a.in;
}

/// What a mesh is taken from, and is found in.
struct MeshField {
    const ChunkSource* source = nullptr;
    CellRanges ranges;
    double value = 0;
    std::string about; // "isosurface of 300 HU"
    std::string notThere;
};

/// Counts alone are wanted.
struct NoSink final : MeshSink {
    void point(const glm::dvec3&) override {}
    void triangle(const std::array<std::uint32_t, 3>&, const std::array<glm::dvec3, 3>&) override {}
};

struct MeshJob {
    const MeshArguments& arguments;
    const std::vector<CropBox>& boxes;
    const StoreReader& store;
    MemoryBudget& ram;
    const CommonOptions& common;

    void write(const MeshField& field) const {
        const auto began = std::chrono::steady_clock::now();
        const VolumeInfo& info = store.info();
        const SurfaceLattice lattice(info, regionOf(boxes, info), arguments.level, regionOption(arguments));
        SurfaceRequest request;
        request.value = field.value;
        MeshWriter writer(arguments.out,
                          "Tessera: mm in patient space, LPS; " + field.about + ", level " +
                              std::to_string(arguments.level) + "; closed, seen from outside turning left",
                          ram, arguments.existing());
        SurfaceCounts found = arguments.needsWhole() ? writeWhole(field, lattice, request, writer)
                                                     : extract(field, lattice, request, writer);
        common.progress->stage("writing " + arguments.out);
        const std::uint64_t bytes = writer.finish();
        common.progress->end();
        const double ml = found.volumeMm3 / 1000, cm2 = found.areaMm2 / 100;
        common.note("wrote " + arguments.out + ": " + std::to_string(found.triangles) + " triangles, " +
                    std::to_string(found.points) + " points, " +
                    formatBytes(static_cast<std::size_t>(bytes)) + "; " + formatNumber(ml) + " ml within " +
                    formatNumber(cm2) + " cm2");
        common.detail("looked at " + std::to_string(found.cellsSeen) + " of " + std::to_string(found.cells) +
                      " cells, decoded " + std::to_string(found.chunksDecoded) + " chunks, in " +
                      formatNumber(secondsSince(began), 3) + " s");
        common.detail("RAM: " + formatBytes(ram.peakBytes()) + " of " + formatBytes(ram.limitBytes()));
    }

    SurfaceCounts extract(const MeshField& field, const SurfaceLattice& lattice,
                          const SurfaceRequest& request, MeshSink& sink) const {
        common.progress->stage("finding the surface");
        SurfaceCounts found = extractSurface(*field.source, lattice, field.ranges, request, ram, sink,
                                             common.progress->shares());
        if (found.triangles == 0)
            throw InputError(field.notThere);
        return found;
    }

    /// Finds the surface twice: its size first, so that memory is asked for before it is taken.
    SurfaceCounts writeWhole(const MeshField& field, const SurfaceLattice& lattice,
                             const SurfaceRequest& request, MeshSink& out) const {
        NoSink nothing;
        SurfaceCounts found = extract(field, lattice, request, nothing);
        const std::size_t held = HeldSurface::heldBytes(found.points, found.triangles),
                          meanwhile = std::max(
                              {surfaceFloorBytes(store.info(), lattice, 0), partsBytes(found.points),
                               arguments.simplifies() ? simplifyBytes(found.points, found.triangles) : 0});
        if (held + meanwhile > ram.freeBytes())
            throw OverBudget(
                badFile(arguments.simplifies() ? "--simplify" : "--keep-largest",
                        "RAM for " + std::to_string(found.triangles) + " triangles at once, --ram " +
                            formatBytes(ram.usedBytes() + held + meanwhile),
                        formatBytes(ram.limitBytes()) + "; a coarser --level or a box needs less")
                    .what());
        const Charge charge = ram.charge(held, "a mesh that is held whole");
        HeldSurface surface(found.points, found.triangles);
        extract(field, lattice, request, surface);
        if (arguments.parts.any()) {
            const Charge scratch = ram.charge(partsBytes(found.points), "parts of a mesh");
            const PartsFound parts = keepParts(surface.mesh, arguments.parts);
            if (parts.kept == 0)
                throw badFile("--min-volume", "a volume that some part encloses",
                              formatNumber(arguments.parts.leastVolumeMm3) + " mm3");
            common.note("kept " + std::to_string(parts.kept) + " of " + std::to_string(parts.parts) +
                        " parts");
        }
        if (arguments.simplifies()) {
            SimplifyRequest goal;
            if (arguments.share)
                goal.mostTriangles = static_cast<std::uint64_t>(
                    *arguments.share * static_cast<double>(surface.mesh.triangles.size()));
            if (arguments.error)
                goal.mostErrorMm = *arguments.error;
            common.progress->stage("simplifying the mesh");
            const std::size_t before = surface.mesh.triangles.size();
            const double error = simplifyMesh(surface.mesh, goal, ram, common.progress->shares());
            common.note("simplified " + std::to_string(before) + " triangles, with an error of " +
                        formatNumber(error, 2) + " mm at most");
        }
        for (const glm::vec3& p : surface.mesh.points)
            out.point(p);
        for (const glm::uvec3& t : surface.mesh.triangles)
            out.triangle({t.x, t.y, t.z},
                         {glm::dvec3(surface.mesh.points[t.x]), glm::dvec3(surface.mesh.points[t.y]),
                          glm::dvec3(surface.mesh.points[t.z])});
        const MeshMeasures measures = measuresOf(surface.mesh);
        found.points = surface.mesh.points.size(), found.triangles = surface.mesh.triangles.size();
        found.areaMm2 = measures.areaMm2, found.volumeMm3 = measures.volumeMm3;
        return found;
    }

    void meshOfValue() const {
        const VolumeInfo& info = store.info();
        const Statistics statistics = loadStatistics(store, ram, 0);
        const double ends[] = {info.rescaleSlope * statistics.lowest + info.rescaleIntercept,
                               info.rescaleSlope * statistics.highest + info.rescaleIntercept};
        const auto text = [&](double value) {
            return formatNumber(value) + (info.unit.empty() ? "" : " " + info.unit);
        };
        MeshField field{&store,
                        {statistics.cells, statistics.cellMin, statistics.cellMax, 1},
                        *arguments.isovalue,
                        "isosurface of " + text(*arguments.isovalue),
                        {}};
        field.notThere =
            badFile("--isosurface",
                    "a value that something of the volume reaches, whose values are " +
                        text(std::min(ends[0], ends[1])) + " to " + text(std::max(ends[0], ends[1])),
                    text(*arguments.isovalue))
                .what();
        write(field);
    }

    void meshOfLabels() const {
        Labels labels;
        labels.path = arguments.labels;
        labels.names = arguments.names;
        labels.sameFrame = arguments.sameFrame;
        importLabelsFor(store.info(), labels, ram, common);
        const LabelVolume volume(labels.store, ram);
        requireSameGrid(volume.voxels(), store.info());
        LabelTable table = volume.table();
        if (arguments.names == Labels::kTotalSegmentator)
            applyNames(table, totalSegmentatorNames());
        else if (!arguments.names.empty())
            applyNames(table, readLabelNames(arguments.names));
        applyKnownNames(table);
        std::vector<bool> chosen(table.labels.size(), arguments.label.empty());
        std::vector<std::string> names;
        const LabelMatcher matcher(table.labels);
        for (const std::string& pattern : arguments.label)
            if (!matcher.forEach(pattern, [&](std::size_t n) { chosen[n] = true; }))
                throw badFile("--label", "the name, the value or the group of a label",
                              "\"" + printable(pattern) +
                                  "\"; nearest: " + joinNames(nearestNames(table, pattern)));
        for (std::size_t n = 0; n < chosen.size(); ++n)
            if (chosen[n])
                names.push_back(table.labels[n].name);
        const LabelShares shares(volume, chosen, ram, 0);
        write({&shares, shares.ranges(), 0.5,
               "surface of " + (arguments.label.empty() ? "all labels" : joinNames(names)),
               badFile("--label", "a label that some voxel of the box has", "none").what()});
    }
};

void runMesh(const MeshArguments& arguments, const CommonOptions& common) {
    if (arguments.labels.empty() == !arguments.isovalue)
        throw badFile("--isosurface", "a value, or --labels", arguments.isovalue ? "both" : "neither");
    checkMeshFile(arguments.out, arguments.existing());
    const std::vector<CropBox> boxes = namedBoxes(arguments);
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const StoreReader store(storeFor(arguments.in, arguments.input, ram, common), ram);
    const MeshJob job{arguments, boxes, store, ram, common};
    if (arguments.isovalue)
        job.meshOfValue();
    else
        job.meshOfLabels();
}

} // namespace

void addMeshCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command(
        "mesh", "Write the surface of a value, or of labels, as a watertight mesh, in bounded memory");
    auto arguments = std::make_shared<MeshArguments>();
    command.option("IN", arguments->in, "store, or source files").required();
    command.option("OUT", arguments->out, "mesh to write: " + joinNames(meshFileEndings())).required();
    command.option("--isosurface", arguments->isovalue, "value of the surface, physical units (CT: HU)")
        .check(numberWithin(-kLargestValue, kLargestValue, "a value"));
    command.option("--labels", arguments->labels,
                   "in place of a value: a segmentation of the volume, as for tessera render --labels");
    command
        .option("--label", arguments->label,
                "with --labels: a label by its name (* and ?), value or group:NAME; of several, one surface "
                "around all; may be repeated (default: all)")
        .needs("--labels")
        .oneValueEach();
    command
        .option("--label-colours", arguments->names,
                "with --labels: a file of their names, or totalsegmentator (default: the labels' own)")
        .needs("--labels");
    command
        .flag("--same-frame", arguments->sameFrame,
              "with --labels: take labels of another frame of reference")
        .needs("--labels");
    command
        .option("--level", arguments->level,
                "level of detail: 0 for all samples, each further one halves them along every axis")
        .showsDefault()
        .check(numberWithin(0, kLevelCount - 1, "a level from 0 to " + std::to_string(kLevelCount - 1)));
    command
        .option("--crop", arguments->boxes,
                std::string("mesh only the inside of a box along the patient's axes, mm, closed at its "
                            "faces: ") +
                    kBoxForm + "; of several, their intersection")
        .oneValueEach();
    command
        .option("--crop-voxels", arguments->boxesInVoxels,
                std::string("the same along the volume's axes, in voxels from 0: ") + kBoxForm)
        .oneValueEach();
    command
        .option("--simplify", arguments->share,
                "keep about this share of the triangles, 0 to 1; takes some 100 bytes of RAM a triangle")
        .check(numberWithin(0, 1, "a share from 0 to 1"));
    command
        .option("--error", arguments->error,
                "simplify as far as points move by this at most (root of the mean square), mm; with "
                "--simplify, what comes first")
        .inUnit("mm")
        .check(numberWithin(1e-6, 1e6, "mm from 0.000001 to 1000000"));
    command.flag("--keep-largest", arguments->parts.largest,
                 "keep only the part that encloses most; its cavities are filled");
    command
        .option("--min-volume", arguments->parts.leastVolumeMm3,
                "keep only parts, and cavities, that enclose so much, mm3")
        .inUnit("mm3")
        .check(numberWithin(0, 1e12, "mm3 from 0 to 1e12"));
    command.flag("--force", arguments->force, "replace an existing file");
    command.option("--ram", arguments->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    addSelectionOptions(command, arguments->input);
    addSpacingOption(command, arguments->input);
    command.footer("Example:\n  tessera mesh abdomen.zarr bone.ply --isosurface 300");
    command.whenChosen(
        [arguments, &common, &action] { action = [arguments, &common] { runMesh(*arguments, common); }; });
}

} // namespace tessera
