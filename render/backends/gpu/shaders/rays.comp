// rays.comp: writes the rays that march.comp makes, so that tests can run the mirror on exactly these.

layout(local_size_x = 8, local_size_y = 8) in;

#include "common_ray.glsl"

layout(std430, binding = BINDING_RAYS) writeonly buffer Rays { float uRays[]; }; // 12 floats a ray

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, uArraySize))) return;
    Ray ray = makeRay(rayPlace(pixel), rayPhase(pixel));
    int at = 12 * raySlot(pixel);
    for (int axis = 0; axis < 3; ++axis) {
        uRays[at + axis] = ray.entry[axis];
        uRays[at + 3 + axis] = ray.step[axis];
        uRays[at + 6 + axis] = ray.direction[axis];
    }
    uRays[at + 9] = ray.segmentMm;
    uRays[at + 10] = ray.tail;
    uRays[at + 11] = intBitsToFloat(ray.count);
}
