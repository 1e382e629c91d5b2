// bricking/import/files/hdf5/h5_slices.cpp: see h5_slices.h.
#include "bricking/import/files/hdf5/h5_slices.h"

#include "bricking/import/source/half_floats.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint64_t kMostHeldBytes = std::uint64_t{256} << 20;

} // namespace

H5Slices::H5Slices(const H5File& file, H5Set set, H5VolumePlace place, std::filesystem::path scratch)
    : file_(file), set_(std::move(set)), place_(std::move(place)), scratch_(std::move(scratch)) {
    TESSERA_CHECK(set_.type.number && place_.at.size() == set_.space.extents.size());
    if (set_.layout.kind != H5Layout::Kind::chunked)
        return;
    chunks_.emplace(file_, set_);
    std::size_t step = set_.type.bytes;
    for (std::size_t axis = place_.at.size(); axis-- > 0;) {
        const std::uint64_t side = set_.layout.chunk[axis];
        if (axis >= place_.slowest && axis < place_.slowest + 3)
            stepBytes_[axis - place_.slowest] = step;
        firstByte_ += place_.at[axis] % side * step;
        step *= side;
    }
}

std::size_t H5Slices::sliceBytes() const {
    return place_.extents[1] * place_.extents[2] * bytesPerFileValue(type());
}

void H5Slices::fillWith(std::span<std::byte> out) const {
    for (std::size_t at = 0; at < out.size(); at += set_.fill.size())
        std::memcpy(out.data() + at, set_.fill.data(), set_.fill.size());
}

H5Slices::Box H5Slices::boxOf(const H5Chunk& chunk) const {
    const auto along = [&](std::size_t n) { // first and size in the volume; first in the chunk
        const std::uint64_t side = set_.layout.chunk[place_.slowest + n],
                            at = chunk.place[place_.slowest + n] * side,
                            begin = std::max(at, place_.first[n]),
                            end = std::min(at + side, place_.first[n] + place_.extents[n]);
        return std::array{begin - place_.first[n], begin < end ? end - begin : 0, begin - at};
    };
    const auto [y, sizeY, inY] = along(1);
    const auto [x, sizeX, inX] = along(2);
    return {x, y, sizeX, sizeY, inX, inY, 0};
}

void H5Slices::copyBox(const std::vector<std::byte>& chunk, const Box& box, std::uint64_t z, std::byte* to,
                       std::size_t rowBytes) const {
    const std::size_t each = set_.type.bytes;
    for (std::uint64_t y = 0; y < box.sizeY; ++y, to += rowBytes) {
        const std::byte* from = chunk.data() + firstByte_ + z * stepBytes_[0] +
                                (box.inY + y) * stepBytes_[1] + box.inX * stepBytes_[2];
        if (stepBytes_[2] == each)
            std::memcpy(to, from, box.sizeX * each);
        else
            for (std::uint64_t x = 0; x < box.sizeX; ++x, from += stepBytes_[2])
                std::memcpy(to + x * each, from, each);
    }
}

void H5Slices::readLayer(std::uint64_t layer) {
    layer_.reset(); // what was here goes
    boxes_.clear();
    spool_.reset();
    const std::size_t first = place_.slowest, each = set_.type.bytes;
    const std::uint64_t side = set_.layout.chunk[first], at0 = layer * side,
                        begin = std::max(at0, place_.first[0]), inZ = begin - at0,
                        slices = std::min(at0 + side, place_.first[0] + place_.extents[0]) - begin;
    layerFirst_ = begin - place_.first[0];
    H5Place at;
    for (std::size_t axis = 0; axis < place_.at.size(); ++axis)
        at.push_back(place_.at[axis] / set_.layout.chunk[axis]);
    at[first] = layer;
    const auto range = [&](std::size_t n) {
        const std::uint64_t along = set_.layout.chunk[first + n];
        return H5Chunks::Range{first + n, place_.first[n] / along,
                               (place_.first[n] + place_.extents[n] - 1) / along + 1};
    };
    std::vector<H5Chunk> chunks = chunks_->ofLayer(at, {range(1), range(2)});
    std::erase_if(chunks, [&](const H5Chunk& chunk) {
        const Box box = boxOf(chunk);
        return box.sizeX == 0 || box.sizeY == 0;
    });
    const std::size_t row = place_.extents[2] * each, plane = place_.extents[1] * row;
    if (plane <= kMostHeldBytes / slices) {
        held_.resize(slices * plane);
        fillWith(held_);
        const auto threads = static_cast<int>(std::clamp<std::uint64_t>(
            kMostHeldBytes / (2 * set_.chunkBytes), 1, static_cast<std::uint64_t>(defaultThreads())));
        parallelFor(chunks.size(), threads, [&](std::size_t n) {
            const std::vector<std::byte> chunk = readH5Chunk(file_, set_, chunks[n]);
            const Box box = boxOf(chunks[n]);
            for (std::uint64_t z = 0; z < slices; ++z)
                copyBox(chunk, box, inZ + z, held_.data() + z * plane + box.y * row + box.x * each, row);
        });
    } else {
        held_ = {};
        spool_ = std::make_unique<SpoolFile>(scratch_);
        std::uint64_t spooled = 0;
        for (const H5Chunk& next : chunks) {
            checkInterrupted();
            const std::vector<std::byte> chunk = readH5Chunk(file_, set_, next);
            Box box = boxOf(next);
            box.at = spooled;
            std::vector<std::byte> slice(box.sizeX * box.sizeY * each);
            for (std::uint64_t z = 0; z < slices; ++z) {
                copyBox(chunk, box, inZ + z, slice.data(), box.sizeX * each);
                spool_->append(slice);
            }
            spooled += slices * slice.size();
            boxes_.push_back(box);
        }
    }
    layer_ = layer;
}

/// Of numbers one behind the other.
void H5Slices::readRun(std::uint64_t z, std::span<std::byte> out) const {
    const std::vector<std::uint64_t>& extents = set_.space.extents;
    const std::size_t each = set_.type.bytes, first = place_.slowest;
    std::uint64_t number = 0; // of the slice's first
    for (std::size_t axis = 0; axis < extents.size(); ++axis)
        number = number * extents[axis] + (axis == first                      ? place_.first[0] + z
                                           : axis > first && axis < first + 3 ? place_.first[axis - first]
                                                                              : place_.at[axis]);
    const bool isCompact = set_.layout.kind == H5Layout::Kind::compact;
    if (!isCompact && set_.layout.at == kH5Nowhere)
        return fillWith(out);
    const std::size_t row = place_.extents[2] * each;
    const bool isWhole = place_.extents[2] == extents[first + 2];
    for (std::uint64_t y = 0; y < place_.extents[1]; y += isWhole ? place_.extents[1] : 1) {
        const std::uint64_t from = (number + y * extents[first + 2]) * each;
        const std::span<std::byte> rows = isWhole ? out : out.subspan(y * row, row);
        if (isCompact) {
            H5Bytes bytes = *set_.layout.compact;
            bytes.skip(from);
            std::ranges::copy(bytes.take(rows.size()), rows.begin());
        } else {
            file_.readAt(set_.layout.at + from, rows);
        }
    }
}

void H5Slices::readSlice(std::uint64_t z, std::span<std::byte> out) {
    TESSERA_CHECK(z < place_.extents[0] && out.size() == sliceBytes());
    checkInterrupted();
    const std::size_t each = set_.type.bytes, row = place_.extents[2] * each, plane = place_.extents[1] * row;
    std::span<std::byte> numbers = out;
    if (set_.type.isHalf) {
        numbers_.resize(plane);
        numbers = numbers_;
    }
    if (!chunks_) {
        readRun(z, numbers);
    } else {
        const std::uint64_t layer = (place_.first[0] + z) / set_.layout.chunk[place_.slowest];
        if (layer_ != layer)
            readLayer(layer);
        if (!spool_) {
            std::memcpy(numbers.data(), held_.data() + (z - layerFirst_) * plane, plane);
        } else {
            fillWith(numbers);
            for (const Box& box : boxes_) {
                std::vector<std::byte> part(box.sizeX * box.sizeY * each);
                spool_->readAt(box.at + (z - layerFirst_) * part.size(), part);
                for (std::uint64_t y = 0; y < box.sizeY; ++y)
                    std::memcpy(numbers.data() + (box.y + y) * row + box.x * each,
                                part.data() + y * box.sizeX * each, box.sizeX * each);
            }
        }
    }
    if (!set_.type.isHalf)
        return;
    for (std::size_t n = 0; n < plane / 2; ++n) {
        std::uint16_t half = 0;
        std::memcpy(&half, numbers_.data() + 2 * n, sizeof half);
        if (set_.type.isBig)
            half = static_cast<std::uint16_t>(half << 8 | half >> 8);
        const float value = floatOfHalf(half);
        std::memcpy(out.data() + sizeof value * n, &value, sizeof value);
    }
}

} // namespace tessera
