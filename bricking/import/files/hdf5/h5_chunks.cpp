// bricking/import/files/hdf5/h5_chunks.cpp: the places of chunks: see h5_chunks.h.
#include "bricking/import/files/hdf5/h5_chunks.h"

#include "bricking/import/files/hdf5/h5_tree.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr const char* kOldTree = "a B-tree of chunks";

std::uint64_t chunksAlong(std::uint64_t extent, std::uint64_t chunk) {
    return extent / chunk + (extent % chunk != 0 ? 1 : 0);
}

} // namespace

H5Chunks::H5Chunks(const H5File& file, const H5Set& set) : file_(file), set_(set) {
    const std::size_t axes = set.layout.chunk.size();
    for (std::size_t axis = 0; axis < axes; ++axis)
        chunks_.push_back(chunksAlong(set.space.extents[axis], set.layout.chunk[axis]));
    const H5Index index = set.layout.index;
    if (index == H5Index::oldTree || index == H5Index::tree || set.layout.at == kH5Nowhere)
        return;
    // Numbers of chunks count those that the set may have. The axis without an end counts slowest.
    std::vector<std::size_t> order;
    for (std::size_t axis = 0; axis < axes; ++axis)
        if (set.space.most[axis] == kH5Unlimited)
            order.insert(order.begin(), axis);
        else
            order.push_back(axis);
    const auto ends = std::ranges::count(set.space.most, kH5Unlimited);
    if (ends != (index == H5Index::extensibleArray ? 1 : 0))
        file.refuse("chunks of " + set.name + " found in a way that fits the axes without an end",
                    std::to_string(ends) + " of them");
    steps_.resize(axes);
    std::uint64_t all = 1;
    for (std::size_t n = axes; n-- > 0;) {
        const std::size_t axis = order[n];
        steps_[axis] = all;
        const std::uint64_t along = set.space.most[axis] == kH5Unlimited
                                        ? 1
                                        : chunksAlong(set.space.most[axis], set.layout.chunk[axis]);
        constexpr std::uint64_t kMost = std::uint64_t{1} << 48;
        if (along > kMost / std::max<std::uint64_t>(all, 1))
            file.refuse("2^48 chunks at most in " + set.name, "more");
        all *= along;
    }
    const H5Entries entries{!set.filters.empty(), set.chunkBytes, 0};
    if (index == H5Index::fixedArray) {
        fixed_.emplace(file, set.layout.at, entries);
        if (fixed_->count() != all)
            file.refuse(std::to_string(all) + " chunks of " + set.name, std::to_string(fixed_->count()));
    } else if (index == H5Index::extensibleArray) {
        growing_.emplace(file, set.layout.at, entries);
    }
}

/// As the trees are ordered: by the axes from the slowest on, up to those along which the layer has several.
int H5Chunks::compare(const H5Place& place, const Layer& layer) const {
    const std::size_t end = std::min(layer.across[0].axis, layer.across[1].axis);
    for (std::size_t axis = 0; axis < end; ++axis)
        if (place[axis] != layer.at[axis])
            return place[axis] < layer.at[axis] ? -1 : 1;
    return 0;
}

void H5Chunks::add(H5Place place, const H5Extent& extent, const Layer& layer) const {
    for (std::size_t axis = 0; axis < place.size(); ++axis) {
        if (place[axis] >= chunks_[axis])
            return; // it was cut off
        const auto [begin, end] =
            axis == layer.across[0].axis   ? std::pair(layer.across[0].begin, layer.across[0].end)
            : axis == layer.across[1].axis ? std::pair(layer.across[1].begin, layer.across[1].end)
                                           : std::pair(layer.at[axis], layer.at[axis] + 1);
        if (place[axis] < begin || place[axis] >= end)
            return;
    }
    if (extent.at == kH5Nowhere)
        return;
    if (!file_.has(extent.at, extent.bytes))
        file_.refuse("chunks of " + set_.name + " within the file",
                     std::to_string(extent.bytes) + " bytes behind its end (is it truncated?)");
    if (layer.found.size() >= layer.across[0].count() * layer.across[1].count())
        file_.refuse("each chunk of " + set_.name + " once", "one again");
    layer.found.push_back({std::move(place), extent});
}

std::vector<H5Chunk> H5Chunks::ofLayer(const H5Place& at, const std::array<Range, 2>& across) {
    std::vector<H5Chunk> found;
    const Layer layer{at, across, found};
    constexpr std::uint64_t kMost = std::uint64_t{1} << 22;
    if (across[0].count() > kMost / std::max<std::uint64_t>(across[1].count(), 1))
        file_.refuse("4194304 chunks at most in a layer of " + set_.name, "more");
    if (set_.layout.at == kH5Nowhere)
        return found;
    std::set<std::uint64_t> seen;
    if (set_.layout.index == H5Index::oldTree)
        searchOldTree(set_.layout.at, -1, layer, seen);
    else if (set_.layout.index == H5Index::tree)
        searchTree(layer);
    else
        searchArray(layer);
    std::ranges::sort(found, {}, &H5Chunk::place);
    if (std::ranges::adjacent_find(found, {}, &H5Chunk::place) != found.end())
        file_.refuse("each chunk of " + set_.name + " once", "one again");
    return found;
}

void H5Chunks::searchOldTree(std::uint64_t at, int expected, const Layer& layer,
                             std::set<std::uint64_t>& seen) const {
    checkInterrupted();
    const std::size_t axes = chunks_.size(), address = file_.addressBytes();
    const std::uint64_t head = 8 + 2 * address, keyBytes = 8 + 8 * (axes + 1);
    H5Bytes bytes = file_.block(at, head, kOldTree);
    if (H5Bytes::textOf(bytes.take(4)) != "TREE")
        bytes.refuse("its mark at byte " + std::to_string(at), "another (damage)");
    const int kind = bytes.byte(), level = bytes.byte();
    constexpr int kMostLevel = 32;
    if (kind != 1 || (expected >= 0 ? level != expected : level > kMostLevel))
        bytes.refuse("levels one below another",
                     "kind " + std::to_string(kind) + ", level " + std::to_string(level));
    const std::uint64_t entries = bytes.number(2);
    H5Bytes rest = file_.block(at + head, entries * (keyBytes + address), kOldTree);
    struct Entry {
        H5Place place;
        H5Extent extent;
    };
    std::vector<Entry> all;
    for (std::uint64_t n = 0; n < entries; ++n) {
        Entry entry;
        entry.extent.bytes = rest.number(4);
        entry.extent.mask = static_cast<std::uint32_t>(rest.number(4));
        for (std::size_t axis = 0; axis < axes; ++axis) {
            const std::uint64_t first = rest.number(8), side = set_.layout.chunk[axis];
            if (first % side != 0)
                rest.refuse("chunks at multiples of their sides", "one at " + std::to_string(first));
            entry.place.push_back(first / side);
        }
        rest.skip(8);
        entry.extent.at = rest.address();
        if (n > 0 && !(all.back().place < entry.place))
            rest.refuse("chunks in order", "others");
        all.push_back(std::move(entry));
    }
    for (std::size_t n = 0; n < all.size(); ++n) {
        if (level == 0) {
            add(std::move(all[n].place), all[n].extent, layer);
            continue;
        }
        if (compare(all[n].place, layer) > 0)
            break;
        if (n + 1 < all.size() && compare(all[n + 1].place, layer) < 0)
            continue; // what follows its first chunk lies before the layer
        if (!seen.insert(all[n].extent.at).second)
            rest.refuse("nodes once", "one that is met again");
        searchOldTree(all[n].extent.at, level - 1, layer, seen);
    }
}

void H5Chunks::searchTree(const Layer& layer) const {
    const std::size_t axes = chunks_.size();
    const bool areFiltered = !set_.filters.empty();
    const std::size_t bytes = h5RecordBytes(file_, set_.layout.at);
    H5Entries entries{areFiltered, set_.chunkBytes, 0};
    const std::size_t places = 8 * axes;
    if (bytes <= places)
        file_.refuse("records of chunks of " + set_.name, std::to_string(bytes) + " bytes");
    entries.setBytes(bytes - places, file_);
    const auto placeOf = [&](H5Bytes& record) {
        H5Place place;
        for (std::size_t axis = 0; axis < axes; ++axis)
            place.push_back(record.number(8));
        return place;
    };
    constexpr int kPlain = 10, kFiltered = 11;
    eachH5Record(
        file_, set_.layout.at, areFiltered ? kFiltered : kPlain,
        [&](H5Bytes record) {
            record.skip(entries.bytes);
            return compare(placeOf(record), layer);
        },
        [&](H5Bytes& record) {
            const H5Extent extent = entries.read(record);
            add(placeOf(record), extent, layer);
        });
}

H5Extent H5Chunks::extentOf(const H5Place& place) {
    const H5Layout& layout = set_.layout;
    std::uint64_t number = 0;
    for (std::size_t axis = 0; axis < place.size(); ++axis)
        number += place[axis] * steps_[axis];
    switch (layout.index) {
    case H5Index::fixedArray:
        return fixed_->entry(number);
    case H5Index::extensibleArray:
        return growing_->entry(number);
    case H5Index::implicit: {
        const std::uint64_t at = layout.at + number * set_.chunkBytes;
        return {number > file_.sizeBytes() / set_.chunkBytes ? file_.sizeBytes() : at, set_.chunkBytes, 0};
    }
    default:
        if (number > 0)
            file_.refuse("one chunk of " + set_.name + ", as its layout says", "more");
        return {layout.at, layout.singleBytes > 0 ? layout.singleBytes : set_.chunkBytes, layout.singleMask};
    }
}

void H5Chunks::searchArray(const Layer& layer) {
    H5Place place = layer.at;
    for (std::uint64_t a = layer.across[0].begin; a < layer.across[0].end; ++a) {
        checkInterrupted();
        for (std::uint64_t b = layer.across[1].begin; b < layer.across[1].end; ++b) {
            place[layer.across[0].axis] = a;
            place[layer.across[1].axis] = b;
            add(place, extentOf(place), layer);
        }
    }
}

} // namespace tessera
