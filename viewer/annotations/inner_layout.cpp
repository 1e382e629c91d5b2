// viewer/annotations/inner_layout.cpp: words and ticks of pictures that a part holds side by side, for
// part_layout.h.
#include "viewer/annotations/part_layout.h"

#include <cmath>
#include <glm/vec2.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr double kLetters = 1.2; // size, as at the edges of parts
constexpr double kTick = 0.8;    // length, letters

/// The room of one picture.
class InnerRoom {
  public:
    InnerRoom(PartLayout& in, const InnerPicture& picture, std::set<std::string>& leftOut)
        : in_(in), leftOut_(leftOut), from_(glm::dvec2(in.part.from + picture.from) + in.margin),
          to_(glm::dvec2(in.part.from + picture.from + picture.size) - in.margin) {}

    const glm::dvec2& from() const { return from_; }
    const glm::dvec2& to() const { return to_; }

    /// @param x, y  0: at the left or upper edge, 1: at the other one
    /// @param down  may move so many letters downwards, or below 0 upwards
    void lay(const std::string& words, double size, double x, double y, double down) {
        if (words.empty())
            return;
        LaidBlock block = blockOf(words, size);
        const glm::dvec2 corner = from_ + glm::dvec2(x, y) * (to_ - from_ - block.size);
        std::vector<glm::dvec2> corners;
        for (double by = 0; by <= std::abs(down); by += 0.5)
            corners.push_back({corner.x, corner.y + std::copysign(by, down) * in_.em});
        put(std::move(block), corners, words);
    }
    /// To the right of a point, in the middle of their height.
    void layBeside(const std::string& words, const glm::dvec2& point) {
        if (words.empty())
            return;
        LaidBlock block = blockOf(words, 1);
        const glm::dvec2 corner(point.x, point.y - block.size.y / 2);
        put(std::move(block), {corner}, words);
    }

  private:
    LaidBlock blockOf(const std::string& words, double size) const {
        LaidBlock block;
        const LaidWords line = in_.line(words, size);
        block.size = PartLayout::boxOf(line);
        block.write(line, {0, 0});
        return block;
    }
    void put(LaidBlock block, const std::vector<glm::dvec2>& corners, const std::string& words) {
        std::vector<glm::dvec2> within;
        for (const glm::dvec2& corner : corners) {
            constexpr double kRounding = 1e-6;
            const glm::dvec2 end = corner + block.size;
            if (corner.x >= from_.x - kRounding && corner.y >= from_.y - kRounding &&
                end.x <= to_.x + kRounding && end.y <= to_.y + kRounding && in_.hasRoom(corner, block.size))
                within.push_back(corner);
        }
        if (within.empty()) {
            leftOut_.insert(words);
            return;
        }
        in_.place(std::move(block), within, words);
    }

    PartLayout& in_;
    std::set<std::string>& leftOut_;
    const glm::dvec2 from_, to_;
};

void layTicks(PartLayout& in, const InnerPicture& picture, InnerRoom& room) {
    if (picture.ticks.empty())
        return;
    LaidLines lines;
    lines.width = in.stroke;
    lines.edge = in.edge;
    lines.ink = in.ink;
    // Sharp lines, as wide as whole pixels, end on these.
    const double half = std::fmod(in.stroke, 2) / 2, length = std::round(kTick * in.em),
                 left = std::ceil(room.from().x), right = std::floor(room.to().x);
    for (const SideTick& tick : picture.ticks) {
        const double y = in.part.from.y + picture.from.y + std::floor(tick.at) + half;
        if (const double reach = in.stroke / 2 + in.edge;
            left + length > right - length || y - reach < in.part.from.y + picture.from.y ||
            y + reach > in.part.from.y + picture.from.y + picture.size.y)
            continue; // a picture with no room for one
        lines.lines.push_back({{left, y}, {left + length, y}});
        lines.lines.push_back({{right - length, y}, {right, y}});
        room.layBeside(tick.words, {left + length + in.gap, y});
    }
    in.add(std::move(lines));
}

} // namespace

void layInnerPictures(PartLayout& in) {
    std::set<std::string> leftOut; // each word once, of however many pictures
    for (const InnerPicture& picture : in.part.inner) {
        constexpr double kDown = 3; // below a title
        InnerRoom room(in, picture, leftOut);
        const double row = picture.lettersOnTop ? 0 : 0.5;
        room.lay(picture.words, 1, picture.lettersOnTop ? 0.5 : 0, 0, kDown);
        room.lay(picture.left, kLetters, 0, row, kDown);
        room.lay(picture.right, kLetters, 1, row, kDown);
        room.lay(picture.top, kLetters, 0.5, 0, kDown);
        room.lay(picture.bottom, kLetters, 0.5, 1, -kDown);
        layTicks(in, picture, room);
    }
    for (const std::string& words : leftOut)
        in.leaveOut("the words " + words);
}

} // namespace tessera
