// bricking/labels/label_placement.cpp: see label_placement.h. A layer whose slices come in another order than
// the scan's is spooled to a temporary file; the scan's voxels then take it in tiles, each from a box of the
// layer.
#include "bricking/labels/label_placement.h"

#include "bricking/import/source/oriented_source.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kBoxVoxels = std::size_t{1} << 21;  // of a layer, held at once
constexpr std::size_t kReadVoxels = std::size_t{1} << 19; // of a layer, spooled at once
constexpr int kTileExtent = 64;
constexpr double kRoundingVoxels = 1e-9; // of positions that are computed in double
constexpr std::uint32_t kUnknownSet = ~std::uint32_t{0};

glm::dvec3 apply(const glm::dmat4& matrix, const glm::dvec3& at) {
    return glm::dvec3(matrix * glm::dvec4(at, 1));
}

glm::ivec3 cornerOf(const glm::ivec3& low, const glm::ivec3& high, int i) {
    return {(i & 1) ? high.x : low.x, (i & 2) ? high.y : low.y, (i & 4) ? high.z : low.z};
}

/// Of an axis of a layer: floor(at), kept near [0, extent], so that it is an int.
int floorNear(double at, int extent) {
    return static_cast<int>(std::floor(std::clamp(at, -2.0, extent + 2.0)));
}

int readAtOnce(const glm::ivec3& extent) {
    return static_cast<int>(std::clamp<std::size_t>(kReadVoxels / cellCount({extent.x, extent.y, 1}), 1,
                                                    static_cast<std::size_t>(extent.z)));
}

/// True if the layer is finer along an axis, each matched with the scan's nearest one.
bool isFiner(const VolumeInfo& layer, const VolumeInfo& scan) {
    const AxisOrder ofLayer = nearestLpsOrder(layer.patientFromVoxel),
                    ofScan = nearestLpsOrder(scan.patientFromVoxel);
    const glm::dvec3 layerMm = layer.spacingMm(), scanMm = scan.spacingMm();
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (scanMm[ofScan.sourceAxis[axis]] >= (kFiner - kSameVoxels) * layerMm[ofLayer.sourceAxis[axis]])
            return true;
    return false;
}

} // namespace

bool overlap(const VolumeInfo& a, const VolumeInfo& b) {
    const PatientBox boxA = patientBoxOf(a), boxB = patientBoxOf(b);
    for (int axis = 0; axis < 3; ++axis)
        if (boxA.high[axis] < boxB.low[axis] || boxB.high[axis] < boxA.low[axis])
            return false;
    return true;
}

/// Votes for combinations, of one voxel of the scan.
class PlacedLabels::Ballot {
  public:
    struct Vote {
        std::uint32_t of;
        double weight;
    };
    void clear() {
        votes_.clear();
        total_ = 0;
    }
    void add(std::uint32_t combination, double weight) {
        total_ += weight;
        const auto at = std::ranges::find(votes_, combination, &Vote::of);
        if (at != votes_.end())
            at->weight += weight;
        else
            votes_.push_back({combination, weight});
    }
    const std::vector<Vote>& votes() const { return votes_; }

    /// The numbers of the labels that the layers elect, ascending, none twice.
    std::span<const std::uint32_t> elect(const LabelSets& combinations, const LabelNumbers& labels) {
        entries_.clear();
        for (const Vote& vote : votes_)
            for (const std::uint32_t entry : combinations.of(vote.of))
                entries_.push_back({entry, vote.weight});
        std::ranges::sort(entries_, {}, &Vote::of);
        elected_.clear();
        const double tie = kRoundingVoxels * total_;
        for (std::size_t at = 0; at < entries_.size();) {
            const std::uint32_t layer = LabelGroup::layerIn(entries_[at].of);
            candidates_.clear();
            double none = total_, most = 0;
            for (; at < entries_.size() && LabelGroup::layerIn(entries_[at].of) == layer; ++at) {
                if (candidates_.empty() || candidates_.back().of != entries_[at].of)
                    candidates_.push_back({entries_[at].of, 0});
                candidates_.back().weight += entries_[at].weight;
                none -= entries_[at].weight;
                most = std::max(most, candidates_.back().weight);
            }
            if (none >= most - tie)
                continue;
            std::uint32_t best = 0;
            bool isAny = false;
            for (const Vote& candidate : candidates_) {
                const std::uint32_t label = LabelGroup::labelIn(candidate.of);
                if (candidate.weight >= most - tie &&
                    (!isAny || labels.valueOf(label) < labels.valueOf(best))) {
                    best = label;
                    isAny = true;
                }
            }
            elected_.push_back(best);
        }
        std::ranges::sort(elected_);
        elected_.erase(std::unique(elected_.begin(), elected_.end()), elected_.end());
        return elected_;
    }

  private:
    std::vector<Vote> votes_, entries_, candidates_;
    std::vector<std::uint32_t> elected_;
    double total_ = 0;
};

PlacedLabels::PlacedLabels(std::unique_ptr<LabelGroup> group, const VolumeInfo& scan,
                           const LabelNumbers& labels, LabelSets& sets, MemoryBudget& ram, int threads,
                           const std::filesystem::path& scratch)
    : group_(std::move(group)), scanExtent_(scan.extentVoxels), extent_(group_->info().extentVoxels),
      labels_(labels), sets_(sets), ram_(ram), threads_(threads),
      charge_(ram.charge(bytesNeeded(group_->info(), scan), "placing labels on the scan")) {
    choose(scan);
    if (how_ != How::streamed) {
        spool_ = std::make_unique<SpoolFile>(scratch);
        spoolAll();
    }
}

std::size_t PlacedLabels::bytesNeeded(const VolumeInfo& grid, const VolumeInfo&) {
    const std::size_t slice = cellCount({grid.extentVoxels.x, grid.extentVoxels.y, 1});
    const std::size_t spooling = slice * static_cast<std::size_t>(readAtOnce(grid.extentVoxels)) *
                                 (sizeof(std::uint32_t) + sizeof(std::uint16_t));
    return std::max(spooling, kBoxVoxels * sizeof(std::uint16_t)) +
           LabelGroup::kMostCombinations * sizeof(std::uint32_t);
}

void PlacedLabels::choose(const VolumeInfo& scan) {
    const VolumeInfo& layer = group_->info();
    layerFromScan_ = glm::inverse(layer.patientFromVoxel) * scan.patientFromVoxel;
    scanFromLayer_ = glm::inverse(layerFromScan_);
    const LatticeMatch match = latticeMatch(layer, scan);
    axis_ = match.axis;
    isFlipped_ = match.isFlipped;
    if (match.isSame)
        how_ = axis_[2] == 2 && !isFlipped_[2] ? How::streamed : How::copied;
    else
        how_ = isFiner(layer, scan) ? How::counted : How::weighted;
}

void PlacedLabels::spoolAll() {
    const int atOnce = readAtOnce(extent_);
    std::vector<std::uint16_t> scratch;
    for (int z = 0; z < extent_.z; z += atOnce) {
        slices_.resize(cellCount({extent_.x, extent_.y, std::min(atOnce, extent_.z - z)}));
        group_->readSlices(std::min(atOnce, extent_.z - z), slices_);
        group_->checkCombinations();
        spoolNumbers(*spool_, slices_, scratch);
    }
    std::vector<std::uint32_t>().swap(slices_);
    for (std::uint32_t combination = 0; combination < group_->combinations().size(); ++combination)
        setOf(combination);
}

std::uint32_t PlacedLabels::setOf(std::uint32_t combination) {
    if (combination >= LabelGroup::kMostCombinations)
        group_->checkCombinations();
    if (combination >= setOf_.size())
        setOf_.resize(combination + 1, kUnknownSet);
    std::uint32_t& set = setOf_[combination];
    if (set == kUnknownSet) {
        std::vector<std::uint32_t> numbers;
        for (const std::uint32_t entry : group_->combinations().of(combination))
            numbers.push_back(LabelGroup::labelIn(entry));
        std::ranges::sort(numbers);
        numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
        set = sets_.numberOf(numbers);
    }
    return set;
}

void PlacedLabels::readSlices(int count, std::span<std::uint32_t> out) {
    TESSERA_CHECK(nextZ_ + count <= scanExtent_.z &&
                  out.size() == cellCount({scanExtent_.x, scanExtent_.y, count}));
    if (how_ == How::streamed) {
        stream(count, out);
    } else {
        for (int y = 0; y < scanExtent_.y; y += kTileExtent)
            for (int x = 0; x < scanExtent_.x; x += kTileExtent)
                placeTile({{x, y, nextZ_},
                           glm::min(glm::ivec3(x, y, nextZ_) + glm::ivec3(kTileExtent, kTileExtent, count),
                                    glm::ivec3(scanExtent_.x, scanExtent_.y, nextZ_ + count))},
                          out);
    }
    nextZ_ += count;
}

std::string PlacedLabels::note() const {
    if (how_ == How::copied || how_ == How::streamed)
        return "";
    const glm::dvec3 mm = group_->info().spacingMm();
    return "a grid other than the scan's, " + std::to_string(extent_.x) + " x " + std::to_string(extent_.y) +
           " x " + std::to_string(extent_.z) + " voxels of " + numberText(mm.x) + " x " + numberText(mm.y) +
           " x " + numberText(mm.z) + " mm: " +
           (how_ == How::counted ? "a voxel of the scan gets the label of most voxels in it"
                                 : "a voxel of the scan gets the label of the largest weight around it");
}

/// Slices in the scan's order: x and y may be exchanged or run the other way.
void PlacedLabels::stream(int count, std::span<std::uint32_t> out) {
    group_->readSlices(count, out);
    std::uint32_t last = 0, set = setOf(0);
    for (std::uint32_t& value : out) {
        if (value != last) {
            last = value;
            set = setOf(last);
        }
        value = set;
    }
    if (axis_[0] == 0 && !isFlipped_[0] && !isFlipped_[1])
        return;
    const std::size_t slice = cellCount({scanExtent_.x, scanExtent_.y, 1});
    const std::array<std::ptrdiff_t, 2> layerStride = {1, extent_.x};
    std::array<std::ptrdiff_t, 2> stride{};
    std::ptrdiff_t origin = 0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const std::ptrdiff_t step = layerStride[static_cast<std::size_t>(axis_[axis])];
        stride[axis] = isFlipped_[axis] ? -step : step;
        origin += isFlipped_[axis] ? (extent_[axis_[axis]] - 1) * step : 0;
    }
    slices_.resize(slice);
    for (int z = 0; z < count; ++z) {
        const auto to = out.subspan(slice * static_cast<std::size_t>(z), slice);
        std::ranges::copy(to, slices_.begin());
        auto* next = to.data();
        for (int y = 0; y < scanExtent_.y; ++y) {
            const std::uint32_t* row = slices_.data() + origin + y * stride[1];
            for (int x = 0; x < scanExtent_.x; ++x)
                *next++ = row[x * stride[0]];
        }
    }
}

PlacedLabels::Box PlacedLabels::boxAround(const Box& tile) const {
    glm::dvec3 low(1e300), high(-1e300);
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 at = apply(layerFromScan_, glm::dvec3(cornerOf(tile.low, tile.high, i)));
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::clamp(floorNear(low[axis] - 1, extent_[axis]), 0, extent_[axis]);
        box.high[axis] = std::clamp(floorNear(high[axis] + 1, extent_[axis]) + 1, 0, extent_[axis]);
    }
    return box;
}

void PlacedLabels::readBox(const Box& box) {
    const glm::ivec3 size = box.extent();
    box_.resize(cellCount(size));
    const bool isWide = size.x == extent_.x; // whole rows: one piece a slice
    const std::size_t piece = cellCount({size.x, isWide ? size.y : 1, 1});
    auto* to = box_.data();
    for (int z = box.low.z; z < box.high.z; ++z)
        for (int y = box.low.y; y < box.high.y; y += isWide ? size.y : 1, to += piece)
            spool_->readAt(linearIndex({box.low.x, y, z}, extent_) * sizeof(std::uint16_t),
                           std::as_writable_bytes(std::span(to, piece)));
}

void PlacedLabels::placeTile(const Box& tile, std::span<std::uint32_t> out) {
    const Box box = boxAround(tile);
    const glm::ivec3 size = tile.extent(), slab(scanExtent_.x, scanExtent_.y, 0);
    const auto rowOf = [&](int y, int z) {
        return out.data() + linearIndex({tile.low.x, y, z - nextZ_}, slab);
    };
    const auto fillWithNone = [&] {
        for (int z = tile.low.z; z < tile.high.z; ++z)
            for (int y = tile.low.y; y < tile.high.y; ++y)
                std::fill_n(rowOf(y, z), size.x, 0u);
    };
    const glm::ivec3 boxSize = box.extent();
    if (boxSize.x <= 0 || boxSize.y <= 0 || boxSize.z <= 0)
        return fillWithNone();
    const bool isOne = size == glm::ivec3(1);
    if (cellCount(boxSize) > kBoxVoxels && !isOne) {
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        Box first = tile, second = tile;
        first.high[axis] = second.low[axis] = tile.low[axis] + size[axis] / 2;
        placeTile(first, out);
        return placeTile(second, out);
    }
    Charge more;
    if (cellCount(boxSize) > kBoxVoxels)
        more =
            ram_.charge(cellCount(boxSize) * sizeof(std::uint16_t), "placing labels far finer than the scan");
    readBox(box);
    if (std::all_of(box_.begin(), box_.end(), [](std::uint16_t value) { return value == 0; }))
        fillWithNone();
    else
        parallelFor(static_cast<std::size_t>(size.z * size.y), threads_, [&](std::size_t row) {
            const int y = tile.low.y + static_cast<int>(row) % size.y,
                      z = tile.low.z + static_cast<int>(row) / size.y;
            Ballot ballot;
            std::uint32_t* const to = rowOf(y, z);
            for (int x = 0; x < size.x; ++x)
                to[x] = placed({tile.low.x + x, y, z}, box, ballot);
        });
    if (more.bytes() > 0)
        std::vector<std::uint16_t>().swap(box_);
}

std::uint32_t PlacedLabels::placed(const glm::ivec3& voxel, const Box& box, Ballot& ballot) {
    if (how_ == How::copied) {
        glm::ivec3 at;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int own = voxel[static_cast<int>(axis)], of = axis_[axis];
            at[of] = isFlipped_[axis] ? extent_[of] - 1 - own : own;
        }
        return setOf_[box_[linearIndex(at - box.low, box.extent())]];
    }
    const glm::dvec3 centre = apply(layerFromScan_, glm::dvec3(voxel) + 0.5);
    if (how_ == How::weighted)
        return weighted(centre, box, ballot);
    Box near = boxAround({voxel, voxel + 1});
    near = {glm::max(near.low, box.low), glm::min(near.high, box.high)}; // rounding may differ
    ballot.clear();
    for (glm::ivec3 at(0, 0, near.low.z); at.z < near.high.z; ++at.z)
        for (at.y = near.low.y; at.y < near.high.y; ++at.y)
            for (at.x = near.low.x; at.x < near.high.x; ++at.x) {
                const glm::dvec3 in =
                    glm::floor(apply(scanFromLayer_, glm::dvec3(at) + 0.5) + kRoundingVoxels);
                if (in == glm::dvec3(voxel))
                    ballot.add(box_[linearIndex(at - box.low, box.extent())], 1);
            }
    return ballot.votes().empty() ? weighted(centre, box, ballot) : elected(ballot);
}

std::uint32_t PlacedLabels::weighted(const glm::dvec3& at, const Box& box, Ballot& ballot) {
    ballot.clear();
    std::array<glm::ivec3, 2> corner;
    glm::dvec3 share;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(at[axis] >= -kRoundingVoxels && at[axis] <= extent_[axis] + kRoundingVoxels))
            return 0;
        const double below = std::floor(at[axis] - 0.5);
        share[axis] = at[axis] - 0.5 - below;
        for (int i = 0; i < 2; ++i)
            corner[static_cast<std::size_t>(i)][axis] =
                std::clamp(static_cast<int>(below) + i, 0, extent_[axis] - 1);
    }
    for (int i = 0; i < 8; ++i) {
        const glm::ivec3 voxel = cornerOf(corner[0], corner[1], i);
        const double weight = ((i & 1) ? share.x : 1 - share.x) * ((i & 2) ? share.y : 1 - share.y) *
                              ((i & 4) ? share.z : 1 - share.z);
        ballot.add(box_[linearIndex(voxel - box.low, box.extent())], weight);
    }
    return elected(ballot);
}

std::uint32_t PlacedLabels::elected(Ballot& ballot) {
    if (ballot.votes().size() == 1)
        return setOf_[ballot.votes().front().of];
    const auto labels = ballot.elect(group_->combinations(), labels_);
    const std::lock_guard lock(setsMutex_);
    return sets_.numberOf(labels);
}

} // namespace tessera
