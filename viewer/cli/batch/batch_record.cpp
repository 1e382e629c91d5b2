// viewer/cli/batch/batch_record.cpp: see batch_record.h.
#include "viewer/cli/batch/batch_record.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "viewer/tables/csv_table.h" // csvLine

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <system_error>
#include <unistd.h>

namespace tessera {

const char* nameOf(RowState state) {
    switch (state) {
    case RowState::drawn:
        return "drawn";
    case RowState::unchanged:
        return "unchanged";
    case RowState::byOthers:
        return "by another process";
    case RowState::wouldBeDrawn:
        return "would be drawn";
    case RowState::failed:
        break;
    }
    return "failed";
}

void BatchRecord::check(const std::filesystem::path& path) {
    for (const std::filesystem::path& named : {path, outputTarget(path)}) {
        const std::string ending = named.extension().string();
        if (ending != ".csv" && ending != ".json" && ending != ".jsonl" && ending != ".ndjson")
            throw badFile("--report", "a file .csv, .json, .jsonl or .ndjson", "\"" + named.string() + "\"");
    }
}

BatchRecord::BatchRecord(const std::filesystem::path& path) : path_(path) {
    if (path.empty())
        return;
    check(path);
    json_ = path.extension() != ".csv";
    const std::filesystem::path folder = outputTarget(path).parent_path();
    std::error_code failed;
    if (!folder.empty())
        std::filesystem::create_directories(folder, failed);
    if (failed)
        throw Error(printable(folder.string()) + ": cannot be made: " + failed.message());
    checkOutputFile(path);
    constexpr int kEveryone = 0666; // less the mask
    file_ = FileHandle(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, kEveryone));
    if (file_.descriptor() < 0)
        throw Error(printable(path.string()) + ": cannot be written: " + std::strerror(errno));
    if (!json_)
        write("row,id,output,state,seconds,message\n");
}

void BatchRecord::write(const std::string& line) {
    std::size_t done = 0;
    while (done < line.size()) {
        const ssize_t written = ::write(file_.descriptor(), line.data() + done, line.size() - done);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            throw Error(printable(path_.string()) + ": cannot be written: " + std::strerror(errno));
        done += static_cast<std::size_t>(written);
    }
}

void BatchRecord::add(const RowResult& result) {
    if (path_.empty())
        return;
    const std::string number = std::to_string(result.row + 1), seconds = numberText(result.seconds, 3);
    std::string line;
    if (json_) {
        nlohmann::json row = {{"row", result.row + 1},
                              {"id", result.id},
                              {"output", result.output},
                              {"state", nameOf(result.state)},
                              {"seconds", result.seconds}};
        if (!result.message.empty())
            row["message"] = result.message;
        line = row.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
    } else {
        line = csvLine({number, result.id, result.output, nameOf(result.state), seconds, result.message});
    }
    const std::lock_guard lock(mutex_);
    write(line);
}

} // namespace tessera
