// render/backends/engine_maker.cpp: see engine_maker.h.
#include "render/backends/engine_maker.h"

#include "core/base/error.h"
#include "core/base/names.h"

#include <algorithm>

namespace tessera {

const EngineTraits& traitsOf(EngineKind kind) {
    const auto& all = engineTraits();
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const EngineTraits& traits) { return traits.kind == kind; });
    TESSERA_CHECK(found != all.end());
    return *found;
}

const std::string& name(EngineKind kind) {
    static const std::string automatic = "auto";
    return kind == EngineKind::automatic ? automatic : traitsOf(kind).name;
}

std::vector<std::string> engineNames(bool quickOnly) {
    std::vector<std::string> names = {name(EngineKind::automatic)};
    for (const EngineTraits& traits : engineTraits())
        if (traits.quick || !quickOnly)
            names.push_back(traits.name);
    return names;
}

EngineKind engineNamed(const std::string& text, const std::string& option, bool quickOnly) {
    const std::vector<std::string> names = engineNames(quickOnly);
    const std::string& found = names[static_cast<std::size_t>(indexOfName(text, names, option))];
    for (const EngineTraits& traits : engineTraits())
        if (traits.name == found)
            return traits.kind;
    return EngineKind::automatic;
}

/// OpenGL is not loaded if the system has no GPU.
EngineMaker::EngineMaker(EngineKind asked, const GlDeviceChoice& device, int threads)
    : kind_(asked), threads_(threads) {
    if (kind_ == EngineKind::automatic) {
        kind_ = EngineKind::gpu;
        if (device.text != "auto") {
            reason_ = "an OpenGL device was requested";
        } else if (mayHaveGpu()) {
            try {
                context_.emplace(device);
                reason_ = context_->software() ? "OpenGL is in software here" : "this machine has a GPU";
            } catch (const Error& e) {
                reason_ = e.what();
            }
            if (!context_ || context_->software()) {
                context_.reset();
                kind_ = EngineKind::native;
            }
        } else {
            reason_ = "this machine has no GPU";
            kind_ = EngineKind::native;
        }
    }
    if (traitsOf(kind_).onContext && !context_)
        context_.emplace(device);
}

std::unique_ptr<Engine> EngineMaker::make(MemoryBudget& ram, MemoryBudget& gpu) const {
    const EngineTraits& traits = traitsOf(kind_);
    if (!traits.make)
        throw InputError("engine: expected one that takes rays, found " + traits.name);
    return traits.make(input(ram, gpu));
}

std::string EngineMaker::about() const {
    return name(kind_) + " engine, " + (context_ ? context_->renderer() : traitsOf(kind_).device);
}

std::string EngineMaker::fault() const {
    return context_ && !context_->errors().empty() ? "OpenGL: " + context_->errors().front() : std::string();
}

} // namespace tessera
