// tests/support/bricking_test_volumes.h: small volumes from a hash, and whole levels read back,
// for the tests of bricking.
#pragma once

#include "bricking/import/importer.h"
#include "bricking/store/store_reader.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

namespace tessera::test {
namespace fs = std::filesystem;

inline std::uint64_t mixed(std::uint64_t h) {
    h = (h ^ (h >> 31)) * 0x7fb5d329728ea185u;
    h = (h ^ (h >> 27)) * 0x81dadef4bc2dd44du;
    return h ^ (h >> 33);
}

inline VolumeInfo plainInfo(const glm::ivec3& extent, ValueType type) {
    VolumeInfo info;
    info.extentVoxels = extent;
    info.type = type;
    info.patientFromVoxel = patientFromVoxelOf({-10, -20, -30}, {0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 1.25});
    return info;
}

/// Values over the whole range of the type, by a hash of the position, or what `value` says.
class HashSource : public SlabSource {
  public:
    using Formula = std::function<double(int, int, int)>;
    explicit HashSource(const VolumeInfo& info, Formula value = {}) : info_(info), value_(std::move(value)) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return "a test volume"; }
    void readSlices(int count, std::span<std::byte> out) override {
        if (nextZ_ + count > failAtZ)
            throw InputError("test: the source broke off");
        const std::size_t bytes = bytesPerValue(info_.type);
        requireSize(out.size(), static_cast<std::size_t>(count) * bytes *
                                    static_cast<std::size_t>(info_.extentVoxels.x) *
                                    static_cast<std::size_t>(info_.extentVoxels.y));
        std::byte* to = out.data();
        for (int z = nextZ_; z < nextZ_ + count; ++z)
            for (int y = 0; y < info_.extentVoxels.y; ++y)
                for (int x = 0; x < info_.extentVoxels.x; ++x, to += bytes)
                    put(valueAt(x, y, z), to);
        nextZ_ += count;
    }
    double valueAt(int x, int y, int z) const {
        if (value_)
            return value_(x, y, z);
        const std::uint64_t h =
            mixed((static_cast<std::uint64_t>(z) * 1000003u + static_cast<std::uint64_t>(y)) * 1000003u +
                  static_cast<std::uint64_t>(x) + 17);
        switch (info_.type) {
        case ValueType::u8:
            return static_cast<double>(h & 0xFF);
        case ValueType::i16:
            return static_cast<double>(h & 0xFFFF) - 32768;
        case ValueType::u16:
            return static_cast<double>(h & 0xFFFF);
        case ValueType::f32:
            return static_cast<double>(static_cast<float>(
                std::ldexp(static_cast<double>(h & 0xFFFFFF) - 8388608.0, static_cast<int>(h >> 60) - 30)));
        }
        return 0;
    }
    int failAtZ = INT32_MAX; // reading this slice throws

  private:
    static void requireSize(std::size_t found, std::size_t expected) {
        if (found != expected)
            throw Error("test: the importer asked for a slab of a wrong size");
    }
    void put(double value, std::byte* to) const {
        const auto copy = [&](auto typed) { std::memcpy(to, &typed, sizeof typed); };
        switch (info_.type) {
        case ValueType::u8:
            return copy(static_cast<std::uint8_t>(value));
        case ValueType::i16:
            return copy(static_cast<std::int16_t>(value));
        case ValueType::u16:
            return copy(static_cast<std::uint16_t>(value));
        case ValueType::f32:
            return copy(static_cast<float>(value));
        }
    }
    VolumeInfo info_;
    Formula value_;
    int nextZ_ = 0;
};

/// A whole level, chunk by chunk, [z][y][x].
/// @param padding  called with every value beyond the level's edge
inline std::vector<double> readLevel(const StoreReader& store, int level,
                                     const std::function<void(double)>& padding = {}) {
    const glm::ivec3 extent = levelExtent(store.info().extentVoxels, level),
                     grid = ceilDiv(extent, kChunkExtent);
    std::vector<double> values(cellCount(extent));
    std::vector<std::byte> chunk(store.chunkBytes());
    for (int k = 0; k < grid.z; ++k)
        for (int j = 0; j < grid.y; ++j)
            for (int i = 0; i < grid.x; ++i) {
                store.readChunk({level, i, j, k}, chunk);
                for (int z = 0; z < kChunkExtent; ++z)
                    for (int y = 0; y < kChunkExtent; ++y)
                        for (int x = 0; x < kChunkExtent; ++x) {
                            const glm::ivec3 at = glm::ivec3(i, j, k) * kChunkExtent + glm::ivec3(x, y, z);
                            const double value =
                                storedValue(store.info().type,
                                            chunk.data() + linearIndex({x, y, z}, glm::ivec3(kChunkExtent)) *
                                                               bytesPerValue(store.info().type));
                            if (at.x < extent.x && at.y < extent.y && at.z < extent.z)
                                values[linearIndex(at, extent)] = value;
                            else if (padding)
                                padding(value);
                        }
            }
    return values;
}

inline std::string fileText(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
inline void setFileText(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

/// Names of all that is in a folder, hidden ones included.
inline std::size_t entriesIn(const fs::path& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

} // namespace tessera::test
