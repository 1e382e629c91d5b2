// bricking/import/zarr/zarr_slices.cpp: see zarr_slices.h.
#include "bricking/import/zarr/zarr_slices.h"

#include "bricking/store/remote_files.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint64_t kNone = ~std::uint64_t{0};
constexpr std::int64_t kMostTold = 4096; // at a time

/// Extents of 0 as the array's.
ZarrVolumePlace wholeOf(ZarrVolumePlace place, const ZarrArray& array) {
    for (std::size_t i = 0; i < 3; ++i)
        if (place.extents[i] == 0)
            place.extents[i] = array.shape[place.axes[i]] - place.first[i];
    return place;
}

/// Of a slice of a chunk.
std::size_t sliceBytesIn(const ZarrArray& array, const std::array<std::size_t, 3>& axes) {
    const auto part = [&](std::size_t axis) {
        return static_cast<std::size_t>(std::min(array.chunk[axis], array.shape[axis]));
    };
    return part(axes[1]) * part(axes[2]) * array.valueBytes();
}

} // namespace

ZarrSlices::ZarrSlices(ZarrArray array, ZarrVolumePlace place, std::filesystem::path scratch)
    : array_(std::move(array)), place_(wholeOf(std::move(place), array_)), scratch_(std::move(scratch)),
      chunks_(array_) {
    for (std::size_t i = 0; i < 3; ++i)
        TESSERA_CHECK(place_.first[i] >= 0 && place_.extents[i] > 0 &&
                      place_.extents[i] <= array_.shape[place_.axes[i]] - place_.first[i]);
    if (across(1) > kMostAcross / across(2))
        throw badFile(array_.where, "at most " + std::to_string(kMostAcross) + " chunks across a slice",
                      std::to_string(across(1)) + " x " + std::to_string(across(2)));
    place_.at.resize(array_.shape.size());
    std::vector<std::size_t> step(array_.chunk.size());
    std::size_t bytes = array_.valueBytes();
    for (std::size_t i = array_.order.size(); i-- > 0;) {
        step[array_.order[i]] = bytes;
        bytes *= static_cast<std::size_t>(array_.chunk[array_.order[i]]);
    }
    for (std::size_t i = 0; i < 3; ++i)
        stepBytes_[i] = step[place_.axes[i]];
    for (std::size_t axis = 0; axis < place_.at.size(); ++axis)
        firstByte_ += static_cast<std::size_t>(place_.at[axis] % array_.chunk[axis]) * step[axis];
}

std::size_t ZarrSlices::bytesNeeded(const ZarrArray& array, const ZarrVolumePlace& given) {
    const ZarrVolumePlace place = wholeOf(given, array);
    const auto across = [&](std::size_t i) {
        const std::int64_t chunk = array.chunk[place.axes[i]], first = place.first[i];
        return static_cast<std::size_t>((first + place.extents[i] - 1) / chunk - first / chunk + 1);
    };
    return ZarrChunks::bytesNeeded(array) + sliceBytesIn(array, place.axes) +
           across(1) * across(2) * sizeof(std::uint64_t) +
           static_cast<std::size_t>(kMostTold) * (sizeof(std::vector<std::int64_t>) + sizeof(RemoteRange) +
                                                  ZarrArray::kMostAxes * sizeof(std::int64_t));
}

void ZarrSlices::spoolChunk(const Part& part, std::span<const std::byte> chunk, std::int64_t slices) {
    const std::size_t value = array_.valueBytes();
    buffer_.resize(static_cast<std::size_t>(part.sizeX * part.sizeY) * value);
    for (std::int64_t z = 0; z < slices; ++z) {
        std::byte* to = buffer_.data();
        for (std::int64_t y = 0; y < part.sizeY; ++y) {
            const std::byte* from = chunk.data() + part.firstByte +
                                    static_cast<std::size_t>(z) * stepBytes_[0] +
                                    static_cast<std::size_t>(y) * stepBytes_[1];
            if (stepBytes_[2] == value) {
                std::memcpy(to, from, static_cast<std::size_t>(part.sizeX) * value);
                to += static_cast<std::size_t>(part.sizeX) * value;
            } else {
                for (std::int64_t x = 0; x < part.sizeX; ++x, from += stepBytes_[2], to += value)
                    std::memcpy(to, from, value);
            }
        }
        spool_->append(buffer_);
    }
    spooled_ += buffer_.size() * static_cast<std::size_t>(slices);
}

ZarrSlices::Part ZarrSlices::partOf(std::int64_t number) const {
    const auto along = [&](int axis,
                           std::int64_t chunk) { // first and size, of the volume; first in the chunk
        const std::int64_t at = (firstChunk(axis) + chunk) * chunkOf(axis),
                           begin = std::max(at, firstOf(axis)),
                           end = std::min(at + chunkOf(axis), firstOf(axis) + lengthOf(axis));
        return std::array{begin - firstOf(axis), end - begin, begin - at};
    };
    const auto [x, sizeX, inX] = along(2, number % across(2));
    const auto [y, sizeY, inY] = along(1, number / across(2));
    const std::int64_t inZ = (firstOf(0) + next_) % chunkOf(0);
    return {x, y, sizeX, sizeY,
            firstByte_ + static_cast<std::size_t>(inZ) * stepBytes_[0] +
                static_cast<std::size_t>(inY) * stepBytes_[1] +
                static_cast<std::size_t>(inX) * stepBytes_[2]};
}

/// The place of a chunk of the layer that the next slice is in.
std::vector<std::int64_t> ZarrSlices::chunkAt(std::int64_t number) const {
    std::vector<std::int64_t> at(array_.shape.size());
    for (std::size_t axis = 0; axis < at.size(); ++axis)
        at[axis] = place_.at[axis] / array_.chunk[axis];
    at[place_.axes[0]] = (firstOf(0) + next_) / chunkOf(0);
    at[place_.axes[1]] = firstChunk(1) + number / across(2);
    at[place_.axes[2]] = firstChunk(2) + number % across(2);
    return at;
}

void ZarrSlices::tellFrom(std::int64_t number) const {
    if (!chunks_.isToBeTold())
        return;
    std::vector<std::vector<std::int64_t>> told;
    const std::int64_t end = std::min(number + kMostTold, static_cast<std::int64_t>(parts_.size()));
    for (; number < end; ++number)
        told.push_back(chunkAt(number));
    chunks_.tell(told);
}

/// The chunks of the layer that begins with the next slice.
void ZarrSlices::readLayer() {
    const std::int64_t left = chunkOf(0) - (firstOf(0) + next_) % chunkOf(0),
                       slices = std::min(left, lengthOf(0) - next_);
    layerAt_ = next_;
    parts_.assign(static_cast<std::size_t>(across(1) * across(2)), kNone);
    spool_.reset();
    spooled_ = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        checkInterrupted();
        const auto number = static_cast<std::int64_t>(i);
        if (number % kMostTold == 0)
            tellFrom(number);
        const auto chunk = chunks_.read(chunkAt(number));
        if (chunk.empty())
            continue;
        if (!spool_)
            spool_ = std::make_unique<SpoolFile>(scratch_);
        parts_[i] = spooled_;
        spoolChunk(partOf(number), chunk, slices);
    }
}

std::string ZarrSlices::sayMissing() const {
    const ZarrChunks::Tally& all = tally();
    if (all.missing == 0)
        return "";
    return std::to_string(all.missing) + " of " + std::to_string(all.read) + " chunks are not there (" +
           all.firstMissing + " is the first): their voxels have the fill value, " + array_.fillShown;
}

void ZarrSlices::readSlice(std::span<std::byte> out) {
    const std::size_t value = array_.valueBytes();
    TESSERA_CHECK(next_ < lengthOf(0) &&
                  out.size() == static_cast<std::size_t>(lengthOf(1) * lengthOf(2)) * value);
    if (next_ == 0 || (firstOf(0) + next_) % chunkOf(0) == 0)
        readLayer();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        const Part part = partOf(static_cast<std::int64_t>(i));
        const bool isThere = parts_[i] != kNone;
        const std::size_t row = static_cast<std::size_t>(part.sizeX) * value;
        if (isThere) {
            buffer_.resize(row * static_cast<std::size_t>(part.sizeY));
            spool_->readAt(parts_[i] + static_cast<std::uint64_t>(next_ - layerAt_) * buffer_.size(),
                           buffer_);
        }
        for (std::int64_t y = 0; y < part.sizeY; ++y) {
            std::byte* const to =
                out.data() + static_cast<std::size_t>((part.y + y) * lengthOf(2) + part.x) * value;
            if (isThere)
                std::memcpy(to, buffer_.data() + static_cast<std::size_t>(y) * row, row);
            else
                for (std::size_t x = 0; x < row; x += value)
                    std::memcpy(to + x, array_.fill.data(), value);
        }
    }
    ++next_;
}

} // namespace tessera
