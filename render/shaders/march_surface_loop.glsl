// march_surface_loop.glsl: the loop of march.comp for scenes with isosurfaces: strides are cut where the ray meets
// surfaces; twin of mirrorRayWithSurfaces() in render/mirror_surfaces.h. Part of main(): reads and writes its i, sum, left
// and counters. One stride is one sample to passes: it waits, names its bricks and is taken as a whole.

float front = 0.0;  // the field at the start of segment i
bool known = false; // front is
while (i < ray.count && left > 0 && gTurns < kMostTurns) {
    --left;
    ++gTurns;
    ++iterations;
    int next = nextNotClear(ray, i, left, iterations);
    if (next > i) {
        i = next;
        known = false;
        continue;
    }
    int n = strideAt(ray, i);
    float length = strideLength(ray, i, n);
    vec3 start = segmentStart(ray, i);
    vec3 end = strideEnd(ray, i, length);
    if (!inHome(start)) enterHome(start);
    precise vec4 before = sum;
    bool solves = isNearSurface(start, end);
#if FEATURE_ENDS
    const bool needs = true;
#else
    bool needs = solves;
#endif
    if (needs && !known) front = valueAt(start);
    float back = needs ? valueAt(end) : 0.0;
    uint samples = needs ? (known ? 1u : 2u) : 0u;
    float from = 0.0; // of what of the volume is not added yet, segments from start
    float valueFrom = front;
    bool done = false; // nothing behind is seen
    // The piece at hand, from w to nextW; its monotone part at hand, from a to b with values va and vb, and the
    // surface in it that is looked at.
    float w = 0.0;
    float nextW = solves ? 0.0 : length;
    float vNext = front;
    Cubic f = Cubic(0.0, 0.0, 0.0, 0.0);
    Parts parts = Parts(0, 1.0, 1.0);
    int part = 0;
    int surface = 0;
    float a = 0.0;
    float b = 0.0;
    float va = 0.0;
    float vb = 0.0;
    bool ended = false; // the stride
    while (!ended && !done) {
        ++gTurns;
        // The next crossing, or the stride's end.
        float at = length;
        int met = -1;
        while (met < 0 && !ended) {
            ++gTurns;
            if (part >= parts.count) {
                if (!(nextW < length)) {
                    ended = true;
                    continue;
                }
                w = nextW;
                precise vec3 p = start + w * ray.step;
                if (!inHome(p)) enterHome(p);
                nextW = min(nextPlane(start, ray.step, w, homePitch()), length);
                precise float piece = nextW - w;
                precise vec3 p1 = start + (w + piece * (1.0 / 3.0)) * ray.step;
                precise vec3 p2 = start + (w + piece * (2.0 / 3.0)) * ray.step;
                precise vec3 p3 = start + nextW * ray.step;
                float v0 = vNext;
                vec3 v = vec3(0.0);
                gTurns += 3;
                for (int k = 0; k < 3; ++k) { // one place in the program, not three
                    vec3 q = k == 0 ? p1 : k == 1 ? p2 : p3;
                    if (k < 2 || nextW < length) v[k] = valueAt(q);
                    else v[k] = back;
                }
                samples += nextW < length ? 3u : 2u;
                vNext = v[2];
                f = cubicThrough(v0, v[0], v[1], v[2]);
                parts = monotoneParts(f);
                part = 0;
                surface = 0;
                a = 0.0;
                va = v0;
                b = parts.x;
                vb = parts.count == 1 ? vNext : cubicAt(f, b);
                continue;
            }
            if (surface >= uSurfaces) {
                ++part;
                surface = 0;
                a = b;
                va = vb;
                b = part == 1 ? parts.y : 1.0;
                b = part + 1 == parts.count ? 1.0 : b;
                vb = part + 1 == parts.count ? vNext : cubicAt(f, b);
                continue;
            }
            int number = vb > va ? surface : uSurfaces - 1 - surface;
            float isovalue = uIsovalues[number];
            ++surface;
            if ((va < isovalue) != (vb < isovalue)) {
                precise float fa = va - isovalue;
                precise float fb = vb - isovalue;
                precise float piece = nextW - w;
                precise float place = w + bracketedRoot(f, isovalue, a, b, fa, fb) * piece;
                at = place;
                met = number;
            }
        }
        // The volume before it, then the surface: one place in the program for both gradients.
        float valueTo = met >= 0 ? uIsovalues[max(met, 0)] : back;
        gTurns += 2;
        for (int what = 0; what < 2 && !done; ++what) {
            precise float extent = at - from;
            precise vec3 p = start + (what == 0 ? from + 0.5 * extent : at) * ray.step;
            float alpha = 0.0;
            vec3 colour = vec3(0.0);
            if (what == 0) {
                if (uVolumeShows == 0 || !(extent > 0.0)) continue;
#if FEATURE_ENDS
                SegmentEnd front = endOf(valueFrom);
                SegmentEnd back = endOf(valueTo);
#else
                SegmentEnd back = endOf(valueAt(p));
                SegmentEnd front = back;
                ++samples;
#endif
                float extinction = segmentExtinction(front, back);
                if (!(extinction > 0.0)) continue;
                precise float depth = extinction * (extent * ray.segmentMm);
                alpha = opacityOf(depth);
                colour = segmentColour(front, back, depth, alpha, n);
            } else {
                if (met < 0) continue;
                colour = uSurfaceColours[met];
                alpha = uSurfaceOpacities[met];
            }
#if FEATURE_SHADING || FEATURE_HITS
            vec3 gradient = fieldGradient(p);
#endif
#if FEATURE_HITS
            if (what == 1 && !hasHit) {
#if FEATURE_PASSES
                if (!gMissing && !gNaming)
#endif
                {
                    hasHit = true;
                    precise float mm = (float(i) + at) * ray.segmentMm;
                    uHits[2 * slot] = vec4(p, mm);
                    uHits[2 * slot + 1] = vec4(unitNormal(gradient, ray.direction), intBitsToFloat(met + 1));
                }
            }
#endif
#if FEATURE_SHADING
            colour = shade(colour, gradient, ray.direction);
            samples += kGradientValues;
#endif
            precise float weight = (1.0 - sum.a) * alpha;
            sum.rgb = sum.rgb + weight * colour;
            sum.a = alpha < 1.0 ? sum.a + weight : 1.0;
            precise float through = 1.0 - sum.a;
            done = !(through > 0.0);
#if FEATURE_TERMINATION
            done = done || through < uTermination;
#endif
        }
        from = at;
        valueFrom = valueTo;
    }
#if FEATURE_PASSES
    if (gNaming) {
        sum = before;
        waiting = true;
        break;
    }
    if (gMissing) { // take the same stride again, naming all that it needs
        sum = before;
        gMissing = false;
        gNaming = true;
        leaveHome();
        known = false;
        continue;
    }
#endif
    ++segments;
    surfaceSamples += samples;
    front = back;
    known = needs;
    i = done ? ray.count : i + n;
}
