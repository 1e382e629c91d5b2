// bricking/import/part_import.h: makes the parts of an import that are missing, together with other
// processes.
#pragma once

#include "bricking/import/importer.h"
#include "bricking/import/part_facts.h"
#include "bricking/import/slab_feed.h"
#include "bricking/import/source/slab_source.h"
#include "bricking/store/volume_parts.h"
#include "bricking/store/work_folder.h"
#include "core/base/budget.h"
#include "core/base/claims.h"
#include "core/base/progress.h"
#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class PartImport {
  public:
    /// @param source  at its first slice
    /// @param info  of the store: source.info() with the user's unit
    PartImport(SlabSource& source, const VolumeInfo& info, WorkFolder& work, MemoryBudget& ram,
               const ImportOptions& options, Progress& progress);

    /// Makes the missing parts, and waits for those that other processes make.
    /// @return false: another process has finished the store
    bool makeAll();
    /// The claim of joining the parts, for one process; waits for it.
    /// @return null: another process has finished the store
    std::unique_ptr<Claim> claimJoining();

    const VolumeParts& parts() const { return all_.parts; }
    int partsFound() const { return found_; }
    /// After makeAll().
    std::vector<PartFiles> files() const;
    VoxelFindings findings() const;
    std::uint64_t bytesIn() const;

  private:
    bool find(int part);
    void make(int part);
    PartFacts write(int part, const std::filesystem::path& folder);
    std::uint64_t readSlabs(int part, PartWriter& writer, SlabFeed& feed);
    void goTo(int slice, SlabFeed& feed, std::span<std::byte> scratch);
    void wait(bool othersWork);
    void showProgress(int slices = 0);

    SlabSource* source_;
    std::unique_ptr<SlabSource> reopened_;
    PartsOfImport all_;
    WorkFolder& work_;
    MemoryBudget& ram_;
    const ImportOptions& options_;
    Progress& progress_;
    std::vector<std::optional<PartFacts>> facts_;
    std::vector<std::string> notes_; // of opening the source
    ImportPlan plan_;
    int next_ = 0;             // slice that the source reads next
    int found_ = 0, idle_ = 0; // idle_: looks in a row without a process at work
    bool isWaiting_ = false;
};

} // namespace tessera
