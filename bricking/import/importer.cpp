// bricking/import/importer.cpp: see importer.h.
#include "bricking/import/importer.h"

#include "bricking/analysis/body/kept_table.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "bricking/store/store_writer.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"

#include <algorithm>
#include <chrono>

namespace tessera {

namespace {
std::string sayWhyNoSuv(const VolumeInfo& info) {
    for (const std::string& remark : info.remarks)
        if (remark.rfind("SUV", 0) == 0)
            return remark;
    return "one that does not";
}
} // namespace

std::size_t importFloorBytes(const VolumeInfo& info, int threads) {
    // Writing gives its memory back before the statistics are made.
    return std::max(StoreWriter::floorBytes(info, threads), statisticsFloorBytes(info, threads));
}

ImportReport importToStore(SlabSource& source, const std::filesystem::path& store, MemoryBudget& ram,
                           const ImportOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    VolumeInfo info = source.info();
    if (!options.unit.empty() && !info.unit.empty() && info.unit != options.unit)
        throw badFile(source.describe(), "values in " + options.unit, "values in " + info.unit);
    if (options.unit == kSuvUnit) {
        if (!(info.suvPerValue > 0))
            throw badFile(source.describe(), "a PET whose header tells all that SUV takes",
                          sayWhyNoSuv(info));
        info.rescaleSlope *= info.suvPerValue;
        info.rescaleIntercept *= info.suvPerValue;
        info.suvPerValue = 1;
    }
    if (!options.unit.empty())
        info.unit = options.unit;
    info.validate(source.describe());
    {
        const Charge floor =
            ram.charge(importFloorBytes(info, options.threads), "importing " + source.describe());
    }
    StoreWriter writer(store, info, ram, options.threads, options.force);
    ImportReport report;
    Progress silent;
    Progress& progress = options.progress ? *options.progress : silent;
    progress.stage("importing " + source.describe());
    int slices = 0;
    while (const int count = writer.nextSlices()) {
        checkInterrupted();
        const std::span<std::byte> slab = writer.next();
        source.readSlices(count, slab);
        writer.push();
        report.bytesIn += slab.size();
        slices += count;
        progress.update(static_cast<double>(slices) / info.extentVoxels.z);
    }
    writer.finish(source.info());
    {
        progress.stage("computing statistics");
        const StoreReader reader(writer.folder(), ram);
        buildStatistics(reader, writer.folder(), ram, options.threads, progress.shares());
        if (info.unit == "HU" && ram.freeBytes() >= tableMaskBytes(info)) // else at first use
            keepTable(findTable(reader, ram, options.threads), reader, writer.folder());
    }
    progress.stage("finishing the store");
    writer.commit(options.durable);
    const StoreWriter::Counters counters = writer.counters();
    report.voxels = info.voxelCount();
    report.bytesOut = counters.bytesWritten;
    report.chunksWritten = counters.chunksWritten;
    report.chunksFill = counters.chunksFill;
    report.seconds = secondsSince(start);
    return report;
}

} // namespace tessera
