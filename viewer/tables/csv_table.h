// viewer/tables/csv_table.h: a table in a CSV file (RFC 4180): a row of names, and rows of as many cells.
#pragma once

#include "core/base/budget.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// The file is held as text, and its rows by their places in it; both are charged. Cells are made on demand.
/// Thread-safe.
class CsvTable {
  public:
    static constexpr std::size_t kMostCellBytes = std::size_t{64} << 10, kMostColumns = 256;

    /// Cells are separated by commas, or by semicolons or tabs where the names have those and no comma. Lines
    /// end as on any system; empty ones and rows of empty cells count for nothing, nor do blanks around a
    /// cell without quotes. Throws InputError naming the file and the line: for no file of text in UTF-8, for
    /// quotes that are not closed or stand inside a cell, for rows with another number of cells than names,
    /// for names that are missing or there twice, for cells of more than kMostCellBytes, and for a budget
    /// without room.
    CsvTable(const std::filesystem::path& path, MemoryBudget& ram);

    const std::filesystem::path& path() const { return path_; }
    const std::vector<std::string>& names() const { return names_; }
    std::size_t rows() const { return places_.size(); }
    /// Rows whose cells are all empty, which count for nothing.
    std::size_t emptyRows() const { return emptyRows_; }
    /// As many cells as names.
    std::vector<std::string> cells(std::size_t row) const;
    /// "table.csv:17", for messages.
    std::string placeOf(std::size_t row) const;

  private:
    struct Place {
        std::uint64_t from, to;
        std::uint64_t line; // in the file, from 1
    };
    void read();
    void checkText() const;
    void findRows();
    std::vector<std::string> parse(const Place& place) const;
    std::string placeOfLine(std::uint64_t line) const;

    std::filesystem::path path_;
    MemoryBudget& ram_;
    Charge ofText_, ofPlaces_;
    std::string text_;
    char separator_ = ',';
    std::vector<std::string> names_;
    std::vector<Place> places_;
    std::size_t emptyRows_ = 0;
};

/// A row of CSV, with its line feed; cells are quoted where they must be.
std::string csvLine(const std::vector<std::string>& cells);

} // namespace tessera
