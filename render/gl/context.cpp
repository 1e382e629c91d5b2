// render/gl/context.cpp: see context.h. The core name eglGetPlatformDisplay aborts inside libepoxy before a
// display is initialised, so the EXT name is used throughout.
#include "render/gl/context.h"

#include "core/error.h"

#include <charconv>
#include <cstring>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

namespace tessera {
namespace {

std::vector<EGLDeviceEXT> queryDevices() {
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!client || !std::strstr(client, "EGL_EXT_device_enumeration")) return {};
    EGLint count = 0;
    if (!eglQueryDevicesEXT(0, nullptr, &count) || count <= 0) return {};
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

/// A device without any extension of a real GPU or of software is Mesa's placeholder for a card without driver.
EGLDisplay displayOf(const std::vector<EGLDeviceEXT>& devices, const std::string& choice) {
    const auto open = [](EGLDeviceEXT device) -> EGLDisplay {
        EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
        return display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) ? display : EGL_NO_DISPLAY;
    };
    int number = -1;
    const auto [end, code] = std::from_chars(choice.data(), choice.data() + choice.size(), number);
    if (choice != "auto" && choice != "software") {
        if (code != std::errc{} || end != choice.data() + choice.size() || number < 0 ||
            static_cast<std::size_t>(number) >= devices.size())
            throw InputError("--gl-device: expected auto, software or a number below " +
                             std::to_string(devices.size()) + ", found '" + choice + "'");
        return open(devices[static_cast<std::size_t>(number)]);
    }
    for (const bool software : {false, true}) {
        if (!software && choice == "software") continue;
        for (EGLDeviceEXT device : devices) {
            if (isSoftware(deviceExtensions(device)) != software) continue;
            if (EGLDisplay display = open(device); display != EGL_NO_DISPLAY) return display;
        }
    }
    // No enumeration: Mesa without a surface, which is llvmpipe on a machine without a GPU.
    EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    return display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) ? display : EGL_NO_DISPLAY;
}

void GLAPIENTRY onDebugMessage(GLenum, GLenum, GLuint, GLenum severity, GLsizei, const GLchar* message,
                               const void* user) {
    if (severity != GL_DEBUG_SEVERITY_HIGH) return;
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

GlContext::GlContext(const GlDeviceChoice& choice) {
    display_ = displayOf(queryDevices(), choice.text);
    if (display_ == EGL_NO_DISPLAY)
        throw Error("EGL: no device could be initialised for --gl-device " + choice.text +
                    "; install libegl1 and libgl1-mesa-dri for software rendering");
    if (!eglBindAPI(EGL_OPENGL_API)) throw Error("EGL: this display offers no desktop OpenGL");
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    context_ = eglCreateContext(display_, nullptr, EGL_NO_CONTEXT, attributes); // EGL_KHR_no_config_context
    if (context_ == EGL_NO_CONTEXT) throw Error("EGL: no OpenGL 4.5 core context on this device");
    if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
        eglDestroyContext(display_, context_);
        throw Error("EGL: the context cannot be made current without a surface");
    }
    renderer_ = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    version_ = reinterpret_cast<const char*>(glGetString(GL_VERSION));
    software_ = renderer_.find("llvmpipe") != std::string::npos ||
                renderer_.find("softpipe") != std::string::npos;
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
    if (!context_) return;
    glDebugMessageCallback(nullptr, nullptr);
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
}

} // namespace tessera
