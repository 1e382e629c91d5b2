// bricking/analysis/lumen/lumen_graph.cpp: blocks, their connected components, and which of these touch. See
// lumen_graph.h.
#include "bricking/analysis/lumen/lumen_graph.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

namespace tessera {
namespace {

constexpr int kLargestBlock = 16;
constexpr std::uint32_t kNoTile = ~0u;

/// Blocks of an extent that contain set voxels of a chunk.
std::uint64_t blocksMet(const VoxelSet& voxels, std::size_t chunk, int extent) {
    const int per = kChunkExtent / extent;
    if (voxels.kind(chunk) == VoxelSet::Kind::all)
        return static_cast<std::uint64_t>(per) * per * per;
    std::uint64_t met = 0;
    const std::uint32_t ends =
        extent == 1 ? ~0u : ~0u / ((1u << extent) - 1); // a bit at each block's first voxel
    for (int z = 0; z < kChunkExtent; z += extent)
        for (int y = 0; y < kChunkExtent; y += extent) {
            std::uint32_t row = 0;
            for (int dz = 0; dz < extent; ++dz)
                for (int dy = 0; dy < extent; ++dy)
                    row |= voxels.row(chunk, y + dy + kChunkExtent * (z + dz));
            std::uint32_t any = 0;
            for (int x = 0; x < extent; ++x)
                any |= row >> x & ends;
            met += static_cast<std::uint64_t>(std::popcount(any));
        }
    return met;
}

} // namespace

LumenGraph::LumenGraph(const VoxelSet& voxels, const glm::dvec3& spacingMm, std::uint64_t mostBlocks,
                       MemoryBudget& ram)
    : voxels_(voxels), spacing_(spacingMm) {
    const std::vector<std::size_t> chunks = voxels.filledChunks();
    std::uint64_t met = 0;
    glm::ivec3 low(std::numeric_limits<int>::max()), high(0);
    for (const std::size_t chunk : chunks) {
        const glm::ivec3 at = gridPosition(chunk, voxels.chunks());
        low = glm::min(low, at);
        high = glm::max(high, at + 1);
    }
    for (extent_ = 1;; extent_ *= 2) {
        met = 0;
        for (const std::size_t chunk : chunks)
            met += blocksMet(voxels, chunk, extent_);
        if (met <= mostBlocks || extent_ == kLargestBlock)
            break;
    }
    if (chunks.empty())
        low = glm::ivec3(0);
    const int perChunk = kChunkExtent / extent_;
    tilesLow_ = low * perChunk / kTile;
    tiles_ = ceilDiv(high * perChunk, kTile) - tilesLow_;
    // position, fill, flags and distance of a block; tiles are at most as many as chunks
    const std::size_t tilesAtMost = std::min<std::size_t>(
        met, chunks.size() * std::max<std::size_t>(1, static_cast<std::size_t>(perChunk / kTile) *
                                                          static_cast<std::size_t>(perChunk / kTile) *
                                                          static_cast<std::size_t>(perChunk / kTile)));
    charge_ = ram.charge(met * (sizeof(glm::ivec3) + 8) * 3 / 2 + cellCount(tiles_) * sizeof(std::uint32_t) +
                             tilesAtMost * sizeof(Tile),
                         "the search of a path");
    tileOf_.assign(cellCount(tiles_), kNoTile);
    tileNodes_.reserve(tilesAtMost);
    blocks_.reserve(met + met / 8);
    build();
    joinFaces();
    measure();
}

LumenNode LumenGraph::first(const glm::ivec3& block) const {
    const glm::ivec3 tile = (block >> 3) - tilesLow_;
    for (int axis = 0; axis < 3; ++axis)
        if (block[axis] < 0 || tile[axis] < 0 || tile[axis] >= tiles_[axis])
            return kNoNode;
    const std::uint32_t at = tileOf_[linearIndex(tile, tiles_)];
    return at == kNoTile ? kNoNode : tileNodes_[at][linearIndex(block & 7, glm::ivec3(kTile))];
}

LumenNode& LumenGraph::slot(const glm::ivec3& block) {
    std::uint32_t& at = tileOf_[linearIndex((block >> 3) - tilesLow_, tiles_)];
    if (at == kNoTile) {
        at = static_cast<std::uint32_t>(tileNodes_.size());
        tileNodes_.emplace_back().fill(kNoNode);
    }
    return tileNodes_[at][linearIndex(block & 7, glm::ivec3(kTile))];
}

LumenGraph::Rows LumenGraph::rowsOf(const glm::ivec3& block) const {
    const glm::ivec3 voxel = block * extent_, local = voxel & 31;
    const std::size_t chunk = linearIndex(voxel >> 5, voxels_.chunks());
    const std::uint32_t wide = (1u << extent_) - 1;
    Rows rows(static_cast<std::size_t>(extent_ * extent_));
    for (int z = 0; z < extent_; ++z)
        for (int y = 0; y < extent_; ++y)
            rows[static_cast<std::size_t>(y + extent_ * z)] =
                voxels_.row(chunk, local.y + y + kChunkExtent * (local.z + z)) >> local.x & wide;
    return rows;
}

LumenGraph::Rows LumenGraph::rowsOf(LumenNode node) const {
    const auto part = parts_.find(node);
    return part == parts_.end() ? rowsOf(blocks_[node]) : part->second;
}

void LumenGraph::build() {
    const int per = kChunkExtent / extent_;
    const auto whole = static_cast<std::uint32_t>(extent_ * extent_ * extent_);
    for (const std::size_t chunk : voxels_.filledChunks()) {
        checkInterrupted();
        const glm::ivec3 corner = gridPosition(chunk, voxels_.chunks()) * per;
        for (int z = 0; z < per; ++z)
            for (int y = 0; y < per; ++y)
                for (int x = 0; x < per; ++x) {
                    const glm::ivec3 block = corner + glm::ivec3(x, y, z);
                    if (voxels_.kind(chunk) == VoxelSet::Kind::all) {
                        addBlock(block, {}, whole);
                        continue;
                    }
                    Rows rows = rowsOf(block);
                    std::uint32_t filled = 0;
                    for (const std::uint32_t row : rows)
                        filled += static_cast<std::uint32_t>(std::popcount(row));
                    if (filled)
                        addBlock(block, std::move(rows), filled);
                }
    }
}

void LumenGraph::addBlock(const glm::ivec3& block, Rows&& rows, std::uint32_t filled) {
    const auto whole = static_cast<std::uint32_t>(extent_ * extent_ * extent_);
    const LumenNode node = count();
    slot(block) = node;
    const auto add = [&](std::uint32_t voxels, std::uint8_t flags) {
        blocks_.push_back(block);
        filled_.push_back(static_cast<std::uint16_t>(std::min(voxels, 65535u)));
        flags_.push_back(flags);
    };
    if (filled == whole) {
        add(filled, kFull);
        return;
    }
    std::vector<Rows> parts;
    while (true) {
        const auto row = std::find_if(rows.begin(), rows.end(), [](std::uint32_t r) { return r != 0; });
        if (row == rows.end())
            break;
        Rows part(rows.size(), 0);
        part[static_cast<std::size_t>(row - rows.begin())] = *row & (~*row + 1);
        floodRows(rows.data(), part.data(), extent_);
        for (std::size_t i = 0; i < rows.size(); ++i)
            rows[i] &= ~part[i];
        parts.push_back(std::move(part));
    }
    if (parts.size() == 1) {
        add(filled, 0);
        return;
    }
    for (Rows& part : parts) {
        std::uint32_t voxels = 0;
        for (const std::uint32_t row : part)
            voxels += static_cast<std::uint32_t>(std::popcount(row));
        if (const LumenNode other = count(); other != node)
            more_[node].push_back(other);
        parts_[count()] = std::move(part);
        add(voxels, kParted);
    }
}

bool LumenGraph::touch(const Rows& a, const Rows& b, int axis) const {
    const int n = extent_;
    for (int i = 0; i < n; ++i) {
        if (axis == 0) {
            for (int j = 0; j < n; ++j) {
                const auto row = static_cast<std::size_t>(j + n * i);
                if (a[row] >> (n - 1) & b[row] & 1u)
                    return true;
            }
        } else {
            const int from = axis == 1 ? n - 1 + n * i : i + n * (n - 1), to = axis == 1 ? n * i : i;
            if (a[static_cast<std::size_t>(from)] & b[static_cast<std::size_t>(to)])
                return true;
        }
    }
    return false;
}

void LumenGraph::joinFaces() {
    for (LumenNode node = 0; node < count(); ++node) {
        if (node % 4096 == 0)
            checkInterrupted();
        if (parted(node))
            continue;
        Rows own;
        for (int axis = 0; axis < 3; ++axis) {
            glm::ivec3 beside = blocks_[node];
            ++beside[axis];
            const LumenNode other = first(beside);
            if (other == kNoNode || parted(other))
                continue;
            if (!full(node) || !full(other)) {
                if (own.empty())
                    own = rowsOf(blocks_[node]);
                if (!touch(own, rowsOf(beside), axis))
                    continue;
            }
            flags_[node] |= static_cast<std::uint8_t>(2u << (2 * axis));
            flags_[other] |= static_cast<std::uint8_t>(1u << (2 * axis));
        }
    }
}

LumenNode LumenGraph::nodeAt(const glm::ivec3& voxel) const {
    if (!voxels_.contains(voxel))
        return kNoNode;
    const glm::ivec3 block = voxel / extent_, local = voxel - block * extent_;
    const LumenNode node = first(block);
    if (node == kNoNode || !parted(node))
        return node;
    const auto has = [&](LumenNode part) {
        return parts_.at(part)[static_cast<std::size_t>(local.y + extent_ * local.z)] >> local.x & 1u;
    };
    if (has(node))
        return node;
    const auto& more = more_.at(node);
    return *std::find_if(more.begin(), more.end(), has);
}

glm::ivec3 LumenGraph::someVoxel(LumenNode node) const {
    const Rows rows = rowsOf(node);
    // the voxel nearest to the block's centre
    glm::ivec3 best(0);
    int least = std::numeric_limits<int>::max();
    for (int z = 0; z < extent_; ++z)
        for (int y = 0; y < extent_; ++y)
            for (int x = 0; x < extent_; ++x) {
                const glm::ivec3 away = 2 * glm::ivec3(x, y, z) + 1 - extent_;
                const int far = away.x * away.x + away.y * away.y + away.z * away.z;
                if (far < least && (rows[static_cast<std::size_t>(y + extent_ * z)] >> x & 1u)) {
                    least = far;
                    best = {x, y, z};
                }
            }
    return blocks_[node] * extent_ + best;
}

bool LumenGraph::solid(const glm::ivec3& block) const {
    const LumenNode node = first(block);
    return node != kNoNode && full(node);
}

void LumenGraph::neighbours(LumenNode node, std::vector<LumenStep>& steps) const {
    steps.clear();
    const glm::dvec3 pitch = spacing_ * static_cast<double>(extent_);
    const glm::ivec3 at = blocks_[node];
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        glm::ivec3 beside = at;
        beside[axis] += face % 2 ? 1 : -1;
        const auto mm = static_cast<float>(pitch[axis]);
        if (flags_[node] >> face & 1u) {
            steps.push_back({first(beside), mm});
            continue;
        }
        const LumenNode other = first(beside);
        if (other == kNoNode || (!parted(node) && !parted(other)))
            continue;
        const auto tryPart = [&](LumenNode part) {
            const Rows a = rowsOf(face % 2 ? node : part), b = rowsOf(face % 2 ? part : node);
            if (touch(a, b, axis))
                steps.push_back({part, mm});
        };
        tryPart(other);
        if (const auto more = more_.find(other); more != more_.end())
            for (const LumenNode part : more->second)
                tryPart(part);
    }
    if (!full(node))
        return;
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) {
                const glm::ivec3 d(x, y, z);
                const int axes = std::abs(x) + std::abs(y) + std::abs(z);
                if (axes < 2 || !solid(at + d))
                    continue;
                bool open = true; // all blocks of the box between
                for (int corner = 1; corner < 7 && open; ++corner) {
                    const glm::ivec3 part = d * glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
                    open = part == d || part == glm::ivec3(0) || solid(at + part);
                }
                if (open)
                    steps.push_back({first(at + d), static_cast<float>(glm::length(glm::dvec3(d) * pitch))});
            }
}

} // namespace tessera
