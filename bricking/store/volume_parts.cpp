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
    explicit RestReader(const std::vector<PartFiles>& files) : files_(files) {}
    void read(std::span<std::byte> out) {
        while (!out.empty()) {
            const PartFiles& part = files_[part_];
            const auto some = out.first(std::min<std::uint64_t>(out.size(), part.written.restBytes - at_));
            readAt(openPart(part, kRest), at_, some, (part.folder / kRest).string());
            crc_ = crc32c(some, crc_);
            at_ += some.size();
            out = out.subspan(some.size());
            if (at_ == part.written.restBytes)
                next(part);
        }
    }

  private:
    void next(const PartFiles& part) {
        if (crc_ != part.written.restCrc)
            throw badFile((part.folder / kRest).string(), "slices whose checksum is right", "damaged ones");
        ++part_;
        at_ = crc_ = 0;
    }
    const std::vector<PartFiles>& files_;
    std::size_t part_ = 0;
    std::uint64_t at_ = 0;
    std::uint32_t crc_ = 0;
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
                       MemoryBudget& ram, int threads)
    : folder_(std::move(folder)), parts_(parts), part_(part), levels_(folder_, info, ram, threads),
      pyramid_(extentOfPart(info, parts, part), info.type, ram, threads,
               [this](const SlabPyramid::Slab& slab) { take(slab); }) {
    TESSERA_CHECK(parts.wholeLevels() > 0 && part >= 0 && part < parts.count());
}

void PartWriter::take(const SlabPyramid::Slab& slab) {
    SlabPyramid::Slab inVolume = slab;
    inVolume.firstSlice += parts_.first(part_) >> slab.level;
    if (slab.level < parts_.wholeLevels())
        return levels_.write(inVolume);
    if (slab.level > parts_.wholeLevels())
        return;
    TESSERA_CHECK(slab.firstSlice == 0); // half a slab at most
    writeFile(folder_ / kRest, slab.values);
    written_.restBytes = slab.values.size();
    written_.restCrc = crc32c(slab.values);
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
                        const fs::path& store, MemoryBudget& ram, int threads) {
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
    LevelWriter levels(store, info, ram, threads);
    SlabPyramid rest(extent, info.type, ram, threads, [&](const SlabPyramid::Slab& slab) {
        SlabPyramid::Slab inVolume = slab;
        inVolume.level += whole;
        if (inVolume.level < kLevelCount)
            levels.write(inVolume);
    });
    RestReader slices(files);
    while (rest.nextSlices() > 0) {
        checkInterrupted();
        slices.read(rest.next());
        rest.push();
    }
    levels.close();
    const WrittenLevels& written = levels.written();
    all.chunksWritten += written.chunksWritten;
    all.chunksFill += written.chunksFill;
    all.files.insert(all.files.end(), written.files.begin(), written.files.end());
    return all;
}

} // namespace tessera
