// bricking/import/labels/seg/seg_labels.cpp: labels in DICOM Segmentations: binary, fractional, label maps.
// Segments that overlap are in different layers.
#include "bricking/import/labels/label_format.h"
#include "bricking/import/labels/seg/seg_grid.h"
#include "bricking/import/labels/seg/seg_object.h"
#include "bricking/import/labels/seg/seg_pixels.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <bit>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// What the layers of a file share.
struct SegFile {
    SegFile(SegObject object, const std::filesystem::path& scratchFolder)
        : seg(std::move(object)), grid(segGridOf(seg)), pixels(seg, scratchFolder) {
        framesOfSlice.resize(static_cast<std::size_t>(grid.info.extentVoxels.z));
        for (std::size_t i = 0; i < grid.sliceOf.size(); ++i)
            framesOfSlice[static_cast<std::size_t>(grid.sliceOf[i])].push_back(i);
        for (const std::vector<std::size_t>& frames : framesOfSlice) {
            std::set<std::uint32_t> segments;
            for (const std::size_t i : frames)
                if (!segments.insert(seg.frames[i].segment).second)
                    throw badFile(seg.file.string(), "one frame a segment at every position",
                                  "frame " + std::to_string(i + 1) + " where another one is");
        }
    }
    SegObject seg;
    SegGrid grid;
    SegPixels pixels;
    std::vector<std::vector<std::size_t>> framesOfSlice;
    std::map<std::uint32_t, std::size_t> layerOf; // of each segment that has frames
};

/// Finds layers within which no segments overlap, as few as a first fit needs. Reads all masks once; memory:
/// those of a slice.
void assignLayers(SegFile& file) {
    std::map<std::uint32_t, std::set<std::uint32_t>> meets;
    const std::size_t words = file.pixels.maskWords();
    std::vector<std::vector<std::uint64_t>> masks;
    for (const std::vector<std::size_t>& frames : file.framesOfSlice) {
        checkInterrupted();
        masks.resize(frames.size(), std::vector<std::uint64_t>(words));
        for (std::size_t i = 0; i < frames.size(); ++i) {
            const std::uint32_t segment = file.seg.frames[frames[i]].segment;
            meets[segment];
            if (frames.size() == 1)
                continue;
            file.pixels.readMask(frames[i], masks[i]);
            for (std::size_t j = 0; j < i; ++j) {
                const std::uint32_t other = file.seg.frames[frames[j]].segment;
                if (meets[segment].contains(other))
                    continue;
                std::uint64_t common = 0;
                for (std::size_t k = 0; k < words; ++k)
                    common |= masks[i][k] & masks[j][k];
                if (common != 0) {
                    meets[segment].insert(other);
                    meets[other].insert(segment);
                }
            }
        }
    }
    for (const auto& [segment, others] : meets) {
        std::set<std::size_t> taken;
        for (const std::uint32_t other : others)
            if (const auto at = file.layerOf.find(other); at != file.layerOf.end())
                taken.insert(at->second);
        std::size_t layer = 0;
        while (taken.contains(layer))
            ++layer;
        file.layerOf[segment] = layer;
    }
}

class SegLayer final : public LabelLayer {
  public:
    SegLayer(std::shared_ptr<SegFile> file, std::size_t layer) : file_(std::move(file)), layer_(layer) {}

    const VolumeInfo& info() const override { return file_->grid.info; }

    void readSlices(int count, std::span<std::uint32_t> out) override {
        const glm::ivec3 extent = info().extentVoxels;
        TESSERA_CHECK(count >= 0 && next_ + count <= extent.z);
        TESSERA_CHECK(out.size() == cellCount({extent.x, extent.y, count}));
        std::fill(out.begin(), out.end(), 0);
        const std::size_t each = cellCount({extent.x, extent.y, 1});
        for (; count > 0; --count, out = out.subspan(each)) {
            checkInterrupted();
            for (const std::size_t frame : file_->framesOfSlice[static_cast<std::size_t>(next_)])
                if (file_->seg.kind == SegKind::labelmap)
                    readMap(frame, out.first(each));
                else if (file_->layerOf.at(file_->seg.frames[frame].segment) == layer_)
                    readSegment(frame, out.first(each));
            ++next_;
        }
    }

  private:
    void readSegment(std::size_t frame, std::span<std::uint32_t> out) {
        const std::uint32_t value = file_->seg.frames[frame].segment;
        mask_.resize(file_->pixels.maskWords());
        file_->pixels.readMask(frame, mask_);
        for (std::size_t i = 0; i < mask_.size(); ++i)
            for (std::uint64_t word = mask_[i]; word != 0; word &= word - 1)
                out[64 * i + static_cast<std::size_t>(std::countr_zero(word))] = value;
    }
    void readMap(std::size_t frame, std::span<std::uint32_t> out) {
        values_.resize(out.size());
        file_->pixels.readValues(frame, values_);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = values_[i] == file_->seg.padding ? 0 : values_[i];
    }

    std::shared_ptr<SegFile> file_;
    std::size_t layer_;
    std::vector<std::uint64_t> mask_;
    std::vector<std::uint16_t> values_;
    int next_ = 0;
};

LabelFile openSegmentation(const std::filesystem::path& path, const SourceOptions& options) {
    auto file = std::make_shared<SegFile>(readSegObject(path), options.scratchFolder);
    std::size_t layers = 1;
    if (file->seg.kind != SegKind::labelmap) {
        assignLayers(*file);
        for (const auto& [segment, layer] : file->layerOf)
            layers = std::max(layers, layer + 1);
    }
    LabelFile labels;
    labels.labels = file->seg.segments;
    labels.frameOfReference = file->seg.frameOfReference;
    labels.notes = file->seg.notes;
    labels.notes.insert(labels.notes.end(), file->grid.notes.begin(), file->grid.notes.end());
    for (std::size_t layer = 0; layer < layers; ++layer)
        labels.layers.push_back(std::make_unique<SegLayer>(file, layer));
    return labels;
}

} // namespace

LabelFormat segLabels() {
    return {"DICOM Segmentations", openSegmentation, isSegmentation};
}

} // namespace tessera
