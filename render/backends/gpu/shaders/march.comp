// march.comp: the single-pass ray caster over resumable rays. A dispatch covers a tile and takes at most
// uMaxIterations steps per ray. A ray's state (next segment, colour, alpha) waits in uState, so that tiles,
// dispatches and passes can be cut anywhere with the same result.

layout(local_size_x = 64) in; // 8 x 8 pixels

#include "common_ray.glsl"
#if FEATURE_FUSED
int gVolume = 0; // the volume at hand, VOLUMES of them: what OF_VOLUME declares is its own
#endif
#include "sampler_field.glsl"
#include "march_optics.glsl"
#include "march_gradient_opacity.glsl"
#include "march_segment.glsl"
#include "march_lights.glsl"
#include "sampler_channels.glsl"
#include "sampler_light.glsl"
#include "sampler_labels.glsl"
#include "march_seen.glsl"
#include "march_strides.glsl"
#include "march_skipping.glsl"
#if FEATURE_FUSED
#include "march_fused.glsl"
#endif
#if FEATURE_SURFACES
#include "march_surface.glsl"
#endif

layout(std430, binding = BINDING_COLOUR) buffer RayColour { vec4 uColour[]; }; // rgb premultiplied, alpha
layout(std430, binding = BINDING_NEXT) buffer RayNext { int uNext[]; };      // next segment; -1: finished
layout(std430, binding = BINDING_WORK) buffer Work { uint uUnfinished, uIterations, uSegments, uSamples, uFetches, uBlended, uWaiting; };
#if FEATURE_VISIBILITY
layout(std430, binding = BINDING_SEEN) buffer Seen { uint uSeen[]; };           // per brick: light in 1/256 of a ray's, and rays
layout(std430, binding = BINDING_LAST_BRICK) buffer LastBrick { int uLastBrick[]; };  // per ray: number of the brick counted last
#endif
#if FEATURE_HITS
layout(std430, binding = BINDING_HITS) buffer Hits { vec4 uHits[]; };           // two a ray: SurfaceHit of render/contract/ray_state.h
#endif
uniform ivec2 uTileOrigin, uTileEnd;
uniform int uMaxIterations;
#if FEATURE_TERMINATION
uniform float uTermination; // transmittance below which a ray ends
#endif

// Devices run neighbours of this order side by side, and all of them wait for the slowest. So 4 x 1, 4 x 2, 4 x 4 and
// 8 x 4 neighbours are patches of the picture, whose rays need much the same.
ivec2 pixelOfGroup(int lane) { return ivec2(lane & 3 | lane >> 2 & 4, lane >> 2 & 3 | lane >> 3 & 4); }

void main() {
    ivec2 pixel = uTileOrigin + 8 * ivec2(gl_WorkGroupID.xy) + pixelOfGroup(int(gl_LocalInvocationIndex));
    if (any(greaterThanEqual(pixel, uTileEnd))) return;
    int slot = raySlot(pixel);
    int i = uNext[slot];
    if (i < 0) return;
    Ray ray = makeRay(rayPlace(pixel), rayPhase(pixel));
    precise vec4 sum = uColour[slot];
#if FEATURE_INTERVALS
    ray = partOf(ray, uIntervals[slot]);
#if !FEATURE_VALUES
    bool opaque = !(1.0 - sum.a > 0.0);
#if FEATURE_TERMINATION
    opaque = opaque || 1.0 - sum.a < uTermination;
#endif
    if (opaque && i == 0) ray.count = 0; // nothing behind the intervals before is seen
#endif
#endif
#if !FEATURE_FUSED
    beginSkipping(ray);
#endif
    uint iterations = 0u;
    uint segments = 0u;
    uint shown = 0u;
    uint fronts = 0u; // segments whose front was not the back of the one before
    int left = uMaxIterations;
#if FEATURE_VISIBILITY
    int lastBrick = uLastBrick[slot];
#endif
#if FEATURE_PASSES
    gRayNumber = uint(slot);
    bool waiting = false; // all that its next sample needs is named
#endif
#if FEATURE_VALUES
#include "march_values_loop.glsl"
#elif FEATURE_FUSED
    uint volumeSamples = 0u;
#include "march_fused_loop.glsl"
#elif FEATURE_SURFACES
    uint surfaceSamples = 0u;
#if FEATURE_HITS
    bool hasHit = floatBitsToInt(uHits[2 * slot + 1].w) != 0;
#endif
#include "march_surface_loop.glsl"
#else
#if FEATURE_ENDS
    SegmentEnd front = endOf(0.0); // at the start of segment i
    bool known = false;            // front is
    bool frontShows = false;       // something can show there
#else
#if FEATURE_MATERIALS
    const SegmentEnd front = SegmentEnd(0.0, 0.0); // not read
#else
    const SegmentEnd front = SegmentEnd(0.0); // not read
#endif
#endif
    while (i < ray.count && left > 0 && TURNS_LEFT) {
        TURN;
        float extinction = 0.0;
        bool taken = false; // a sample may show
        SegmentEnd back; // the stride's, or its middle where that alone counts
        bool shows = false; // something can show there
        float length = 0.0; // of the stride, in segments
        int n = 0;
        vec3 p = vec3(0.0);
        // Three loops, one in another. All rays of a group go on in their bricks until each needs another brick or a
        // blend. Then those that do get it; and once every ray has a sample that shows, all shade. Fewer loops would
        // do the rare work of few lanes while the others wait, at every sample.
        while (i < ray.count && left > 0 && TURNS_LEFT) {
            TURN;
            bool within = true;
            while (i < ray.count && left > 0 && TURNS_LEFT) {
                --left;
                TURN;
                ++iterations;
                n = currentBrickStride(i);
                length = strideLength(ray, i, n);
#if FEATURE_ENDS
                p = strideEnd(ray, i, length);
                shows = isOccupied(p);
                within = known && (frontShows || shows) && inCurrentBrick(p) && startsInCurrentBrick(ray, i);
#else
                p = stridePosition(ray, i, length);
                within = inCurrentBrick(p) && startsInCurrentBrick(ray, i) && isOccupied(p);
#endif
                if (!within) break;
                back = endOf(currentBrickValue(p));
                extinction = segmentExtinction(front, back);
                if (taken = MAY_SHOW) break;
                ++segments;
                i += n;
#if FEATURE_ENDS
                front = back;
                frontShows = shows;
#endif
            }
            if (within) break; // shows, or at its end, or its turns are spent
            n = strideAt(ray, i);
            length = strideLength(ray, i, n);
#if FEATURE_ENDS
            int next = nextShown(ray, i, left, iterations);
            if (next > i) {
                i = next;
                known = false;
                continue;
            }
            if (!known) front = endOf(fieldValue(segmentStart(ray, i)));
            fronts += uint(!known);
            known = true;
            p = strideEnd(ray, i, length);
            shows = isOccupied(p);
#else
            p = stridePosition(ray, i, length);
            int next = nextOccupied(ray, i, n, p, left, iterations);
            if (next > i) {
                i = next;
                continue;
            }
#endif
            enterBrick(p);
#if FEATURE_VISIBILITY
            if (gBrickNumber != lastBrick) {
                lastBrick = gBrickNumber;
                atomicAdd(uSeen[2 * lastBrick], uint((1.0 - sum.a) * 256.0 + 0.5));
                atomicAdd(uSeen[2 * lastBrick + 1], 1u);
            }
#endif
            back = endOf(fieldValue(p));
            extinction = segmentExtinction(front, back);
#if FEATURE_PASSES
            if (gMissing || gNaming) break;
#endif
            if (taken = MAY_SHOW) break;
            ++segments;
            i += n;
#if FEATURE_ENDS
            front = back;
            frontShows = shows;
#endif
        }
#if FEATURE_PASSES
        bool waits = gNaming || gMissing; // then also the gradient's bricks are named
#else
        const bool waits = false;
#endif
        if (!taken && !waits) break;
        vec3 middle = stridePosition(ray, i, length);
        SeenSegment seen = seenSegment(front, back, extinction, middle, ray.direction, length * ray.segmentMm, n);
#if FEATURE_PASSES
        if (gNaming) {
            waiting = true;
            break;
        }
        if (gMissing) { // take the same sample again, naming all that it needs
            gMissing = false;
            gNaming = true;
            leaveBrick();
            left = max(left, 1);
#if FEATURE_ENDS
            known = false;
#endif
            continue;
        }
#endif
        compositeBehind(sum.rgb, sum.a, seen.colour, seen.alpha);
        ++segments;
        ++shown;
        i += n;
#if FEATURE_ENDS
        front = back;
        frontShows = shows;
#endif
#if FEATURE_TERMINATION
        if (1.0 - sum.a < uTermination) i = ray.count;
#endif
    }
#endif
    uColour[slot] = sum;
    uNext[slot] = i < ray.count ? i : -1;
#if FEATURE_VISIBILITY
    uLastBrick[slot] = lastBrick;
#endif
#if FEATURE_PASSES
    if (waiting) atomicAdd(uWaiting, 1u);
    else
#endif
    if (i < ray.count) atomicAdd(uUnfinished, 1u);
    atomicAdd(uIterations, iterations); // always: it paces the dispatches
#if FEATURE_COUNTING
    uint gradientValues = 0u;
#if FEATURE_SHADING && FEATURE_GRADIENT_OPACITY
    gradientValues = SMOOTHS ? 2u * kGradientValues : kGradientValues;
#elif FEATURE_SHADING || FEATURE_GRADIENT_OPACITY
    gradientValues = kGradientValues;
#endif
    atomicAdd(uSegments, segments);
#if FEATURE_SURFACES
    atomicAdd(uSamples, surfaceSamples);
#elif FEATURE_FUSED
    atomicAdd(uSamples, volumeSamples + gradientValues * shown);
#else
    atomicAdd(uSamples, segments + fronts + gradientValues * shown);
#endif
    atomicAdd(uFetches, gFetches);
#if FEATURE_MIXED
    atomicAdd(uBlended, gBlended);
#endif
#endif
}
