// tests/bench/report/page.h: writes reports: CSV files, PNG pictures, plots where gnuplot is installed,
// and one Markdown page. Sections of a page that is already there and was not made again are kept.
#pragma once

#include "tests/bench/report/report.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera::bench {

/// How a section was made; no path in it, because folders carry names.
struct MadeBy {
    std::string command; // as typed, folders left out
    std::string machine; // processor, cores, device, load
    std::string version;
};

/// The machine that this runs on: processor, number of cores; device as the caller knows it.
std::string describeMachine(const std::string& device);
/// Load average of the last minute; -1 where it is not told.
double loadAverage();

std::string csvText(const Table& table);
std::string markdownText(const Table& table);
/// A section with its marks; pictures are named relative to the page, in folder `files`.
/// @param plotted  names of the plots that were drawn
std::string sectionText(const Report& report, const MadeBy& madeBy, const std::string& files,
                        const std::vector<std::string>& plotted);
/// The page with its section of that name put in place of the old one, or appended before the page's end.
/// @param order  names of all sections in the order of the page
std::string mergedPage(const std::string& page, const std::string& heading, const std::string& name,
                       const std::string& section, const std::vector<std::string>& order);

/// Where a page and its files go.
struct PagePlace {
    std::filesystem::path folder; // FOLDER/NAME.md and FOLDER/NAME/...
    std::string name, heading;
    std::vector<std::string> order;
};
/// Writes one report into the page. Throws Error naming the file that cannot be written.
/// @return  its plots that could not be drawn
std::size_t writeReport(const Report& report, const MadeBy& madeBy, const PagePlace& place);
/// Says so, and why; empty where there are none.
std::string withoutFigures(std::size_t figures);

} // namespace tessera::bench
