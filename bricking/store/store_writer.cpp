// bricking/store/store_writer.cpp: see store_writer.h.
#include "bricking/store/store_writer.h"

#include "bricking/store/level_writer.h"
#include "bricking/store/pyramid.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h" // isStore
#include "bricking/store/zarr_metadata.h"
#include "core/base/brick.h"
#include "core/base/error.h"

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <system_error>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;
namespace {

/// All checks before a folder is made.
const fs::path& checkedTarget(const fs::path& target, const VolumeInfo& info, bool force) {
    checkStoreTarget(target, info, force);
    return target;
}

} // namespace

struct StoreWriter::State {
    State(const fs::path& storeAt, const VolumeInfo& volume, MemoryBudget& ram, int threads, bool replace,
          PyramidRule rule);

    fs::path target;
    bool force;
    VolumeInfo info;
    std::string rule;
    TemporaryFolder folder;
    std::optional<LevelWriter> levels;
    std::optional<SlabPyramid> pyramid;
    Counters counters;
    bool finished = false;
};

void checkStoreTarget(const fs::path& target, const VolumeInfo& info, bool force) {
    checkStorable(info, target.string());
    std::error_code ignored;
    if (fs::symlink_status(target, ignored).type() != fs::file_type::not_found) {
        if (!isStore(target))
            throw badFile(target.string(), "a new name or a store of Tessera",
                          "something else; it is left alone");
        if (!force)
            throw badFile(target.string(), "a new name, or --force to replace", "an existing store");
    }
}

StoreWriter::State::State(const fs::path& storeAt, const VolumeInfo& volume, MemoryBudget& ram, int threads,
                          bool replace, PyramidRule pyramidRule)
    : target(storeAt), force(replace), info(withPlainTexts(volume)), rule(pyramidRule.name),
      folder(checkedTarget(target, info, force)) {
    // The total first, so that the message names the minimum and not one of its parts.
    { const Charge floor = ram.charge(floorBytes(info, threads), "importing a volume this wide"); }
    levels.emplace(folder.path(), info, ram, threads);
    pyramid.emplace(
        info.extentVoxels, info.type, ram, threads,
        [this](const SlabPyramid::Slab& slab) { levels->write(slab); }, std::move(pyramidRule));
}

std::uint64_t writeDocuments(const fs::path& folder, const StoreMetadata& metadata) {
    std::uint64_t bytes = 0;
    for (int level = 0; level < kLevelCount; ++level) {
        const std::string text = levelDocument(metadata, level);
        const fs::path ofLevel = folder / std::to_string(level);
        fs::create_directories(ofLevel); // a level of fill alone has no shard
        writeFile(ofLevel / "zarr.json", text);
        bytes += text.size();
    }
    const std::string text = groupDocument(metadata);
    if (text.size() > kMaxMetadataBytes)
        throw badFile(folder.string(), "metadata of at most 16 MiB", "a volume with more shards");
    writeFile(folder / "zarr.json", text);
    return bytes + text.size();
}

StoreMetadata metadataOf(const VolumeInfo& info, const WrittenLevels& written) {
    StoreMetadata metadata;
    metadata.info = info;
    metadata.lowest = written.lowest;
    metadata.highest = written.highest;
    std::array<glm::ivec3, kLevelCount> grids;
    for (int l = 0; l < kLevelCount; ++l) {
        const auto at = static_cast<std::size_t>(l);
        grids[at] = shardLayout(levelExtent(info.extentVoxels, l)).shards;
        metadata.shards[at].resize(cellCount(grids[at]));
    }
    for (const ShardFile& file : written.files) {
        const auto at = static_cast<std::size_t>(file.level);
        metadata.shards[at][linearIndex(file.at, grids[at])] = file.record;
    }
    return metadata;
}

void keepVoxelFindings(VolumeInfo& info, const VolumeInfo& final) {
    info.nonFiniteVoxels = final.nonFiniteVoxels;
    info.absentStored = final.absentStored;
    info.clampedVoxels = final.clampedVoxels;
    info.lossy = final.lossy;
    info.remarks = withPlainTexts(final).remarks;
}

StoreWriter::StoreWriter(const fs::path& target, const VolumeInfo& info, MemoryBudget& ram, int threads,
                         bool force, PyramidRule rule)
    : state_(std::make_unique<State>(target, info, ram, threads, force, std::move(rule))) {}
StoreWriter::~StoreWriter() = default;

std::size_t StoreWriter::floorBytes(const VolumeInfo& info, int threads) {
    return SlabPyramid::bytesNeeded(info.extentVoxels, info.type) + LevelWriter::bytesNeeded(info, threads);
}

int StoreWriter::nextSlices() const {
    return state_->pyramid ? state_->pyramid->nextSlices() : 0;
}
std::span<std::byte> StoreWriter::next() {
    return state_->pyramid->next();
}
void StoreWriter::push() {
    state_->pyramid->push();
}

void StoreWriter::finish(const VolumeInfo& final, const std::string& imageLabel) {
    State& s = *state_;
    TESSERA_CHECK(s.pyramid && s.pyramid->nextSlices() == 0);
    s.pyramid.reset();
    s.levels->close();
    keepVoxelFindings(s.info, final);
    const WrittenLevels& written = s.levels->written();
    StoreMetadata metadata = metadataOf(s.info, written);
    metadata.rule = s.rule;
    metadata.imageLabel = imageLabel;
    s.counters = {written.chunksWritten, written.chunksFill,
                  written.bytes() + writeDocuments(s.folder.path(), metadata)};
    s.finished = true;
}

void StoreWriter::commit(bool durable) {
    TESSERA_CHECK(state_->finished);
    checkedTarget(state_->target, state_->info, state_->force); // something may have appeared there meanwhile
    state_->folder.commit(durable, state_->force);
}

const fs::path& StoreWriter::folder() const {
    return state_->folder.path();
}
StoreWriter::Counters StoreWriter::counters() const {
    return state_->counters;
}

} // namespace tessera
