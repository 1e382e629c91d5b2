// bricking/analysis/lumen/voxel_set.cpp: see voxel_set.h.
#include "bricking/analysis/lumen/voxel_set.h"

#include "core/base/error.h"

#include <algorithm>
#include <bit>

namespace tessera {

std::uint32_t RowsPool::take() {
    if (free_.empty()) {
        Charge charge = ram_->charge(sizeof(Slab), what_);
        auto slab = std::make_unique<Slab>();
        slab->charge = std::move(charge);
        slabs_.push_back(std::move(slab));
        const auto first = static_cast<std::uint32_t>(slabs_.size() - 1) * kPerSlab;
        for (std::uint32_t i = kPerSlab; i-- > 0;)
            free_.push_back(first + i);
    }
    const std::uint32_t slot = free_.back();
    free_.pop_back();
    return slot;
}

VoxelSet::VoxelSet(const glm::ivec3& extentVoxels, MemoryBudget& ram, const char* what)
    : extent_(extentVoxels), chunks_(chunkGrid(extentVoxels, 0)),
      charge_(ram.charge(cellCount(chunks_) * sizeof(std::uint32_t), what)),
      slots_(cellCount(chunks_), kNone), pool_(ram, what) {}

void VoxelSet::setChunk(std::size_t chunk, const ChunkRows& rows) {
    if (slots_[chunk] == kNone || slots_[chunk] == kAll)
        slots_[chunk] = pool_.take();
    pool_.at(slots_[chunk]) = rows;
    settle(chunk);
}

void VoxelSet::setAll(std::size_t chunk) {
    if (slots_[chunk] != kNone && slots_[chunk] != kAll)
        pool_.giveBack(slots_[chunk]);
    slots_[chunk] = kAll;
}

ChunkRows& VoxelSet::edit(std::size_t chunk) {
    TESSERA_CHECK(slots_[chunk] != kAll);
    if (slots_[chunk] == kNone) {
        slots_[chunk] = pool_.take();
        pool_.at(slots_[chunk]).fill(0);
    }
    return pool_.at(slots_[chunk]);
}

void VoxelSet::settle(std::size_t chunk) {
    if (slots_[chunk] == kNone || slots_[chunk] == kAll)
        return;
    const ChunkRows& rows = pool_.at(slots_[chunk]);
    const bool none = std::all_of(rows.begin(), rows.end(), [](std::uint32_t r) { return r == 0; });
    const bool all = std::all_of(rows.begin(), rows.end(), [](std::uint32_t r) { return r == ~0u; });
    if (!none && !all)
        return;
    pool_.giveBack(slots_[chunk]);
    slots_[chunk] = none ? kNone : kAll;
}

std::uint64_t VoxelSet::count(std::size_t chunk) const {
    if (kind(chunk) != Kind::some)
        return kind(chunk) == Kind::all ? kRowsPerChunk * kChunkExtent : 0;
    std::uint64_t sum = 0;
    for (const std::uint32_t row : pool_.at(slots_[chunk]))
        sum += static_cast<std::uint64_t>(std::popcount(row));
    return sum;
}

std::uint64_t VoxelSet::count() const {
    std::uint64_t sum = 0;
    for (std::size_t chunk = 0; chunk < slots_.size(); ++chunk)
        sum += count(chunk);
    return sum;
}

std::vector<std::size_t> VoxelSet::filledChunks() const {
    std::vector<std::size_t> filled;
    for (std::size_t chunk = 0; chunk < slots_.size(); ++chunk)
        if (slots_[chunk] != kNone)
            filled.push_back(chunk);
    return filled;
}

namespace {

/// All bits of a row that are connected to `bits` by runs of `inside`.
std::uint32_t alongRow(std::uint32_t bits, std::uint32_t inside) {
    std::uint32_t up = inside, down = inside;
    for (int shift = 1; shift < 32; shift *= 2) {
        bits |= (up & (bits << shift)) | (down & (bits >> shift));
        up &= up << shift;
        down &= down >> shift;
    }
    return bits;
}

} // namespace

void floodRows(const std::uint32_t* inside, std::uint32_t* reached, int n) {
    std::array<std::uint16_t, kRowsPerChunk> stack; // each row at most once
    std::array<bool, kRowsPerChunk> waits{};
    std::size_t waiting = 0;
    const auto push = [&](int row) {
        if (!waits[static_cast<std::size_t>(row)]) {
            waits[static_cast<std::size_t>(row)] = true;
            stack[waiting++] = static_cast<std::uint16_t>(row);
        }
    };
    for (int row = n * n; row-- > 0;)
        if (reached[row])
            push(row);
    while (waiting > 0) {
        const int row = stack[--waiting];
        waits[static_cast<std::size_t>(row)] = false;
        const std::uint32_t bits = alongRow(reached[row], inside[row]);
        reached[row] = bits;
        const auto spread = [&](int next) {
            const std::uint32_t more = bits & inside[next] & ~reached[next];
            if (more) {
                reached[next] |= more;
                push(next);
            }
        };
        const int y = row % n, z = row / n;
        if (y > 0)
            spread(row - 1);
        if (y + 1 < n)
            spread(row + 1);
        if (z > 0)
            spread(row - n);
        if (z + 1 < n)
            spread(row + n);
    }
}

} // namespace tessera
