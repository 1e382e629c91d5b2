// bricking/import/files/nrrd/nrrd_phase.cpp: see nrrd_phase.h.
#include "bricking/import/files/nrrd/nrrd_phase.h"

#include "bricking/import/files/data_files.h"
#include "bricking/import/files/file_reading.h"
#include "bricking/import/source/slice_converter.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// The numbers of one layer.
class PhaseVoxels final : public VoxelStream {
  public:
    PhaseVoxels(const NrrdHeader& header, const NrrdGrid& grid, std::filesystem::path path, int layer)
        : reader_(header, std::move(path)), bytes_(bytesPerFileValue(dataType(header))),
          layers_(static_cast<std::uint64_t>(grid.layers)), layer_(static_cast<std::uint64_t>(layer)),
          isInterleaved_(grid.order == NrrdGrid::Order::interleaved),
          volumeBytes_(grid.info.voxelCount() * bytes_) {
        if (!isInterleaved_)
            reader_.skip(layer_ * volumeBytes_);
    }

    void read(std::span<std::byte> out) override {
        if (!isInterleaved_)
            return reader_.read(out);
        constexpr std::size_t kAtOnce = std::size_t{1} << 20; // bytes, about
        const std::size_t group = bytes_ * static_cast<std::size_t>(layers_);
        groups_.resize(std::max<std::size_t>(1, kAtOnce / group) * group);
        for (std::size_t at = 0; at < out.size();) {
            const std::size_t count = std::min((out.size() - at) / bytes_, groups_.size() / group);
            reader_.read(std::span(groups_).first(count * group));
            const std::byte* from = groups_.data() + static_cast<std::size_t>(layer_) * bytes_;
            for (std::size_t n = 0; n < count; ++n, from += group, at += bytes_)
                std::memcpy(out.data() + at, from, bytes_);
        }
    }

    void finish() override {
        if (!isInterleaved_)
            reader_.skip((layers_ - 1 - layer_) * volumeBytes_);
        reader_.finish();
    }

  private:
    DataReader reader_;
    std::size_t bytes_; // of a number
    std::uint64_t layers_, layer_;
    bool isInterleaved_;
    std::uint64_t volumeBytes_;
    std::vector<std::byte> groups_; // numbers of all layers
};

} // namespace

bool layersArePhases(const NrrdHeader& header, const NrrdGrid& grid) {
    static const std::set<std::string_view> kinds = {"list", "time", "domain", "none", "???", ""};
    if (grid.layers < 2)
        return false;
    const std::size_t axis = grid.order == NrrdGrid::Order::interleaved ? 0 : 3;
    return header.kinds.empty() || kinds.contains(header.kinds[axis]);
}

std::unique_ptr<SlabSource> openNrrdPhase(const NrrdHeader& header, const NrrdGrid& grid,
                                          const std::filesystem::path& path, int layer,
                                          std::string description) {
    return makeForwardFileSource(
        [header, grid, path, layer] { return std::make_unique<PhaseVoxels>(header, grid, path, layer); },
        grid.info, dataType(header), isDataBigEndian(header), std::move(description));
}

} // namespace tessera
