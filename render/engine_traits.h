// render/engine_traits.h: the table of renderers by name: ray backends (engines) and others. Each is a folder
// of render/backends/ with a function that returns its traits (cmake/Backend.cmake), and a value of
// EngineKind.
#pragma once

#include "core/base/budget.h"
#include "render/plan/frame_plan.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

class Engine;
class Renderer;
class GlContext;
struct RenderOptions;

/// automatic: gpu if there is a GPU, else native.
enum class EngineKind { automatic, gpu, native, mirror, reference, splat };

/// Inputs of an engine's constructor; budgets outlive it.
struct EngineInput {
    const GlContext* context = nullptr; ///< current; null for engines that need none
    int threads = 0;                    ///< 0: all processors
    MemoryBudget* ram = nullptr;
    MemoryBudget* gpu = nullptr;
};

struct EngineTraits {
    EngineKind kind = EngineKind::automatic;
    std::string name;           ///< in options, manifests and messages
    std::string device = "CPU"; ///< of engines that need no context
    bool onContext = false;     ///< draws by OpenGL: pictures depend on the device, and hardware may filter
    bool quick = false;         ///< draws the pictures of windows, and first coarse pictures
    bool exact = false;         ///< the true integral at the finest level, without steps
    bool countsAlways = false;  ///< work is always counted
    bool fuses = false;         ///< composites several volumes
    bool followsPaths = false;  ///< draws scenes with a transport of light, and reflections of isosurfaces
    bool drawsParts = false;    ///< draws parts of rays: of a volume that processes share
    bool singleRays = false;    ///< one ray through each pixel's centre, unless samples are requested
    /// Why the device cannot draw a scene's volumes, as part of a sentence; empty: it can. Null: any device
    /// can. Where onContext, the context is current.
    std::string (*refuses)(const Scene& scene) = nullptr;
    /// Why it cannot draw a scene as it is asked for, as part of a sentence; empty: it can. Null: what it
    /// cannot draw follows from the members above.
    std::string (*declines)(const Scene& scene, const RenderOptions& options) = nullptr;
    /// RAM per pixel of the engine and its caller, at least kPictureBytesPerPixel.
    std::size_t bytesPerPixel = kPictureBytesPerPixel;
    /// Makes the ray backend; null if `renderer` draws without rays.
    std::unique_ptr<Engine> (*make)(const EngineInput& input) = nullptr;
    /// Makes the renderer; null: the ray renderer, with the engine.
    std::unique_ptr<Renderer> (*renderer)(const EngineInput& input) = nullptr;
};

/// All engines, in the order of EngineKind. Defined by the build (cmake/Backend.cmake).
const std::vector<EngineTraits>& engineTraits();
/// @param kind  not automatic (checked)
const EngineTraits& traitsOf(EngineKind kind);
/// "auto" for automatic.
const std::string& name(EngineKind kind);
/// "auto" and the engines' names; on request only of those for windows.
std::vector<std::string> engineNames(bool quickOnly = false);
/// @param option  the option's name, for the message. Throws InputError with the nearest name.
EngineKind engineNamed(const std::string& text, const std::string& option, bool quickOnly = false);

} // namespace tessera
