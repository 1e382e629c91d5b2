// render/engine_traits.h: the renderers that there are, by name: those that take rays, engines, and others.
// Each is a folder of render/backends/ that tells its traits in a function (cmake/Backend.cmake), and a kind.
#pragma once

#include "core/base/budget.h"
#include "render/plan/memory_plan.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

class Engine;
class Renderer;
class GlContext;

/// automatic: the GPU's march where there is a GPU, else the native engine.
enum class EngineKind { automatic, gpu, native, mirror, reference };

/// What an engine is made from; budgets outlive it.
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
    bool quick = false;         ///< draws a window's pictures, and a first one before a picture is finished
    bool exact = false;         ///< the true integral at the finest level, without steps
    bool countsAlways = false;  ///< work is counted whether or not that was asked for
    bool singleRays = false;    ///< a ray through each pixel's middle, where nobody names a number of samples
    /// RAM that the engine and its caller take for a pixel, at least kPictureBytesPerPixel.
    std::size_t bytesPerPixel = kPictureBytesPerPixel;
    /// What takes rays; null where `renderer` draws without any.
    std::unique_ptr<Engine> (*make)(const EngineInput& input) = nullptr;
    /// What draws frames; null: rays, by the engine.
    std::unique_ptr<Renderer> (*renderer)(const EngineInput& input) = nullptr;
};

/// Of all engines, in the order of EngineKind.
const std::vector<EngineTraits>& engineTraits();
/// @param kind  not automatic (checked)
const EngineTraits& traitsOf(EngineKind kind);
/// "auto" for automatic.
const std::string& name(EngineKind kind);
/// "auto" and the engines' names; of those that draw a window's pictures alone, where asked.
std::vector<std::string> engineNames(bool quickOnly = false);
/// @param option  that names it, in the message. Throws InputError with the nearest name.
EngineKind engineNamed(const std::string& text, const std::string& option, bool quickOnly = false);

} // namespace tessera
