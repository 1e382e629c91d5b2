// bricking/import/part_import.cpp: see part_import.h.
#include "bricking/import/part_import.h"

#include "bricking/store/store_files.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <future>
#include <thread>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr char kJoining[] = "store"; // name of that claim

std::vector<std::string> without(std::vector<std::string> lines, const std::vector<std::string>& others) {
    std::erase_if(lines,
                  [&](const std::string& line) { return std::ranges::find(others, line) != others.end(); });
    return lines;
}

} // namespace

PartImport::PartImport(SlabSource& source, const VolumeInfo& info, WorkFolder& work, MemoryBudget& ram,
                       const ImportOptions& options, Progress& progress)
    : source_(&source), all_{options.key, info, {info.extentVoxels.z, options.partSlices}}, work_(work),
      ram_(ram), options_(options), progress_(progress), facts_(static_cast<std::size_t>(all_.parts.count())),
      notes_(source.notes()), plan_(planImport(source, info, ram.freeBytes(), options.threads, work.path())) {
    source_->setThreads(options.threads);
    for (int part = 0; part < all_.parts.count(); ++part)
        found_ += find(part);
    if (found_ > 0)
        progress_.startAt(static_cast<double>(found_) / all_.parts.count());
}

/// Looks for a part that is finished.
bool PartImport::find(int part) {
    std::optional<PartFacts>& facts = facts_[static_cast<std::size_t>(part)];
    if (!facts)
        facts = readPartFacts(work_.part(part), all_, part, work_.store());
    return facts.has_value();
}

bool PartImport::makeAll() {
    for (;;) {
        bool areAll = true, hasMade = false, othersWork = false;
        for (int part = 0; part < all_.parts.count(); ++part) {
            if (facts_[static_cast<std::size_t>(part)])
                continue;
            checkInterrupted();
            if (work_.isFinished())
                return false;
            if (find(part))
                continue;
            const std::string name = WorkFolder::nameOfPart(part);
            const std::unique_ptr<Claim> claim = work_.claims().claim(name);
            if (!claim) {
                areAll = false;
                othersWork = othersWork || work_.claims().isTaken(name);
            } else if (!find(part)) { // else an earlier holder has finished it
                make(part);
                hasMade = true;
            }
        }
        showProgress();
        if (areAll)
            return true;
        if (!hasMade)
            wait(othersWork);
    }
}

std::unique_ptr<Claim> PartImport::claimJoining() {
    for (;;) {
        checkInterrupted();
        if (work_.isFinished())
            return nullptr;
        if (std::unique_ptr<Claim> claim = work_.claims().claim(kJoining)) {
            if (work_.isFinished())
                return nullptr;
            return claim;
        }
        wait(work_.claims().isTaken(kJoining));
    }
}

/// Of a process that has nothing to do while others work.
void PartImport::wait(bool othersWork) {
    constexpr std::chrono::milliseconds kBetweenLooks{50};
    constexpr int kMostIdle = 100; // looks without any other process at work
    if (othersWork && !isWaiting_)
        progress_.stage("waiting for other processes");
    isWaiting_ = isWaiting_ || othersWork;
    idle_ = othersWork ? 0 : idle_ + 1;
    if (idle_ > kMostIdle)
        throw Error(work_.path().string() + ": lock files cannot be made in it (is the disk full?)");
    std::this_thread::sleep_for(kBetweenLooks);
}

void PartImport::make(int part) {
    std::error_code ignored;
    fs::remove_all(work_.part(part), ignored); // a damaged one
    if (std::exchange(isWaiting_, false))
        progress_.stage("importing " + source_->describe());
    try {
        work_.makePart(part, [&](const fs::path& folder) {
            facts_[static_cast<std::size_t>(part)] = write(part, folder);
        });
    } catch (const Error&) {
        if (!options_.shared || !work_.isFinished()) // else the folder went with all that is in it
            throw;
    }
}

/// Makes the source read `slice` next.
/// @param scratch  a slice, where slabs are whole
void PartImport::goTo(int slice, SlabFeed& feed, std::span<std::byte> scratch) {
    if (next_ == slice || feed.isAnywhere())
        return;
    // What a source tells of all voxels at its first slice belongs to the first part, whoever makes it.
    const bool isAnew = slice == 0 && options_.reopen;
    if (const int before = std::max(slice - 1, 0); !isAnew && source_->seek(before)) {
        next_ = before;
    } else if (next_ > slice) {
        if (!options_.reopen)
            throw Error(source_->describe() + ": read to slice " + std::to_string(next_) + ", and slice " +
                        std::to_string(slice) + " is wanted, of a source that reads on only");
        reopened_ = options_.reopen();
        source_ = reopened_.get();
        source_->setThreads(options_.threads);
        next_ = 0;
    }
    for (; next_ < slice; ++next_) {
        checkInterrupted();
        feed.pass(*source_, next_, scratch);
    }
}

/// Reads a band while the one before it is compressed, if the budget has one more. (Deferred: where no more
/// threads are to be had.)
/// @return bytes
std::uint64_t PartImport::readSlabs(int part, PartWriter& writer, SlabFeed& feed) {
    const int first = all_.parts.first(part), end = first + all_.parts.slicesOf(part);
    const int height = all_.info.extentVoxels.y, bandRows = writer.nextRows();
    const auto bandAt = [&](int slice, int row) {
        return SlabFeed::Band{slice, std::min(kChunkExtent, end - slice), row,
                              std::min(bandRows, height - row)};
    };
    const auto bytesOf = [&](const SlabFeed::Band& band) {
        return rowBytesOf(all_.info) * static_cast<std::size_t>(band.rows) *
               static_cast<std::size_t>(band.slices);
    };
    std::optional<Charge> charge;
    std::vector<std::byte> ahead;
    const bool hasMore = end - first > kChunkExtent || bandRows < height;
    if (hasMore && options_.threads != 1 && defaultThreads() > 1)
        charge = ram_.tryCharge(writer.next().size());
    if (charge)
        ahead.resize(writer.next().size());
    const auto read = [&](const SlabFeed::Band& band, std::span<std::byte> out) {
        feed.read(*source_, band, out);
        if (band.firstRow == 0 && !feed.isAnywhere()) // all of the slab has come from the source
            next_ += band.slices;
    };
    SlabFeed::Band band = bandAt(first, 0);
    read(band, writer.next());
    for (;;) {
        const bool isLast = band.firstRow + band.rows == height;
        const int slice = isLast ? band.firstSlice + band.slices : band.firstSlice;
        if (slice == end)
            break;
        band = bandAt(slice, isLast ? 0 : band.firstRow + band.rows);
        checkInterrupted();
        showProgress(slice - first);
        if (!charge) {
            writer.push();
            read(band, writer.next());
            continue;
        }
        std::future<void> reading =
            std::async(std::launch::async | std::launch::deferred, [&, wanted = Cancellation::current()] {
                const Cancellation same(wanted);
                read(band, std::span(ahead).first(bytesOf(band)));
            });
        writer.push();
        reading.get();
        writer.swapNext(ahead);
    }
    writer.push();
    return static_cast<std::uint64_t>(end - first) * sliceBytesOf(all_.info);
}

PartFacts PartImport::write(int part, const fs::path& folder) {
    SlabFeed feed(plan_, all_.info, ram_);
    PartWriter writer(folder, all_.info, all_.parts, part, ram_, options_.threads, plan_.slabs,
                      options_.codec);
    goTo(all_.parts.first(part), feed,
         writer.next().first(plan_.slabs.isWhole() ? sliceBytesOf(all_.info) : 0));
    source_->takeTally();
    const VolumeInfo before = source_->info();
    const std::vector<std::string> notesBefore = source_->notes();
    PartFacts facts;
    facts.bytesIn = readSlabs(part, writer, feed);
    facts.written = writer.finish();
    const VolumeInfo& after = source_->info();
    VoxelFindings& found = facts.findings;
    found.nonFiniteVoxels = after.nonFiniteVoxels - before.nonFiniteVoxels;
    found.clampedVoxels = after.clampedVoxels - before.clampedVoxels;
    if (found.nonFiniteVoxels > 0)
        found.absentStored = after.absentStored;
    found.lossy = after.lossy;
    found.tally = source_->takeTally();
    found.notes = without(source_->notes(), notesBefore);
    if (options_.checkSource)
        options_.checkSource();
    if (options_.durable && work_.outlives())
        syncAll(folder); // before what says that all is there
    writePartFacts(folder, all_, part, facts);
    return facts;
}

/// @param slices  of a part that is being made
void PartImport::showProgress(int slices) {
    for (int part = 0; part < all_.parts.count(); ++part)
        if (facts_[static_cast<std::size_t>(part)])
            slices += all_.parts.slicesOf(part);
    progress_.update(static_cast<double>(slices) / all_.parts.slicesInAll);
}

std::vector<PartFiles> PartImport::files() const {
    std::vector<PartFiles> files;
    for (int part = 0; part < all_.parts.count(); ++part)
        files.push_back({work_.part(part), facts_[static_cast<std::size_t>(part)]->written});
    return files;
}

VoxelFindings PartImport::findings() const {
    VoxelFindings all;
    for (const std::optional<PartFacts>& part : facts_)
        all.add(part->findings);
    std::vector<std::string> notes = notes_;
    for (std::string& note : without(std::move(all.notes), notes_))
        notes.push_back(std::move(note));
    for (std::string& note : all.tally.notes())
        notes.push_back(std::move(note));
    all.notes = std::move(notes);
    return all;
}

std::uint64_t PartImport::bytesIn() const {
    std::uint64_t bytes = 0;
    for (const std::optional<PartFacts>& part : facts_)
        bytes += part->bytesIn;
    return bytes;
}

} // namespace tessera
