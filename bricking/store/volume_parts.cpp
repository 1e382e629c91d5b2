// bricking/store/volume_parts.cpp: see volume_parts.h. Slabs come with z ascending and a slab's chunks in the
// order of the index. So the chunks that a part has in a shard are contiguous, and the parts follow one
// another.
#include "bricking/store/volume_parts.h"

#include "bricking/store/codec.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <system_error>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr char kRest[] = "rest";

glm::ivec3 extentOfPart(const VolumeInfo& info, const VolumeParts& parts, int part) {
    return {info.extentVoxels.x, info.extentVoxels.y, parts.slicesOf(part)};
}

/// A file of a part below its folder.
StoreFile openPart(const PartFiles& part, const std::string& relative) {
    std::optional<StoreFile> file = openIn(openFolder(part.folder), relative, part.folder);
    if (!file)
        throw badFile((part.folder / relative).string(), "a file of an unfinished import", "none");
    return std::move(*file);
}

std::uint32_t crcOfFile(const StoreFile& file, std::uint64_t bytes, const std::string& shown) {
    std::vector<std::byte> piece(std::min<std::uint64_t>(bytes, std::uint64_t{1} << 20));
    std::uint32_t crc = 0;
    for (std::uint64_t at = 0; at < bytes;) {
        const auto some = std::span(piece).first(std::min<std::uint64_t>(piece.size(), bytes - at));
        readAt(file, at, some, shown);
        crc = crc32c(some, crc);
        at += some.size();
    }
    return crc;
}

/// What a part has of a shard.
struct Fragment {
    const PartFiles* part;
    const ShardFile* file;
};

void moveFragment(const Fragment& only, const fs::path& store) {
    const std::string relative = shardPath(only.file->level, only.file->at);
    std::error_code ignored;
    if (!fs::exists(only.part->folder / relative, ignored)) // an earlier call has moved it
        return;
    fs::create_directories((store / relative).parent_path());
    fs::rename(only.part->folder / relative, store / relative);
}

class ShardJoiner {
  public:
    ShardJoiner(const ShardLayout& layout, std::size_t bufferBytes, MemoryBudget& ram)
        : layout_(layout),
          charge_(ram.charge(layout.entries() *
                                     (2 * sizeof(ShardEntry) + sizeof(ShardEntry) + sizeof(std::uint32_t)) +
                                 2 * kCrcBytes + bufferBytes,
                             "joining shards")),
          buffer_(bufferBytes) {}

    ShardFile join(const std::vector<Fragment>& fragments, const fs::path& store) {
        const ShardFile& first = *fragments.front().file;
        const fs::path path = store / shardPath(first.level, first.at);
        fs::create_directories(path.parent_path());
        fs::remove(path);
        FileHandle out = openForWriting(path);
        index_.assign(layout_.entries(), {});
        crcs_.assign(layout_.entries(), 0);
        std::uint64_t end = 0;
        for (const Fragment& fragment : fragments)
            end = append(fragment, out, path, end);
        const std::vector<std::byte> encoded = encodeIndex(index_);
        writeAt(out, end, encoded, path);
        out.close(path.string());
        return {first.level, first.at, end + encoded.size(), shardRecord(index_, crcs_, encoded)};
    }

  private:
    std::uint64_t append(const Fragment& fragment, const FileHandle& out, const fs::path& path,
                         std::uint64_t end) {
        const std::string relative = shardPath(fragment.file->level, fragment.file->at);
        const std::string shown = (fragment.part->folder / relative).string();
        const StoreFile in = openPart(*fragment.part, relative);
        if (fragment.file->bytes < layout_.indexBytes())
            throw badFile(shown, "a shard's index at the end",
                          std::to_string(fragment.file->bytes) + " bytes");
        const std::uint64_t payload = fragment.file->bytes - layout_.indexBytes();
        {
            std::vector<std::byte> encoded(layout_.indexBytes());
            readAt(in, payload, encoded, shown);
            const std::vector<ShardEntry> own = decodeIndex(encoded, payload, shown);
            for (std::size_t i = 0; i < own.size(); ++i) {
                if (own[i].absent())
                    continue;
                if (own[i].bytes < kCrcBytes)
                    throw badFile(shown, "chunks with a checksum", std::to_string(own[i].bytes) + " bytes");
                index_[i] = {end + own[i].offset, own[i].bytes};
                readAt(in, own[i].offset + own[i].bytes - kCrcBytes,
                       std::as_writable_bytes(std::span(crcs_).subspan(i, 1)), shown);
            }
        }
        for (std::uint64_t at = 0; at < payload;) {
            checkInterrupted();
            const auto some = std::span(buffer_).first(std::min<std::uint64_t>(buffer_.size(), payload - at));
            readAt(in, at, some, shown);
            writeAt(out, end + at, some, path);
            at += some.size();
        }
        return end + payload;
    }

    ShardLayout layout_;
    Charge charge_;
    std::vector<std::byte> buffer_;
    std::vector<ShardEntry> index_;
    std::vector<std::uint32_t> crcs_;
};

/// Everything in a store but shards, which are moved or made again.
void removeOthers(const fs::path& store) {
    std::vector<fs::path> others;
    for (const auto& entry : fs::directory_iterator(store)) {
        const std::string name = entry.path().filename().string();
        const bool isLevel = name.size() == 1 && std::isdigit(static_cast<unsigned char>(name[0]));
        others.push_back(isLevel ? entry.path() / "zarr.json" : entry.path());
    }
    for (const fs::path& other : others)
        fs::remove_all(other);
}

/// The slices of all parts' rests, in order.
class RestReader {
  public:
    /// Throws InputError for a file whose checksum is wrong.
    /// @param sliceBytes  of the level
    RestReader(const std::vector<PartFiles>& files, std::size_t sliceBytes) : sliceBytes_(sliceBytes) {
        for (const PartFiles& part : files) {
            const fs::path path = part.folder / kRest;
            const std::uint64_t slices = part.written.restBytes / sliceBytes;
            rests_.push_back({openPart(part, kRest), path.string(), first_, slices});
            first_ += slices;
            if (crcOfFile(rests_.back().file, part.written.restBytes, path.string()) != part.written.restCrc)
                throw badFile(path.string(), "slices whose checksum is right", "damaged ones");
        }
    }
    /// Of a slice, from a byte on.
    void read(std::uint64_t slice, std::uint64_t at, std::span<std::byte> out) const {
        const auto rest =
            std::ranges::find_if(rests_, [&](const Rest& each) { return slice < each.first + each.slices; });
        TESSERA_CHECK(rest != rests_.end());
        readAt(rest->file, (slice - rest->first) * sliceBytes_ + at, out, rest->shown);
    }

  private:
    struct Rest {
        StoreFile file;
        std::string shown;
        std::uint64_t first, slices;
    };
    std::size_t sliceBytes_;
    std::vector<Rest> rests_;
    std::uint64_t first_ = 0; // slice behind those that are known
};

} // namespace

int VolumeParts::slicesOf(int part) const {
    return std::min(slices, slicesInAll - first(part));
}

int VolumeParts::wholeLevels() const {
    int levels = 0;
    for (int left = slices; levels < kLevelCount && left % kChunkExtent == 0; left /= 2)
        ++levels;
    return levels;
}

PartWriter::PartWriter(fs::path folder, const VolumeInfo& info, const VolumeParts& parts, int part,
                       MemoryBudget& ram, int threads, const SlabPlan& plan, Codec codec)
    : folder_(std::move(folder)), parts_(parts), part_(part), extent_(extentOfPart(info, parts, part)),
      levels_(folder_, info, ram, threads, codec),
      pyramid_(
          extent_, info.type, ram, threads, [this](const SlabPyramid::Slab& slab) { take(slab); }, {}, plan) {
    TESSERA_CHECK(parts.wholeLevels() > 0 && part >= 0 && part < parts.count());
}

void PartWriter::take(const SlabPyramid::Slab& slab) {
    SlabPyramid::Slab inVolume = slab;
    inVolume.firstSlice += parts_.first(part_) >> slab.level;
    if (slab.level < parts_.wholeLevels())
        return levels_.write(inVolume);
    if (slab.level > parts_.wholeLevels())
        return;
    writeRest(slab);
}

void PartWriter::writeRest(const SlabPyramid::Slab& band) {
    TESSERA_CHECK(band.firstSlice == 0); // half a slab at most
    const glm::ivec3 extent = levelExtent(extent_, band.level);
    const auto slices = static_cast<std::size_t>(band.slices), rows = static_cast<std::size_t>(extent.y);
    const fs::path path = folder_ / kRest;
    if (band.rows == extent.y) {
        writeFile(path, band.values);
        written_.restBytes = band.values.size();
        written_.restCrc = crc32c(band.values);
        return;
    }
    const std::size_t bytes = band.values.size() / slices, row = bytes / static_cast<std::size_t>(band.rows);
    FileHandle file = openForWriting(path);
    for (std::size_t slice = 0; slice < slices; ++slice)
        writeAt(file, (slice * rows + static_cast<std::size_t>(band.firstRow)) * row,
                band.values.subspan(slice * bytes, bytes), path);
    file.close(path.string());
    if (band.firstRow + band.rows < extent.y)
        return;
    written_.restBytes = slices * rows * row;
    written_.restCrc = crcOfFile(openPart({folder_, {}}, kRest), written_.restBytes, path.string());
}

WrittenPart PartWriter::finish() {
    TESSERA_CHECK(pyramid_.nextSlices() == 0);
    levels_.close();
    written_.levels = levels_.written();
    return std::move(written_);
}

bool isWhole(const PartFiles& part, const fs::path& store) {
    const auto hasSize = [](const fs::path& path, std::uint64_t bytes) {
        std::error_code failed;
        const std::uint64_t found = fs::file_size(path, failed);
        return !failed && found == bytes;
    };
    const WrittenPart& written = part.written;
    return (written.restBytes == 0 || hasSize(part.folder / kRest, written.restBytes)) &&
           std::ranges::all_of(written.levels.files, [&](const ShardFile& file) {
               const std::string relative = shardPath(file.level, file.at);
               return hasSize(part.folder / relative, file.bytes) || hasSize(store / relative, file.bytes);
           });
}

WrittenLevels joinParts(const std::vector<PartFiles>& files, const VolumeParts& parts, const VolumeInfo& info,
                        const fs::path& store, MemoryBudget& ram, int threads,
                        const std::function<SlabPlan(const glm::ivec3&)>& planOf, Codec codec) {
    removeOthers(store);
    WrittenLevels all;
    std::array<std::vector<std::vector<Fragment>>, kLevelCount> fragments; // by shard, z ascending
    for (const PartFiles& part : files) {
        const WrittenLevels& written = part.written.levels;
        all.lowest = std::min(all.lowest, written.lowest);
        all.highest = std::max(all.highest, written.highest);
        all.chunksWritten += written.chunksWritten;
        all.chunksFill += written.chunksFill;
        for (const ShardFile& file : written.files) {
            const glm::ivec3 grid = shardLayout(levelExtent(info.extentVoxels, file.level)).shards;
            auto& ofLevel = fragments[static_cast<std::size_t>(file.level)];
            ofLevel.resize(cellCount(grid));
            ofLevel[linearIndex(file.at, grid)].push_back({&part, &file});
        }
    }
    const std::size_t bufferBytes = 2 * cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
    for (int l = 0; l < kLevelCount; ++l) {
        std::optional<ShardJoiner> joiner;
        for (const std::vector<Fragment>& ofShard : fragments[static_cast<std::size_t>(l)]) {
            if (ofShard.size() == 1) {
                moveFragment(ofShard.front(), store);
                all.files.push_back(*ofShard.front().file);
            } else if (!ofShard.empty()) {
                if (!joiner)
                    joiner.emplace(shardLayout(levelExtent(info.extentVoxels, l)), bufferBytes, ram);
                all.files.push_back(joiner->join(ofShard, store));
            }
        }
    }
    const int whole = parts.wholeLevels();
    if (whole == kLevelCount)
        return all;
    const glm::ivec3 extent = levelExtent(info.extentVoxels, whole);
    LevelWriter levels(store, info, ram, threads, codec);
    const auto take = [&](const SlabPyramid::Slab& slab) {
        SlabPyramid::Slab inVolume = slab;
        inVolume.level += whole;
        if (inVolume.level < kLevelCount)
            levels.write(inVolume);
    };
    SlabPyramid rest(extent, info.type, ram, threads, take, {}, planOf ? planOf(extent) : SlabPlan{});
    const std::size_t row = static_cast<std::size_t>(extent.x) * bytesPerValue(info.type);
    const RestReader slices(files, row * static_cast<std::size_t>(extent.y));
    for (int z = 0; rest.nextSlices() > 0;) {
        checkInterrupted();
        const int count = rest.nextSlices(), firstRow = rest.nextFirstRow();
        const std::size_t bytes = row * static_cast<std::size_t>(rest.nextRows()); // of a slice
        for (int i = 0; i < count; ++i)
            slices.read(static_cast<std::uint64_t>(z + i), static_cast<std::uint64_t>(firstRow) * row,
                        rest.next().subspan(static_cast<std::size_t>(i) * bytes, bytes));
        rest.push();
        z += rest.nextFirstRow() == 0 ? count : 0;
    }
    levels.close();
    const WrittenLevels& written = levels.written();
    all.chunksWritten += written.chunksWritten;
    all.chunksFill += written.chunksFill;
    all.files.insert(all.files.end(), written.files.begin(), written.files.end());
    return all;
}

} // namespace tessera
