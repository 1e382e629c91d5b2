// viewer/tables/csv_table.cpp: see csv_table.h. libcsv parses; this checks and keeps.
#include "viewer/tables/csv_table.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <csv.h>
#include <fstream>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

constexpr std::string_view kMark = "\xef\xbb\xbf"; // of UTF-8

/// libcsv's parser, freed.
class Parser {
  public:
    explicit Parser(char separator) {
        csv_init(&parser_, CSV_STRICT | CSV_STRICT_FINI);
        csv_set_delim(&parser_, static_cast<unsigned char>(separator));
        csv_set_realloc_func(&parser_, &grow);
    }
    ~Parser() { csv_free(&parser_); }
    Parser(const Parser&) = delete;
    Parser& operator=(const Parser&) = delete;

    /// False where it cannot go on: why() says why.
    bool take(std::string_view text) {
        return csv_parse(&parser_, text.data(), text.size(), &onCell, &onRow, this) == text.size();
    }
    bool finish() { return csv_fini(&parser_, &onCell, &onRow, this) == 0; }
    const char* why() {
        return csv_error(&parser_) == CSV_EPARSE ? "a quote inside a cell, or one that is not closed"
                                                 : "a larger cell";
    }

    std::vector<std::string> cells; // of the row so far
    std::size_t ended = 0;          // rows

  private:
    static void* grow(void* block, std::size_t bytes) {
        constexpr std::size_t kSlack = 4096; // it grows by blocks
        return bytes > CsvTable::kMostCellBytes + kSlack ? nullptr : std::realloc(block, bytes);
    }
    static void onCell(void* text, std::size_t bytes, void* self) {
        static_cast<Parser*>(self)->cells.emplace_back(static_cast<const char*>(text), bytes);
    }
    static void onRow(int, void* self) { ++static_cast<Parser*>(self)->ended; }

    csv_parser parser_{};
};

/// The first byte that is no UTF-8; its size: none.
std::size_t firstBadByte(std::string_view text) {
    const auto byteAt = [&](std::size_t n) { return static_cast<unsigned char>(text[n]); };
    std::size_t n = 0;
    while (n < text.size()) {
        const unsigned char lead = byteAt(n);
        const std::size_t more = lead < 0x80                   ? 0
                                 : lead >= 0xc2 && lead < 0xe0 ? 1
                                 : lead >= 0xe0 && lead < 0xf0 ? 2
                                 : lead >= 0xf0 && lead < 0xf5 ? 3
                                                               : 4;
        if (more == 4 || n + more >= text.size())
            return n;
        for (std::size_t k = 1; k <= more; ++k)
            if ((byteAt(n + k) & 0xc0) != 0x80)
                return n;
        if ((lead == 0xe0 && byteAt(n + 1) < 0xa0) || (lead == 0xed && byteAt(n + 1) > 0x9f) ||
            (lead == 0xf0 && byteAt(n + 1) < 0x90) || (lead == 0xf4 && byteAt(n + 1) > 0x8f))
            return n; // too long, a surrogate, or beyond the last character
        n += more + 1;
    }
    return n;
}

} // namespace

CsvTable::CsvTable(const std::filesystem::path& path, MemoryBudget& ram) : path_(path), ram_(ram) {
    read();
    checkText();
    findRows();
}

void CsvTable::read() {
    refusePipeOrDevice(path_);
    std::error_code failed;
    const std::uintmax_t bytes = std::filesystem::file_size(path_, failed);
    std::ifstream file(path_, std::ios::binary);
    if (failed || !file)
        throw badFile(path_.string(), "a table, .csv", "no file that can be read");
    ofText_ = ram_.charge(bytes, "the table " + printable(path_.string()));
    text_.resize(bytes);
    file.read(text_.data(), static_cast<std::streamsize>(bytes));
    if (static_cast<std::uintmax_t>(file.gcount()) != bytes)
        throw badFile(path_.string(), std::to_string(bytes) + " bytes", "fewer");
    if (text_.starts_with(kMark))
        text_.erase(0, kMark.size());
}

std::string CsvTable::placeOfLine(std::uint64_t line) const {
    return path_.string() + ":" + std::to_string(line);
}

void CsvTable::checkText() const {
    const auto lineAt = [&](std::size_t at) {
        return 1 + static_cast<std::uint64_t>(
                       std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    };
    if (const std::size_t at = text_.find('\0'); at != std::string::npos)
        throw badFile(placeOfLine(lineAt(at)), "text", "a byte of 0");
    if (const std::size_t at = firstBadByte(text_); at < text_.size())
        throw badFile(placeOfLine(lineAt(at)), "text in UTF-8", "other bytes");
}

void CsvTable::findRows() {
    const std::string_view text = text_;
    const std::string_view first = text.substr(0, text.find_first_of("\r\n"));
    if (first.find(',') == std::string_view::npos)
        for (const char other : {';', '\t'})
            if (first.find(other) != std::string_view::npos)
                separator_ = other;
    const auto lines = static_cast<std::size_t>(
        std::count_if(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }));
    ofPlaces_ = ram_.charge((lines + 1) * sizeof(Place), "the rows of " + printable(path_.string()));
    places_.reserve(lines + 1);

    Parser parser(separator_);
    std::uint64_t line = 1, began = 1; // of the row
    std::size_t from = 0;
    const auto end = [&](std::size_t to) {
        if (names_.empty())
            names_ = parser.cells;
        else if (std::ranges::all_of(parser.cells, &std::string::empty))
            ++emptyRows_;
        else if (parser.cells.size() != names_.size())
            throw badFile(placeOfLine(began), std::to_string(names_.size()) + " cells, as there are names",
                          std::to_string(parser.cells.size()));
        else
            places_.push_back({from, to, began});
        parser.cells.clear();
        parser.ended = 0;
    };
    bool between = true; // rows
    for (std::size_t n = 0; n < text.size(); ++n) {
        const bool endsLine = text[n] == '\n' || text[n] == '\r';
        if (between && !endsLine) {
            began = line;
            from = n;
            between = false;
        }
        line += text[n] == '\n' || (endsLine && text.substr(n + 1, 1) != "\n") ? 1 : 0;
        if (between)
            continue;
        if (!parser.take(text.substr(n, 1)))
            throw badFile(placeOfLine(began), "cells by RFC 4180 of at most " + formatBytes(kMostCellBytes),
                          parser.why());
        if (parser.cells.size() > kMostColumns)
            throw badFile(placeOfLine(began), "at most " + std::to_string(kMostColumns) + " columns", "more");
        if (parser.ended > 0) {
            end(n + 1);
            between = true;
        }
    }
    if (!parser.finish())
        throw badFile(placeOfLine(began), "a table that is whole", parser.why());
    if (parser.ended > 0)
        end(text.size());
    if (names_.empty())
        throw badFile(path_.string(), "a row with the names of columns", "no row");
    for (std::size_t n = 0; n < names_.size(); ++n) {
        if (names_[n].empty())
            throw badFile(path_.string(), "a name for each column",
                          "none for column " + std::to_string(n + 1));
        if (std::find(names_.begin(), names_.begin() + static_cast<std::ptrdiff_t>(n), names_[n]) !=
            names_.begin() + static_cast<std::ptrdiff_t>(n))
            throw badFile(path_.string(), "columns of different names",
                          "\"" + names_[n].substr(0, 60) + "\" twice");
    }
}

std::vector<std::string> CsvTable::parse(const Place& place) const {
    Parser parser(separator_);
    parser.take(std::string_view(text_).substr(place.from, place.to - place.from));
    parser.finish();
    TESSERA_CHECK(parser.cells.size() == names_.size());
    return std::move(parser.cells);
}

std::vector<std::string> CsvTable::cells(std::size_t row) const {
    return parse(places_.at(row));
}

std::string CsvTable::placeOf(std::size_t row) const {
    return placeOfLine(places_.at(row).line);
}

std::string csvLine(const std::vector<std::string>& cells) {
    std::string line;
    for (std::size_t n = 0; n < cells.size(); ++n) {
        const std::string& cell = cells[n];
        line += n > 0 ? "," : "";
        const auto isBlank = [](char c) { return c == ' ' || c == '\t'; };
        const bool isAsRead = cell.empty() || !(isBlank(cell.front()) || isBlank(cell.back()));
        if (isAsRead && cell.find_first_of(",\"\r\n") == std::string::npos) {
            line += cell;
            continue;
        }
        std::string quoted(2 * cell.size() + 2, '\0');
        quoted.resize(csv_write(quoted.data(), quoted.size(), cell.data(), cell.size()));
        line += quoted;
    }
    return line + "\n";
}

} // namespace tessera
