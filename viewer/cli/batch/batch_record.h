// viewer/cli/batch/batch_record.h: the record of a batch: a line for each row, written as it ends.
#pragma once

#include "core/base/files.h"

#include <cstddef>
#include <filesystem>
#include <mutex>
#include <string>

namespace tessera {

enum class RowState { drawn, unchanged, byOthers, wouldBeDrawn, failed };
/// "drawn", "unchanged", "by another process", "would be drawn", "failed"
const char* nameOf(RowState state);

struct RowResult {
    std::size_t row = 0; // from 0
    std::string id = {}, output = {};
    RowState state = RowState::failed;
    double seconds = 0;
    std::string message = {}; // of a failure, without the row's id
};

/// All functions may be called from any thread.
class BatchRecord {
  public:
    /// Throws InputError for a name of another ending, and for a link to one.
    static void check(const std::filesystem::path& path);
    /// A table, or with the ending .json, .jsonl or .ndjson a JSON object a line; "": none. A file of that
    /// name is replaced, and its folder made. Throws as check() does, and InputError naming the path as
    /// checkOutputFile() does.
    explicit BatchRecord(const std::filesystem::path& path);
    /// Throws Error naming the path if the line cannot be written.
    void add(const RowResult& result);

  private:
    void write(const std::string& line);
    std::filesystem::path path_;
    bool json_ = false;
    std::mutex mutex_;
    FileHandle file_;
};

} // namespace tessera
