// viewer/cli/batch/row_pool.h: rows of a batch on several threads, with one line of progress for all.
#pragma once

#include "core/base/progress.h"
#include "viewer/cli/batch/batch_record.h"
#include "viewer/cli/options/options.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// What was done, with the first failures.
struct BatchTally {
    static constexpr std::size_t kMostNamed = 100;
    std::size_t drawn = 0, unchanged = 0, byOthers = 0, wouldBeDrawn = 0, failed = 0;
    std::vector<RowResult> failures; // at most kMostNamed
    void add(const RowResult& result);
    std::size_t all() const { return drawn + unchanged + byOthers + wouldBeDrawn + failed; }
};

/// What a thread works on.
struct RowAtWork {
    std::string id = {};
    std::shared_ptr<Progress> progress = {};
};
/// Does one row. Sets what it works on, for others to see, by tell().
using DoRow = std::function<void(std::size_t row, const std::function<void(RowAtWork)>& tell)>;

/// Does the rows in their order, on so many threads. Shows their progress; `total` rows are all, `done()` of
/// them are done. Throws InputError naming --jobs where the system does not let so many run, Interrupted
/// after Ctrl-C, and what a row throws, once all threads have ended.
void doRows(const std::vector<std::size_t>& rows, int threads, std::size_t total,
            const std::function<std::size_t()>& done, const DoRow& doRow, Progress& progress);

} // namespace tessera
