// bricking/import/importer.cpp: see importer.h.
#include "bricking/import/importer.h"

#include "bricking/analysis/body/kept_table.h"
#include "bricking/import/part_facts.h"
#include "bricking/import/part_import.h"
#include "bricking/import/slab_feed.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h"
#include "bricking/store/store_writer.h"
#include "bricking/store/volume_parts.h"
#include "bricking/store/work_folder.h"
#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/base/claims.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/base/volume.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace tessera {

namespace {
namespace fs = std::filesystem;

std::string sayWhyNoSuv(const VolumeInfo& info) {
    for (const std::string& remark : info.remarks)
        if (remark.rfind("SUV", 0) == 0)
            return remark;
    return "one that does not";
}

/// The source's info with the unit that the user says.
VolumeInfo infoOf(const SlabSource& source, const std::string& unit) {
    VolumeInfo info = source.info();
    if (!unit.empty() && !info.unit.empty() && info.unit != unit)
        throw badFile(source.describe(), "values in " + unit, "values in " + info.unit);
    if (unit == kSuvUnit) {
        if (!(info.suvPerValue > 0))
            throw badFile(source.describe(), "a PET whose header tells all that SUV takes",
                          sayWhyNoSuv(info));
        info.rescaleSlope *= info.suvPerValue;
        info.rescaleIntercept *= info.suvPerValue;
        info.suvPerValue = 1;
    }
    if (!unit.empty())
        info.unit = unit;
    info.validate(source.describe());
    return info;
}

InputError anotherVolume(const fs::path& store) {
    return badFile(store.string(), "a new name, or this source's volume that others have imported",
                   "a store of another volume");
}

/// True if the store has slices of the source: a few if it can go to them, else all. Like voxels alone tell
/// two scans of one machine apart.
bool hasSlicesOf(SlabSource& source, const StoreReader& store, MemoryBudget& ram) {
    constexpr int kSlices = 8;
    const VolumeInfo& info = store.info();
    const glm::ivec3 extent = info.extentVoxels;
    const std::size_t value = bytesPerValue(info.type), sliceBytes = sliceBytesOf(info);
    const Charge charge =
        ram.charge(sliceBytes + store.chunkBytes(), "comparing with " + store.path().string());
    std::vector<std::byte> slice(sliceBytes), chunk(store.chunkBytes());
    const auto isThere = [&](int z) {
        for (int y = 0; y < extent.y; y += kChunkExtent)
            for (int x = 0; x < extent.x; x += kChunkExtent) {
                store.readChunk({0, x / kChunkExtent, y / kChunkExtent, z / kChunkExtent}, chunk);
                const auto count = static_cast<std::size_t>(std::min(kChunkExtent, extent.x - x)) * value;
                for (int row = y; row < std::min(y + kChunkExtent, extent.y); ++row) {
                    const auto at = static_cast<std::size_t>((z % kChunkExtent) * kChunkExtent + row - y);
                    const auto of = static_cast<std::size_t>(row) * static_cast<std::size_t>(extent.x) +
                                    static_cast<std::size_t>(x);
                    if (std::memcmp(&chunk[at * kChunkExtent * value], &slice[of * value], count) != 0)
                        return false;
                }
            }
        return true;
    };
    const int step = source.seek(0) ? std::max(extent.z / kSlices, 1) : 1;
    for (int z = 0; z < extent.z; z += step) {
        checkInterrupted();
        if (step > 1)
            source.seek(z);
        source.readSlices(1, slice);
        if (!isThere(z))
            return false;
    }
    return true;
}

/// Of a store that others made. Where machines share a folder, its name may take a while to come.
ImportReport reportOfOthers(const fs::path& store, const VolumeInfo& info, MemoryBudget& ram) {
    constexpr std::chrono::milliseconds kBetweenLooks{100};
    for (int looks = 0; !isStore(store) && looks < 50; ++looks)
        std::this_thread::sleep_for(kBetweenLooks);
    if (!isStore(store))
        throw Error(store.string() + ": another process ended this import without a store");
    ImportReport report;
    report.info = StoreReader(store, ram).info();
    report.byOthers = true;
    if (report.info.extentVoxels != info.extentVoxels || report.info.type != info.type ||
        report.info.patientFromVoxel != info.patientFromVoxel || report.info.unit != info.unit)
        throw anotherVolume(store);
    return report;
}

/// Joins the parts and publishes the store.
/// @param isOfUse  true from when the parts are found to be whole
void finish(const PartImport& made, const Claim& claim, VolumeInfo info, WorkFolder& work, MemoryBudget& ram,
            const ImportOptions& options, Progress& progress, ImportReport& report, bool& isOfUse) {
    progress.stage("joining parts");
    const WrittenLevels written = joinParts(
        made.files(), made.parts(), info, work.store(), ram, options.threads,
        [&](const glm::ivec3& extent) { return planSlabs(extent, info.type, ram.freeBytes(), work.path()); },
        options.codec);
    isOfUse = true;
    const VoxelFindings findings = made.findings();
    report.info = findings.applied(info);
    report.notes = findings.notes;
    info = withPlainTexts(std::move(info));
    keepVoxelFindings(info, report.info);
    StoreMetadata metadata = metadataOf(info, written);
    metadata.rule = kPyramidRule;
    metadata.codec = options.codec;
    report.bytesOut = written.bytes() + writeDocuments(work.store(), metadata);
    report.chunksWritten = written.chunksWritten;
    report.chunksFill = written.chunksFill;
    {
        progress.stage("computing statistics");
        const StoreReader reader(work.store(), ram);
        buildStatistics(reader, work.store(), ram, options.threads, progress.shares());
        if (info.unit == "HU" && ram.freeBytes() >= tableMaskBytes(info)) // else at first use
            keepTable(findTable(reader, ram, options.threads), reader, work.store());
    }
    progress.stage("finishing the store");
    if (options.checkSource) {
        isOfUse = false; // of a source that changed
        options.checkSource();
        isOfUse = true;
    }
    if (!claim.isHeld())
        throw Error(work.path().string() + ": another process took this one for dead");
    work.publish(options.durable, options.force);
}
} // namespace

std::size_t importFloorBytes(const SlabSource& source, const VolumeInfo& info, int threads) {
    // Writing gives its memory back before the statistics are made.
    return std::max(leastImportBytes(source, info, threads), buildStatisticsFloorBytes(info, threads));
}

ImportReport importToStore(SlabSource& source, const fs::path& store, MemoryBudget& ram,
                           const ImportOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    const VolumeInfo info = infoOf(source, options.unit);
    {
        const Charge floor =
            ram.charge(importFloorBytes(source, info, options.threads), "importing " + source.describe());
    }
    if (options.shared && isStore(store)) {
        recoverFolders(placeOfStore(store).parent_path());
        ImportReport report = reportOfOthers(store, info, ram);
        if (!hasSlicesOf(source, StoreReader(store, ram), ram))
            throw anotherVolume(store);
        return report;
    }
    checkStoreTarget(store, info, options.force);
    Progress silent;
    Progress& progress = options.progress ? *options.progress : silent;
    const bool hasParts = info.extentVoxels.z > options.partSlices; // else nothing to go on with
    WorkFolder work(store, {hasParts || options.shared ? options.key : "", options.shared});
    ImportReport report;
    bool isOfUse = false; // what is finished, whatever goes wrong
    const auto madeByOthers = [&] {
        if (!options.shared) // there are none
            throw Error(work.path().string() + ": the folder of this import was removed meanwhile");
        return reportOfOthers(store, info, ram);
    };
    try {
        progress.stage("importing " + source.describe());
        PartImport parts(source, info, work, ram, options, progress);
        if (!parts.makeAll())
            return madeByOthers();
        const std::unique_ptr<Claim> claim = parts.claimJoining();
        if (!claim)
            return madeByOthers();
        report.bytesIn = parts.bytesIn();
        report.parts = parts.parts().count();
        report.partsFound = parts.partsFound();
        isOfUse = true;
        checkStoreTarget(store, info, options.force); // something may have appeared there meanwhile
        isOfUse = false;
        finish(parts, *claim, info, work, ram, options, progress, report, isOfUse);
    } catch (const InputError&) {
        if (!isOfUse)
            work.discard();
        throw;
    }
    report.voxels = info.voxelCount();
    report.seconds = secondsSince(start);
    return report;
}

} // namespace tessera
