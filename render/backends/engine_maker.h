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

/// Makes engines of one kind, chosen once, that draw on one device: a GL context, where they need one, is
/// theirs together. It is current on the calling thread, from which all calls come then; and
/// outlives the engines.
class EngineMaker {
  public:
    /// Throws InputError where the device that was asked for is not there.
    /// @param threads  0: all processors
    EngineMaker(EngineKind asked, const GlDeviceChoice& device, int threads = 0);
    /// What takes rays. Throws InputError where the kind draws without any.
    /// @param gpu, ram  outlive the engine
    std::unique_ptr<Engine> make(MemoryBudget& ram, MemoryBudget& gpu) const;
    EngineInput input(MemoryBudget& ram, MemoryBudget& gpu) const {
        return {context_ ? &*context_ : nullptr, threads_, &ram, &gpu};
    }
    EngineKind kind() const { return kind_; }             // never automatic
    const std::string& reason() const { return reason_; } // why this one; empty where it was asked for
    /// "native engine, CPU, avx2"
    std::string about() const;
    /// What OpenGL complained of; empty: nothing.
    std::string fault() const;

  private:
    std::optional<GlContext> context_;
    EngineKind kind_;
    std::string reason_;
    int threads_;
};

} // namespace tessera
