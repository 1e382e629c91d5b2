// viewer/window/run_window.cpp: see run_window.h: the loop. A frame is drawn when something happened: an
// event, news from the viewing, or something that moves on its own. Between frames the thread sleeps.
#include "viewer/window/run_window.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "viewer/window/beside.h"
#include "viewer/window/cut_handles.h"
#include "viewer/window/endoscopy.h"
#include "viewer/window/glfw_window.h"
#include "viewer/window/opener.h"
#include "viewer/window/overlays.h"
#include "viewer/window/panels.h"
#include "viewer/window/picture_view.h"
#include "viewer/window/script.h"
#include "viewer/window/slice_panel.h"
#include "viewer/window/tools.h"
#include "viewer/window/window_state.h"

#include <algorithm>
#include <backends/imgui_impl_opengl3.h>
#include <cmath>
#include <cstdint>
#include <epoxy/gl.h> // before GLFW, which would include GL's own
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Of the width beside the panel, where there are two scans.
constexpr double kSharedByPlanes = 0.4;
constexpr double kAwakeSeconds = 1.0 / 60, kDozingSeconds = 0.1;

/// All that belongs to a GL context.
struct Screen {
    Screen(const glm::ivec2& size, Events& events) : window(size, events), gui(window) {}
    Window window;
    Gui gui;
    PictureTexture texture, beside;
    SlicePanel slices, slicesOfBeside;
    Opener opener;
};

class Loop {
  public:
    Loop(const WindowOptions& options, Settings& settings)
        : settings_(settings), screen_(std::in_place, startSize(options, settings), events_),
          viewing_(options.makeViewing([] { glfwPostEmptyEvent(); })),
          desk_(*viewing_, settings, options.presets),
          script_(options.script ? Script(*options.script) : Script()) {
        desk_.showPanels = options.panels && settings.panels;
        if (!options.path.empty())
            toOpen_ = options.path;
        if (!options.beside.empty())
            beside_.emplace(options.makeViewing([] { glfwPostEmptyEvent(); }), options.beside);
        if (beside_) {
            desk_.setBeside(&*beside_);
            desk_.setPlanesShare(kSharedByPlanes);
        }
    }

    void run() {
        while (!glfwWindowShouldClose(screen_->window.get())) {
            checkInterrupted();
            frame();
            if (screen_->window.isLost() || std::exchange(loseContext_, false))
                beginAnew();
            sleep();
        }
        settings_.windowSize = screen_->window.size();
        settings_.panels = desk_.showPanels;
    }

  private:
    /// The session, which has no context of this kind, goes on.
    void beginAnew() {
        const glm::ivec2 size = screen_->window.size();
        screen_.reset();
        screen_.emplace(size, events_);
        events_.framesOwed = kFramesAfterEvent;
        title_.clear();
        desk_.tell("the graphics device was reset; the window has restarted");
    }

    static glm::ivec2 startSize(const WindowOptions& options, const Settings& settings) {
        const bool remembers = settings.windowSize.x > 0 && !options.script;
        return options.size ? *options.size
               : remembers  ? settings.windowSize
                            : glm::ivec2(WindowOptions::kFirstSize[0], WindowOptions::kFirstSize[1]);
    }

    /// @param opens  the area after a volume has been opened
    Area pictureArea(bool opens = false) const {
        const glm::ivec2 size = screen_->window.size(), pixels = screen_->window.framebuffer();
        Area area;
        const double panels = desk_.showPanels ? static_cast<double>(Panels::kWidth) : 0.0;
        area.from = {std::min(panels, size.x - 1.0), 0};
        area.size = glm::dvec2(size) - area.from;
        if (desk_.showSlices && (desk_.volume() || opens))
            area.size.x = std::max(1.0, std::floor(area.size.x * (1 - desk_.planesShare())));
        if (beside_)
            area.size.x = std::max(1.0, std::floor(area.size.x / 2));
        area.pixelsPerUnit = size.x > 0 ? static_cast<double>(pixels.x) / size.x : 1;
        return area;
    }

    /// Of the other scan, as large as the picture.
    static Area besideOf(const Area& picture) {
        Area area = picture;
        area.from.x += picture.size.x;
        return area;
    }
    /// Whether a hand is at the other scan's picture, and not at the first.
    bool isBesideUnderPointer(const Area& picture) const {
        return beside_ && static_cast<double>(ImGui::GetIO().MousePos.x) >= besideOf(picture).from.x;
    }
    /// Of both pictures.
    Area pictures(const Area& picture) const {
        Area area = picture;
        area.size.x *= beside_ ? 2 : 1;
        return area;
    }

    /// Draws the parts right of the pictures.
    Area slicesBeside(const Area& picture) const {
        Area area = picture;
        area.from.x = picture.from.x + pictures(picture).size.x + 2;
        area.size.x = screen_->window.size().x - area.from.x;
        return area;
    }
    /// The planes of both scans side by side.
    void drawSlices(const Area& area) {
        Area part = area;
        if (beside_)
            part.size.x = std::floor(area.size.x / 2);
        screen_->slices.draw(desk_, tools_, endoscopy_, part);
        if (!beside_)
            return;
        part.from.x += part.size.x;
        screen_->slicesOfBeside.drawBeside(desk_, *beside_, part);
    }

    void frame() {
        Gui::begin(screen_->window, std::exchange(scriptedHand_, {}));
        const glm::ivec2 pixels = screen_->window.framebuffer();
        const Area area = pictureArea();
        if (pixels.x > 0 && pixels.y > 0) // while a volume is being opened: the size of its first picture
            desk_.setPictureSize(pictureArea(true).pixels());
        if (toOpen_)
            desk_.open(*std::exchange(toOpen_, {}));
        for (const fs::path& path : std::exchange(events_.dropped, {}))
            desk_.open(path);
        desk_.update();
        const bool flies = endoscopy_.advance(desk_);
        const bool planes = desk_.showSlices && desk_.volume();
        moves_ = (planes && screen_->slices.divide(desk_, pictures(area), slicesBeside(area))) ||
                 tools_.handle(desk_, area) || endoscopy_.handle(desk_, area) || cuts_.handle(desk_, area) ||
                 handOnPicture(area) || flies;
        for (const Events::Key& key : std::exchange(events_.pressed, {}))
            if (!ImGui::GetIO().WantTextInput)
                press(key);
        scripted_ = script_.advance(desk_, endoscopy_,
                                    {[this](const glm::ivec2& size) { screen_->window.resize(size); },
                                     [this](const fs::path& path) { toCapture_ = path; },
                                     [this] { glfwSetWindowShouldClose(screen_->window.get(), GLFW_TRUE); },
                                     countGlObjects, [this] { loseContext_ = true; },
                                     [this](const ScriptedHand& hand) { scriptedHand_ = hand; },
                                     [this](int key, bool shift) {
                                         events_.pressed.push_back({key, shift ? GLFW_MOD_SHIFT : 0});
                                     }});
        waits_ = desk_.settle();
        if (beside_)
            beside_->update(desk_, area.pixels());
        nameWindow();
        drawPicture(screen_->texture, *viewing_, area);
        if (beside_) {
            drawPicture(screen_->beside, beside_->viewing(), besideOf(area));
            drawBeside(*beside_, desk_, besideOf(area), hand_);
        }
        drawOverlays(desk_, area, hand_);
        tools_.draw(desk_, area);
        cuts_.draw(desk_, area);
        endoscopy_.draw(desk_, area);
        if (planes)
            drawSlices(slicesBeside(area));
        endoscopy_.drawQuestion(desk_, area);
        panels_.draw(desk_, tools_, cuts_, endoscopy_, static_cast<float>(screen_->window.size().y));
        screen_->opener.draw(desk_, area);
        drawHelp(desk_);
        ImGui::Render();
        glViewport(0, 0, pixels.x, pixels.y);
        glClearColor(0.055f, 0.058f, 0.066f, 1);
        glClear(GL_COLOR_BUFFER_BIT);
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        if (toCapture_)
            screen_->window.capture(*std::exchange(toCapture_, {}));
        glfwSwapBuffers(screen_->window.get());
    }

    bool handOnPicture(const Area& area) {
        if (isBesideUnderPointer(area) && beside_->volume())
            return hand_.handle(desk_, besideOf(area), &*beside_);
        return hand_.handle(desk_, isBesideUnderPointer(area) ? besideOf(area) : area);
    }

    void press(const Events::Key& key) {
        const bool control = (key.modifiers & GLFW_MOD_CONTROL) != 0,
                   shift = (key.modifiers & GLFW_MOD_SHIFT) != 0;
        if (control && key.key == GLFW_KEY_Q)
            glfwSetWindowShouldClose(screen_->window.get(), GLFW_TRUE);
        else if (shift && key.key == GLFW_KEY_SLASH)
            desk_.showHelp = !desk_.showHelp;
        else if (control && key.key == GLFW_KEY_O)
            desk_.showBrowser = !desk_.showBrowser;
        else if (key.key == GLFW_KEY_F12)
            desk_.savePicture();
        else if (key.key == GLFW_KEY_ESCAPE)
            tools_.stop(), endoscopy_.stop(desk_);
        else if (key.key == GLFW_KEY_L)
            desk_.showLevels = !desk_.showLevels;
        else if (key.key == GLFW_KEY_X)
            desk_.showSlices = !desk_.showSlices;
        else if (key.key == GLFW_KEY_TAB)
            desk_.showPanels = !desk_.showPanels;
        else if (control || (!endoscopy_.press(desk_, key.key, shift) && !pressTool(key.key, shift)))
            hand_.press(desk_, key.key, control, shift);
    }

    bool pressTool(int key, bool shift) {
        using Tool = Tools::Tool;
        if (!desk_.volume() || desk_.flying)
            return false;
        if (key == GLFW_KEY_M)
            tools_.take(Tool::distance);
        else if (key == GLFW_KEY_G)
            tools_.take(Tool::angle);
        else if (key == GLFW_KEY_C)
            tools_.take(Tool::circle);
        else if (key == GLFW_KEY_K)
            tools_.take(shift ? Tool::scissorsInside : Tool::scissorsOutside);
        else if (key == GLFW_KEY_COMMA || key == GLFW_KEY_PERIOD)
            desk_.stepPhase(key == GLFW_KEY_COMMA ? -1 : 1);
        else if (key == GLFW_KEY_B)
            cuts_.toggleBox(desk_);
        else if (key == GLFW_KEY_N)
            cuts_.addPlane(desk_);
        else
            return false;
        return true;
    }

    static void drawPicture(PictureTexture& texture, const Viewing& viewing, const Area& area) {
        const std::shared_ptr<const ShownPicture> picture = viewing.picture();
        texture.show(picture);
        if (!picture || texture.size().x == 0)
            return;
        // A picture of another size is centred with its own aspect ratio until one of this size exists.
        const glm::dvec2 size = glm::dvec2(texture.size()) / area.pixelsPerUnit;
        const double fits = std::min(area.size.x / size.x, area.size.y / size.y);
        const glm::dvec2 shown = texture.size() == area.pixels() ? area.size : size * fits;
        const glm::dvec2 from = area.from + 0.5 * (area.size - shown);
        ImGui::GetBackgroundDrawList()->AddImage(
            reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture.name())),
            {static_cast<float>(from.x), static_cast<float>(from.y)},
            {static_cast<float>(from.x + shown.x), static_cast<float>(from.y + shown.y)});
    }

    /// The open volume and the picture's quality: for lists of windows, and for programs that drive one.
    void nameWindow() {
        std::string title = "Tessera";
        if (const VolumeSeen* const volume = desk_.volume())
            title = volume->path.stem().string() + " - " + title;
        const ViewingState& s = desk_.state();
        if (s.kind == ViewingState::Kind::opening)
            title += " (opening)";
        else if (desk_.offers())
            title += " (choosing)";
        else if (s.atRest && desk_.hasAsked() && desk_.volume() && (!beside_ || beside_->atRest()))
            title += " (at rest)";
        if (title != title_)
            glfwSetWindowTitle(screen_->window.get(), title.c_str());
        title_ = title;
    }

    /// Sleeps until the next event.
    void sleep() {
        const bool opening = desk_.state().kind == ViewingState::Kind::opening;
        if (moves_ || events_.framesOwed > 0)
            glfwWaitEventsTimeout(events_.framesOwed > 0 ? 0.001 : kAwakeSeconds);
        else if (waits_ || scripted_ || opening || ImGui::GetIO().WantTextInput)
            glfwWaitEventsTimeout(scripted_ ? kAwakeSeconds : kDozingSeconds);
        else
            glfwWaitEvents();
        events_.framesOwed = std::max(0, events_.framesOwed - 1);
    }

    Settings& settings_;
    Events events_;
    std::optional<Screen> screen_;
    std::unique_ptr<Viewing> viewing_;
    std::optional<Beside> beside_;
    WindowState desk_;
    PictureHand hand_;
    Tools tools_;
    CutHandles cuts_;
    Endoscopy endoscopy_;
    Panels panels_;
    Script script_;
    std::optional<fs::path> toOpen_, toCapture_;
    std::string title_;
    std::optional<ScriptedHand> scriptedHand_;
    bool moves_ = false, waits_ = false, scripted_ = false;
    bool loseContext_ = false; // as if the device had been reset
};

} // namespace

void runWindow(const WindowOptions& options) {
    if (options.script)
        Script(*options.script); // a mistake is told before there is a window
    const fs::path file = options.script ? fs::path() : settingsFile();
    Settings settings = loadSettings(file);
    const Glfw glfw;
    Loop(options, settings).run();
    if (const std::string problem = saveSettings(settings, file); !problem.empty())
        throw Error(problem);
}

} // namespace tessera
