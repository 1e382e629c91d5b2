// viewer/window/run_window.cpp: see run_window.h: GLFW, ImGui and the loop. A frame is drawn when something
// happened: an event, news from the viewing, or something that moves on its own. Between frames the thread
// sleeps.
#include "viewer/window/run_window.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/output_file.h"
#include "viewer/window/beside.h"
#include "viewer/window/cut_handles.h"
#include "viewer/window/endoscopy.h"
#include "viewer/window/opener.h"
#include "viewer/window/overlays.h"
#include "viewer/window/panels.h"
#include "viewer/window/picture_view.h"
#include "viewer/window/script.h"
#include "viewer/window/slice_panel.h"
#include "viewer/window/tools.h"
#include "viewer/window/window_state.h"

#include <algorithm>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <cmath>
#include <cstring>
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

constexpr double kAwakeSeconds = 1.0 / 60, kDozingSeconds = 0.1;
constexpr int kFramesAfterEvent = 3; // ImGui answers some events a frame late
constexpr const char* kFonts[] = {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                  "/usr/share/fonts/TTF/DejaVuSans.ttf",
                                  "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf"};

std::string lastGlfwProblem;
void onProblem(int, const char* words) {
    lastGlfwProblem = words;
}

/// GLFW as long as it lives.
struct Glfw {
    Glfw() {
        glfwSetErrorCallback(onProblem);
        if (!glfwInit())
            throw Error("no window can be opened: " + lastGlfwProblem +
                        " (tessera render draws pictures without a display)");
    }
    ~Glfw() { glfwTerminate(); }
};

/// Input of events for the next frame.
struct Events {
    int framesOwed = kFramesAfterEvent;
    std::vector<fs::path> dropped;
    struct Key {
        int key = 0, modifiers = 0;
    };
    /// In order; kept here because ImGui forgets a key that goes up again before the next frame.
    std::vector<Key> pressed;
};

class Window {
  public:
    Window(const glm::ivec2& size, Events& events) {
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
        // Reports a reset of the graphics device, where supported.
        glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
        window_ = glfwCreateWindow(size.x, size.y, "Tessera", nullptr, nullptr);
        tellsResets_ = window_ != nullptr;
        if (!window_) {
            glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_NO_ROBUSTNESS);
            window_ = glfwCreateWindow(size.x, size.y, "Tessera", nullptr, nullptr);
        }
        if (!window_)
            throw Error("no window can be opened: " + lastGlfwProblem);
        glfwMakeContextCurrent(window_);
        tellsResets_ = tellsResets_ && epoxy_has_gl_extension("GL_ARB_robustness");
        glfwSwapInterval(1);
        float scale = 1, ignored = 1;
        glfwGetWindowContentScale(window_, &scale, &ignored);
        if (const int wide = this->size().x; wide > 0) // the part of the scale that the system does not apply
            perUnit_ = std::max(1.0, static_cast<double>(scale) * wide / std::max(1, framebuffer().x));
        glfwSetWindowUserPointer(window_, &events);
        const auto owed = [](GLFWwindow* w) {
            static_cast<Events*>(glfwGetWindowUserPointer(w))->framesOwed = kFramesAfterEvent;
        };
        static const auto note = owed;
        glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double, double) { note(w); });
        glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int, int, int) { note(w); });
        glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double) { note(w); });
        glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int modifiers) {
            note(w);
            if (action == GLFW_PRESS)
                static_cast<Events*>(glfwGetWindowUserPointer(w))->pressed.push_back({key, modifiers});
        });
        glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned) { note(w); });
        glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* w, int, int) { note(w); });
        glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { note(w); });
        glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
            note(w);
            for (int i = 0; i < count; ++i)
                static_cast<Events*>(glfwGetWindowUserPointer(w))->dropped.emplace_back(paths[i]);
        });
    }
    ~Window() { glfwDestroyWindow(window_); }
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    GLFWwindow* get() const { return window_; }
    glm::ivec2 framebuffer() const {
        glm::ivec2 size(0);
        glfwGetFramebufferSize(window_, &size.x, &size.y);
        return size;
    }
    /// In units of the same size on every display. Some systems use such units; others use pixels, several
    /// per unit on a high-resolution display.
    glm::ivec2 size() const {
        glm::ivec2 size(0);
        glfwGetWindowSize(window_, &size.x, &size.y);
        return glm::ivec2(glm::round(glm::dvec2(size) / perUnit_));
    }
    void resize(const glm::ivec2& units) {
        const glm::ivec2 size(glm::round(glm::dvec2(units) * perUnit_));
        glfwSetWindowSize(window_, size.x, size.y);
    }
    /// True if the GL context is lost: its objects are gone, and it cannot draw any more.
    bool isLost() const { return tellsResets_ && glGetGraphicsResetStatusARB() != GL_NO_ERROR; }
    /// System coordinates per unit, also for the pointer.
    double perUnit() const { return perUnit_; }

  private:
    GLFWwindow* window_;
    double perUnit_ = 1;
    bool tellsResets_ = false;
};

/// ImGui on that window; after its callbacks were set, which ImGui calls too.
struct Gui {
    explicit Gui(const Window& window) {
        IMGUI_CHECKVERSION();
        ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        const glm::ivec2 size = window.size(), pixels = window.framebuffer();
        const float pixelsPerUnit =
            size.x > 0 ? static_cast<float>(pixels.x) / static_cast<float>(size.x) : 1;
        std::error_code ignored;
        for (const char* font : kFonts)
            if (fs::exists(font, ignored)) {
                io.Fonts->AddFontFromFileTTF(font, 14 * pixelsPerUnit);
                io.FontGlobalScale = 1 / pixelsPerUnit;
                break;
            }
        ImGui::StyleColorsDark();
        ImGui::GetStyle().WindowBorderSize = 0;
        ImGui_ImplGlfw_InitForOpenGL(window.get(), true);
        ImGui_ImplOpenGL3_Init("#version 330 core");
#if IMGUI_VERSION_NUM >= 18700 // from here on ImGui gets the pointer's position from events
        static double perUnit = 1;
        perUnit = window.perUnit();
        glfwSetCursorPosCallback(window.get(), [](GLFWwindow* w, double x, double y) {
            ImGui_ImplGlfw_CursorPosCallback(w, x / perUnit, y / perUnit); // also calls the window's callback
        });
#endif
    }
    /// Before each frame.
    /// @param hand  replaces the user's input
    static void begin(const Window& window, const std::optional<ScriptedHand>& hand) {
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        const glm::vec2 size(window.size()), pixels(window.framebuffer());
        ImGuiIO& io = ImGui::GetIO();
        io.DisplaySize = {size.x, size.y};
        if (size.x > 0 && size.y > 0)
            io.DisplayFramebufferScale = {pixels.x / size.x, pixels.y / size.y};
#if IMGUI_VERSION_NUM < 18700
        if (ImGui::IsMousePosValid(&io.MousePos)) {
            io.MousePos.x /= static_cast<float>(window.perUnit());
            io.MousePos.y /= static_cast<float>(window.perUnit());
        }
#endif
        if (hand) {
            const ImVec2 at(static_cast<float>(hand->at.x), static_cast<float>(hand->at.y));
#if IMGUI_VERSION_NUM < 18700
            io.MousePos = at;
            io.MouseDown[0] = hand->down;
            io.MouseWheel += static_cast<float>(hand->wheel);
#else
            io.AddMousePosEvent(at.x, at.y);
            io.AddMouseButtonEvent(0, hand->down);
            io.AddMouseWheelEvent(0, static_cast<float>(hand->wheel));
#endif
        }
        ImGui::NewFrame();
    }
    ~Gui() {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
};

/// The window as it is shown, as PPM: a few lines, and no library for a picture that is only looked at.
void capture(const Window& window, const fs::path& path) {
    const glm::ivec2 size = window.framebuffer();
    const auto row = static_cast<std::size_t>(size.x) * 3;
    std::vector<unsigned char> pixels(row * static_cast<std::size_t>(size.y));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.x, size.y, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    std::string text = "P6\n" + std::to_string(size.x) + " " + std::to_string(size.y) + "\n255\n";
    for (int y = size.y - 1; y >= 0; --y)
        text.append(reinterpret_cast<const char*>(&pixels[static_cast<std::size_t>(y) * row]), row);
    writeOutputFile(path, text);
}

/// Textures, buffers, programs and framebuffers that exist; names are small numbers.
int countGlObjects() {
    constexpr GLuint kMostNames = 4096;
    int count = 0;
    for (GLuint name = 1; name < kMostNames; ++name)
        count += glIsTexture(name) + glIsBuffer(name) + glIsProgram(name) + glIsFramebuffer(name) +
                 glIsVertexArray(name);
    return count;
}

/// All that belongs to a GL context.
struct Screen {
    Screen(const glm::ivec2& size, Events& events) : window(size, events), gui(window) {}
    Window window;
    Gui gui;
    PictureTexture texture, beside;
    SlicePanel slices;
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
    /// Of which a hand at the pointer moves the camera.
    Area areaUnderPointer(const Area& picture) const {
        return beside_ && ImGui::GetIO().MousePos.x >= besideOf(picture).from.x ? besideOf(picture) : picture;
    }

    /// Draws the parts right of the pictures.
    Area slicesBeside(const Area& picture) const {
        Area area = picture;
        area.from.x = picture.from.x + picture.size.x * (beside_ ? 2 : 1) + 2;
        area.size.x = screen_->window.size().x - area.from.x;
        return area;
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
        moves_ = (planes && screen_->slices.divide(desk_, area, slicesBeside(area))) ||
                 tools_.handle(desk_, area) || endoscopy_.handle(desk_, area) || cuts_.handle(desk_, area) ||
                 hand_.handle(desk_, areaUnderPointer(area)) || flies;
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
            drawBeside(*beside_, desk_, besideOf(area));
        }
        drawOverlays(desk_, area, hand_);
        tools_.draw(desk_, area);
        cuts_.draw(desk_, area);
        endoscopy_.draw(desk_, area);
        if (planes)
            screen_->slices.draw(desk_, tools_, endoscopy_, slicesBeside(area));
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
            capture(screen_->window, *std::exchange(toCapture_, {}));
        glfwSwapBuffers(screen_->window.get());
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
