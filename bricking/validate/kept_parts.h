// bricking/validate/kept_parts.h: KeptParts, what a store keeps beside its levels: statistics, local
// histograms, the mask of a table, the sets of labels.
#pragma once

#include "bricking/store/store_reader.h"
#include "bricking/validate/store_faults.h"
#include "core/base/budget.h"
#include "core/base/progress.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

class KeptParts {
  public:
    /// All references outlive this.
    KeptParts(const StoreReader& store, MemoryBudget& ram, int threads, StoreFaults& faults,
              std::vector<std::string>& notes)
        : store_(store), ram_(ram), threads_(threads), faults_(faults), notes_(notes) {}

    /// Reads all of it that a volume of values has, with every checksum.
    void check();
    /// Reads the table and the cells of a volume of labels.
    void checkLabels();
    /// Makes statistics, the mask and local histograms again, the former in the system's folder for temporary
    /// files; what differs is a fault. The levels are whole.
    void compare(const ShareDone& progress);
    /// The same for the cells of a volume of labels.
    void compareLabels();
    /// Makes again what has faults.
    /// @param areLevelsWhole  else only what needs no voxels is mended
    void repair(bool areLevelsWhole, const ShareDone& progress);

  private:
    void make(const std::filesystem::path& folder, bool withStatistics, bool withTable,
              const ShareDone& progress);
    void checkTexts();
    bool hasStatisticsFaults() const;
    bool isSame(const std::filesystem::path& made, const std::string& part) const;
    void publish(const std::filesystem::path& made, const std::string& part);

    const StoreReader& store_;
    MemoryBudget& ram_;
    int threads_;
    StoreFaults& faults_;
    std::vector<std::string>& notes_;
    int version_ = 0; // of the statistics
};

} // namespace tessera
