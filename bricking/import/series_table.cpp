// bricking/import/series_table.cpp: a catalogue as text, for catalogue.h: the table of series, and what
// opening one of them passes over.
#include "bricking/import/catalogue.h"
#include "bricking/import/source/oriented_source.h"

#include <algorithm>
#include <cstdio>

namespace tessera {
namespace {

/// In the order of the source's axes: columns, rows.
std::string cellOfSize(const Catalogue& catalogue, const CatalogueRow& row) {
    glm::ivec2 size(0);
    if (row.series > 0 && !row.isInFile) {
        const DicomSlice& first =
            catalogue.scan.series[static_cast<std::size_t>(row.series - 1)].slices.front();
        size = {first.columns, first.rows};
    } else if (row.info) {
        size = glm::ivec2(alongSourceAxes(*row.info, row.info->extentVoxels));
    }
    return size.x > 0 ? std::to_string(size.x) + " x " + std::to_string(size.y) : "-";
}

/// In the order of the source's axes: columns, rows, slices.
std::string cellOfSpacing(const CatalogueRow& row) {
    if (!row.info)
        return "-";
    const glm::dvec3 ofSource = alongSourceAxes(*row.info, row.info->spacingMm());
    const bool uneven = row.problem.find("--resample-z") != std::string::npos;
    char text[96];
    std::snprintf(text, sizeof text, uneven ? "%.3f x %.3f x uneven" : "%.3f x %.3f x %.3f", ofSource.x,
                  ofSource.y, ofSource.z);
    return text;
}

/// The end of a long path, which is more informative than its beginning.
std::string endOf(const std::string& folder) {
    constexpr std::size_t kMostShown = 40;
    return folder.size() <= kMostShown ? folder : "..." + folder.substr(folder.size() - kMostShown + 3);
}

std::string shortly(const CatalogueRow& row) {
    if (row.series == 0)
        return row.what;
    const std::string modality = row.modality.empty() ? "unknown modality" : row.modality;
    return "series " + std::to_string(row.series) + " (" + modality + ", " + std::to_string(row.slices) +
           (row.slices == 1 ? " slice" : " slices") + (row.rank == CatalogueRank::scout ? ": scout)" : ")");
}

} // namespace

std::string tableOf(const Catalogue& catalogue) {
    const auto& rows = catalogue.rows;
    const auto any = [&](const auto& has) { return std::any_of(rows.begin(), rows.end(), has); };
    const bool numbers = any([](const CatalogueRow& row) { return row.number.has_value(); });
    const bool dates = any([](const CatalogueRow& row) { return !row.date.empty(); });
    const bool folders = any([&](const CatalogueRow& row) {
        return row.rank != CatalogueRank::none && row.folder != rows.front().folder;
    });
    const auto orDash = [](const std::string& text) { return text.empty() ? "-" : text; };
    std::vector<std::vector<std::string>> lines;
    const auto add = [&](const std::string& series, const std::string& number, const std::string& date,
                         const std::string& folder, std::vector<std::string> rest) {
        std::vector<std::string> line = {series};
        if (numbers)
            line.push_back(orDash(number));
        if (dates)
            line.push_back(orDash(date));
        if (folders)
            line.push_back(orDash(folder));
        line.insert(line.end(), rest.begin(), rest.end());
        lines.push_back(std::move(line));
    };
    add("series", "number", "date", "folder", {"modality", "slices", "size", "spacing (mm)", "what"});
    for (const CatalogueRow& row : rows) {
        std::string what = row.what;
        if (!row.problem.empty())
            what += (what.empty() ? "" : "; ") + row.problem;
        add(row.series > 0 ? std::to_string(row.series) : "-", row.number ? std::to_string(*row.number) : "",
            row.date, endOf(row.folder),
            {orDash(row.modality),
             row.files > 0 ? std::to_string(row.files) + (row.files == 1 ? " file" : " files")
                           : std::to_string(row.slices),
             cellOfSize(catalogue, row), cellOfSpacing(row), what});
    }
    std::vector<std::size_t> width(lines.front().size());
    for (const auto& line : lines)
        for (std::size_t i = 0; i < line.size(); ++i)
            width[i] = std::max(width[i], line[i].size());
    std::string text;
    for (const auto& line : lines) {
        text += text.empty() ? "  " : "\n  ";
        for (std::size_t i = 0; i + 1 < line.size(); ++i)
            text += line[i] + std::string(width[i] - line[i].size() + 2, ' ');
        text += line.back();
    }
    return text;
}

std::string passedOverText(const Catalogue& catalogue, const CatalogueRow& row) {
    constexpr int kMostRows = 6;
    std::string text;
    int others = 0;
    for (const CatalogueRow& other : catalogue.rows) {
        if (&other == &row || other.rank == CatalogueRank::none)
            continue;
        if (++others <= kMostRows)
            text += (text.empty() ? "" : ", ") + shortly(other);
    }
    if (others > kMostRows)
        text += ", " + std::to_string(others - kMostRows) + " more volumes or scouts";
    const std::string counted = countPassed(catalogue.scan.passed);
    return text + (text.empty() || counted.empty() ? "" : ", ") + counted;
}

bool passesOverSomething(const Catalogue& catalogue, const CatalogueRow& row) {
    const auto& passed = catalogue.scan.passed;
    return std::any_of(catalogue.rows.begin(), catalogue.rows.end(),
                       [&](const CatalogueRow& other) { return &other != &row; }) ||
           std::any_of(passed.begin(), passed.end(), [](const PassedFile& file) {
               return file.reason != PassedReason::notSlice && file.reason != PassedReason::zarr &&
                      file.reason != PassedReason::emptyFolder;
           });
}

} // namespace tessera
