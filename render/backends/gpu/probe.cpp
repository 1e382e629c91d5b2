// render/backends/gpu/probe.cpp: see probe.h.
#include "render/backends/gpu/probe.h"

#include "render/backends/gpu/composition.h"
#include "render/backends/gpu/gl/objects.h"

#include <span>

namespace tessera {

std::vector<glm::vec4> probeField(const std::vector<glm::vec3>& positions, std::uint32_t features,
                                  const VolumeInfo& info, const FieldSource& source, MemoryBudget& gpu) {
    std::vector<glm::vec4> probes;
    probes.reserve(positions.size());
    for (const glm::vec3& p : positions)
        probes.emplace_back(p, 0.0f);
    const Composition composition({{"PROBES", "the probes"}}, features);
    const GlProgram program = composition.program("probe.comp");
    GlBuffer buffer(probes.size() * sizeof(glm::vec4), std::as_bytes(std::span(probes)), gpu, "the probes");
    bindField(VolumeUniforms(program), features, info, source);
    program.set("uCount", static_cast<int>(probes.size()));
    buffer.bind(composition.binding("PROBES"));
    program.use();
    glDispatchCompute(static_cast<GLuint>((probes.size() + 63) / 64), 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    buffer.read(0, std::as_writable_bytes(std::span(probes)));
    return probes;
}

} // namespace tessera
