// viewer/paths/point_table.cpp: see point_table.h.
#include "viewer/paths/point_table.h"

#include "core/base/budget.h"
#include "core/base/decimal.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "viewer/paths/point_line.h"
#include "viewer/tables/csv_table.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {
namespace {

constexpr std::size_t kMostBytes = std::size_t{64} << 20;

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}

struct Columns {
    std::size_t axes[3] = {0, 0, 0};
    bool ras = false;
    std::optional<std::size_t> radius, defined;
};

Columns columnsOf(const CsvTable& table) {
    std::vector<std::string> names;
    for (const std::string& name : table.names())
        names.push_back(lower(name));
    const auto placeOf = [&](std::string_view name) -> std::optional<std::size_t> {
        const auto at = std::find(names.begin(), names.end(), name);
        return at == names.end() ? std::optional<std::size_t>()
                                 : static_cast<std::size_t>(at - names.begin());
    };
    Columns columns;
    columns.radius = placeOf("radius");
    columns.defined = placeOf("defined");
    for (const char* const axes : {"xyz", "lps", "ras"}) {
        std::size_t found = 0;
        for (std::size_t n = 0; n < 3; ++n)
            if (const auto at = placeOf({axes + n, 1})) {
                columns.axes[n] = *at;
                ++found;
            }
        columns.ras = std::string_view(axes) == "ras";
        if (found == 3)
            return columns;
    }
    std::string found;
    for (const std::string& name : table.names())
        found += (found.empty() ? "" : ",") + printable(name.substr(0, 40));
    throw badFile(table.path().string(), "columns x,y,z or l,p,s or r,a,s, and a radius if there is one",
                  found.substr(0, 200));
}

double numberIn(const std::string& cell, const std::string& where, double least) {
    const std::optional<double> number = decimalNumber(cell);
    if (!number || *number < least)
        throw badFile(where, least < 0 ? "a number of mm" : "a number of mm from 0 on",
                      "\"" + printable(cell.substr(0, 40)) + "\"" +
                          (hasDecimalComma(cell) ? "; a decimal comma is not read" : ""));
    return *number;
}

} // namespace

bool isPointTable(const std::filesystem::path& file) {
    const std::string extension = lower(file.extension().string());
    return extension == ".csv" || extension == ".tsv" || extension == ".txt";
}

Path pathOfTable(const std::filesystem::path& file) {
    constexpr double kAny = -std::numeric_limits<double>::max();
    MemoryBudget ram("the table's memory", "", kMostBytes);
    const CsvTable table(file, ram);
    const Columns columns = columnsOf(table);
    if (table.rows() > kMostPlacedPoints)
        throw badFile(file.string(), "at most " + std::to_string(kMostPlacedPoints) + " points",
                      std::to_string(table.rows()));
    PlacedPoints points;
    const double sign = columns.ras ? -1 : 1;
    for (std::size_t row = 0; row < table.rows(); ++row) {
        const std::vector<std::string> cells = table.cells(row);
        if (columns.defined && cells[*columns.defined] == "0")
            continue;
        const std::string where = table.placeOf(row);
        const auto axis = [&](std::size_t n) { return numberIn(cells[columns.axes[n]], where, kAny); };
        points.mm.emplace_back(sign * axis(0), sign * axis(1), axis(2));
        if (columns.radius)
            points.radiusMm.push_back(numberIn(cells[*columns.radius], where, 0));
    }
    Path path;
    path.lines.push_back(lineThrough(points, file.string()));
    return path;
}

} // namespace tessera
