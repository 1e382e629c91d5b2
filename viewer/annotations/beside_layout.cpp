// viewer/annotations/beside_layout.cpp: annotations beside a picture, on strips around it, for part_layout.h:
// the letters of its edges nearest to it, beyond them the title above, the scale bar and the caption below,
// and the legends at the right.
#include "viewer/annotations/part_layout.h"
#include "viewer/session/patient_letters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// Stands blocks around a picture. Places are whole pixels from its upper left corner, so that a larger strip
/// moves none of them.
class Around {
  public:
    explicit Around(const PartLayout& in)
        : in_(in), width_(in.part.size.x), height_(in.part.size.y), gap_(std::ceil(in.margin)),
          right_(width_), below_(height_) {
        if (in.part.annotations.margin == AnnotationMargin::all) {
            standLetters();
            standBelow();
            standAbove();
        }
        standLegends();
    }

    /// What the blocks need.
    Strips strips() const {
        const auto need = [this](double reach) { return reach > 0 ? static_cast<int>(reach + gap_) : 0; };
        return {need(-left_), need(right_ - width_), need(-above_), need(below_ - height_)};
    }
    /// Into the layout: each where the part's strips have room for it.
    void place(PartLayout& in) const {
        for (const std::string& what : leftOut_)
            in.leaveOut(what);
        for (const Stood& stood : stood_)
            in.place(stood.block, {glm::dvec2(in.part.from) + stood.corner}, stood.what);
    }

  private:
    struct Stood {
        LaidBlock block;
        glm::dvec2 corner;
        std::string what;
    };

    void stand(LaidBlock block, double x, double y, const std::string& what) {
        stood_.push_back({std::move(block), glm::floor(glm::dvec2(x, y)), what});
    }
    void standAtRight(LaidBlock block, double x, double y, const std::string& what) {
        reach_ = std::max(reach_, x + std::ceil(block.size.x));
        stand(std::move(block), x, y, what);
    }
    double middle(const LaidBlock& block) const { return (width_ - block.size.x) / 2; }

    void standLetters() {
        if (!showsLetters(in_.part))
            return;
        const EdgeLetters letters = edgeLetters(in_.part.camera);
        const glm::dvec2 widest = PartLayout::boxOf(in_.line("RR", kTitleLetters)); // of whatever camera
        double column = std::ceil(widest.x);
        for (const std::string& side : {letters.left, letters.right})
            column = std::max(column, std::ceil(edgeLetterBlock(in_, side).size.x));
        const double row = std::ceil(widest.y);
        const auto add = [&](const std::string& words, const auto& corner) {
            LaidBlock block = edgeLetterBlock(in_, words);
            const glm::dvec2 at = corner(block);
            stand(std::move(block), at.x, at.y, "the letters " + words);
        };
        const auto level = [&](const LaidBlock& block) { return (height_ - block.size.y) / 2; };
        add(letters.left, [&](const LaidBlock& b) { return glm::dvec2(-gap_ - b.size.x, level(b)); });
        add(letters.right, [&](const LaidBlock& b) { return glm::dvec2(width_ + gap_, level(b)); });
        add(letters.top, [&](const LaidBlock& b) { return glm::dvec2(middle(b), -gap_ - row); });
        add(letters.bottom, [&](const LaidBlock& b) { return glm::dvec2(middle(b), height_ + gap_); });
        left_ = -gap_ - column;
        right_ = width_ + gap_ + column;
        above_ = -gap_ - row;
        below_ = height_ + gap_ + row;
        bottomLetters_ = (width_ + widest.x) / 2;
    }

    /// A row of words under all that is there.
    void standWords(const std::string& words, const std::string& what) {
        LaidBlock block = centredBlock(in_, words, 1, width_, what);
        if (block.words.empty()) {
            if (!block.cut.empty())
                leftOut_.push_back(what);
            return;
        }
        const double x = middle(block), y = below_ + gap_;
        below_ = y + std::ceil(block.size.y);
        stand(std::move(block), x, y, what);
    }

    void standBelow() {
        const Annotations& asked = in_.part.annotations;
        if (asked.scaleBar) {
            LaidBlock block = scaleBarBlock(in_);
            if (block.size.x > width_) {
                leftOut_.emplace_back(kScaleBarWords);
            } else { // beside the letters, if there is room
                const double x = width_ - block.size.x;
                const double y = (x - gap_ >= bottomLetters_ ? height_ : below_) + gap_;
                below_ = std::max(below_, y + std::ceil(block.size.y));
                stand(std::move(block), x, y, kScaleBarWords);
            }
        }
        if (!asked.caption.empty())
            standWords(asked.caption, "the caption");
        if (asked.error && !in_.part.error.empty())
            standWords(in_.part.error, "the measured error");
    }

    void standAbove() {
        const std::string& title = in_.part.annotations.title;
        LaidBlock mark, words;
        if (!in_.part.mark.empty())
            mark = markBlock(in_);
        if (!title.empty())
            words = centredBlock(in_, title, kTitleLetters,
                                 width_ - (mark.words.empty() ? 0 : 2 * std::ceil(mark.size.x + in_.gap + 1)),
                                 "the title");
        if (words.words.empty() && !words.cut.empty())
            leftOut_.emplace_back("the title");
        if (mark.words.empty() && words.words.empty())
            return;
        above_ -= gap_ + std::ceil(std::max(mark.size.y, words.size.y));
        if (!mark.words.empty())
            stand(std::move(mark), 0, above_, "the letter " + in_.part.mark);
        const double x = middle(words);
        if (!words.words.empty())
            stand(std::move(words), x, above_, "the title");
    }

    /// At the right: the cube at the top, bars of colours at the bottom, names of labels between them and in
    /// further columns.
    void standLegends() {
        const double first = right_ + std::ceil(in_.em);
        double widest = 0, top = 0, end = height_;
        if (in_.part.annotations.margin == AnnotationMargin::all && showsCube(in_.part)) {
            LaidBlock cube = cubeBlock(in_);
            if (cube.size.y > height_) {
                leftOut_.emplace_back("the cube of directions");
            } else {
                widest = cube.size.x;
                top = std::ceil(cube.size.y);
                standAtRight(std::move(cube), first, 0, "the cube of directions");
            }
        }
        const std::vector<LegendBar>& bars = in_.part.legend;
        for (auto bar = bars.rbegin(); in_.part.annotations.legend && bar != bars.rend(); ++bar) {
            LaidBlock block = colourLegendBlock(in_, *bar);
            if (end - std::ceil(block.size.y) < top) {
                leftOut_.push_back(nameOfLegend(*bar));
                continue;
            }
            end -= std::ceil(block.size.y);
            widest = std::max(widest, block.size.x);
            standAtRight(std::move(block), first, end, nameOfLegend(*bar));
        }
        if (in_.part.annotations.labelLegend)
            standLabels(first, top, end, widest);
        right_ = std::max(right_, reach_);
    }

    /// @param widest  of what stands above and below the first column
    void standLabels(double x, double top, double end, double widest) {
        const std::vector<LegendLabel>& labels = in_.part.labels;
        const double most = x + width_; // a page is at most about twice as wide as its picture
        double y = top;
        std::size_t count = 0;
        const std::size_t before = stood_.size();
        for (; count < labels.size(); ++count) {
            LaidBlock row = labelBlock(in_, labels[count].name, &labels[count].colour);
            if (y + row.size.y > end) { // the next column
                x += widest > 0 ? std::ceil(widest) + gap_ : 0;
                y = widest = 0, end = height_;
            }
            if (y + row.size.y > end || x + row.size.x > most)
                break;
            widest = std::max(widest, row.size.x);
            const double height = row.size.y;
            standAtRight(std::move(row), x, y, labels[count].name);
            y += height;
        }
        if (count == labels.size())
            return;
        // The last place tells of the others.
        leftOut_.push_back(unnamedLabels(labels.size() - (count > 0 ? count - 1 : 0), labels.size()));
        if (stood_.size() > before) {
            LaidBlock more =
                labelBlock(in_, "and " + std::to_string(labels.size() - (count - 1)) + " more", nullptr);
            const Stood last = std::move(stood_.back());
            stood_.pop_back();
            standAtRight(std::move(more), last.corner.x, last.corner.y, "how many more labels there are");
        }
    }

    const PartLayout& in_;
    const double width_, height_, gap_;
    double left_ = 0, right_, above_ = 0, below_; // what is taken, from the picture's upper left corner
    double bottomLetters_ = 0;                    // their right end
    double reach_ = 0;                            // of the legends
    std::vector<Stood> stood_;
    std::vector<std::string> leftOut_;
};

} // namespace

void layBeside(PartLayout& in) {
    Around(in).place(in);
}

Strips stripsBeside(const FigurePart& part, double dpi, const MeasureWords& measure) {
    if (part.annotations.margin == AnnotationMargin::none)
        return {};
    FigureLayout unused;
    const PartLayout in(part, dpi, measure, unused, Room::strips);
    return Around(in).strips();
}

} // namespace tessera
