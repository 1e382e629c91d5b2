// tests/bench/report/page.cpp: see page.h.
#include "tests/bench/report/page.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#if TESSERA_WITH_IMAGE_FILES
#include "core/base/files.h"
#include "core/image/image_file.h"
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <thread>

namespace tessera::bench {
namespace {

namespace fs = std::filesystem;

std::string markOf(const std::string& name) {
    return "<!-- section: " + name + " -->\n";
}

std::string readText(const fs::path& path) {
    refusePipeOrDevice(path);
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

std::string full(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", number);
    return text;
}

std::string csvField(const Cell& cell) {
    if (const auto* number = std::get_if<double>(&cell))
        return full(*number);
    const auto& word = std::get<std::string>(cell);
    if (word.find_first_of(",\"\n") == std::string::npos)
        return word;
    std::string quoted = "\"";
    for (const char c : word)
        quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

std::string gnuplotText(const std::string& word) {
    std::string out = "\"";
    for (const char c : word)
        out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return out + "\"";
}

/// Colours that stay apart in print and for most eyes (Okabe and Ito 2008, black for yellow).
constexpr std::array<const char*, 8> kPalette = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                 "#E69F00", "#56B4E9", "#000000", "#999933"};

std::string styleText(const Plot::Curve& curve, std::size_t place) {
    if (curve.style == Plot::Style::guide)
        return " with lines dashtype 3 linewidth 1.5 linecolor rgb \"#666666\" notitle";
    const std::size_t colour = curve.colour < 0 ? place : static_cast<std::size_t>(curve.colour);
    const std::string look = std::string(" linecolor rgb \"") + kPalette[colour % kPalette.size()] +
                             "\" title " + gnuplotText(curve.label);
    if (curve.style == Plot::Style::points || curve.style == Plot::Style::crosses)
        return std::string(" with points pointsize 0.8 pointtype ") +
               (curve.style == Plot::Style::points ? "7" : "2") + look;
    const bool dashed = curve.style == Plot::Style::dashed;
    return std::string(" with linespoints pointsize 0.6 linewidth 1.5 pointtype ") + (dashed ? "6" : "7") +
           " dashtype " + (dashed ? "2" : "1") + look;
}

/// "[0.5:20]" around all of the points of one coordinate, with some air; nothing where gnuplot does well by
/// itself.
template <typename Coordinate> std::string rangeText(const Plot& plot, const Coordinate& coordinate) {
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (const Plot::Curve& curve : plot.curves)
        for (const auto& point : curve.points) {
            low = std::min(low, coordinate(point));
            high = std::max(high, coordinate(point));
        }
    if (!(low > 0 && low <= high))
        return "[*:*]";
    const double air = std::pow(high / low, 0.04) * 1.02;
    return "[" + full(low / air) + ":" + full(high * air) + "]";
}

/// Places to name on a logarithmic axis that spans too few decades to do with powers of ten; empty: enough.
std::string ticsText(const Plot& plot) {
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (const Plot::Curve& curve : plot.curves)
        for (const auto& [x, y] : curve.points) {
            low = std::min(low, x);
            high = std::max(high, x);
        }
    if (!(low > 0 && high < 100 * low))
        return "";
    std::string list;
    for (double power = std::pow(10, std::floor(std::log10(low)) - 1); power <= 10 * high; power *= 10)
        for (const double digit : {1, 2, 5})
            list += (list.empty() ? "" : ",") + full(digit * power);
    return "set xtics (" + list + ")\n";
}

/// All values of the vertical axis can be read without exponents.
bool fewDigits(const Plot& plot) {
    for (const Plot::Curve& curve : plot.curves)
        for (const auto& point : curve.points)
            if (point.second < 0.001 || point.second > 9999)
                return false;
    return true;
}

/// The plot as commands for gnuplot, its data included.
std::string gnuplotScript(const Plot& plot, const fs::path& svg, const fs::path& png) {
    std::ostringstream text;
    text << "set key outside right reverse Left\nset grid\n"
         << "set xlabel " << gnuplotText(plot.xLabel) << "\nset ylabel " << gnuplotText(plot.yLabel) << "\n";
    if (plot.logX)
        text << "set logscale x\nset format x \"%g\"\nset xrange "
             << rangeText(plot, [](const auto& p) { return p.first; }) << "\n"
             << ticsText(plot);
    if (plot.logY)
        text << "set logscale y\nset format y \"" << (fewDigits(plot) ? "%g" : "%.0e") << "\"\nset yrange "
             << rangeText(plot, [](const auto& p) { return p.second; }) << "\n";
    for (std::size_t i = 0; i < plot.curves.size(); ++i) {
        const Plot::Curve& curve = plot.curves[i];
        text << "$curve" << i << " << EOD\n";
        for (const auto& [x, y] : curve.points)
            text << full(x) << " " << full(y) << "\n";
        text << "EOD\n";
        if (curve.style == Plot::Style::guide && !curve.points.empty()) // named where it is, not in the key
            text << "set label " << gnuplotText(curve.label) << " at " << full(curve.points.back().first)
                 << "," << full(curve.points.back().second)
                 << (curve.points.back().first < curve.points.front().first ? " left offset 0.5,-0.6"
                                                                            : " right offset -0.5,0.6")
                 << " textcolor rgb \"#666666\"\n";
    }
    const auto draw = [&](const std::string& terminal, const fs::path& out) {
        text << "set terminal " << terminal << "\nset output " << gnuplotText(out.string()) << "\nplot ";
        for (std::size_t i = 0; i < plot.curves.size(); ++i)
            text << (i ? ", " : "") << "$curve" << i << styleText(plot.curves[i], i);
        text << "\nset output\n";
    };
    draw("svg size 860,440 noenhanced background rgb \"white\" font \"sans,12\"", svg);
    if (plot.png)
        draw("pngcairo size 1290,660 noenhanced background rgb \"white\" font \"sans,13\" fontscale 1.1 "
             "linewidth 1.5",
             png);
    return text.str();
}

bool gnuplotIsHere() {
    return std::system("command -v gnuplot > /dev/null 2>&1") == 0;
}

/// It does not always tell that a write failed.
void finishPlot(OutputFile& file, const fs::path& out, const char* last) {
    if (readText(file.path()).find(last) == std::string::npos)
        throw Error(out.string() + ": cannot be written: gnuplot ended in the middle");
    file.finish();
}

/// True when the plot was drawn.
bool drawPlot(const Plot& plot, const fs::path& out) {
    if (!gnuplotIsHere())
        return false;
    OutputFile svg(out);
    const fs::path pngOut = fs::path(out).replace_extension(".png");
    std::optional<OutputFile> png;
    if (plot.png)
        png.emplace(pngOut);
    std::FILE* const gnuplot = ::popen("gnuplot > /dev/null 2>&1", "w");
    if (!gnuplot)
        return false;
    const std::string script = gnuplotScript(plot, svg.path(), png ? png->path() : fs::path());
    const bool written = std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
    if (::pclose(gnuplot) != 0 || !written)
        return false;
    finishPlot(svg, out, "</svg>");
    if (png)
        finishPlot(*png, pngOut, "IEND");
    return true;
}

#if TESSERA_WITH_IMAGE_FILES
void writePanel(const fs::path& path, const Image& image) {
    writeImage(path, overBackground(image, glm::vec3(0)), "");
}
#else
void writePanel(const fs::path&, const Image&) {}
#endif

} // namespace

std::string formatCell(const Cell& cell) {
    const auto* number = std::get_if<double>(&cell);
    if (!number)
        return std::get<std::string>(cell);
    char text[64];
    if (std::abs(*number) < 1e15 && (std::abs(*number) >= 1000 || *number == std::floor(*number)))
        std::snprintf(text, sizeof text, "%.0f", *number);
    else
        std::snprintf(text, sizeof text, "%.3g", *number);
    return text;
}

std::string describeMachine(const std::string& device) {
    std::ifstream file("/proc/cpuinfo");
    std::string line, processor = "unknown processor";
    while (std::getline(file, line))
        if (line.rfind("model name", 0) == 0) {
            processor = line.substr(std::min(line.size(), line.find(':') + 2));
            break;
        }
    return processor + ", " + std::to_string(std::thread::hardware_concurrency()) + " processors; " + device;
}

double loadAverage() {
    double load = -1;
    return ::getloadavg(&load, 1) == 1 ? load : -1;
}

std::string csvText(const Table& table) {
    std::string text;
    const auto line = [&text](const auto& cells) {
        for (std::size_t i = 0; i < cells.size(); ++i)
            text += (i ? "," : "") + csvField(cells[i]);
        text += "\n";
    };
    line(table.columns);
    for (const auto& row : table.rows) {
        TESSERA_CHECK(row.size() == table.columns.size());
        line(row);
    }
    return text;
}

std::string markdownText(const Table& table) {
    std::string text = "|", rule = "|";
    for (const std::string& column : table.columns) {
        text += " " + column + " |";
        rule += "---|";
    }
    text += "\n" + rule + "\n";
    for (const auto& row : table.rows) {
        text += "|";
        for (const Cell& cell : row)
            text += " " + formatCell(cell) + " |";
        text += "\n";
    }
    return text;
}

std::string sectionText(const Report& report, const MadeBy& madeBy, const std::string& files,
                        const std::vector<std::string>& plotted) {
    std::string text = markOf(report.name) + "## " + report.title + "\n\n";
    for (const std::string& paragraph : report.text)
        text += paragraph + "\n\n";
    for (const Table& table : report.tables) {
        const std::string csv = "[" + table.name + ".csv](" + files + "/" + table.name + ".csv)";
        text += (table.caption.empty() ? "" : table.caption + " ") + "(" + csv + ")\n\n";
        if (table.onPage)
            text += markdownText(table) + "\n";
    }
    for (const Figure& figure : report.figures) {
        text += figure.caption + "\n\n| |";
        std::string rule = "|---|";
        for (const std::string& column : figure.columns) {
            text += " " + column + " |";
            rule += "---|";
        }
        text += "\n" + rule + "\n";
        for (const auto& [heading, panels] : figure.rows) {
            text += "| " + heading + " |";
            for (const Panel& panel : panels)
                text += panel.name.empty() ? " |" : " ![](" + files + "/" + panel.name + ".png) |";
            text += "\n";
        }
        text += "\n";
    }
    for (const Plot& plot : report.plots)
        if (std::find(plotted.begin(), plotted.end(), plot.name) != plotted.end())
            text += plot.caption + "\n\n![](" + files + "/" + plot.name + ".svg)\n\n";
    for (const std::string& paragraph : report.after)
        text += paragraph + "\n\n";
    text += "Made by `" + madeBy.command + "`, Tessera " + madeBy.version + ", on " + madeBy.machine + ".\n";
    return text;
}

std::string mergedPage(const std::string& page, const std::string& heading, const std::string& name,
                       const std::string& section, const std::vector<std::string>& order) {
    std::map<std::string, std::string> sections;
    for (const std::string& known : order) {
        const std::size_t start = page.find(markOf(known));
        if (start != std::string::npos)
            sections[known] = page.substr(start, page.find("<!-- section: ", start + 1) - start);
    }
    sections[name] = section;
    std::string merged = heading;
    for (const std::string& known : order) {
        const auto found = sections.find(known);
        if (found == sections.end())
            continue;
        while (!found->second.empty() && found->second.back() == '\n')
            found->second.pop_back();
        merged += "\n" + found->second + "\n";
    }
    return merged;
}

std::string withoutFigures(std::size_t figures) {
    if (figures == 0)
        return "";
    return std::to_string(figures) + (figures == 1 ? " figure was" : " figures were") +
           " not drawn, because " +
           (gnuplotIsHere() ? "gnuplot failed" : "gnuplot is not installed (Debian: gnuplot-nox)") +
           "; what would be in them is in the CSV files";
}

std::size_t writeReport(const Report& report, const MadeBy& madeBy, const PagePlace& place) {
    const fs::path files = place.folder / place.name;
    std::error_code error;
    fs::create_directories(files, error);
    if (error)
        throw Error(files.string() + ": cannot be made: " + error.message());
    for (const Table& table : report.tables)
        writeOutputFile(files / (table.name + ".csv"), csvText(table));
    for (const Figure& figure : report.figures)
        for (const auto& row : figure.rows)
            for (const Panel& panel : row.second)
                if (!panel.name.empty())
                    writePanel(files / (panel.name + ".png"), panel.image);
    std::vector<std::string> plotted;
    for (const Plot& plot : report.plots)
        if (drawPlot(plot, files / (plot.name + ".svg")))
            plotted.push_back(plot.name);
#if !TESSERA_WITH_IMAGE_FILES
    Report shown = report; // no pictures can be written
    shown.figures.clear();
#else
    const Report& shown = report;
#endif
    const fs::path page = place.folder / (place.name + ".md");
    writeOutputFile(page, mergedPage(readText(page), place.heading, report.name,
                                     sectionText(shown, madeBy, place.name, plotted), place.order));
    return report.plots.size() - plotted.size();
}

} // namespace tessera::bench
