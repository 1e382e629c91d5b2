// tests/support/headless_window.h: the window's parts in one frame after another, without display,
// graphics and volume; a hand that finds what it clicks by its words; and what each step changed, as lines.
#pragma once

#include "tests/support/drawn_words.h"
#include "tests/support/pretended_viewing.h"
#include "viewer/window/beside.h"
#include "viewer/window/opener.h"
#include "viewer/window/overlays.h"
#include "viewer/window/panels.h"
#include "viewer/window/slice_panel.h"

#include <cmath>
#include <epoxy/gl.h>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <thread>

namespace tessera::test {

/// GL as far as the parts use it: textures have numbers, and nothing else happens.
inline void pretendGl() {
    static GLuint last = 100;
    last = 100;
    epoxy_glGenTextures = [](GLsizei n, GLuint* names) {
        for (int i = 0; i < n; ++i)
            names[i] = ++last;
    };
    epoxy_glDeleteTextures = [](GLsizei, const GLuint*) {};
    epoxy_glBindTexture = [](GLenum, GLuint) {};
    epoxy_glTexParameteri = [](GLenum, GLenum, GLint) {};
    epoxy_glPixelStorei = [](GLenum, GLint) {};
    epoxy_glTexImage2D = [](GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const void*) {};
    epoxy_glTexSubImage2D = [](GLenum, GLint, GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, const void*) {};
}

/// Numbers with six digits, so that the last bits of a double do not matter.
inline void roundNumbers(nlohmann::json& value) {
    if (value.is_number_float()) {
        char text[40];
        std::snprintf(text, sizeof text, "%.6g", value.get<double>() + 0.0);
        value = std::abs(value.get<double>()) < 1e-9 ? 0.0 : std::strtod(text, nullptr);
    } else if (value.is_structured()) {
        for (auto& part : value)
            roundNumbers(part);
    }
}

class HeadlessWindow {
    struct Gui {
        explicit Gui(const glm::ivec2& size) {
            pretendGl();
            ImGui::CreateContext();
            ImGuiIO& io = ImGui::GetIO();
            io.IniFilename = nullptr;
            io.DisplaySize = {static_cast<float>(size.x), static_cast<float>(size.y)};
            io.MousePos = {-50, -50};
            unsigned char* pixels = nullptr;
            int width = 0, height = 0;
            io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
            ImGui::StyleColorsDark();
            ImGui::GetStyle().WindowBorderSize = 0;
        }
        ~Gui() { ImGui::DestroyContext(); }
    };
    glm::ivec2 size_;
    Gui gui_;

  public:
    PretendedViewing viewing;
    Settings settings;
    PresetShelf presets;
    WindowState desk;
    PictureHand hand;
    Tools tools;
    CutHandles cuts;
    Endoscopy endoscopy;
    Panels panels;
    SlicePanel slices;
    Opener opener;
    Area area;
    std::function<bool(const Drawn&)> records = [](const Drawn&) { return true; };

    /// Another scan at the right of the picture.
    struct Second {
        PretendedViewing& viewing;
        Beside beside;
        Area area, planes;
        SlicePanel slices;
        Second(std::unique_ptr<PretendedViewing> own, const Area& picture, const Area& planesOf)
            : viewing(*own), beside(std::move(own), "/scans/later.zarr"), area(picture), planes(planesOf) {}
    };
    std::optional<Second> second;

    bool relative = false; // lines say how far below the one before things are

    /// @param picture  of the volume; the planes are right of it
    HeadlessWindow(const glm::ivec2& size, const Area& picture)
        : size_(size), gui_(size), desk(viewing, settings, presets), area(picture) {
        desk.setPictureSize(area.pixels());
        presets.names = [] { return std::vector<std::string>{"mine"}; };
    }

    /// @param by  the scan lies there; the planes are below the first ones
    PretendedViewing& addSecond(const glm::dvec3& by) {
        auto own = std::make_unique<PretendedViewing>();
        own->opened(area.pixels());
        own->seen->info.patientFromVoxel[3] += glm::dvec4(by, 0);
        own->drawn.reset();
        Area right = area;
        right.from.x += area.size.x;
        Area planes = right;
        planes.from += glm::dvec2(area.size.x + 2, area.size.y + 20);
        planes.size = {120, 300};
        second.emplace(std::move(own), right, planes);
        desk.setBeside(&second->beside);
        return second->viewing;
    }
    bool handOnPicture() {
        if (second && static_cast<double>(ImGui::GetIO().MousePos.x) >= second->area.from.x)
            return hand.handle(desk, second->area, &second->beside);
        return hand.handle(desk, area);
    }

    Area planesArea() const {
        Area beside = area;
        beside.from.x = area.from.x + (second ? 2 : 1) * area.size.x + 2;
        beside.size.x = size_.x - beside.from.x;
        return beside;
    }
    void frame(float seconds = 1.0f / 60) {
        ImGuiIO& io = ImGui::GetIO();
        io.DeltaTime = seconds;
        ImGui::NewFrame();
        desk.update();
        endoscopy.advance(desk);
        const bool planes = desk.showSlices && desk.volume();
        moves = (planes && slices.divide(desk, area, planesArea())) || tools.handle(desk, area) ||
                endoscopy.handle(desk, area) || cuts.handle(desk, area) || handOnPicture();
        viewing.draw();
        if (second) {
            second->beside.update(desk, area.pixels());
            second->viewing.draw();
            drawBeside(second->beside, desk, second->area, hand);
        }
        drawOverlays(desk, area, hand);
        tools.draw(desk, area);
        cuts.draw(desk, area);
        endoscopy.draw(desk, area);
        if (planes)
            slices.draw(desk, tools, endoscopy, planesArea());
        if (planes && second)
            second->slices.drawBeside(desk, second->beside, second->planes);
        endoscopy.drawQuestion(desk, area);
        panels.draw(desk, tools, cuts, endoscopy, static_cast<float>(size_.y));
        opener.draw(desk, area);
        drawHelp(desk);
        ImGui::Render();
        drawn = DrawnReader().read(*ImGui::GetDrawData());
        io.MouseWheel = 0;
    }
    bool moves = false; // a part took the last frame's mouse
    std::vector<Drawn> drawn;

    // The hand.
    void moveTo(const glm::dvec2& at) {
        ImGui::GetIO().MousePos = {static_cast<float>(at.x), static_cast<float>(at.y)};
        frame();
    }
    void button(int number, bool down) {
        ImGui::GetIO().MouseDown[number] = down;
        frame();
    }
    void click(const glm::dvec2& at, int number = 0) {
        moveTo(at);
        button(number, true);
        button(number, false);
        frame();
    }
    void drag(const glm::dvec2& from, const glm::dvec2& to, int number = 0) {
        moveTo(from);
        button(number, true);
        for (int n = 1; n <= 4; ++n)
            moveTo(from + (to - from) * (n / 4.0));
        button(number, false);
        frame();
    }
    void wheel(const glm::dvec2& at, double notches) {
        moveTo(at);
        ImGui::GetIO().MouseWheel = static_cast<float>(notches);
        frame();
        frame();
    }
    void type(const std::string& words) {
        for (const char c : words)
            ImGui::GetIO().AddInputCharacter(static_cast<unsigned>(c));
        frame();
    }
    /// The pointer leaves, and what comes next is no double click.
    void rest() {
        ImGui::GetIO().MousePos = {-50, -50};
        frame();
        frame(1);
        frame();
    }
    /// The middle of words that are drawn. "WORDS@2" are the second of them, "WORDS@0" the last.
    glm::dvec2 placeOf(std::string words) const {
        std::size_t number = 1;
        if (const auto at = words.rfind('@'); at != std::string::npos) {
            number = static_cast<std::size_t>(std::stoi(words.substr(at + 1)));
            words.resize(at);
        }
        std::vector<const Drawn*> found;
        for (const bool exact : {true, false})
            for (const Drawn& d : drawn)
                if (found.size() < 100 && (exact ? d.words == words : d.words.starts_with(words)) &&
                    !words.empty() && (exact || found.empty() || found.front()->words != words))
                    found.push_back(&d);
        if (found.empty() || number > found.size()) {
            ADD_FAILURE() << "no words \"" << words << "\" are drawn";
            return {-50, -50};
        }
        const Drawn& d = number == 0 ? *found.back() : *found[number - 1];
        return {std::floor((d.left + d.right) / 2), std::floor((d.top + d.bottom) / 2)};
    }
    bool shows(const std::string& words) const {
        return std::any_of(drawn.begin(), drawn.end(),
                           [&](const Drawn& d) { return d.words.find(words) != std::string::npos; });
    }
    void clickOn(const std::string& words) { click(placeOf(words)); }
    void dragOn(const std::string& words, double right) {
        const glm::dvec2 from = placeOf(words);
        drag(from, from + glm::dvec2(right, 0));
    }

    // Records.
    /// Does a step, and adds what it changed: what is drawn, asked for, and in the scene, and whether undo
    /// takes it back.
    /// @param leaves  the pointer, before it is looked at what is drawn
    void step(const std::string& name, const std::function<void()>& act, bool leaves = true) {
        if (texts_.empty())
            rest();
        const nlohmann::json before = scene();
        viewing.said.clear();
        const std::uint64_t shows = viewing.shows;
        act();
        if (leaves)
            rest();
        lines_.push_back("> " + name);
        const nlohmann::json after = scene();
        for (const auto& change : nlohmann::json::diff(before, after))
            lines_.push_back("scene: " + change.at("op").get<std::string>() + " " +
                             change.at("path").get<std::string>() + " " +
                             change.value("value", nlohmann::json()).dump());
        if (shows == viewing.shows && before != after)
            lines_.push_back("no picture is asked for");
        for (const std::string& words : viewing.said)
            lines_.push_back("asks: " + words);
        addDrawn();
        if (!desk.volume())
            return;
        nlohmann::json edited = before;
        edited["camera"] = after.value("camera", nlohmann::json());
        if (edited != after && desk.history().canUndo()) {
            const Scene now = desk.scene();
            desk.undo();
            const nlohmann::json back = scene();
            nlohmann::json onlyCamera = before;
            onlyCamera["camera"] = back.value("camera", nlohmann::json());
            lines_.push_back(back == onlyCamera ? "undo takes it back" : "undo takes something else back");
            desk.redo();
            desk.setScene(now, false);
        }
    }
    std::vector<std::string> lines() const { return lines_; }
    nlohmann::json scene() const {
        if (!desk.volume())
            return nlohmann::json::object();
        auto json = nlohmann::json::parse(sceneJson(desk.scene()));
        roundNumbers(json);
        return json;
    }

  private:
    void addDrawn() {
        std::vector<std::string> now;
        const Drawn* above = nullptr;
        for (const Drawn& d : drawn)
            if (records(d) && d.words.find(" a second, ") == std::string::npos &&
                d.words.find("half within") == std::string::npos) // times
                now.push_back(d.text(relative ? std::exchange(above, &d) : nullptr));
        std::map<std::string, int> count;
        for (const std::string& text : now)
            ++count[text];
        for (const std::string& text : texts_)
            if (count[text]-- <= 0)
                lines_.push_back("- " + text);
        count.clear();
        for (const std::string& text : texts_)
            ++count[text];
        for (const std::string& text : now)
            if (count[text]-- <= 0)
                lines_.push_back("+ " + text);
        texts_ = now;
    }
    std::vector<std::string> texts_, lines_;
};

} // namespace tessera::test
