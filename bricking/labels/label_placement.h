// bricking/labels/label_placement.h: PlacedLabels: the layers of a group on the lattice of a scan.
//
// Where the lattices are one, in any order of axes and to kSameVoxels of a voxel, voxels are copied. Else the
// label of a scan's voxel is, for every layer, the value with the largest sum of trilinear weights at its
// centre, over the eight voxels of the layer around it; no label counts as a value. A tie goes to the lower
// value. Beyond the layer's outermost voxels there is no label. Where the layer is finer by kFiner or more
// along an axis, it is the value of most of the layer's voxels whose centres lie in the scan's voxel, if any
// do.
#pragma once

#include "bricking/labels/label_group.h"
#include "bricking/labels/label_volume.h"
#include "bricking/labels/lattice_match.h"

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace tessera {

constexpr double kFiner = 2;

/// False if the boxes of both along the patient's axes have no point in common.
bool overlap(const VolumeInfo& a, const VolumeInfo& b);

class PlacedLabels {
  public:
    /// @param sets  gets the sets of numbers of labels
    PlacedLabels(std::unique_ptr<LabelGroup> group, const VolumeInfo& scan, const LabelNumbers& labels,
                 LabelSets& sets, MemoryBudget& ram, int threads, const std::filesystem::path& scratch);
    static std::size_t bytesNeeded(const VolumeInfo& grid, const VolumeInfo& scan);

    /// The next slices of the scan: [z][y][x] numbers of sets.
    void readSlices(int count, std::span<std::uint32_t> out);
    /// How voxels get there, for people; "" where they are copied.
    std::string note() const;

  private:
    enum class How { copied, streamed, weighted, counted };
    struct Box {
        glm::ivec3 low{0}, high{0};
        glm::ivec3 extent() const { return high - low; }
    };
    class Ballot;
    void choose(const VolumeInfo& scan);
    void spoolAll();
    void stream(int count, std::span<std::uint32_t> out);
    void placeTile(const Box& tile, std::span<std::uint32_t> out);
    void readBox(const Box& box);
    Box boxAround(const Box& tile) const;
    std::uint32_t placed(const glm::ivec3& voxel, const Box& box, Ballot& ballot);
    std::uint32_t weighted(const glm::dvec3& at, const Box& box, Ballot& ballot);
    std::uint32_t setOf(std::uint32_t combination);
    std::uint32_t elected(Ballot& ballot);

    std::unique_ptr<LabelGroup> group_;
    glm::ivec3 scanExtent_, extent_;
    const LabelNumbers& labels_;
    LabelSets& sets_;
    std::mutex setsMutex_;
    MemoryBudget& ram_;
    int threads_;
    Charge charge_;
    How how_ = How::weighted;
    glm::dmat4 layerFromScan_{1}, scanFromLayer_{1};
    std::array<int, 3> axis_ = {0, 1, 2}; // copies: of the layer, for each of the scan's
    std::array<bool, 3> isFlipped_ = {false, false, false};
    std::vector<std::uint32_t> setOf_; // by combination; kUnknown
    std::unique_ptr<SpoolFile> spool_; // combinations, [z][y][x] of 16 bits
    std::vector<std::uint16_t> box_;
    std::vector<std::uint32_t> slices_;
    int nextZ_ = 0;
};

} // namespace tessera
