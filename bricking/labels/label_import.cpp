// bricking/labels/label_import.cpp: see label_import.h. The type of the volume, the numbers of its sets and
// the ties of its levels need all voxels. So the first pass puts numbers in a temporary file, and the second
// one writes the store from it.
#include "bricking/labels/label_import.h"

#include "bricking/labels/label_files.h"
#include "bricking/labels/label_majority.h"
#include "bricking/labels/label_placement.h"
#include "bricking/labels/label_volume.h"
#include "bricking/store/codec.h"
#include "bricking/store/store_writer.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr int kSlabSlices = 16;                             // of the scan, placed at once
constexpr std::size_t kPieceValues = std::size_t{1} << 19;  // compressed at once
constexpr std::size_t kNumbersBytes = std::size_t{6} << 20; // counts and numbers of the most sets and labels
constexpr std::size_t kTableBytes = std::size_t{1} << 20;   // a table of some thousand labels
constexpr std::size_t kMostNamed = 5;                       // of empty labels

std::string whereOf(const LabelFile& file) {
    return file.shown.empty() ? "labels" : file.shown;
}

std::size_t sliceOf(const VolumeInfo& info) {
    return cellCount({info.extentVoxels.x, info.extentVoxels.y, 1});
}

/// Slices of 16 bits, compressed, in a temporary file.
class PackedSlices {
  public:
    PackedSlices(const fs::path& folder, std::size_t sliceValues)
        : spool_(folder), sliceValues_(sliceValues), encoded_(encodedBound(pieceBytes())) {}
    static std::size_t bytesNeeded(const VolumeInfo& info) {
        const std::size_t piece = std::min(kPieceValues, sliceOf(info)) * sizeof(std::uint16_t);
        const auto pieces = (sliceOf(info) + kPieceValues - 1) / kPieceValues;
        return encodedBound(piece) +
               2 * sizeof(std::uint64_t) * pieces * static_cast<std::size_t>(info.extentVoxels.z);
    }

    void append(std::span<const std::uint16_t> slice) {
        TESSERA_CHECK(slice.size() == sliceValues_);
        for (std::size_t at = 0; at < slice.size(); at += kPieceValues) {
            const auto piece = slice.subspan(at, std::min(kPieceValues, slice.size() - at));
            const EncodedChunk chunk = encodeChunk(std::as_bytes(piece), sizeof(std::uint16_t), encoded_);
            spool_.append(std::span(std::as_const(encoded_)).first(chunk.bytes));
            ends_.push_back((ends_.empty() ? 0 : ends_.back()) + chunk.bytes);
        }
    }
    /// The next slice, from the first one on.
    void next(std::span<std::uint16_t> slice) {
        for (std::size_t at = 0; at < slice.size(); at += kPieceValues, ++read_) {
            const std::uint64_t begin = read_ == 0 ? 0 : ends_[read_ - 1];
            const auto bytes = std::span(encoded_).first(static_cast<std::size_t>(ends_[read_] - begin));
            spool_.readAt(begin, bytes);
            decodeChunk(bytes,
                        std::as_writable_bytes(slice.subspan(at, std::min(kPieceValues, slice.size() - at))),
                        "a temporary file of labels");
        }
    }

  private:
    std::size_t pieceBytes() const { return std::min(kPieceValues, sliceValues_) * sizeof(std::uint16_t); }

    SpoolFile spool_;
    std::size_t sliceValues_;
    std::vector<std::byte> encoded_;
    std::vector<std::uint64_t> ends_; // of pieces
    std::size_t read_ = 0;            // pieces
};

/// The layers, those of one grid together.
std::vector<std::vector<LabelLayer*>> groupsOf(const LabelFile& file) {
    std::vector<std::vector<LabelLayer*>> groups;
    for (const auto& layer : file.layers) {
        const auto group = std::ranges::find_if(
            groups, [&](const auto& known) { return isSameGrid(known.front()->info(), layer->info()); });
        if (group == groups.end())
            groups.push_back({layer.get()});
        else
            group->push_back(layer.get());
    }
    return groups;
}

std::size_t slabBytes(std::size_t groups, const VolumeInfo& scan) {
    const std::size_t slab =
        sliceOf(scan) * static_cast<std::size_t>(std::min(kSlabSlices, scan.extentVoxels.z));
    return slab * sizeof(std::uint32_t) * std::min<std::size_t>(groups, 2) +
           sliceOf(scan) * sizeof(std::uint16_t);
}

std::string shownBox(const VolumeInfo& info) {
    const PatientBox box = patientBoxOf(info);
    const auto point = [](const glm::dvec3& at) {
        return "(" + numberText(at.x) + ", " + numberText(at.y) + ", " + numberText(at.z) + ")";
    };
    return point(box.low) + " to " + point(box.high) + " mm";
}

/// Numbers of sets in the order of their first voxels, and how many voxels have each.
class SetsInUse {
  public:
    explicit SetsInUse(std::string where) : where_(std::move(where)) {}
    std::uint16_t numberOf(std::uint32_t set) {
        if (set >= numbers_.size())
            numbers_.resize(set + 1, kNew);
        if (numbers_[set] == kNew) {
            if (sets_.size() == LabelTable::kMostSets)
                throw badFile(where_,
                              "at most " + std::to_string(LabelTable::kMostSets) +
                                  " sets of labels that share voxels",
                              "more");
            numbers_[set] = static_cast<std::uint32_t>(sets_.size());
            sets_.push_back(set);
            voxels_.push_back(0);
        }
        const auto number = static_cast<std::uint16_t>(numbers_[set]);
        ++voxels_[number];
        return number;
    }
    const std::vector<std::uint32_t>& sets() const { return sets_; }
    const std::vector<std::uint64_t>& voxels() const { return voxels_; }

  private:
    static constexpr std::uint32_t kNew = ~std::uint32_t{0};
    std::string where_;
    std::vector<std::uint32_t> numbers_, sets_;
    std::vector<std::uint64_t> voxels_;
};

/// The table, and what leads to its numbers.
struct Settled {
    LabelTable table;
    std::vector<std::uint16_t> numberOf; // of a set, from its number in the temporary file
    std::vector<std::uint64_t> voxels;   // of a set of the table
    std::uint64_t labelled = 0;          // voxels
    Charge charge;
};

Label shownLabel(Label label) {
    label.name = printable(label.name);
    if (label.name.empty())
        label.name = "label " + std::to_string(label.value);
    label.group = printable(label.group);
    if (label.colour)
        for (int i = 0; i < 3; ++i) {
            float& part = (*label.colour)[i];
            part = std::isfinite(part) ? std::clamp(part, 0.0f, 1.0f) : 0.0f;
        }
    return label;
}

Settled settle(const LabelFile& file, const LabelNumbers& labels, const LabelSets& sets,
               const SetsInUse& used, MemoryBudget& ram) {
    constexpr std::size_t kLabelBytes = 320, kSetBytes = 128; // with what leads to them; without names
    std::size_t bytes = (file.labels.size() + labels.size()) * kLabelBytes;
    for (const Label& label : file.labels)
        bytes += 2 * (label.name.size() + label.group.size());
    for (const std::uint32_t set : used.sets())
        bytes += kSetBytes + 2 * sizeof(std::uint16_t) * sets.of(set).size();
    Settled settled;
    settled.charge = ram.charge(bytes - std::min(bytes, kTableBytes), "the table of labels");
    std::map<std::uint32_t, Label> byValue;
    for (const Label& label : file.labels)
        if (label.value != 0)
            byValue.try_emplace(label.value, shownLabel(label));
    for (std::uint32_t i = 0; i < labels.size(); ++i)
        byValue.try_emplace(labels.valueOf(i), shownLabel({labels.valueOf(i), ""}));
    if (byValue.size() > LabelTable::kMostSets)
        throw badFile(whereOf(file), "at most " + std::to_string(LabelTable::kMostSets) + " labels",
                      std::to_string(byValue.size()));
    std::map<std::uint32_t, std::uint16_t> indices; // by value
    for (auto& [value, label] : byValue) {
        indices[value] = static_cast<std::uint16_t>(settled.table.labels.size());
        settled.table.labels.push_back(std::move(label));
    }
    struct Row {
        std::vector<std::uint16_t> set;
        std::size_t number;
    };
    std::vector<Row> rows;
    for (std::size_t i = 0; i < used.sets().size(); ++i) {
        Row row{{}, i};
        for (const std::uint32_t label : sets.of(used.sets()[i]))
            row.set.push_back(indices.at(labels.valueOf(label)));
        std::ranges::sort(row.set);
        rows.push_back(std::move(row));
    }
    std::ranges::sort(rows, [](const Row& a, const Row& b) { return comesBefore(a.set, b.set); });
    settled.voxels.push_back(0);
    settled.numberOf.resize(rows.size());
    for (Row& row : rows) {
        const std::uint64_t voxels = used.voxels()[row.number];
        if (row.set.empty()) {
            settled.numberOf[row.number] = 0;
            settled.voxels[0] = voxels;
            continue;
        }
        if (settled.table.sets.size() == LabelTable::kMostSets)
            throw badFile(whereOf(file),
                          "at most " + std::to_string(LabelTable::kMostSets) + " sets of labels", "one more");
        settled.numberOf[row.number] = static_cast<std::uint16_t>(settled.table.sets.size());
        settled.table.sets.push_back(std::move(row.set));
        settled.voxels.push_back(voxels);
        settled.labelled += voxels;
    }
    return settled;
}

/// "3 labels have no voxel on the scan: a, b, c"; "" for none.
std::string emptyLabels(const LabelTable& table) {
    std::vector<bool> isUsed(table.labels.size());
    for (const auto& set : table.sets)
        for (const std::uint16_t label : set)
            isUsed[label] = true;
    std::string names;
    std::size_t count = 0;
    for (std::size_t i = 0; i < isUsed.size(); ++i)
        if (!isUsed[i] && ++count <= kMostNamed)
            names += (count == 1 ? "" : ", ") + table.labels[i].name;
    if (count == 0)
        return "";
    return std::to_string(count) + (count == 1 ? " label has" : " labels have") +
           " no voxel on the scan: " + names +
           (count > kMostNamed ? " and " + std::to_string(count - kMostNamed) + " more" : "");
}

VolumeInfo labelInfo(const VolumeInfo& scan, ValueType type) {
    VolumeInfo info;
    info.extentVoxels = scan.extentVoxels;
    info.type = type;
    info.patientFromVoxel = scan.patientFromVoxel;
    info.orientationKnown = scan.orientationKnown;
    info.originalOrder = scan.originalOrder;
    info.frameOfReference = scan.frameOfReference;
    info.acquisition.modality = "SEG";
    return info;
}

std::size_t writingBytes(const VolumeInfo& scan, int threads) {
    return StoreWriter::floorBytes(labelInfo(scan, ValueType::u16), threads) +
           LabelFilesWriter::bytesNeeded(scan.extentVoxels, threads) +
           sliceOf(scan) * kCellExtent * sizeof(std::uint16_t) + PackedSlices::bytesNeeded(scan);
}

/// A layer whose voxels are a scan's.
class LayerOnScan final : public LabelLayer {
  public:
    LayerOnScan(std::unique_ptr<LabelLayer> layer, const VolumeInfo& scan)
        : layer_(std::move(layer)), info_(layer_->info()) {
        info_.patientFromVoxel = scan.patientFromVoxel;
        info_.orientationKnown = scan.orientationKnown;
    }
    const VolumeInfo& info() const override { return info_; }
    void readSlices(int count, std::span<std::uint32_t> out) override { layer_->readSlices(count, out); }
    bool isAlone() const override { return layer_->isAlone(); }
    std::size_t bytesToRead() const override { return layer_->bytesToRead(); }
    std::vector<std::string> notes() const override { return layer_->notes(); }

  private:
    std::unique_ptr<LabelLayer> layer_;
    VolumeInfo info_;
};

void layOnScan(LabelFile& file, const VolumeInfo& scan) {
    for (auto& layer : file.layers) {
        const glm::ivec3 e = layer->info().extentVoxels, s = scan.extentVoxels;
        const auto text = [](const glm::ivec3& extent) {
            return std::to_string(extent.x) + "x" + std::to_string(extent.y) + "x" +
                   std::to_string(extent.z) + " voxels";
        };
        if (e != s)
            throw badFile(whereOf(file), "the scan's " + text(s) + ", as it has no place of its own",
                          text(e));
        layer = std::make_unique<LayerOnScan>(std::move(layer), scan);
    }
    file.isOnScan = false;
}

void checkLayers(const LabelFile& file, const VolumeInfo& scan) {
    if (file.layers.empty())
        throw badFile(whereOf(file), "layers of labels", "none");
    for (const auto& layer : file.layers) {
        layer->info().validate(whereOf(file));
        if (!overlap(layer->info(), scan))
            throw badFile(whereOf(file), "labels in the scan's box, " + shownBox(scan),
                          "labels in " + shownBox(layer->info()) + ": a label file of another patient?");
    }
}

/// The first pass: numbers of sets of every voxel.
Settled placeAll(LabelFile& file, const VolumeInfo& scan, const fs::path& scratch, MemoryBudget& ram,
                 const LabelImportOptions& options, Progress& progress, PackedSlices& packed,
                 std::vector<std::string>& notes) {
    const auto groups = groupsOf(file);
    const Charge own = ram.charge(slabBytes(groups.size(), scan), "placing labels on the scan");
    LabelNumbers labels(whereOf(file));
    LabelSets sets(ram, whereOf(file));
    SetsInUse used(whereOf(file));
    std::vector<std::unique_ptr<PlacedLabels>> placed;
    for (const auto& group : groups)
        placed.push_back(std::make_unique<PlacedLabels>(
            std::make_unique<LabelGroup>(group, labels, ram, options.threads, scratch), scan, labels, sets,
            ram, options.threads, scratch));
    const glm::ivec3 extent = scan.extentVoxels;
    std::vector<std::uint32_t> slab, other;
    std::vector<std::uint16_t> slice(sliceOf(scan));
    for (int z = 0; z < extent.z; z += kSlabSlices) {
        checkInterrupted();
        const int slices = std::min(kSlabSlices, extent.z - z);
        slab.resize(sliceOf(scan) * static_cast<std::size_t>(slices));
        placed.front()->readSlices(slices, slab);
        for (std::size_t i = 1; i < placed.size(); ++i) {
            other.resize(slab.size());
            placed[i]->readSlices(slices, other);
            for (std::size_t at = 0; at < slab.size(); ++at)
                slab[at] = sets.together(slab[at], other[at]);
        }
        for (int i = 0; i < slices; ++i) {
            const std::uint32_t* from = slab.data() + slice.size() * static_cast<std::size_t>(i);
            std::transform(from, from + slice.size(), slice.begin(),
                           [&](std::uint32_t set) { return used.numberOf(set); });
            packed.append(slice);
        }
        progress.update(static_cast<double>(z + slices) / extent.z);
    }
    for (const auto& layers : placed)
        if (std::string note = layers->note(); !note.empty())
            notes.push_back(std::move(note));
    placed.clear();
    return settle(file, labels, sets, used, ram);
}

/// The second pass: levels and cells.
void writeAll(StoreWriter& writer, LabelFilesWriter& files, PackedSlices& packed, const Settled& settled,
              const VolumeInfo& info, MemoryBudget& ram, Progress& progress) {
    const std::size_t slice = sliceOf(info);
    const Charge own = ram.charge(slice * kCellExtent * sizeof(std::uint16_t), "writing labels");
    std::vector<std::uint16_t> part;
    for (int z = 0; const int count = writer.nextSlices();) {
        checkInterrupted();
        std::byte* to = writer.next().data();
        for (int done = 0; done < count; done += kCellExtent) {
            const int slices = std::min(kCellExtent, count - done);
            part.resize(slice * static_cast<std::size_t>(slices));
            for (int i = 0; i < slices; ++i)
                packed.next(std::span(part).subspan(slice * static_cast<std::size_t>(i), slice));
            for (std::uint16_t& number : part)
                number = settled.numberOf[number];
            files.add(part, slices);
            withValueType(info.type, [&](auto typed) {
                std::transform(part.begin(), part.end(), reinterpret_cast<decltype(typed)*>(to),
                               [](std::uint16_t number) { return static_cast<decltype(typed)>(number); });
            });
            to += part.size() * bytesPerValue(info.type);
        }
        writer.push();
        z += count;
        progress.update(static_cast<double>(z) / info.extentVoxels.z);
    }
}

} // namespace

std::size_t labelImportFloorBytes(const LabelFile& file, const VolumeInfo& scan, int threads) {
    const auto groups = groupsOf(file);
    std::size_t placing =
        slabBytes(groups.size(), scan) + PackedSlices::bytesNeeded(scan) + LabelSets::kStepBytes;
    for (const auto& group : groups) {
        const VolumeInfo& grid = group.front()->info();
        placing += LabelGroup::bytesNeeded(group, threads) + LabelSets::kStepBytes +
                   PlacedLabels::bytesNeeded(grid, scan);
    }
    return std::max(placing, writingBytes(scan, threads)) + kNumbersBytes + kTableBytes;
}

LabelImportReport importLabels(LabelFile& file, const VolumeInfo& scan, const fs::path& store,
                               MemoryBudget& ram, const LabelImportOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    if (!options.sameFrame)
        requireSameFrame(file.frameOfReference, scan, whereOf(file));
    if (file.isOnScan)
        layOnScan(file, scan);
    checkLayers(file, scan);
    checkStoreTarget(store, labelInfo(scan, ValueType::u16), options.force);
    {
        const Charge floor = ram.charge(labelImportFloorBytes(file, scan, options.threads),
                                        "importing labels onto a scan this wide");
    }
    const Charge own =
        ram.charge(kNumbersBytes + kTableBytes + PackedSlices::bytesNeeded(scan), "importing labels");
    const fs::path scratch = fs::absolute(store).parent_path();
    Progress silent;
    Progress& progress = options.progress ? *options.progress : silent;
    progress.stage("reading labels");
    PackedSlices packed(scratch, sliceOf(scan));
    LabelImportReport report;
    report.notes = file.notes;
    const Settled settled = placeAll(file, scan, scratch, ram, options, progress, packed, report.notes);
    if (settled.labelled == 0)
        throw badFile(whereOf(file), "labels on the scan", "no labelled voxel");
    progress.stage("writing labels");
    VolumeInfo info = labelInfo(scan, labelTypeOf(settled.table));
    if (info.frameOfReference.empty())
        info.frameOfReference = file.frameOfReference;
    StoreWriter writer(store, info, ram, options.threads, options.force, majorityRule(settled.voxels));
    {
        const Charge forFiles = ram.charge(LabelFilesWriter::bytesNeeded(info.extentVoxels, options.threads),
                                           "the cells of a volume of labels");
        LabelFilesWriter files(writer.folder(), info.extentVoxels, options.threads);
        writeAll(writer, files, packed, settled, info, ram, progress);
        writer.finish(info, imageLabelOf(settled.table));
        files.finish(settled.table, StoreReader(writer.folder(), ram));
    }
    progress.stage("finishing the store");
    writer.commit(options.durable);
    report.voxels = info.voxelCount();
    report.labelled = settled.labelled;
    report.labels = settled.table.labels.size();
    report.sets = settled.table.sets.size();
    report.bytesOut = writer.counters().bytesWritten;
    for (const auto& layer : file.layers)
        for (std::string& note : layer->notes())
            report.notes.push_back(std::move(note));
    if (std::string note = emptyLabels(settled.table); !note.empty())
        report.notes.push_back(std::move(note));
    report.seconds = secondsSince(start);
    return report;
}

} // namespace tessera
