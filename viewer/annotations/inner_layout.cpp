// viewer/annotations/inner_layout.cpp: words and ticks of pictures that a part holds side by side, for
// part_layout.h.
#include "viewer/annotations/part_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/vec2.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr double kLetters = 1.2; // size, as at the edges of parts
constexpr double kTick = 0.8;    // length, letters
constexpr double kRows = 11;     // of letters that a picture has at least, until they are

/// The room of one picture.
class InnerRoom {
  public:
    InnerRoom(PartLayout& in, const InnerPicture& picture, std::set<std::string>& leftOut)
        : in_(in), leftOut_(leftOut), from_(glm::dvec2(in.part.from + picture.from) + in.margin),
          to_(glm::dvec2(in.part.from + picture.from + picture.size) - in.margin),
          scale_(std::clamp(std::min(picture.size.x, picture.size.y) / (kRows * in.em),
                            std::min(1.0, kLeastPixels / in.em), 1.0)) {}

    const glm::dvec2& from() const { return from_; }
    const glm::dvec2& to() const { return to_; }
    /// Of letters, in the part's: less in a small picture.
    double scale() const { return scale_; }

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
        if (!put(std::move(block), corners))
            leaveOut(words);
    }
    /// Places a block at the first corner where all of it lies in the picture and has room.
    bool put(LaidBlock block, const std::vector<glm::dvec2>& corners) {
        std::vector<glm::dvec2> within;
        for (const glm::dvec2& corner : corners) {
            constexpr double kRounding = 1e-6;
            const glm::dvec2 end = corner + block.size;
            if (corner.x >= from_.x - kRounding && corner.y >= from_.y - kRounding &&
                end.x <= to_.x + kRounding && end.y <= to_.y + kRounding && in_.hasRoom(corner, block.size))
                within.push_back(corner);
        }
        return !within.empty() && in_.place(std::move(block), within, "");
    }
    void leaveOut(const std::string& words) { leftOut_.insert(words); }

  private:
    LaidBlock blockOf(const std::string& words, double size) const {
        LaidBlock block;
        const LaidWords line = in_.line(words, size * scale_);
        block.size = PartLayout::boxOf(line);
        block.write(line, {0, 0});
        return block;
    }

    PartLayout& in_;
    std::set<std::string>& leftOut_;
    const glm::dvec2 from_, to_;
    const double scale_;
};

/// A tick at the left or right edge, as a block with the words beside it.
/// @param high  of the block, at least
LaidBlock tickBlock(const PartLayout& in, const std::string& words, double scale, double high) {
    LaidLines lines;
    lines.width = in.stroke;
    lines.edge = in.edge;
    lines.ink = in.ink;
    const double length = std::round(kTick * in.em);
    LaidBlock block;
    block.size = {length, std::max(high, in.stroke)};
    LaidWords line;
    glm::dvec2 box(0);
    if (!words.empty()) {
        line = in.line(words, scale);
        box = PartLayout::boxOf(line);
        block.size = {length + in.gap + box.x, std::max(block.size.y, std::ceil(box.y / 2) * 2)};
    }
    const double middle = std::floor(block.size.y / 2) + std::fmod(in.stroke, 2) / 2; // sharp
    lines.lines = {{{0, middle}, {length, middle}}};
    block.shapes.emplace_back(std::move(lines));
    if (!words.empty())
        block.write(std::move(line), {length + in.gap, (block.size.y - box.y) / 2});
    return block;
}

void layTicks(PartLayout& in, const InnerPicture& picture, InnerRoom& room) {
    for (const SideTick& tick : picture.ticks) {
        const double y = in.part.from.y + picture.from.y + std::floor(tick.at);
        const auto lay = [&](const std::string& words, bool right, double high) {
            LaidBlock block = tickBlock(in, words, room.scale(), high);
            const glm::dvec2 size = block.size;
            const glm::dvec2 corner(right ? std::floor(room.to().x - size.x) : std::ceil(room.from().x),
                                    y - std::floor(size.y / 2));
            return room.put(std::move(block), {corner}) ? size.y : 0;
        };
        double high = lay(tick.words, false, 0);
        if (high == 0 && !tick.words.empty()) {
            room.leaveOut(tick.words);
            high = lay("", false, 0);
        }
        if (lay("", true, high) == 0) // as high as the left one: letters stand below both
            lay("", true, 0);
    }
}

} // namespace

void layInnerPictures(PartLayout& in) {
    std::set<std::string> leftOut; // each word once, of however many pictures
    for (const InnerPicture& picture : in.part.inner) {
        constexpr double kDown = 3; // below a title
        InnerRoom room(in, picture, leftOut);
        const double row = picture.lettersOnTop ? 0 : 0.5;
        layTicks(in, picture, room); // first: they have one place each; then letters, which have an edge
        room.lay(picture.left, kLetters, 0, row, kDown);
        room.lay(picture.right, kLetters, 1, row, kDown);
        room.lay(picture.top, kLetters, 0.5, 0, kDown);
        room.lay(picture.bottom, kLetters, 0.5, 1, -kDown);
        room.lay(picture.words, 1, picture.lettersOnTop ? 0.5 : 0, 0, kDown);
    }
    constexpr std::size_t kMostTold = 6;
    std::size_t told = 0;
    for (const std::string& words : leftOut)
        if (told++ < kMostTold)
            in.leaveOut("the words " + words);
    if (leftOut.size() > kMostTold)
        in.leaveOut("other words of its pictures, " + std::to_string(leftOut.size() - kMostTold));
}

} // namespace tessera
