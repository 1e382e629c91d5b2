// viewer/annotations/figure_layout.cpp: see figure_layout.h: title, caption, scale bar and directions.
#include "viewer/annotations/figure_layout.h"

#include "core/base/shown_text.h"
#include "core/image/colour.h"
#include "viewer/annotations/part_layout.h"
#include "viewer/session/patient_letters.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr double kMostOfTitle = 0.25; // of the part's height, as for the caption

} // namespace

LaidBlock centredBlock(const PartLayout& in, const std::string& words, double size, double room,
                       const std::string& what) {
    const double row = PartLayout::boxOf(in.line("Ag", size)).y;
    const auto most = static_cast<std::size_t>(std::max(1.0, kMostOfTitle * in.height() / row));
    LaidBlock block;
    std::vector<LaidWords> lines;
    const BrokenWords broken =
        brokenWords(printableLines(words), size * in.em, room - 2 * in.edge, most, in.measure());
    block.cut = broken.cut ? what : "";
    for (const std::string& text : broken.lines) {
        lines.push_back(in.line(text, size));
        block.size.x = std::max(block.size.x, PartLayout::boxOf(lines.back()).x);
    }
    for (LaidWords& line : lines) {
        const glm::dvec2 box = PartLayout::boxOf(line);
        block.write(std::move(line), {(block.size.x - box.x) / 2, block.size.y});
        block.size.y += box.y;
    }
    return block;
}

namespace {

/// Places centred words; what has no room for a letter is left out.
void placeCentred(PartLayout& in, LaidBlock block, const std::vector<glm::dvec2>& corners,
                  const std::string& what) {
    if (!block.words.empty())
        in.place(std::move(block), corners, what);
    else if (!block.cut.empty())
        in.leaveOut(what);
}

void layAtBottom(PartLayout& in, const std::string& words, const std::string& what) {
    LaidBlock block = centredBlock(in, words, 1, in.width(), what);
    const glm::dvec2 corner((in.from.x + in.to.x - block.size.x) / 2, in.to.y - block.size.y);
    placeCentred(in, std::move(block), in.slide(corner, -1), what);
}

} // namespace

LaidBlock markBlock(const PartLayout& in) {
    constexpr double kMark = 1.6; // size of its letters
    LaidBlock block;
    const LaidWords line = in.line(in.part.mark, kMark, true);
    block.size = PartLayout::boxOf(line);
    block.write(line, {0, 0});
    return block;
}

void layMark(PartLayout& in) {
    if (in.part.mark.empty())
        return;
    LaidBlock block = markBlock(in);
    const double width = block.size.x;
    if (in.place(std::move(block), {in.from}, "the letter " + in.part.mark))
        in.besideMark = width + in.gap;
}

void layTitle(PartLayout& in) {
    if (in.part.annotations.title.empty())
        return;
    const std::string what = "the title";
    LaidBlock block = centredBlock(in, in.part.annotations.title, kTitleLetters,
                                   in.width() - 2 * std::ceil(in.besideMark + 1), what);
    const glm::dvec2 corner((in.from.x + in.to.x - block.size.x) / 2, in.from.y);
    placeCentred(in, std::move(block), {corner}, what);
}

void layCaption(PartLayout& in) {
    if (in.part.annotations.error && !in.part.error.empty())
        layAtBottom(in, in.part.error, "the measured error");
    if (!in.part.annotations.caption.empty())
        layAtBottom(in, in.part.annotations.caption, "the caption");
}

LaidBlock scaleBarBlock(const PartLayout& in) {
    const ScaleBar bar = scaleBarOf(in.part.camera, in.part.size);
    LaidBlock block;
    const LaidWords text = in.line(bar.text());
    const glm::dvec2 box = PartLayout::boxOf(text);
    const double end = std::max(in.stroke + 2, std::round(0.6 * in.em)); // the height of its ends
    block.size = {std::ceil(std::max(bar.pixels + 2 * in.edge, box.x)), std::ceil(box.y + end + 2 * in.edge)};
    const double right = block.size.x - std::ceil(in.edge), left = right - bar.pixels,
                 bottom = block.size.y - std::ceil(in.edge);
    const double middle = bottom - std::floor((end - in.stroke) / 2) - in.stroke / 2;
    LaidLines lines;
    lines.lines = {{{left, middle}, {right, middle}}};
    for (const double x : {left + in.stroke / 2, right - in.stroke / 2})
        lines.lines.push_back({{x, bottom - end}, {x, bottom}});
    lines.width = in.stroke;
    lines.edge = in.edge;
    lines.ink = in.ink;
    block.shapes.emplace_back(std::move(lines));
    block.write(text, {block.size.x - box.x, 0});
    return block;
}

void layScaleBar(PartLayout& in) {
    if (!in.part.annotations.scaleBar)
        return;
    LaidBlock block = scaleBarBlock(in);
    const glm::dvec2 corner = in.to - block.size;
    in.place(std::move(block), in.slide(corner, -1), kScaleBarWords);
}

bool showsLetters(const FigurePart& part) {
    const Directions wanted = part.annotations.directions;
    return (wanted == Directions::letters || wanted == Directions::all) && part.orientationKnown;
}

bool showsCube(const FigurePart& part) {
    const Directions wanted = part.annotations.directions;
    return (wanted == Directions::cube || wanted == Directions::all) && part.orientationKnown;
}

LaidBlock edgeLetterBlock(const PartLayout& in, const std::string& letters) {
    LaidBlock block;
    const LaidWords line = in.line(letters, kTitleLetters);
    block.size = PartLayout::boxOf(line);
    block.write(line, {0, 0});
    return block;
}

void layEdgeLetters(PartLayout& in) {
    if (!showsLetters(in.part))
        return;
    constexpr double kFarthest = 0.25; // from its place, of the height: further in, it belongs to no edge
    const EdgeLetters letters = edgeLetters(in.part.camera);
    const glm::dvec2 middle = (in.from + in.to) / 2.0;
    const auto lay = [&](const std::string& text, double x, double y, int towards) {
        LaidBlock block = edgeLetterBlock(in, text);
        const glm::dvec2 corner(in.from.x + x * (in.width() - block.size.x),
                                y == 0.5 ? middle.y - block.size.y / 2
                                         : in.from.y + y * (in.height() - block.size.y));
        std::vector<glm::dvec2> corners = in.slide(corner, towards);
        std::erase_if(corners, [&](const glm::dvec2& at) {
            return std::abs(at.y - corner.y) > kFarthest * in.height();
        });
        in.place(std::move(block), corners, "the letters " + text);
    };
    lay(letters.left, 0, 0.5, 0);
    lay(letters.right, 1, 0.5, 0);
    lay(letters.top, 0.5, 0, 1);
    lay(letters.bottom, 0.5, 1, -1);
}

LaidBlock cubeBlock(const PartLayout& in) {
    constexpr double kHalf = 2.6, kEdge = 0.62, kReach = 1.1; // letters; parts of the half
    constexpr double kSeen = 0.02, kLettered = 0.3;           // cosines of faces
    const glm::dmat3 cameraFromPatient = glm::transpose(patientFromCamera(in.part.camera));
    const double half = kHalf * in.em;
    LaidBlock block;
    block.size = glm::dvec2(2 * kReach * half);
    const auto project = [&](const glm::dvec3& p) {
        const glm::dvec3 c = cameraFromPatient * p;
        return glm::dvec2(block.size.x / 2 + half * c.x, block.size.y / 2 - half * c.y);
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) {
            glm::dvec3 normal(0), u(0), v(0);
            normal[axis] = side;
            u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1;
            const double facing = (cameraFromPatient * normal).z;
            if (facing <= kSeen)
                continue;
            LaidArea face;
            for (const glm::dvec3& corner : {u + v, u - v, -u - v, v - u})
                face.corners.push_back(project(kEdge * (normal + corner)));
            face.colour = glm::vec3(static_cast<float>(linearFromSrgb((50 + 90 * facing) / 255)));
            LaidLines frame;
            frame.lines = {face.corners};
            frame.lines[0].push_back(face.corners[0]);
            frame.width = std::max(1.0, in.stroke / 2);
            frame.edge = 0;
            block.shapes.emplace_back(std::move(face));
            block.shapes.emplace_back(std::move(frame));
            if (facing <= kLettered)
                continue;
            LaidWords letter = in.line(directionLetters(normal));
            letter.ink = Ink::light; // the faces are dark
            const glm::dvec2 box = PartLayout::boxOf(letter);
            block.write(std::move(letter), project(kEdge * normal) - box / 2.0);
        }
    return block;
}

void layCube(PartLayout& in) {
    if (!showsCube(in.part))
        return;
    LaidBlock block = cubeBlock(in);
    const glm::dvec2 corner(in.to.x - block.size.x, in.from.y);
    in.place(std::move(block), in.slide(corner, 1), "the cube of directions");
}

FigureLayout layOut(const Figure& figure, const MeasureWords& measure) {
    FigureLayout layout;
    for (const FigurePart& part : figure.parts) {
        PartLayout in(part, figure.dpi, measure, layout);
        if (part.annotations.directions != Directions::none && !part.orientationKnown)
            in.leaveOut("the patient's directions: the volume does not tell them");
        const AnnotationMargin beside = part.annotations.margin;
        if (beside != AnnotationMargin::none) {
            PartLayout around(part, figure.dpi, measure, layout, Room::strips);
            layBeside(around);
        }
        if (beside != AnnotationMargin::all) {
            layMark(in);
            layTitle(in);
            layCaption(in);
            layScaleBar(in);
        }
        layInnerPictures(in);
        if (beside != AnnotationMargin::all)
            layEdgeLetters(in);
        if (beside == AnnotationMargin::none) {
            layColourLegend(in);
            layLabelLegend(in);
        }
        if (beside != AnnotationMargin::all)
            layCube(in);
        layMeasurements(in);
        layArrows(in);
    }
    return layout;
}

StripHeights stripsNeeded(const FigurePart& words, double dpi, const MeasureWords& measure) {
    constexpr int kMostRounds = 60;
    FigurePart part;
    part.size = words.size;
    part.annotations.title = words.annotations.title;
    part.annotations.caption = words.annotations.caption;
    part.annotations.textPoints = words.annotations.textPoints;
    const auto needed = [&](const StripHeights& strips) {
        part.size.y = words.size.y + strips.above + strips.below;
        FigureLayout layout;
        PartLayout in(part, dpi, measure, layout);
        StripHeights heights;
        layTitle(in);
        for (const LaidWords& line : layout.words)
            heights.above = std::max(heights.above, static_cast<int>(std::ceil(line.to().y + in.margin)));
        const std::size_t ofTitle = layout.words.size();
        layCaption(in);
        for (std::size_t n = ofTitle; n < layout.words.size(); ++n)
            heights.below =
                std::max(heights.below,
                         static_cast<int>(std::ceil(part.size.y - layout.words[n].from().y + in.margin)));
        return heights;
    };
    // Letters grow with the figure, and strips with the letters: from more than any strip needs, for words
    // have a quarter of a figure at most, down to what is needed.
    constexpr int kMargins = 64;
    const int most = words.size.y + kMargins;
    StripHeights enough{part.annotations.title.empty() ? 0 : most,
                        part.annotations.caption.empty() ? 0 : most};
    StripHeights next = needed(enough);
    for (int round = 0; round < kMostRounds && next != enough; ++round) {
        const StripHeights further = needed(next);
        if (further.above > next.above || further.below > next.below)
            break; // these would be too low
        enough = std::exchange(next, further);
    }
    return enough;
}

} // namespace tessera
