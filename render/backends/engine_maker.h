// render/backends/engine_maker.h: chooses the engine and its device, and makes it.
#pragma once

#include "core/base/budget.h"
#include "render/backends/gpu/gl/context.h"
#include "render/engine.h"
#include "render/engine_traits.h"

#include <memory>
#include <optional>
#include <string>

namespace tessera {

/// Makes engines of one kind, chosen once, that draw on one device and share a GL context, if they need one.
/// The context is current on the calling thread, which must make all calls, and outlives the engines.
class EngineMaker {
  public:
    /// Throws InputError if the requested device is missing.
    /// @param threads  0: all processors
    EngineMaker(EngineKind asked, const GlDeviceChoice& device, int threads = 0);
    /// Makes the ray backend. Throws InputError if the kind draws without rays.
    /// @param gpu, ram  outlive the engine
    std::unique_ptr<Engine> make(MemoryBudget& ram, MemoryBudget& gpu) const;
    EngineInput input(MemoryBudget& ram, MemoryBudget& gpu) const {
        return {context_ ? &*context_ : nullptr, threads_, &ram, &gpu};
    }
    EngineKind kind() const { return kind_; }             // never automatic
    const std::string& reason() const { return reason_; } // reason of the choice; empty if it was requested
    /// "native engine, CPU, avx2"
    std::string about() const;
    /// Error of OpenGL; empty: none.
    std::string fault() const;

  private:
    std::optional<GlContext> context_;
    EngineKind kind_;
    std::string reason_;
    int threads_;
};

} // namespace tessera
