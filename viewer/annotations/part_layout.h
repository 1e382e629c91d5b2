// viewer/annotations/part_layout.h: the layout of one part of a figure while it is made: free space, and
// blocks of lines and words that take some of it. For figure_layout.cpp and its neighbours.
#pragma once

#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_layout.h"
#include "viewer/annotations/words.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
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

/// Where blocks have room: in the picture, or on the strips around it.
enum class Room { picture, strips };

class PartLayout {
  public:
    PartLayout(const FigurePart& part, double dpi, const MeasureWords& measure, FigureLayout& out,
               Room room = Room::picture);

    const FigurePart& part;
    const double dpi, em; // em: the size of letters, pixels
    const double edge, gap, margin, stroke;
    const Ink ink;
    const glm::dvec2 from, to; // where blocks have room: the box without its margin, or the strips' outside

    /// Of the picture without its margin.
    double width() const { return extent_.x; }
    double height() const { return extent_.y; }
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
    const glm::dvec2 extent_;
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

/// What stands beside the picture, on its strips.
/// @param in  of Room::strips
void layBeside(PartLayout& in);

// Their blocks.

constexpr double kTitleLetters = 1.2; // size of a title's letters, and of those at the edges
LaidBlock markBlock(const PartLayout& in);
/// Lines one above the other, each in the middle. Empty: no room for a letter.
/// @param room  their width at most
/// @param what  they are, where they are cut
LaidBlock centredBlock(const PartLayout& in, const std::string& words, double size, double room,
                       const std::string& what);
LaidBlock scaleBarBlock(const PartLayout& in);
LaidBlock edgeLetterBlock(const PartLayout& in, const std::string& letters);
LaidBlock cubeBlock(const PartLayout& in);
LaidBlock colourLegendBlock(const PartLayout& in, const LegendBar& bar);
/// @param colour  none: words alone
LaidBlock labelBlock(const PartLayout& in, const std::string& name, const glm::vec3* colour);
/// How messages call it.
std::string nameOfLegend(const LegendBar& bar);
/// "3 of 12 names of labels" are left out.
std::string unnamedLabels(std::size_t left, std::size_t all);
bool showsLetters(const FigurePart& part);
bool showsCube(const FigurePart& part);

} // namespace tessera
