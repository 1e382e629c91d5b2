// march_surface_loop.glsl: the loop of march.comp for scenes with isosurfaces: strides are cut where the ray meets
// surfaces; twin of mirrorRayWithSurfaces() in render/mirror_surfaces.h. Part of main(): reads and writes its i, sum, left
// and counters. One stride is one sample to passes: it waits, names its bricks and is taken as a whole.
// Loops in loops, as in march.comp: all rays of a group go on through the volume until each has a stride near surfaces,
// then those are solved.

float front = 0.0;  // the field at the start of segment i
bool known = false; // front is
while (i < ray.count && left > 0 && gTurns < kMostTurns) {
    ++gTurns;
    int n = 0;
    float length = 0.0;
    vec3 start = vec3(0.0);
    float back = 0.0;
    float extinction = 0.0; // of a stride that stays whole
    float whole = 0.0;      // and the field in its middle
    bool solves = false;    // near surfaces
    bool needs = false;     // the field at the stride's ends
    bool taken = false;
    uint samples = 0u;
    while (!solves && i < ray.count && left > 0 && gTurns < kMostTurns) {
        ++gTurns;
        taken = false;
        extinction = 0.0;
        // Strides in which nothing shows, until each ray has one that does or is near.
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
            n = strideAt(ray, i);
            length = strideLength(ray, i, n);
            start = segmentStart(ray, i);
            vec3 end = strideEnd(ray, i, length);
            for (int outside = int(!inHome(start)); outside != 0; outside &= outside - 1) {
                ++gTurns;
                enterHome(start);
            }
            solves = isNearSurface(start, end);
#if FEATURE_ENDS
            needs = true;
#else
            needs = solves;
#endif
            samples = needs ? (known ? 1u : 2u) : 0u;
            for (int missing = int(needs && !known); missing != 0; missing &= missing - 1) {
                ++gTurns;
                front = valueAt(start);
            }
#if FEATURE_ENDS
            back = valueAt(end);
            taken = true;
            if (solves) break;
            extinction = segmentExtinction(endOf(front), endOf(back));
#else
            precise vec3 middle = start + (0.0 + 0.5 * (length - 0.0)) * ray.step;
            whole = valueAt(solves ? end : middle);
            taken = true;
            if (solves) {
                back = whole;
                break;
            }
            extinction = segmentExtinction(endOf(whole), endOf(whole));
#endif
#if FEATURE_PASSES
            if (gMissing || gNaming) break;
#endif
            if (extinction > 0.0) break;
            taken = false;
            ++segments;
#if !FEATURE_ENDS
            ++samples;
#endif
            surfaceSamples += samples;
            i += n;
            front = back;
            known = needs;
        }
        if (!taken) break;
#if FEATURE_PASSES
        bool waits = gNaming || gMissing; // then also the gradient's bricks are named, and the surfaces' values
        solves = solves || waits;
#endif
        if (solves) break;
        precise float depth = extinction * (length * ray.segmentMm);
        float alpha = opacityOf(depth);
#if FEATURE_ENDS
        vec3 colour = segmentColour(endOf(front), endOf(back), depth, alpha, n);
#else
        vec3 colour = segmentColour(endOf(whole), endOf(whole), depth, alpha, n);
        ++samples;
#endif
#if FEATURE_SHADING
        precise vec3 p = start + (0.0 + 0.5 * (length - 0.0)) * ray.step;
        colour = shade(colour, fieldGradient(p), ray.direction);
        samples += kGradientValues;
#if FEATURE_PASSES
        solves = gMissing;
        if (solves) break;
#endif
#endif
        precise float weight = (1.0 - sum.a) * alpha;
        sum.rgb = sum.rgb + weight * colour;
        sum.a = alpha < 1.0 ? sum.a + weight : 1.0;
        precise float through = 1.0 - sum.a;
        bool isLast = !(through > 0.0);
#if FEATURE_TERMINATION
        isLast = isLast || through < uTermination;
#endif
        ++segments;
        surfaceSamples += samples;
        front = back;
        known = needs;
        i = isLast ? ray.count : i + n;
    }
    if (!solves) break; // at its end, or its turns are spent
    precise vec4 before = sum;
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
            // The next piece, where this one is spent.
            for (int spent = int(part >= parts.count && nextW < length); spent != 0; spent &= spent - 1) {
                w = nextW;
                precise vec3 p = start + w * ray.step;
                for (int outside = int(!inHome(p)); outside != 0; outside &= outside - 1) {
                    ++gTurns;
                    enterHome(p);
                }
                nextW = min(nextPlane(start, ray.step, w, homePitch()), length);
                precise float piece = nextW - w;
                precise vec3 p1 = start + (w + piece * (1.0 / 3.0)) * ray.step;
                precise vec3 p2 = start + (w + piece * (2.0 / 3.0)) * ray.step;
                precise vec3 p3 = start + nextW * ray.step;
                float v0 = vNext;
                float v1 = 0.0;
                float v2 = 0.0;
                gTurns += 4;
                for (int k = 0; k < 3; ++k) { // one place in the program, not three
                    float v = valueAt(k == 0 ? p1 : k == 1 ? p2 : p3);
                    if (k == 0) v1 = v;
                    if (k == 1) v2 = v;
                    if (k == 2) vNext = nextW < length ? v : back;
                }
                samples += nextW < length ? 3u : 2u;
                f = cubicThrough(v0, v1, v2, vNext);
                parts = monotoneParts(f);
                part = 0;
                surface = 0;
                a = 0.0;
                va = v0;
                b = parts.x;
                vb = parts.count == 1 ? vNext : cubicAt(f, b);
            }
            ended = part >= parts.count;
            // The surfaces between the values at the part's ends, in the order in which it meets them.
            while (!ended && surface < uSurfaces && met < 0) {
                ++gTurns;
                int number = vb > va ? surface : uSurfaces - 1 - surface;
                float isovalue = uIsovalues[number];
                if ((va < isovalue) != (vb < isovalue)) met = number;
                ++surface;
            }
            for (int crossed = int(met >= 0); crossed != 0; crossed &= crossed - 1) {
                float isovalue = uIsovalues[met];
                precise float fa = va - isovalue;
                precise float fb = vb - isovalue;
                precise float piece = nextW - w;
                precise float place = w + bracketedRoot(f, isovalue, a, b, fa, fb) * piece;
                at = place;
            }
            if (met < 0 && !ended) {
                ++part;
                surface = 0;
                a = b;
                va = vb;
                b = part == 1 ? parts.y : 1.0;
                b = part + 1 == parts.count ? 1.0 : b;
                vb = part + 1 == parts.count ? vNext : cubicAt(f, b);
            }
        }
        // The volume before it, then the surface.
        float valueTo = met >= 0 ? uIsovalues[max(met, 0)] : back;
        precise float extent = at - from;
        precise vec3 middle = start + (from + 0.5 * extent) * ray.step;
        SegmentEnd partBack;
        SegmentEnd partFront;
#if FEATURE_ENDS
        partFront = endOf(valueFrom);
        partBack = endOf(valueTo);
#else
        float partValue = 0.0;
        for (int samplesIt = int(uVolumeShows != 0 && extent > 0.0); samplesIt != 0; samplesIt &= samplesIt - 1) {
            ++gTurns;
            partValue = valueAt(middle);
            ++samples;
        }
        partBack = endOf(partValue);
        partFront = partBack;
#endif
        float partExtinction = segmentExtinction(partFront, partBack);
        bool shows = uVolumeShows != 0 && extent > 0.0 && partExtinction > 0.0;
        for (int todo = int(shows) | int(met >= 0) << 1; todo != 0 && !done; todo &= todo - 1) {
            ++gTurns;
            bool isVolume = (todo & 1) != 0;
            precise vec3 p = start + at * ray.step;
            if (isVolume) p = middle;
            vec3 colour = uSurfaceColours[max(met, 0)];
            float alpha = uSurfaceOpacities[max(met, 0)];
            if (isVolume) {
                precise float depth = partExtinction * (extent * ray.segmentMm);
                alpha = opacityOf(depth);
                colour = segmentColour(partFront, partBack, depth, alpha, n);
            }
#if FEATURE_SHADING || FEATURE_HITS
            vec3 gradient = fieldGradient(p);
#endif
#if FEATURE_HITS
            bool isHit = !isVolume && !hasHit;
#if FEATURE_PASSES
            isHit = isHit && !gMissing && !gNaming;
#endif
            if (isHit) {
                hasHit = true;
                precise float mm = (float(i) + at) * ray.segmentMm;
                uHits[2 * slot] = vec4(p, mm);
                uHits[2 * slot + 1] = vec4(unitNormal(gradient, ray.direction), intBitsToFloat(met + 1));
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
