// viewer/cli/batch/run_batch.cpp: see run_batch.h.
#include "viewer/cli/batch/run_batch.h"

#include "core/base/address.h"
#include "core/base/budget_error.h"
#include "core/base/claims.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "viewer/cli/batch/batch_record.h"
#include "viewer/cli/batch/batch_rows.h"
#include "viewer/cli/batch/batch_summary.h"
#include "viewer/cli/batch/done_before.h"
#include "viewer/cli/batch/row_pool.h"
#include "viewer/cli/batch/row_shares.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/input/remote_input.h"
#include "viewer/cli/render/run_render.h"
#include "viewer/tables/csv_table.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <new>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

class Batch {
  public:
    Batch(const BatchArguments& arguments, const BatchRows& rows, const RowShares& shares,
          BatchRecord& record, const CommonOptions& common)
        : arguments_(arguments), rows_(rows), shares_(shares), record_(record), common_(common) {}

    /// Draws all rows. Throws as doRows() does.
    void run() {
        std::vector<std::size_t> all(rows_.size());
        std::iota(all.begin(), all.end(), std::size_t{0});
        pass(all, shares_);
        std::vector<std::size_t> again = std::exchange(tooSmall_, {});
        RowShares alone = shares_;
        alone.ram *= static_cast<std::size_t>(shares_.jobs);
        alone.gpu *= static_cast<std::size_t>(shares_.jobs);
        alone.jobs = 1, alone.threads = 0;
        isLastTry_ = true;
        pass(again, alone);
        for (std::size_t before = 0; !ofOthers_.empty();) { // they may still fail, or be killed
            constexpr std::chrono::milliseconds kBetweenLooks{200};
            if (ofOthers_.size() == before)
                std::this_thread::sleep_for(kBetweenLooks);
            before = ofOthers_.size();
            isTakenAfter_ = true;
            std::vector<std::size_t> open = std::exchange(ofOthers_, {});
            std::ranges::sort(open);
            pass(open, shares_);
        }
    }
    const BatchTally& tally() const { return tally_; }

  private:
    void pass(const std::vector<std::size_t>& rows, const RowShares& shares) {
        if (rows.empty())
            return;
        doRows(
            rows, std::min(shares.jobs, static_cast<int>(std::min<std::size_t>(rows.size(), 1 << 20))),
            rows_.size(),
            [&] {
                const std::lock_guard lock(mutex_);
                return tally_.all();
            },
            [&](std::size_t row, const auto& tell) { doRow(row, shares, tell); }, *common_.progress);
    }

    void doRow(std::size_t number, const RowShares& shares, const std::function<void(RowAtWork)>& tell) {
        const auto start = Clock::now();
        RowResult result{.row = number};
        bool isOverBudget = false;
        CommonOptions mine = common_;
        mine.shared = common_.progress;
        mine.progress = std::make_shared<Progress>(Verbosity::quiet, true);
        mine.kept = std::make_shared<std::vector<std::shared_ptr<void>>>();
        try {
            const BatchRow named = rows_.named(number);
            result.id = named.id;
            result.output = named.output.string();
            mine.prefix = named.id + ": ";
            tell({named.id, mine.progress});
            const std::optional<RowState> state = draw(rows_.row(number), shares, mine);
            if (!state) { // another process has it
                const std::lock_guard lock(mutex_);
                ofOthers_.push_back(number);
                return;
            }
            result.state = *state;
        } catch (const Interrupted&) {
            throw;
        } catch (const OverBudget& error) {
            result.message = error.what();
            isOverBudget = true;
        } catch (const std::bad_alloc&) {
            result.message = "out of memory";
        } catch (const std::exception& error) {
            result.message = error.what();
        }
        if (result.state == RowState::failed) {
            if (isOverBudget && shares.jobs > 1 && !isLastTry_) {
                const std::lock_guard lock(mutex_);
                tooSmall_.push_back(number);
                return;
            }
            mine.problem(result.message);
        }
        result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
        record_.add(result);
        const std::lock_guard lock(mutex_);
        tally_.add(result);
    }

    RenderArguments argumentsOf(const BatchRow& row, const RowShares& shares) const {
        RenderArguments render;
        render.in = row.place;
        render.out = row.output.string();
        render.scene = row.scene;
        render.engine = arguments_.engine;
        render.device = arguments_.device;
        render.verify = arguments_.verify;
        render.noCheck = arguments_.noCheck;
        render.allowDamaged = arguments_.allowDamaged;
        render.layers = arguments_.layers;
        render.threads = shares.threads;
        render.tellsRequest = true;
        render.ram = std::to_string(shares.ram);
        render.gpuMemory = std::to_string(shares.gpu);
        return render;
    }

    /// Nullopt: another process is drawing it.
    std::optional<RowState> draw(const BatchRow& row, const RowShares& shares, const CommonOptions& mine) {
        const RenderArguments render = argumentsOf(row, shares);
        if (arguments_.dryRun)
            return look(row, render, shares, mine);
        const fs::path folder = row.output.has_parent_path() ? row.output.parent_path() : fs::path(".");
        std::error_code failed;
        fs::create_directories(folder, failed);
        if (failed)
            throw Error(printable(folder.string()) + ": cannot be made: " + failed.message());
        std::unique_ptr<Claim> claim;
        if (arguments_.claim) {
            claim = Claims(folder).claim(row.output.filename().string());
            if (!claim) {
                const OutputFile canBeMade(row.output); // throws where no lock file can be, either
                return std::nullopt;
            }
        }
        if ((!arguments_.again || isTakenAfter_) && isDone(row, render, DoneCheck::imports, shares, mine))
            return isTakenAfter_ ? RowState::byOthers : RowState::unchanged;
        runRender(render, mine);
        return RowState::drawn;
    }

    static bool isDone(const BatchRow& row, const RenderArguments& render, DoneCheck check,
                       const RowShares& shares, const CommonOptions& mine) {
        MemoryBudget ram("RAM", "--ram", shares.ram);
        return isDoneBefore(row.output, render, check, ram, mine);
    }

    /// Of --dry-run: checks what can be checked without importing and drawing.
    RowState look(const BatchRow& row, const RenderArguments& render, const RowShares& shares,
                  const CommonOptions& mine) {
        Scene scene = row.scene;
        applyArguments(render, scene, mine);
        const auto require = [&](const fs::path& path, const char* what) {
            std::error_code ignored;
            if (!path.empty() && path != Labels::kTotalSegmentator && !isAddress(path) &&
                !fs::exists(path, ignored))
                throw badFile(path.string(), what, "nothing there");
        };
        for (const SceneVolume& volume : scene.volumes) {
            require(volume.path, "a store or source files");
            require(volume.labels.path, "labels");
            require(volume.labels.names, "names of labels");
        }
        for (const SceneMesh& mesh : scene.meshes)
            require(mesh.path, "a mesh");
        if (const auto& sky = scene.lighting.environment)
            require(sky->file.path, "an environment");
        const RowState state = !arguments_.again && isDone(row, render, DoneCheck::asItIs, shares, mine)
                                   ? RowState::unchanged
                                   : RowState::wouldBeDrawn;
        const std::lock_guard lock(mutex_);
        if (!arguments_.json)
            std::printf("row %zu, %s: %s %s\n", row.number + 1, printable(row.id).c_str(),
                        printable(row.output.string()).c_str(), nameOf(state));
        return state;
    }

    const BatchArguments& arguments_;
    const BatchRows& rows_;
    const RowShares shares_;
    BatchRecord& record_;
    const CommonOptions& common_;
    std::mutex mutex_; // of all below
    BatchTally tally_;
    std::vector<std::size_t> tooSmall_, ofOthers_;  // rows: for a share of the budget; that others draw
    bool isLastTry_ = false, isTakenAfter_ = false; // between passes: alone; after others had them
};

/// The file that --report leads to. Throws InputError for the table, and for the scene.
fs::path checkedReport(const BatchArguments& arguments) {
    if (arguments.report.empty())
        return {};
    BatchRecord::check(arguments.report);
    const fs::path target = outputTarget(arguments.report);
    for (const auto& [path, what] :
         {std::pair{&arguments.table, "the table"}, {&arguments.scene, "--scene"}}) {
        std::error_code ignored;
        if (!path->empty() && !isAddress(*path) && fs::equivalent(target, *path, ignored))
            throw badFile("--report", "a file of its own",
                          printable(arguments.report) + ", which is " + what);
    }
    return fs::absolute(target).lexically_normal();
}

} // namespace

void runBatch(const BatchArguments& arguments, const CommonOptions& common) {
    const auto start = Clock::now();
    const std::size_t gpuBytes = budgetBytes(arguments.gpuMemory, "--gpu-memory", common);
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const Scene scene = styleOf(arguments.scene);
    const CsvTable table(arguments.table, ram);
    if (const std::size_t empty = table.emptyRows(); empty > 0)
        common.note(arguments.table + ": " + std::to_string(empty) +
                    (empty == 1 ? " row of empty cells counts" : " rows of empty cells count") +
                    " for nothing");
    const BatchRows rows(table, scene, arguments.out);
    common.progress->stage("checking the rows of " + arguments.table);
    const fs::path report = checkedReport(arguments);
    rows.requireDistinctOutputs(report, ram);
    const RowShares shares = sharesOf(arguments, rows, scene, ram.freeBytes(), gpuBytes, common);
    BatchRecord record(arguments.dryRun ? fs::path() : fs::path(arguments.report));
    common.progress->stage((arguments.dryRun ? "checking " : "drawing ") + std::to_string(rows.size()) +
                           (rows.size() == 1 ? " picture" : " pictures"));
    Batch batch(arguments, rows, shares, record, common);
    const auto summarise = [&] {
        common.progress->end();
        printSummary(arguments, rows.size(), batch.tally(), secondsSince(start));
        finishStandardOutput();
    };
    try {
        batch.run();
    } catch (...) {
        summarise();
        throw;
    }
    summarise();
    if (batch.tally().failed > 0)
        throw Error(arguments.table + ": " + std::to_string(batch.tally().failed) + " of " +
                    std::to_string(rows.size()) + " rows failed");
}

} // namespace tessera
