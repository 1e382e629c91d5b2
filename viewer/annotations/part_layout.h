// viewer/annotations/part_layout.h: the layout of one part of a figure while it is made: free space, and
// blocks of lines and words that take some of it. For figure_layout.cpp and its neighbours.
#pragma once

#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_layout.h"
#include "viewer/annotations/words.h"

#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera {

constexpr double kLeastPixels = 6; // of letters that can be read

/// Shapes and words that are placed together, from (0,0) on.
struct LaidBlock {
    glm::dvec2 size{0};
    std::vector<LaidShape> shapes;
    std::vector<LaidWords> words;
    std::string cut = {}; // whose words are cut in it: "the title"

    /// At their left end and the upper edge of their box.
    void write(LaidWords line, const glm::dvec2& at);
    void move(const glm::dvec2& by);
};

class PartLayout {
  public:
    PartLayout(const FigurePart& part, double dpi, const MeasureWords& measure, FigureLayout& out);

    const FigurePart& part;
    const double dpi, em; // em: the size of letters, pixels
    const double edge, gap, margin, stroke;
    const Ink ink;
    const glm::dvec2 from, to; // where blocks have room: the box without its margin

    double width() const { return to.x - from.x; }
    double height() const { return to.y - from.y; }
    const MeasureWords& measure() const { return measure_; }
    double besideMark = 0; // what a mark takes of a row, from the left
    /// Measured, at (0,0).
    LaidWords line(const std::string& words, double size = 1, bool bold = false) const;
    /// A line's box, with its edge.
    static glm::dvec2 boxOf(const LaidWords& line) { return line.to() - line.from(); }

    /// isFree() of the corner that place() takes for it.
    bool hasRoom(const glm::dvec2& corner, const glm::dvec2& size) const;
    bool isFree(const glm::dvec2& corner, const glm::dvec2& size) const;
    /// Places the block at the first of these upper left corners that has room for it, else leaves it out, as
    /// the end of words that are cut.
    bool place(LaidBlock block, const std::vector<glm::dvec2>& corners, const std::string& what);
    void leaveOut(const std::string& what);
    /// Shapes over the picture, which take no room.
    void add(LaidShape shape) { out_.shapes.push_back(std::move(shape)); }

    /// Corners from a first one on along one axis, down (1) or up (-1), or alternately (0).
    std::vector<glm::dvec2> slide(const glm::dvec2& first, int towards) const;

  private:
    struct Taken {
        glm::dvec2 from, to;
    };
    const MeasureWords& measure_;
    FigureLayout& out_;
    std::vector<Taken> taken_;
};

// What a part says, in the order that it takes room in.

void layMark(PartLayout& in);
void layTitle(PartLayout& in);
void layCaption(PartLayout& in);
void layScaleBar(PartLayout& in);
void layInnerPictures(PartLayout& in);
void layEdgeLetters(PartLayout& in);
void layCube(PartLayout& in);
void layColourLegend(PartLayout& in);
void layLabelLegend(PartLayout& in);
void layMeasurements(PartLayout& in);
void layArrows(PartLayout& in);

} // namespace tessera
