// viewer/cli/batch/batch_summary.cpp: see batch_summary.h.
#include "viewer/cli/batch/batch_summary.h"

#include "core/base/shown_text.h"
#include "viewer/cli/render/picture_files.h" // printReport

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera {

void printSummary(const BatchArguments& arguments, std::size_t rows, const BatchTally& tally,
                  double seconds) {
    if (arguments.json) {
        nlohmann::json failures = nlohmann::json::array();
        for (const RowResult& one : tally.failures)
            failures.push_back({{"row", one.row + 1}, {"id", one.id}, {"message", one.message}});
        printReport({{"rows", rows},
                     {"drawn", tally.drawn},
                     {"unchanged", tally.unchanged},
                     {"byOthers", tally.byOthers},
                     {"wouldBeDrawn", tally.wouldBeDrawn},
                     {"failed", tally.failed},
                     {"failures", failures},
                     {"seconds", seconds}});
        return;
    }
    const auto part = [](std::size_t count, const char* what) {
        return count > 0 ? ", " + std::to_string(count) + " " + what : std::string();
    };
    const std::string counts =
        arguments.dryRun
            ? std::to_string(tally.wouldBeDrawn) + " would be drawn" + part(tally.unchanged, "unchanged")
            : std::to_string(tally.drawn) + " drawn" +
                  part(tally.unchanged, "unchanged and left as they are") +
                  part(tally.byOthers, "drawn by other processes");
    std::printf("%zu rows: %s%s%s\n", rows, counts.c_str(), part(tally.failed, "failed").c_str(),
                part(rows - tally.all(), "not reached").c_str());
    for (const RowResult& one : tally.failures)
        std::printf("  row %zu, %s: %s\n", one.row + 1,
                    one.id.empty() ? "(no id)" : printable(one.id).c_str(), printable(one.message).c_str());
    if (tally.failed > tally.failures.size())
        std::printf("  and %zu more, which --report lists\n", tally.failed - tally.failures.size());
}

} // namespace tessera
