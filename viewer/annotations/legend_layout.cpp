// viewer/annotations/legend_layout.cpp: the legends of a part, for part_layout.h: bars of colours by value at
// the lower left, names and colours of labels at the upper left.
#include "core/base/shown_text.h"
#include "viewer/annotations/part_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr double kMostOfNames = 0.6; // of the part's width
constexpr double kApart = 0.5;       // letters, between numbers, so that two are not read as one

LaidArea rectangle(const glm::dvec2& from, const glm::dvec2& to, const glm::vec3& colour) {
    LaidArea area;
    area.corners = {from, {to.x, from.y}, to, {from.x, to.y}};
    area.colour = colour;
    return area;
}

double edgeOf(const PartLayout& in) {
    return std::round(in.edge) + std::max(1.0, std::round(in.stroke / 2));
}

/// A rectangle's line, and an edge around it that sets it off from any picture. Both lie in as much as
/// edgeOf().
void frame(LaidBlock& block, const PartLayout& in, const glm::dvec2& from, const glm::dvec2& to) {
    const double line = std::max(1.0, std::round(in.stroke / 2)), edge = edgeOf(in);
    const glm::vec3 light(1), dark(0);
    const bool isLight = in.ink == Ink::light;
    block.shapes.emplace_back(rectangle(from - edge, to + edge, isLight ? dark : light));
    block.shapes.emplace_back(rectangle(from - line, to + line, isLight ? light : dark));
}

/// Words at the ends and, where there is room, in the middle of a bar. Adds their height to the block.
void writeValues(LaidBlock& block, const PartLayout& in, const LegendBar& bar, double left, double width) {
    std::vector<LaidWords> values;
    std::vector<double> widths;
    for (const double part : {0.0, 0.5, 1.0}) {
        values.push_back(in.line(bar.textAt(part)));
        widths.push_back(PartLayout::boxOf(values.back()).x);
    }
    const bool all = std::max(widths[0], widths[2]) + 0.5 * widths[1] + kApart * in.em <= 0.5 * width;
    for (std::size_t n = 0; n < values.size(); n += all ? 1 : 2) {
        const double part = static_cast<double>(n) / 2, box = PartLayout::boxOf(values[n]).x;
        block.write(values[n], {left + part * (width - box), block.size.y});
    }
    block.size.y += PartLayout::boxOf(values.front()).y;
}

} // namespace

LaidBlock colourLegendBlock(const PartLayout& in, const LegendBar& bar) {
    constexpr double kWidth = 14, kHeight = 0.8, kMostOfWidth = 0.45; // letters; of the part
    const double edge = edgeOf(in);
    double ends = kApart * in.em; // of the values there
    for (const double part : {0.0, 1.0})
        ends += PartLayout::boxOf(in.line(bar.textAt(part))).x;
    const double width = std::ceil(std::max(ends, std::min(kWidth * in.em, kMostOfWidth * in.width())));
    LaidBlock block;
    block.size.x = width + 2 * edge;
    const std::string title = cutWords(bar.title(), in.em, width, in.measure());
    block.cut = title != bar.title() ? "the title " + bar.title() : "";
    if (!title.empty()) {
        const LaidWords line = in.line(title);
        block.write(line, {0, 0});
        block.size.y = PartLayout::boxOf(line).y;
        block.size.x = std::max(block.size.x, PartLayout::boxOf(line).x);
    }
    const glm::dvec2 from(edge, std::ceil(block.size.y) + edge);
    const glm::dvec2 to = from + glm::dvec2(width, std::max(3.0, std::round(kHeight * in.em)));
    frame(block, in, from, to);
    // Each colour reaches to the end, and the next ones lie over it: no gap shows between them.
    const auto count = static_cast<double>(bar.colours.size());
    for (std::size_t n = 0; n < bar.colours.size(); ++n)
        block.shapes.emplace_back(
            rectangle({from.x + std::round(static_cast<double>(n) * width / count), from.y}, to,
                      glm::vec3(bar.colours[n])));
    block.size.y = to.y + edge;
    writeValues(block, in, bar, edge, width);
    return block;
}

std::string nameOfLegend(const LegendBar& bar) {
    return bar.title().empty() ? "the colour legend" : "the colour legend of " + bar.title();
}

LaidBlock labelBlock(const PartLayout& in, const std::string& name, const glm::vec3* colour) {
    constexpr double kMostLetters = 16, kSquare = 0.8; // of a name; letters
    const double square = std::round(kSquare * in.em), edge = edgeOf(in);
    const double most = std::min(kMostLetters * in.em, kMostOfNames * in.width() - square - 2 * in.edge);
    LaidBlock row;
    const LaidWords line = in.line(cutWords(printable(name), in.em, most, in.measure()));
    row.cut = line.words != printable(name) ? "the name " + printable(name) : "";
    const glm::dvec2 box = PartLayout::boxOf(line);
    const double left = square + 2 * edge + in.gap, side = square + 2 * edge;
    row.size = {left + box.x, std::ceil(std::max(box.y, side))};
    if (colour) {
        const double top = std::floor((row.size.y - side) / 2) + edge;
        frame(row, in, {edge, top}, glm::dvec2(edge, top) + square);
        row.shapes.emplace_back(rectangle({edge, top}, glm::dvec2(edge, top) + square, *colour));
    }
    row.write(line, {left, (row.size.y - box.y) / 2});
    return row;
}

std::string unnamedLabels(std::size_t left, std::size_t all) {
    return std::to_string(left) + " of " + std::to_string(all) + " names of labels";
}

void layColourLegend(PartLayout& in) {
    if (!in.part.annotations.legend)
        return;
    const std::vector<LegendBar>& bars = in.part.legend;
    for (auto bar = bars.rbegin(); bar != bars.rend(); ++bar) { // the first on top
        LaidBlock block = colourLegendBlock(in, *bar);
        const glm::dvec2 corner(in.from.x, in.to.y - block.size.y);
        in.place(std::move(block), in.slide(corner, -1), nameOfLegend(*bar));
    }
}

void layLabelLegend(PartLayout& in) {
    if (!in.part.annotations.labelLegend)
        return;
    // Down the columns, past what has its room already, as far as there are columns.
    const std::vector<LegendLabel>& labels = in.part.labels;
    const double end = in.from.x + kMostOfNames * in.width();
    std::vector<LaidBlock> rows;
    std::vector<glm::dvec2> places;
    glm::dvec2 at = glm::ceil(in.from);
    double widest = 0; // of the column
    while (places.size() < labels.size()) {
        if (rows.size() == places.size()) {
            const LegendLabel& label = labels[rows.size()];
            rows.push_back(labelBlock(in, label.name, &label.colour));
        }
        const glm::dvec2 size = rows.back().size;
        if (at.x + size.x > end || (at.y + size.y > in.to.y && widest == 0))
            break;
        if (at.y + size.y > in.to.y) {
            at = glm::ceil(glm::dvec2(at.x + widest + in.gap, in.from.y));
            widest = 0;
        } else if (in.isFree(at, size)) {
            places.push_back(at);
            widest = std::max(widest, size.x);
            at.y += size.y;
        } else {
            at.y += std::ceil(0.5 * in.em);
        }
    }
    if (places.size() < labels.size()) { // the last place tells of the others
        in.leaveOut(unnamedLabels(labels.size() - (places.empty() ? 0 : places.size() - 1), labels.size()));
        for (bool told = false; !told && !places.empty(); places.pop_back()) {
            const std::size_t n = places.size() - 1;
            rows[n] = labelBlock(in, "and " + std::to_string(labels.size() - n) + " more", nullptr);
            told = in.isFree(places[n], rows[n].size);
            if (told)
                in.place(std::move(rows[n]), {places[n]}, "");
        }
    }
    for (std::size_t n = 0; n < places.size(); ++n)
        in.place(std::move(rows[n]), {places[n]}, labels[n].name);
}

} // namespace tessera
