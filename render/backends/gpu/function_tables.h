// render/backends/gpu/function_tables.h: a transfer function's tables on the device, as
// shaders/march_optics.glsl and march_segment.glsl read them.
#pragma once

#include "core/base/budget.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/backends/gpu/gl/program.h"
#include "render/contract/optics.h"

namespace tessera {

class FunctionTables {
  public:
    /// Instead of those before, which go first, so that two are never charged.
    /// @param integrated  those of pre-integration too
    void set(const Optics& optics, bool integrated, MemoryBudget& gpu);
    void bind(const GlProgram& program) const;

  private:
    GlTexelBuffer extinctions_, colours_, sums_;
};

} // namespace tessera
