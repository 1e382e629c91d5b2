// tests/support/drawn_words.h: reads what ImGui would draw: words, from the glyphs that triangles show,
// and shapes by their boxes and colours. No display is needed.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <imgui.h>
#include <string>
#include <vector>

namespace tessera::test {

/// A word or shape of a window's list, in units of the window.
struct Drawn {
    std::string list, words; // words: empty for a shape
    ImU32 colour = 0;
    float left = 1e9f, top = 1e9f, right = -1e9f, bottom = -1e9f;
    float firstX = 0, firstY = 0; // of a shape's first corner: which diagonal a line is
    unsigned texture = 0;         // of a picture
    int columns = 0;              // of a graph of narrow bars; 0: another shape
    double heights = 0, colours = 0;

    /// @param above  heights are from its upper edge, if it is in the same list
    std::string text(const Drawn* above = nullptr) const {
        // Away from halves, where the last bit of a float would decide.
        const auto whole = [](float x) { return static_cast<int>(std::lround(x + 0.013f)); };
        const float from = above && above->list == list ? above->top : 0;
        char line[200];
        if (columns > 0)
            std::snprintf(line, sizeof line, "%d bars, %.4g high, colours %.4g", columns, heights, colours);
        else
            std::snprintf(line, sizeof line, "%08x %d %d %d %d", colour, whole(left), whole(top - from),
                          whole(right), whole(bottom - from));
        std::string all = "[" + list + "] " + line;
        if (!words.empty())
            all += " \"" + words + "\"";
        else if (texture != 0)
            all += " picture " + std::to_string(texture);
        else if (columns == 0 && (firstX > left + 2 || firstY > top + 2))
            all += " from " + std::to_string(whole(firstX)) + " " + std::to_string(whole(firstY - from));
        return all;
    }
};

class DrawnReader {
  public:
    std::vector<Drawn> read(const ImDrawData& data) {
        all_.clear();
        for (int n = 0; n < data.CmdListsCount; ++n) {
            const ImDrawList& list = *data.CmdLists[n];
            list_ = list._OwnerName ? list._OwnerName : "over";
            for (const ImDrawCmd& command : list.CmdBuffer)
                readCommand(list, command);
            endWord();
        }
        return all_;
    }

  private:
    static const ImFontGlyph* glyphOf(const ImDrawVert& a, const ImDrawVert& b) {
        for (const ImFontGlyph& glyph : ImGui::GetIO().Fonts->Fonts[0]->Glyphs)
            if (glyph.Visible && glyph.U0 == a.uv.x && glyph.V0 == a.uv.y && glyph.U1 == b.uv.x &&
                b.uv.y <= glyph.V1 && b.uv.y > a.uv.y) // its foot may be clipped
                return &glyph;
        return nullptr;
    }
    void endWord() {
        if (!word_.words.empty())
            all_.push_back(word_);
        word_ = {};
    }
    void addGlyph(const ImFontGlyph& glyph, const ImDrawVert& at) {
        const float x = at.pos.x - glyph.X0, y = at.pos.y - glyph.Y0;
        const float gap = word_.words.empty() ? 1e9f : x - pen_;
        if (std::abs(y - line_) > 0.6f || gap < -0.6f || gap > 1.5f * glyph.AdvanceX ||
            at.col != word_.colour)
            endWord();
        else
            word_.words += std::string(static_cast<std::size_t>(std::lround(gap / glyph.AdvanceX)), ' ');
        if (word_.words.empty()) {
            word_.list = list_;
            word_.colour = at.col;
            word_.left = x, word_.top = y;
        }
        const unsigned code = glyph.Codepoint; // of Latin-1, as UTF-8
        if (code < 0x80)
            word_.words += static_cast<char>(code);
        else
            (word_.words += static_cast<char>(0xC0 | code >> 6)) += static_cast<char>(0x80 | (code & 0x3F));
        pen_ = x + glyph.AdvanceX, line_ = y;
        word_.right = pen_, word_.bottom = y + ImGui::GetFontSize();
    }
    void addShape(Drawn shape, const ImVec4& clip, int triangles) {
        if (shape.right < clip.x || shape.left > clip.z || shape.bottom < clip.y || shape.top > clip.w ||
            shape.colour >> 24 == 0)
            return;
        shape.left = std::max(shape.left, clip.x), shape.right = std::min(shape.right, clip.z);
        shape.top = std::max(shape.top, clip.y), shape.bottom = std::min(shape.bottom, clip.w);
        shape.list = list_;
        if (triangles == 2 && shape.right - shape.left <= 3.2f && shape.texture == 0 &&
            shape.firstX <= shape.left + 0.1f) {
            shape.columns = 1;
            shape.heights = static_cast<double>(shape.bottom - shape.top);
            for (int channel = 0; channel < 4; ++channel)
                shape.colours += (channel + 1.0) * (shape.colour >> (8 * channel) & 255) / 255;
            if (!all_.empty() && all_.back().columns > 0 && all_.back().list == list_) {
                Drawn& bars = all_.back();
                ++bars.columns, bars.heights += shape.heights, bars.colours += shape.colours;
                return;
            }
        }
        all_.push_back(shape);
    }
    void readCommand(const ImDrawList& list, const ImDrawCmd& command) {
        const ImDrawIdx* const index = &list.IdxBuffer[static_cast<int>(command.IdxOffset)];
        const auto vertex = [&](unsigned i) -> const ImDrawVert& {
            return list.VtxBuffer[static_cast<int>(command.VtxOffset + index[i])];
        };
        const auto texture = static_cast<unsigned>(reinterpret_cast<std::uintptr_t>(command.GetTexID()));
        for (unsigned i = 0; i < command.ElemCount;) {
            if (i + 6 <= command.ElemCount && texture == 0)
                if (const ImFontGlyph* const glyph = glyphOf(vertex(i), vertex(i + 2))) {
                    if (vertex(i).pos.y < command.ClipRect.w && vertex(i + 2).pos.y > command.ClipRect.y)
                        addGlyph(*glyph, vertex(i));
                    i += 6;
                    continue;
                }
            endWord();
            Drawn shape;
            shape.texture = texture;
            shape.firstX = vertex(i).pos.x, shape.firstY = vertex(i).pos.y;
            int triangles = 0;
            unsigned most = 0;
            do { // triangles of one shape share vertices
                for (unsigned k = i; k < i + 3; ++k) {
                    const ImDrawVert& v = vertex(k);
                    most = std::max<unsigned>(most, index[k]);
                    shape.left = std::min(shape.left, v.pos.x), shape.right = std::max(shape.right, v.pos.x);
                    shape.top = std::min(shape.top, v.pos.y), shape.bottom = std::max(shape.bottom, v.pos.y);
                    if (v.col >> 24 > shape.colour >> 24 || triangles == 0)
                        shape.colour = v.col;
                }
                i += 3, ++triangles;
            } while (i < command.ElemCount && std::min({index[i], index[i + 1], index[i + 2]}) <= most);
            addShape(shape, command.ClipRect, triangles);
        }
    }

    std::vector<Drawn> all_;
    Drawn word_;
    std::string list_;
    float pen_ = 0, line_ = 0;
};

} // namespace tessera::test
