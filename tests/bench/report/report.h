// tests/bench/report/report.h: the results of an experiment: numbers as tables, pictures, plots, and
// sentences about them. Experiments compute and fill these; page.h writes them. So an experiment can be
// tested without a disk.
#pragma once

#include "core/image/image.h"

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera::bench {

/// A word, or a number as it was computed; rounded only where it is shown.
using Cell = std::variant<std::string, double>;

struct Table {
    std::string name; // of its CSV file
    std::string caption;
    std::vector<std::string> columns;
    std::vector<std::vector<Cell>> rows; // each as long as columns
    bool onPage = true;                  // false: CSV only
};

/// Pictures in a grid. A picture's image is linear light; on the page it lies on the scene's background.
struct Panel {
    std::string name; // of its PNG file; nothing: an empty place
    Image image;
};
struct Figure {
    std::string caption;
    std::vector<std::string> columns;
    std::vector<std::pair<std::string, std::vector<Panel>>> rows; // a heading and its pictures
};

/// Curves; drawn where a plotting program is at hand, in a table's CSV in any case.
struct Plot {
    std::string name; // of its picture
    std::string caption, xLabel, yLabel;
    bool logX = false, logY = false;
    /// Points and crosses: no line between them. A guide is there to be compared with: a thin grey line
    /// without points.
    enum class Style { line, dashed, points, crosses, guide };
    struct Curve {
        std::string label;
        std::vector<std::pair<double, double>> points;
        Style style = Style::line;
        int colour = -1; // of a small palette; negative: by the curve's place
    };
    std::vector<Curve> curves;
    bool png = false; // also as PNG, beside the SVG
};

struct Report {
    std::string name;  // what --only calls it, and the start of its files' names
    std::string title; // of its section
    std::vector<std::string> text;
    std::vector<Table> tables;
    std::vector<Figure> figures;
    std::vector<Plot> plots;
    std::vector<std::string> after; // conclusions, below all the rest
};

/// At most four significant digits, no exponent for whole numbers: as tables show it.
std::string formatCell(const Cell& cell);

} // namespace tessera::bench
