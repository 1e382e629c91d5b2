// tests/viewer/batch/tables_test.cpp: tables of a batch as any program may write them, and patterns with
// places for their cells.
#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "viewer/cli/batch/text_pattern.h"
#include "viewer/tables/csv_table.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

namespace tessera {
namespace {

using ::testing::HasSubstr;

/// Random cells and their forms in a file.
struct Writer {
    explicit Writer(unsigned seed) : random(seed) {}
    std::size_t below(std::size_t most) { return static_cast<std::size_t>(random() % most); }
    std::string cell() {
        static const std::string pieces[] = {"a",  "b",    ",", ";",        "\t", "\"",
                                             "\n", "\r\n", " ", "\xc3\xa4", "7"};
        std::string text;
        for (std::size_t k = below(6); k > 0; --k)
            text += pieces[below(11)];
        return text;
    }
    /// Quoted where it must be, and now and then where it need not.
    std::string form(const std::string& cell) {
        if (cell.find_first_of(",;\t\"\r\n") == std::string::npos && below(4) > 0) {
            const bool isWhole = cell.empty() || (cell.front() != ' ' && cell.back() != ' ');
            if (isWhole) // blanks around it count for nothing
                return std::string(below(3) / 2, ' ') + cell + std::string(below(3) / 2, ' ');
        }
        std::string quoted = "\"";
        for (const char c : cell)
            quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
        return quoted + "\"";
    }
    std::mt19937 random;
};

/// Lines of a text that end with any of the ends that a file may have.
std::uint64_t linesOf(const std::string& text) {
    std::uint64_t lines = 0;
    for (std::size_t n = 0; n < text.size(); ++n)
        lines +=
            text[n] == '\n' || (text[n] == '\r' && (n + 1 == text.size() || text[n + 1] != '\n')) ? 1 : 0;
    return lines;
}

TEST(Tables, AreReadAsAnyProgramWritesThem) {
    const ScratchFolder folder;
    const std::filesystem::path path = folder.path() / "t.csv";
    Writer writer(1);
    for (int n = 0; n < 400; ++n) {
        const std::string separator(1, ",;\t"[n % 3]), end = n % 5 == 0 ? "\r\n" : n % 5 == 1 ? "\r" : "\n";
        std::vector<std::string> names;
        std::vector<std::vector<std::string>> rows(writer.below(6));
        std::vector<std::uint64_t> lines;
        std::size_t emptyRows = 0;
        for (std::size_t column = 0; column <= writer.below(5); ++column)
            names.push_back("n" + std::to_string(column) + (column > 0 && n % 7 == 0 ? " \"x\"" : ""));
        std::string text = n % 4 == 0 ? "\xef\xbb\xbf" : "";
        const auto write = [&](const std::vector<std::string>& cells, bool last) {
            for (std::size_t k = 0; k < cells.size(); ++k)
                text += (k > 0 ? separator : "") + writer.form(cells[k]);
            text += last && writer.below(2) == 0 ? "" : end;
        };
        write(names, rows.empty());
        for (std::size_t row = 0; row < rows.size(); ++row) {
            for (std::size_t blank = writer.below(3); blank > 1; --blank)
                text += end;
            const bool isSeparated = names.size() > 1 || separator == ","; // else it is not known
            for (std::size_t blank = isSeparated ? writer.below(4) : 0; blank > 2; --blank, ++emptyRows) {
                static const std::string forms[] = {"", " ", "\"\""};
                text += forms[writer.below(3)];
                for (std::size_t cells = 1 + writer.below(5); cells > 0; --cells)
                    text += separator + forms[writer.below(3)];
                text += end;
            }
            for (std::size_t k = 0; k < names.size(); ++k)
                rows[row].push_back(writer.cell());
            if (std::ranges::all_of(rows[row], &std::string::empty))
                rows[row].back() = "x"; // an empty row counts for nothing
            lines.push_back(1 + linesOf(text));
            write(rows[row], row + 1 == rows.size());
        }
        std::ofstream(path, std::ios::binary) << text;
        MemoryBudget ram("RAM", "--ram", std::size_t{1} << 20);
        const CsvTable table(path, ram);
        SCOPED_TRACE(text);
        EXPECT_GE(ram.usedBytes(), text.size());
        EXPECT_EQ(table.names(), names);
        ASSERT_EQ(table.rows(), rows.size());
        EXPECT_EQ(table.emptyRows(), emptyRows);
        for (std::size_t row = 0; row < rows.size(); ++row) {
            EXPECT_EQ(table.cells(row), rows[row]);
            EXPECT_EQ(table.placeOf(row), path.string() + ":" + std::to_string(lines[row]));
        }
    }
}

// What is written is read again.
TEST(Tables, LinesAreReadAsTheyAreWritten) {
    const ScratchFolder folder;
    const std::filesystem::path path = folder.path() / "t.csv";
    Writer writer(2);
    for (int n = 0; n < 100; ++n) {
        const std::vector<std::string> cells = {writer.cell(), writer.cell(), writer.cell()};
        std::ofstream(path, std::ios::binary) << csvLine({"a", "b", "c"}) << csvLine(cells);
        MemoryBudget ram("RAM", "--ram", std::size_t{1} << 20);
        EXPECT_EQ(CsvTable(path, ram).cells(0), cells);
    }
    EXPECT_EQ(csvLine({"a", "", "b c"}), "a,,b c\n") << "no quotes without need";
}

/// What a file is refused with; "" where it is read.
std::string refusal(const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 24);
    try {
        const CsvTable table(path, ram);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

// Every sequence of two to four bytes is UTF-8 or not as the standard's table (Unicode 3.9, 3-7) has it.
TEST(Tables, AreOfWholeCharacters) {
    const ScratchFolder folder;
    const std::filesystem::path path = folder.path() / "t.csv";
    const unsigned char edges[] = {0x7f, 0x80, 0x8f, 0x90, 0x9f, 0xa0, 0xbf, 0xc0};
    const auto isRest = [](unsigned char c) { return c >= 0x80 && c <= 0xbf; };
    for (const int lead : {0x80, 0xbf, 0xc0, 0xc1, 0xc2, 0xdf, 0xe0, 0xe1, 0xec, 0xed, 0xee, 0xef, 0xf0, 0xf1,
                           0xf3, 0xf4, 0xf5, 0xff})
        for (const unsigned char second : edges) {
            const int more = lead >= 0xc2 && lead <= 0xdf   ? 1
                             : lead >= 0xe0 && lead <= 0xef ? 2
                             : lead >= 0xf0 && lead <= 0xf4 ? 3
                                                            : 0;
            const bool isSecond = lead == 0xe0   ? second >= 0xa0 && second <= 0xbf
                                  : lead == 0xed ? second >= 0x80 && second <= 0x9f
                                  : lead == 0xf0 ? second >= 0x90 && second <= 0xbf
                                  : lead == 0xf4 ? second >= 0x80 && second <= 0x8f
                                                 : isRest(second);
            for (int rest = 0; rest <= 2; ++rest) {
                std::string text = "id\n";
                text += static_cast<char>(lead);
                text += static_cast<char>(second);
                text += std::string(static_cast<std::size_t>(rest), '\x80');
                const std::string found = refusal(path, text);
                if (more > 0 && isSecond && rest == more - 1) {
                    EXPECT_EQ(found, "") << lead << " " << int{second};
                } else {
                    EXPECT_THAT(found, HasSubstr("t.csv:2: expected text in UTF-8")) << lead;
                }
            }
        }
}

TEST(Tables, HaveAsManyColumnsAndBytesAsTheySay) {
    const ScratchFolder folder;
    const std::filesystem::path path = folder.path() / "t.csv";
    std::string names = "c0";
    for (std::size_t n = 1; n < CsvTable::kMostColumns; ++n)
        names += ",c" + std::to_string(n);
    EXPECT_EQ(refusal(path, names + "\n"), "");
    EXPECT_THAT(refusal(path, names + ",more\n"), HasSubstr("256 columns"));
    EXPECT_EQ(refusal(path, "id\n" + std::string(CsvTable::kMostCellBytes, 'x')), "");
    EXPECT_THAT(refusal(path, "id\n\n" + std::string(2 * CsvTable::kMostCellBytes, 'x')),
                HasSubstr("t.csv:3"));
    EXPECT_THAT(refusal(path, "id,a,b,id\n"), HasSubstr("\"id\" twice"));
    EXPECT_THAT(refusal(path, "\n\r\nid,a\"b\n"), HasSubstr("t.csv:3")) << "lines before it count";
    EXPECT_THAT(refusal(path, "a,b,\n"), HasSubstr("none for column 3"));
}

// A pattern is its text, with each place's cell in it.
TEST(TextPatterns, HaveTheCellsInTheirPlaces) {
    const std::vector<std::string> names = {"id", "who", "a b"}, cells = {"7", "", "x{y}"};
    std::mt19937 random(3);
    for (int n = 0; n < 500; ++n) {
        std::string text, expected, begin;
        bool used[3] = {}, any = false;
        for (auto k = random() % 8; k > 0; --k)
            switch (const auto what = random() % 7; what) {
            case 0:
                text += "{{", expected += "{";
                break;
            case 1:
                text += "}}", expected += "}";
                break;
            case 2:
                begin = any ? begin : expected;
                text += "{row}", expected += "42", any = true;
                break;
            case 3:
            case 4:
            case 5:
                begin = any ? begin : expected;
                text += "{" + names[what - 3] + "}", expected += cells[what - 3];
                used[what - 3] = any = true;
                break;
            default:
                text += "ab/", expected += "ab/";
            }
        const TextPattern pattern(text, names, "-o");
        SCOPED_TRACE(text);
        EXPECT_EQ(pattern.fill(cells, 41), expected);
        EXPECT_EQ(pattern.hasPlaces(), any);
        EXPECT_EQ(pattern.begin(), any ? begin : expected);
        for (std::size_t column = 0; column < 3; ++column)
            EXPECT_EQ(pattern.uses(column), used[column]);
    }
    const auto wrong = [&](const std::string& text) {
        try {
            const TextPattern pattern(text, names, "where");
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    EXPECT_THAT(wrong("a}b"), HasSubstr("\"}\" alone"));
    EXPECT_THAT(wrong("a{b"), HasSubstr("\"{\" alone"));
    EXPECT_THAT(wrong("{ib}"), HasSubstr("{ib}; nearest: {id}"));
    EXPECT_THAT(wrong("{rov}"), HasSubstr("nearest: {row}"));
}

// Cells make names, never ways out of the folder.
TEST(TextPatterns, OfFilesStayInTheirFolder) {
    const OutputPattern pattern("some/out/{id}-{who}/x{row}.png", {"id", "who", "note"});
    EXPECT_EQ(pattern.fill({"a", "b c", "/"}, 4, "t.csv:6"), std::filesystem::path("some/out/a-b c/x5.png"));
    EXPECT_TRUE(pattern.uses(0) && pattern.uses(1));
    EXPECT_FALSE(pattern.uses(2));
    for (const std::string bad : {"", ".", "..", ".a", "a/b", "/", "a\nb", "\x1f", "\x7f", "x\x01"})
        for (const std::size_t column : {0U, 1U}) {
            std::vector<std::string> cells = {"a", "b", ""};
            cells[column] = bad;
            EXPECT_THROW((void)pattern.fill(cells, 0, "t.csv:2"), InputError) << bad;
        }
    EXPECT_NO_THROW((void)pattern.fill({"a b~", "\x80", "../.."}, 0, "t.csv:2"));
    const OutputPattern name("{id}.png", {"id"});
    EXPECT_EQ(name.fill({std::string(196, 'x')}, 0, "t.csv:2"), std::string(196, 'x') + ".png");
    EXPECT_THROW((void)name.fill({std::string(197, 'x')}, 0, "t.csv:2"), InputError);
    EXPECT_EQ(OutputPattern("/tmp/a{{/{id}", {"id"}).fill({"b"}, 0, ""), std::filesystem::path("/tmp/a{/b"));
    EXPECT_THROW(OutputPattern("a/{id}/../b", {"id"}), InputError);
    EXPECT_THROW(OutputPattern("a/{id}/..", {"id"}), InputError);
    EXPECT_NO_THROW(OutputPattern("../{id}", {"id"}));
}

} // namespace
} // namespace tessera
