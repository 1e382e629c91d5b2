// viewer/window/glfw_window.cpp: see glfw_window.h.
#include "viewer/window/glfw_window.h"

#include "core/base/error.h"
#include "core/base/output_file.h"

#include <algorithm>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <cstddef>
#include <epoxy/gl.h> // before GLFW, which would include GL's own
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <glm/common.hpp>
#include <imgui.h>
#include <string>
#include <system_error>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFonts[] = {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                  "/usr/share/fonts/TTF/DejaVuSans.ttf",
                                  "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf"};

std::string lastGlfwProblem;
void onProblem(int, const char* words) {
    lastGlfwProblem = words;
}

} // namespace

Glfw::Glfw() {
    glfwSetErrorCallback(onProblem);
    if (!glfwInit())
        throw Error("no window can be opened: " + lastGlfwProblem +
                    " (tessera render draws pictures without a display)");
}

Glfw::~Glfw() {
    glfwTerminate();
}

Window::Window(const glm::ivec2& size, Events& events) {
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

Window::~Window() {
    glfwDestroyWindow(window_);
}

glm::ivec2 Window::framebuffer() const {
    glm::ivec2 size(0);
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return size;
}

glm::ivec2 Window::size() const {
    glm::ivec2 size(0);
    glfwGetWindowSize(window_, &size.x, &size.y);
    return glm::ivec2(glm::round(glm::dvec2(size) / perUnit_));
}

void Window::resize(const glm::ivec2& units) {
    const glm::ivec2 size(glm::round(glm::dvec2(units) * perUnit_));
    glfwSetWindowSize(window_, size.x, size.y);
}

bool Window::isLost() const {
    return tellsResets_ && glGetGraphicsResetStatusARB() != GL_NO_ERROR;
}

void Window::capture(const fs::path& path) const {
    const glm::ivec2 size = framebuffer();
    const auto row = static_cast<std::size_t>(size.x) * 3;
    std::vector<unsigned char> pixels(row * static_cast<std::size_t>(size.y));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.x, size.y, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    std::string text = "P6\n" + std::to_string(size.x) + " " + std::to_string(size.y) + "\n255\n";
    for (int y = size.y - 1; y >= 0; --y)
        text.append(reinterpret_cast<const char*>(&pixels[static_cast<std::size_t>(y) * row]), row);
    writeOutputFile(path, text);
}

Gui::Gui(const Window& window) {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    const glm::ivec2 size = window.size(), pixels = window.framebuffer();
    const float pixelsPerUnit = size.x > 0 ? static_cast<float>(pixels.x) / static_cast<float>(size.x) : 1;
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

void Gui::begin(const Window& window, const std::optional<ScriptedHand>& hand) {
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

Gui::~Gui() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

int countGlObjects() {
    constexpr GLuint kMostNames = 4096;
    int count = 0;
    for (GLuint name = 1; name < kMostNames; ++name)
        count += glIsTexture(name) + glIsBuffer(name) + glIsProgram(name) + glIsFramebuffer(name) +
                 glIsVertexArray(name);
    return count;
}

} // namespace tessera
