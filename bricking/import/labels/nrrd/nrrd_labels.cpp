// bricking/import/labels/nrrd/nrrd_labels.cpp: labels in NRRD files (.nrrd, .nhdr), among them the
// segmentations of 3D Slicer (.seg.nrrd), which have layers.
#include "bricking/import/files/data_files.h"
#include "bricking/import/files/nrrd/nrrd_grid.h"
#include "bricking/import/files/nrrd/nrrd_header.h"
#include "bricking/import/labels/label_format.h"
#include "bricking/import/labels/label_values.h"
#include "bricking/import/labels/nrrd/nrrd_segments.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// What the layers of a file share.
struct NrrdFile {
    std::filesystem::path path;
    NrrdHeader header;
    NrrdGrid grid;
    NrrdSegments segments;
};

/// A layer in the file's order of voxels. Layers read on their own; a file's data are opened with the first
/// slice and closed with the last.
class NrrdLayer final : public LabelLayer {
  public:
    NrrdLayer(std::shared_ptr<const NrrdFile> file, int layer)
        : file_(std::move(file)), layer_(static_cast<std::size_t>(layer)),
          values_(dataType(file_->header), isDataBigEndian(file_->header), file_->path.string(),
                  file_->grid.info.extentVoxels) {}

    const VolumeInfo& info() const override { return file_->grid.info; }

    bool isAlone() const override { return true; } // what is shared does not change

    bool hasWholeType() const override {
        const FileType type = dataType(file_->header);
        return type != FileType::f32 && type != FileType::f64;
    }

    void readSlices(int count, std::span<std::uint32_t> out) override {
        const glm::ivec3 extent = info().extentVoxels;
        TESSERA_CHECK(count >= 0 && next_ + count <= extent.z);
        TESSERA_CHECK(out.size() == static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y) *
                                        static_cast<std::size_t>(count));
        if (count == 0)
            return;
        if (!data_)
            open();
        const std::size_t bytes = bytesPerFileValue(dataType(file_->header)), step = stepValues();
        const std::size_t pieceVoxels = std::max<std::size_t>(1, kPieceBytes / (bytes * step));
        std::vector<std::byte> piece(std::min(pieceVoxels, out.size()) * step * bytes);
        for (std::size_t done = 0; done < out.size(); done += pieceVoxels) {
            checkInterrupted();
            const auto to = out.subspan(done, std::min(pieceVoxels, out.size() - done));
            data_->read(std::span(piece).first(to.size() * step * bytes));
            if (step > 1)
                for (std::size_t i = 0; i < to.size(); ++i)
                    std::memmove(piece.data() + i * bytes, piece.data() + (i * step + layer_) * bytes, bytes);
            values_.convert(std::span(piece).first(to.size() * bytes), to);
            nameAnew(to);
        }
        next_ += count;
        if (next_ == extent.z) {
            if (file_->grid.order != NrrdGrid::Order::apart ||
                layer_ + 1 == static_cast<std::size_t>(file_->grid.layers))
                data_->finish();
            data_.reset();
        }
    }

  private:
    static constexpr std::size_t kPieceBytes = 64 * 1024;

    std::size_t stepValues() const {
        return file_->grid.order == NrrdGrid::Order::interleaved
                   ? static_cast<std::size_t>(file_->grid.layers)
                   : 1;
    }
    void open() {
        const auto& layers = file_->segments.layers;
        for (const auto& [number, value] : layers[layer_])
            isRenumbered_ = isRenumbered_ || number != value;
        for (std::size_t other = 0; other < layers.size(); ++other)
            if (other != layer_)
                for (const auto& [number, value] : layers[other])
                    if (!layers[layer_].contains(value))
                        ofOthers_.push_back(value);
        std::sort(ofOthers_.begin(), ofOthers_.end());
        data_.emplace(file_->header, file_->path);
        if (file_->grid.order == NrrdGrid::Order::apart)
            data_->skip(layer_ * file_->grid.info.voxelCount() * bytesPerFileValue(dataType(file_->header)));
    }

    /// From the layer's numbers to values of labels. A number that no segment of the layer has stays what it
    /// is, unless it would become a segment of another layer.
    void nameAnew(std::span<std::uint32_t> voxels) const {
        if (!isRenumbered_ && ofOthers_.empty())
            return;
        const auto& values = file_->segments.layers[layer_];
        std::uint32_t last = 0, lastValue = 0; // labels come in runs
        for (std::uint32_t& voxel : voxels) {
            if (voxel == 0)
                continue;
            if (voxel != last) {
                last = voxel;
                const auto at = values.find(voxel);
                if (at == values.end() && std::binary_search(ofOthers_.begin(), ofOthers_.end(), voxel))
                    throw badFile(file_->path.string(),
                                  "in layer " + std::to_string(layer_) + " label values of its segments",
                                  std::to_string(voxel) + ", which a segment of another layer has");
                lastValue = at == values.end() ? voxel : at->second;
            }
            voxel = lastValue;
        }
    }

    std::shared_ptr<const NrrdFile> file_;
    std::size_t layer_;
    LabelValues values_;
    bool isRenumbered_ = false;
    std::vector<std::uint32_t> ofOthers_; // values of segments of other layers alone, ascending
    std::optional<DataReader> data_;
    int next_ = 0;
};

LabelFile openNrrdLabels(const std::filesystem::path& path, const SourceOptions&) {
    auto nrrd = std::make_shared<NrrdFile>();
    nrrd->path = path;
    nrrd->header = readNrrdHeader(InputFile(path));
    nrrd->grid = nrrdGridOf(nrrd->header, path.string());
    if (const std::vector<std::string>& kinds = nrrd->header.kinds;
        nrrd->grid.layers > 1 && std::find(kinds.begin(), kinds.end(), "time") != kinds.end())
        throw badFile(path.string(), "an axis of layers of kind \"list\"", "\"time\": labels of one time");
    checkDataLengths(nrrd->header, path);
    nrrd->segments = nrrdSegmentsOf(nrrd->header.pairs, nrrd->grid.layers, path.string());
    nrrd->header.pairs.clear();
    LabelFile file;
    file.labels = nrrd->segments.labels;
    file.notes = nrrd->grid.notes;
    file.notes.insert(file.notes.end(), nrrd->segments.notes.begin(), nrrd->segments.notes.end());
    if (nrrd->grid.layers > 1 && file.labels.empty())
        file.notes.push_back(
            std::to_string(nrrd->grid.layers) +
            " layers without descriptions of segments: equal values of layers are one label");
    for (int layer = 0; layer < nrrd->grid.layers; ++layer)
        file.layers.push_back(std::make_unique<NrrdLayer>(nrrd, layer));
    return file;
}

bool isNrrd(const std::filesystem::path& path) {
    std::error_code none;
    try {
        return std::filesystem::is_regular_file(path, none) && beginsAsNrrd(InputFile(path));
    } catch (const Error&) {
        return false;
    }
}

} // namespace

LabelFormat nrrdLabels() {
    return {"NRRD files (.nrrd, .nhdr, .seg.nrrd)", openNrrdLabels, isNrrd, true};
}

} // namespace tessera
