// render/engines/native/packet_target.cpp: which set of instructions packets are drawn with.
#include "render/engines/native/packet.h"

#include <cstdlib>
#include <cstring>

namespace tessera::native {

const PacketTarget& packetTarget() {
    // Named by the environment for tests and measurements.
    const char* const named = std::getenv("TESSERA_INSTRUCTIONS");
    [[maybe_unused]] const auto allowed = [&](const PacketTarget& target) {
        return !named || std::strcmp(named, target.name) == 0;
    };
#if TESSERA_X86_TARGETS
    __builtin_cpu_init();
    if (allowed(kAvx512Target) && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("bmi2"))
        return kAvx512Target;
    if (allowed(kAvx2Target) && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2"))
        return kAvx2Target;
#endif
    return kBaselineTarget;
}

} // namespace tessera::native
