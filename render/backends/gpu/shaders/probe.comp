// probe.comp: value and gradient of the field at given positions, by the very functions that the ray caster uses.

layout(local_size_x = 64) in;

#include "sampler_field.glsl"

layout(std430, binding = BINDING_PROBES) buffer Probes { vec4 uProbes[]; }; // in: position (voxels); out: gradient, value
uniform int uCount;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= uCount) return;
    vec3 p = uProbes[i].xyz;
    // Every other one as the ray caster takes it, which is in a brick and stays there if no other has weight.
    if ((i & 1) != 0) enterBrick(p);
    uProbes[i] = vec4(fieldGradient(p), inCurrentBrick(p) ? currentBrickValue(p) : fieldValue(p));
}
