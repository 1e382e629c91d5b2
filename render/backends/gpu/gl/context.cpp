// render/backends/gpu/gl/context.cpp: see context.h. The core name eglGetPlatformDisplay aborts inside
// libepoxy before a display is initialised, so the EXT name is used throughout.
#include "render/backends/gpu/gl/context.h"

#include "core/base/error.h"

#include <charconv>
#include <cstring>
#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <filesystem>
#include <system_error>

namespace tessera {
namespace {

/// False where the system lacks libraries that libepoxy loads: it would end the program over one.
bool hasGlLibraries() {
    static const bool has = [] {
        const auto loads = [](const char* name) { return ::dlopen(name, RTLD_LAZY | RTLD_LOCAL) != nullptr; };
        return loads("libEGL.so.1") && (loads("libOpenGL.so.0") || loads("libGL.so.1"));
    }();
    return has;
}

std::vector<EGLDeviceEXT> queryDevices() {
    if (!hasGlLibraries())
        return {};
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!client || !std::strstr(client, "EGL_EXT_device_enumeration"))
        return {};
    EGLint count = 0;
    if (!eglQueryDevicesEXT(0, nullptr, &count) || count <= 0)
        return {};
    std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
    eglQueryDevicesEXT(count, devices.data(), &count);
    devices.resize(static_cast<std::size_t>(count));
    return devices;
}

std::string deviceExtensions(EGLDeviceEXT device) {
    const char* text = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
    return text ? text : "";
}

bool isSoftware(const std::string& extensions) {
    return extensions.find("EGL_MESA_device_software") != std::string::npos;
}

EGLDisplay initialised(EGLDisplay display) {
    return display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) ? display : EGL_NO_DISPLAY;
}

bool isWord(const std::string& choice) {
    return choice == "auto" || choice == "software";
}

/// Of a choice that is no word. Throws InputError where there is no such device.
std::size_t deviceNumber(const std::string& choice, std::size_t devices) {
    std::size_t number = 0;
    const auto [end, code] = std::from_chars(choice.data(), choice.data() + choice.size(), number);
    if (code != std::errc{} || end != choice.data() + choice.size() || number >= devices)
        throw InputError("--gl-device: expected auto, software or a number below " + std::to_string(devices) +
                         ", found '" + choice + "'");
    return number;
}

/// Displays to try, in order. A number gives its device alone; auto puts GPUs before software.
std::vector<EGLDisplay> candidates(const std::string& choice) {
    const std::vector<EGLDeviceEXT> devices = queryDevices();
    const auto open = [](EGLDeviceEXT device) {
        return initialised(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
    };
    if (!isWord(choice))
        return {open(devices[deviceNumber(choice, devices.size())])};
    if (!hasGlLibraries())
        return {};
    std::vector<EGLDisplay> displays;
    for (const bool software : {false, true})
        for (EGLDeviceEXT device : devices)
            if (isSoftware(deviceExtensions(device)) == software && (software || choice == "auto"))
                displays.push_back(open(device));
    // No enumeration: Mesa without a surface, which is llvmpipe on a machine without a GPU.
    displays.push_back(
        initialised(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)));
    return displays;
}

/// A current GL 4.5 core context without a surface and without a config, or EGL_NO_CONTEXT.
EGLContext currentContext(EGLDisplay display) {
    if (display == EGL_NO_DISPLAY || !eglBindAPI(EGL_OPENGL_API))
        return EGL_NO_CONTEXT;
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    EGLContext context = eglCreateContext(display, nullptr, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT)
        return EGL_NO_CONTEXT;
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
        return context;
    eglDestroyContext(display, context);
    return EGL_NO_CONTEXT;
}

void GLAPIENTRY onDebugMessage(GLenum, GLenum, GLuint, GLenum severity, GLsizei, const GLchar* message,
                               const void* user) {
    if (severity != GL_DEBUG_SEVERITY_HIGH)
        return;
    static_cast<std::vector<std::string>*>(const_cast<void*>(user))->emplace_back(message);
}

} // namespace

std::vector<GlDevice> listGlDevices() {
    std::vector<GlDevice> out;
    for (EGLDeviceEXT device : queryDevices()) {
        const std::string extensions = deviceExtensions(device);
        out.push_back({static_cast<int>(out.size()), isSoftware(extensions), extensions});
    }
    return out;
}

bool mayHaveGpu() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator("/dev/dri", ignored))
        if (entry.path().filename().string().starts_with("renderD"))
            return true;
    return fs::exists("/dev/nvidia0", ignored) || fs::exists("/dev/dxg", ignored) || // of Windows below
           fs::exists("/dev/kgsl-3d0", ignored);
}

void checkGlDevice(const GlDeviceChoice& choice) {
    if (!isWord(choice.text))
        deviceNumber(choice.text, queryDevices().size());
}

bool isSoftwareRenderer(std::string_view renderer) {
    return renderer.find("llvmpipe") != std::string_view::npos ||
           renderer.find("softpipe") != std::string_view::npos;
}

GlContext::GlContext(const GlDeviceChoice& choice) {
    for (EGLDisplay display : candidates(choice.text)) {
        display_ = display;
        context_ = currentContext(display);
        if (context_ != EGL_NO_CONTEXT)
            break;
    }
    if (context_ == EGL_NO_CONTEXT)
        throw Error("EGL: no OpenGL 4.5 core context for --gl-device " + choice.text +
                    "; install libegl1 and libgl1-mesa-dri for software rendering");
    renderer_ = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    version_ = reinterpret_cast<const char*>(glGetString(GL_VERSION));
    software_ = isSoftwareRenderer(renderer_);
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &max3dTextureSize_);
    GLint64 block = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    maxStorageBlockBytes_ = block;
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(onDebugMessage, errors_.get());
    const bool numbered = choice.text != "auto" && choice.text != "software";
    const auto devices = listGlDevices();
    if (numbered && software_ && !devices[static_cast<std::size_t>(std::stoi(choice.text))].software)
        throw Error("EGL: device " + choice.text + " was asked for, but the driver gave " + renderer_);
}

GlContext::~GlContext() {
    if (!context_)
        return;
    glDebugMessageCallback(nullptr, nullptr);
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
}

} // namespace tessera
