// tests/support/window_record.h: the lines of a HeadlessWindow compared with those that
// tests/viewer/window/recorded/ holds. Where a change is meant, TESSERA_RECORD=1 writes the files anew, and
// their differences show what it changed.
#pragma once

#include "tests/support/folders.h"
#include "tests/support/headless_window.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <gtest/gtest.h>
#include <vector>

namespace tessera::test {

constexpr int kPanel = 330;

/// The panel alone, high enough to show all of it.
class PanelWindow : public HeadlessWindow {
  public:
    PanelWindow() : HeadlessWindow({1000, 3000}, {{kPanel, 0}, {400, 300}, 1}) {
        desk.showSlices = false;
        viewing.opened({400, 300});
        relative = true;
        records = [](const Drawn& d) { return d.list.find("ackground") == std::string::npos; };
    }
    void clicked(const std::string& words) {
        step("click " + words, [&] { clickOn(words); });
    }
    void dragged(const std::string& words, double right) {
        step("drag " + words, [&] { dragOn(words, right); });
    }
    /// Opens a box of names and takes one.
    void chosen(const std::string& box, const std::string& name) {
        step("choose " + name + " instead of " + box, [&] {
            clickOn(box);
            clickOn(name + "@0");
        });
    }
};

/// The picture beside the panel's place, and the planes.
class PictureWindow : public HeadlessWindow {
  public:
    PictureWindow() : HeadlessWindow({1000, 600}, {{100, 0}, {600, 600}, 1}) {
        desk.showPanels = false;
        viewing.opened({600, 600});
    }
    void keyed(bool ImGuiIO::*key, const std::function<void()>& act) {
        ImGui::GetIO().*key = true;
        act();
        ImGui::GetIO().*key = false;
    }
};

/// Middles of the handles of a box that is drawn, one a side.
inline std::vector<glm::dvec2> handlesOfBox(const HeadlessWindow& w) {
    std::vector<glm::dvec2> found;
    for (const Drawn& d : w.drawn)
        if (std::abs(d.right - d.left - 8) < 0.1f && std::abs(d.bottom - d.top - 8) < 0.1f)
            found.emplace_back((d.left + d.right) / 2, (d.top + d.bottom) / 2);
    return found;
}

/// Of a plane, by the ring around it. Fails where none is drawn.
inline glm::dvec2 handleOfPlane(const HeadlessWindow& w) {
    for (const Drawn& d : w.drawn)
        if (std::abs(d.right - d.left - 20) < 1.8f && std::abs(d.bottom - d.top - 20) < 1.8f)
            return glm::round(glm::dvec2(d.left + d.right, d.top + d.bottom) / 2.0);
    ADD_FAILURE() << "no handle of a plane is drawn";
    return glm::dvec2(0);
}

/// Numbers may be apart by as much as rounding makes of them, other words not. Places are rounded to pixels,
/// and processors' tangents differ in the last bit: one that lies between two pixels may be at either.
inline bool alike(const std::string& a, const std::string& b) {
    if (a == b)
        return true;
    std::istringstream left(a), right(b);
    const bool isDrawn = a.starts_with("+ [") || a.starts_with("- [");
    std::size_t word = 0; // "+ [LIST] COLOUR LEFT TOP RIGHT BOTTOM from X Y"
    for (std::string x, y;; ++word) {
        const bool more = static_cast<bool>(left >> x);
        if (more != static_cast<bool>(right >> y))
            return false;
        if (!more)
            return true;
        if (x == y)
            continue;
        char *endX = nullptr, *endY = nullptr;
        const double p = std::strtod(x.c_str(), &endX), q = std::strtod(y.c_str(), &endY);
        const auto ends = [](const std::string& text, const char* end) {
            return end != text.c_str() && (*end == '\0' || std::string(end) == ",");
        };
        const bool isPlace = isDrawn && ((word >= 3 && word <= 6) || word == 8 || word == 9);
        if (!ends(x, endX) || !ends(y, endY) ||
            !(std::abs(p - q) <= std::max(1e-3 * std::abs(p), isPlace ? 1.0 : 0.0)))
            return false;
    }
}

inline void compareWithRecord(const HeadlessWindow& window, const std::string& name) {
    const std::filesystem::path file = sourceFolder() / "tests/viewer/window/recorded" / (name + ".txt");
    if (std::getenv("TESSERA_RECORD")) {
        std::ofstream out(file);
        for (const std::string& line : window.lines())
            out << line << "\n";
        GTEST_SKIP() << "recorded " << file;
    }
    std::ifstream in(file);
    std::vector<std::string> recorded;
    for (std::string line; std::getline(in, line);)
        recorded.push_back(line);
    const std::vector<std::string> found = window.lines();
    std::string step;
    int differences = 0;
    for (std::size_t i = 0; i < std::max(recorded.size(), found.size()) && differences < 8; ++i) {
        const std::string was = i < recorded.size() ? recorded[i] : "nothing",
                          is = i < found.size() ? found[i] : "nothing";
        if (was.starts_with("> "))
            step = was;
        if (alike(was, is))
            continue;
        ADD_FAILURE() << step << "\nrecorded " << was << "\nfound    " << is;
        ++differences;
    }
    if (differences > 0)
        ADD_FAILURE() << "if that is meant: TESSERA_RECORD=1 writes " << file << " anew";
}

} // namespace tessera::test
