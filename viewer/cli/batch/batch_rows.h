// viewer/cli/batch/batch_rows.h: the rows of a table as scenes: what columns mean, and which file a row
// becomes.
#pragma once

#include "core/base/progress.h"
#include "core/scene/scene.h"
#include "viewer/cli/batch/text_pattern.h"
#include "viewer/tables/csv_table.h"

#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera {

struct BatchRow {
    std::size_t number = 0; // from 0
    std::string place;      // "table.csv:17"
    std::string id;         // the cell of column "id", or the file's name without its ending
    std::filesystem::path output;
    Scene scene;
};

/// The table outlives it. Thread-safe.
class BatchRows {
  public:
    /// A column is a key of the scene, or an option that sets one, or stands in the pattern or in the scene's
    /// texts, or is called "id". Paths in cells are relative to the table, those of the scene to the
    /// working folder.
    /// Throws InputError for other columns, with the nearest, and as the patterns do.
    BatchRows(const CsvTable& table, const Scene& scene, const std::string& pattern);

    std::size_t size() const { return table_.rows(); }
    /// Throws InputError naming the row and its column for a value that a scene cannot have, and for a name
    /// that leaves the pattern's folder.
    BatchRow row(std::size_t number) const;
    /// The row's id and output alone. Throws likewise.
    BatchRow named(std::size_t number) const;
    /// At least as wide and high as any picture.
    glm::ivec2 largestSize() const;
    /// Names all outputs. Throws as named() does, for two rows with the same output, and for one that leads
    /// to the record.
    /// @param record  absolute; "": none
    /// @param ram  is charged meanwhile
    void requireDistinctOutputs(const std::filesystem::path& record, MemoryBudget& ram) const;

  private:
    struct Column {
        std::string key; // "": stands in texts alone
    };
    struct Text {
        TextPattern pattern;
        std::string key; // of the scene: "annotations.title"
    };
    BatchRow named(std::size_t number, const std::vector<std::string>& cells) const;

    const CsvTable& table_;
    Scene scene_;
    OutputPattern output_;
    std::vector<Column> columns_;
    std::vector<Text> texts_;
};

} // namespace tessera
