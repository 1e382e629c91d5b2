// march_fused_loop.glsl: the loop of march.comp for rays through several volumes: the same as fusedAlong() in
// render/backends/mirror/mirror_fused.h. Part of main(): reads and writes its i, sum, left and counters.

#if FEATURE_PASSES
#define GOES_ON (left > 0 && (TURNS_LEFT || gNaming)) // to name bricks takes the turns of another sample, or no ray would get on
#else
#define GOES_ON (left > 0 && TURNS_LEFT)
#endif
while (i < ray.count && GOES_ON) {
    TURN;
    // Leaps until a volume may show something, in a loop of its own: a turn of it is cheap beside a sample.
    int looks = 0; // a bit a volume that may
    float length = 0.0;
    float at = 0.0;
    while (i < ray.count && GOES_ON) {
        --left;
        TURN;
        ++iterations;
        length = strideLength(ray, i, uStride);
        at = strideMiddle(float(i), length);
        float next = kMaxFloat; // of the first of them
        for (gVolume = 0; gVolume < uVolumes; ++gVolume) {
            TURN;
            float another = 0.0;
            if (looksInto(inVolume(ray), at, another)) looks |= 1 << gVolume;
            next = min(next, another);
        }
        if (looks != 0) break;
        i = next < float(ray.count) ? max(i + uStride, strideStart(ray, max(int(next), 0))) : ray.count;
    }
    if (looks == 0) break; // at its end, or its turns are spent
    Fused fused = Fused(0.0, 0.0, 0.0, 0.0);
    bool adds = false;
    for (gVolume = 0; gVolume < uVolumes; ++gVolume) {
        TURN;
        ONCE ((looks >> gVolume & 1) != 0) {
            Ray inside = inVolume(ray);
            vec3 p = placeAlong(inside.entry, inside.step, at);
            enterBrick(p);
            float value = currentBrickValue(p);
            ONCE (!inCurrentBrick(p)) value = fieldValue(p);
            SegmentEnd middle = endOf(value);
            float extinction = segmentExtinction(middle, middle);
            ++volumeSamples;
            bool sees = MAY_SHOW;
#if FEATURE_PASSES
            sees = sees || gMissing || gNaming; // then also the gradient's bricks are named
#endif
            ONCE (sees) {
                SeenSegment seen = seenSegment(middle, middle, extinction, p, inside.direction, length * ray.segmentMm, uStride);
                ++shown;
                if (seen.extinction > 0.0) {
                    precise float unitDepth = seen.extinction * uUnitMm;
                    fused = fusedWith(fused, uFusion, seen.extinction, opacityOf(unitDepth), seen.colour.r, seen.colour.g, seen.colour.b);
                    adds = true;
                }
            }
        }
    }
#if FEATURE_PASSES
    if (gNaming) {
        waiting = true;
        break;
    }
    if (gMissing) { // take the same sample again, naming all that it needs
        gMissing = false;
        gNaming = true;
        left = max(left, 1);
        continue;
    }
#endif
    ++segments;
    i += uStride;
    if (adds) {
        precise float depth = fused.extinction * (length * ray.segmentMm);
        compositeBehind(sum.rgb, sum.a, vec3(fused.red, fused.green, fused.blue), opacityOf(depth));
#if FEATURE_TERMINATION
        if (1.0 - sum.a < uTermination) i = ray.count;
#endif
    }
}
