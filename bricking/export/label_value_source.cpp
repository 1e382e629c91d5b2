// bricking/export/label_value_source.cpp: see label_value_source.h.
#include "bricking/export/label_value_source.h"

#include "core/base/error.h"

#include <algorithm>
#include <cstring>

namespace tessera {
namespace {

constexpr std::uint32_t kMostValue = 65535, kMostOfByte = 255;

/// Replaces numbers of sets; out may begin where in does, or in may be its second half.
template <class In, class Out>
void replaceNumbers(const std::byte* in, std::span<std::byte> out, const std::vector<std::uint16_t>& values) {
    for (std::size_t i = 0; i < out.size() / sizeof(Out); ++i) {
        In number = 0;
        std::memcpy(&number, in + i * sizeof(In), sizeof number);
        if (number >= values.size())
            throw Error("a number of a set of labels that the table lacks: " + std::to_string(number));
        const auto value = static_cast<Out>(values[number]);
        std::memcpy(out.data() + i * sizeof(Out), &value, sizeof value);
    }
}

} // namespace

LabelValueSource::LabelValueSource(const ChunkSource& sets, const LabelTable& table, const std::string& where)
    : sets_(sets), info_(sets.info()), values_(table.sets.size()) {
    std::uint32_t most = 0;
    for (std::size_t set = 0; set < table.sets.size(); ++set) {
        const std::vector<std::uint16_t>& labels = table.sets[set];
        if (labels.empty())
            continue;
        const Label& first = table.labels.at(labels.front());
        if (labels.size() > 1)
            throw badFile(where, "labels that do not overlap, which alone fit into one number a voxel",
                          "voxels of both \"" + first.name + "\" and \"" + table.labels.at(labels[1]).name +
                              "\"");
        if (first.value > kMostValue)
            throw badFile(where, "values of labels up to 65535", std::to_string(first.value));
        most = std::max(most, first.value);
        values_[set] = static_cast<std::uint16_t>(first.value);
    }
    info_.type = sets.info().type == ValueType::u8 && most <= kMostOfByte ? ValueType::u8 : ValueType::u16;
    info_.rescaleSlope = 1;
    info_.rescaleIntercept = info_.fillStored = 0;
    info_.unit.clear();
}

void LabelValueSource::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    const std::size_t bytes = sets_.chunkBytes();
    // The last bytes of out: what is written there was read before.
    const std::span<std::byte> numbers = out.last(bytes);
    sets_.readChunk(key, numbers);
    if (info_.type == ValueType::u8)
        replaceNumbers<std::uint8_t, std::uint8_t>(numbers.data(), out, values_);
    else if (sets_.info().type == ValueType::u8)
        replaceNumbers<std::uint8_t, std::uint16_t>(numbers.data(), out, values_);
    else
        replaceNumbers<std::uint16_t, std::uint16_t>(numbers.data(), out, values_);
}

} // namespace tessera
