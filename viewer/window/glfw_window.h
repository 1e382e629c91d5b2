// viewer/window/glfw_window.h: the window of the system, by GLFW, with ImGui in it: events, sizes in units
// that are the same on every display, and what is shown as a file.
#pragma once

#include "viewer/window/script.h" // ScriptedHand

#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>
#include <vector>

struct GLFWwindow;

namespace tessera {

/// ImGui answers some events a frame late.
constexpr int kFramesAfterEvent = 3;

/// GLFW as long as it lives. Throws Error if no window can be opened.
struct Glfw {
    Glfw();
    ~Glfw();
    Glfw(const Glfw&) = delete;
    Glfw& operator=(const Glfw&) = delete;
};

/// Input of events for the next frame.
struct Events {
    int framesOwed = kFramesAfterEvent;
    std::vector<std::filesystem::path> dropped;
    struct Key {
        int key = 0, modifiers = 0;
    };
    /// In order; kept here because ImGui forgets a key that goes up again before the next frame.
    std::vector<Key> pressed;
};

class Window {
  public:
    /// Throws Error if it cannot be opened. Its GL context is current. events outlive it.
    Window(const glm::ivec2& size, Events& events);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    GLFWwindow* get() const { return window_; }
    glm::ivec2 framebuffer() const;
    /// In units of the same size on every display. Some systems use such units; others use pixels, several
    /// per unit on a high-resolution display.
    glm::ivec2 size() const;
    void resize(const glm::ivec2& units);
    /// True if the GL context is lost: its objects are gone, and it cannot draw any more.
    bool isLost() const;
    /// System coordinates per unit, also for the pointer.
    double perUnit() const { return perUnit_; }
    /// The window as it is shown, as PPM: a few lines, and no library for a picture that is only looked at.
    void capture(const std::filesystem::path& path) const;

  private:
    GLFWwindow* window_;
    double perUnit_ = 1;
    bool tellsResets_ = false;
};

/// ImGui on that window; after its callbacks were set, which ImGui calls too.
struct Gui {
    explicit Gui(const Window& window);
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;
    /// Before each frame.
    /// @param hand  replaces the user's input
    static void begin(const Window& window, const std::optional<ScriptedHand>& hand);
};

/// Textures, buffers, programs and framebuffers that exist; names are small numbers.
int countGlObjects();

} // namespace tessera
