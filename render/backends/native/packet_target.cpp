// render/backends/native/packet_target.cpp: the instruction sets that packets can be drawn with.
#include "render/backends/native/packet.h"

#include <cstdlib>
#include <cstring>

namespace tessera::native {

PacketTargets packetTargets() {
    PacketTargets targets;
    targets.all[targets.count++] = &kBaselineTarget;
#if TESSERA_X86_TARGETS
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
        __builtin_cpu_supports("bmi2")) {
        targets.all[targets.count++] = &kAvx2Target;
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
            __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
            __builtin_cpu_supports("avx512vl"))
            targets.all[targets.count++] = &kAvx512Target;
    }
#endif
    return targets;
}

const PacketTarget& packetTarget() {
    const PacketTargets targets = packetTargets();
    if (const char* const named = std::getenv("TESSERA_INSTRUCTIONS"))
        for (int n = 0; n < targets.count; ++n)
            if (std::strcmp(named, targets.all[n]->name) == 0)
                return *targets.all[n];
    return *targets.all[targets.count - 1];
}

} // namespace tessera::native
