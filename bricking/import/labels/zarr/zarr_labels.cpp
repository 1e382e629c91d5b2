// bricking/import/labels/zarr/zarr_labels.cpp: labels in OME-Zarr 0.4 and 0.5 (STORE/labels/NAME), and in
// arrays of Zarr.
#include "bricking/import/labels/label_format.h"
#include "bricking/import/labels/label_values.h"
#include "bricking/import/labels/zarr/ome_labels.h"
#include "bricking/import/zarr/ome_image.h"
#include "bricking/import/zarr/zarr_chunks.h"
#include "bricking/import/zarr/zarr_slices.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h" // isStore
#include "bricking/store/zarr_metadata.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

class ZarrLayer final : public LabelLayer {
  public:
    ZarrLayer(const ZarrArray& array, const OmeGrid& grid, fs::path scratch)
        : info_(grid.info), place_{grid.axes, {}}, array_(array), scratch_(std::move(scratch)),
          values_(array.type, array.bigEndian, array.path.string(), grid.info.extentVoxels) {}

    const VolumeInfo& info() const override { return info_; }
    bool isAlone() const override { return true; }
    std::size_t bytesToRead() const override {
        return ZarrSlices::bytesNeeded(array_, place_) + sliceVoxels() * array_.valueBytes();
    }

    void readSlices(int count, std::span<std::uint32_t> out) override {
        TESSERA_CHECK(count >= 0 && next_ + count <= info_.extentVoxels.z &&
                      out.size() == sliceVoxels() * static_cast<std::size_t>(count));
        if (!slices_)
            slices_.emplace(array_, place_, scratch_);
        std::vector<std::byte> slice(sliceVoxels() * array_.valueBytes());
        for (int i = 0; i < count; ++i) {
            checkInterrupted();
            slices_->readSlice(slice);
            values_.convert(slice, out.subspan(static_cast<std::size_t>(i) * sliceVoxels(), sliceVoxels()));
        }
        next_ += count;
        if (next_ == info_.extentVoxels.z) {
            noteMissing();
            slices_.reset();
        }
    }
    std::vector<std::string> notes() const override { return notes_; }

  private:
    std::size_t sliceVoxels() const {
        return static_cast<std::size_t>(info_.extentVoxels.x) *
               static_cast<std::size_t>(info_.extentVoxels.y);
    }
    /// Chunks without labels are left out as a rule.
    void noteMissing() {
        const bool isUsual = std::ranges::all_of(array_.fill, [](std::byte b) { return b == std::byte{0}; });
        if (std::string missing = slices_->sayMissing();
            !missing.empty() && (!isUsual || slices_->tally().lacksAll()))
            notes_.push_back(std::move(missing));
    }

    VolumeInfo info_;
    ZarrVolumePlace place_;
    ZarrArray array_;
    fs::path scratch_;
    LabelValues values_;
    std::optional<ZarrSlices> slices_;
    std::vector<std::string> notes_;
    int next_ = 0;
};

/// The names that a "labels" group lists; nullopt: the group is none.
std::optional<std::vector<std::string>> listedLabels(const ZarrNode& group) {
    constexpr std::size_t kMostNames = 10000;
    const auto ome = omeAttributesOf(group);
    if (!ome || !ome->has("labels"))
        return std::nullopt;
    std::vector<std::string> names;
    for (const JsonValue name : ome->at("labels").items(kMostNames, "names of labels"))
        names.push_back(pathBelow(name.text(), name.place()));
    return names;
}

/// The one label image of a group of them, below it. Throws InputError with their names if there are several.
std::string onlyOf(const ZarrNode& group, const std::vector<std::string>& names) {
    if (names.size() == 1)
        return names.front();
    if (names.empty())
        throw badFile(group.attributesFile, "a label image", "an empty list of them");
    constexpr std::size_t kMostShown = 20;
    std::string all;
    for (std::size_t i = 0; i < std::min(names.size(), kMostShown); ++i)
        all += (i == 0 ? "" : ", ") + printable(names[i]);
    if (names.size() > kMostShown)
        all += " and " + std::to_string(names.size() - kMostShown) + " more";
    throw badFile(group.path.string(),
                  "one label image: name it, as in " + printable((group.path / names.front()).string()),
                  std::to_string(names.size()) + " of them: " + all);
}

/// The label image or array that a path means: itself, or the only one in its "labels".
ZarrNode labelNodeAt(const fs::path& path) {
    const fs::path folder = path.has_filename() ? path : path.parent_path(); // "a.zarr/" means a.zarr
    ZarrNode node = requireZarrNode(folder, "labels in Zarr");
    if (node.isArray || omeLabelsOf(node).isThere)
        return node;
    if (const auto names = listedLabels(node))
        return requireZarrNode(node, onlyOf(node, *names), "the label image that its group lists");
    if (isZarr(folder / "labels")) {
        const ZarrNode group = requireZarrNode(node, "labels", "a group of labels");
        const auto names = listedLabels(group);
        if (!names)
            throw badFile(group.attributesFile, "a list \"labels\" of names", "none");
        return requireZarrNode(group, onlyOf(group, *names), "the label image that its group lists");
    }
    return node;
}

/// Labels of a store of this program are placed as its volume is, which OME-Zarr cannot say.
void placeAsStore(OmeGrid& grid, const ZarrNode& group) {
    const fs::path store = group.path.parent_path().parent_path();
    if (group.path.parent_path().filename() != "labels" || !isStore(store))
        return;
    const std::string where = (store / "zarr.json").string();
    const auto text = readText(openFolder(store), "zarr.json", store, kMaxMetadataBytes);
    const VolumeInfo image = parseGroup(text.value_or(""), where).info;
    // As in the store's metadata: voxel 0 of the volume at its place in the patient, along straight axes.
    const glm::dvec3 origin = firstVoxelCentreMm(image), spacing = image.spacingMm();
    const auto inPatient = [&](const glm::dvec3& mm, double w) {
        const glm::dvec3 voxels = mm / spacing;
        return glm::dvec3(image.patientFromVoxel * glm::dvec4(voxels, w));
    };
    const glm::dmat4 ome = grid.info.patientFromVoxel;
    const glm::dvec3 first = firstVoxelCentreMm(grid.info) - origin + 0.5 * spacing;
    grid.info.patientFromVoxel =
        patientFromVoxelOf(inPatient(first, 1), inPatient(glm::dvec3(ome[0]), 0),
                           inPatient(glm::dvec3(ome[1]), 0), inPatient(glm::dvec3(ome[2]), 0));
    grid.info.orientationKnown = image.orientationKnown;
    grid.notes.clear();
    grid.info.validate(group.attributesFile);
}

LabelFile openZarrLabels(const fs::path& path, const SourceOptions& options) {
    const ZarrNode node = labelNodeAt(path);
    LabelFile file;
    OmeGrid grid;
    if (node.isArray) {
        ZarrArray array = zarrArrayOf(node);
        findSeparator(array);
        grid = bareGridOf(array);
        requireOneVolume(grid, array.where);
        file.isOnScan = true;
        file.notes = {"an array without a place in the patient: its voxels are the scan's"};
        file.layers.push_back(std::make_unique<ZarrLayer>(array, grid, options.scratchFolder));
        return file;
    }
    const std::optional<OmeImage> image = omeImageOf(node);
    if (!image)
        throw badFile(node.attributesFile, "\"multiscales\" of OME-Zarr 0.4 or 0.5, or the path of an array",
                      "a group without them");
    const ZarrNode data =
        requireZarrNode(node, image->levels.front().path, "the array that \"multiscales\" names");
    if (!data.isArray)
        throw badFile(data.metadataFile, "an array", "a group");
    ZarrArray array = zarrArrayOf(data);
    findSeparator(array);
    grid = omeGridOf(*image, image->levels.front(), array, node.attributesFile);
    requireOneVolume(grid, node.attributesFile);
    if (!grid.spacingProblem.empty())
        throw badFile(node.attributesFile,
                      "a scale and a unit of length of each axis of space; or the path of the array, whose "
                      "voxels are then the scan's",
                      grid.spacingProblem);
    placeAsStore(grid, node);
    OmeLabels labels = omeLabelsOf(node);
    file.labels = std::move(labels.labels);
    file.notes = std::move(grid.notes);
    if (!labels.image.empty())
        file.notes.push_back("labels of the image " + printable(labels.image));
    file.layers.push_back(std::make_unique<ZarrLayer>(array, grid, options.scratchFolder));
    return file;
}

bool isZarrFolder(const fs::path& path) {
    std::error_code none;
    return (isAddress(path) || fs::is_directory(path, none)) && isZarr(path);
}

} // namespace

LabelFormat zarrLabels() {
    return {"folders of OME-Zarr", openZarrLabels, isZarrFolder};
}

} // namespace tessera
