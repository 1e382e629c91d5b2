// march_surface_loop.glsl: the loop of march.comp for scenes with isosurfaces: strides are cut where the ray meets
// surfaces; as surfaceRay() in render/backends/mirror/mirror_surfaces.h. Part of main(): reads and writes its i, sum,
// left and counters. One stride is one sample to passes: it waits, names its bricks and is taken as a whole.
// Loops in loops, as in march.comp. All rays of a group go on until each has something to add. Within that they go
// through the strides that hold nothing, then through the pieces of strides near surfaces that no surface can cross.
// The ray's state from one turn to the next comes first; the data of one turn are declared in it.

float front = 0.0;    // the field at the start of segment i
bool known = false;   // front is
bool needs = false;   // the field at the ends of the stride at hand
bool solving = false; // that stride is near surfaces
int n = 0;
float length = 0.0;
vec3 start = vec3(0.0);
float back = 0.0;
precise vec4 before = sum; // when the stride began
uint samples = 0u;         // of it
float from = 0.0;          // start of its part not added yet, segments from start
float valueFrom = 0.0;
// Its piece at hand, from w to nextW. The piece's monotone part at hand, from a to b with values va and vb, and the
// surface that is searched in it.
bool inPiece = false;
float w = 0.0;
float nextW = 0.0;
float vNext = 0.0;
CellCubic f = CellCubic(0.0, 0.0, 0.0, 0.0);
Parts parts = Parts(0, 1.0, 1.0);
int part = 0;
int surface = 0;
float a = 0.0;
float b = 0.0;
float va = 0.0;
float vb = 0.0;
#if FEATURE_PASSES
#define GOES_ON (gNaming || TURNS_LEFT) // a stride that is taken again is taken to its end
#else
#define GOES_ON TURNS_LEFT
#endif
while (solving || (i < ray.count && left > 0 && GOES_ON)) {
    TURN;
    int met = -1;            // number of the surface to add
    float at = 0.0;          // its place, or the stride's end
    float extinction = 0.0;  // of the volume before it, from from to at
    vec3 middle = vec3(0.0); // of that
    SegmentEnd partFront = endOf(0.0);
    SegmentEnd partBack = partFront;
    float valueTo = 0.0;
    bool adds = false;
    bool ended = false; // the stride, with the added part
    while (!adds && (solving || (i < ray.count && left > 0 && GOES_ON))) {
        TURN;
        // Strides in which nothing shows, until each ray has one that does or is near surfaces.
        while (!solving && !adds && i < ray.count && left > 0 && GOES_ON) {
            --left;
            TURN;
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
            ONCE (!inCurrentBrick(start)) enterBrick(start);
            solving = mayHoldSurface(start, end);
#if FEATURE_ENDS
            needs = true;
#else
            needs = solving;
#endif
            samples = needs ? (known ? 1u : 2u) : 0u;
            ONCE (needs && !known) front = valueAt(start);
            before = sum;
            from = 0.0;
            valueFrom = front;
            at = length;
            precise vec3 centre = start + (0.0 + 0.5 * (length - 0.0)) * ray.step;
            middle = centre;
#if FEATURE_ENDS
            back = valueAt(end);
            partFront = endOf(front);
            partBack = endOf(back);
#else
            float value = valueAt(solving ? end : middle);
            back = value;
            samples += solving ? 0u : 1u;
            partBack = endOf(value);
            partFront = partBack;
#endif
            nextW = 0.0;
            vNext = front;
            if (solving) break;
            extinction = segmentExtinction(partFront, partBack);
            adds = extinction > 0.0;
#if FEATURE_PASSES
            adds = adds || gMissing || gNaming;
#endif
            ended = adds;
            if (adds) break;
            ++segments;
            surfaceSamples += samples;
            i += n;
            front = back;
            known = needs;
        }
        // Pieces that no surface can cross, until each ray has one that may be crossed, or is at its stride's end.
        bool found = false;
        while (solving && !inPiece && nextW < length) {
            TURN;
            w = nextW;
            precise vec3 p = start + w * ray.step;
            ONCE (!inCurrentBrick(p)) enterBrick(p);
            nextW = min(nextPlane(start, ray.step, w, currentBrickPitch()), length);
            precise float piece = nextW - w;
            precise vec3 p1 = start + (w + piece * (1.0 / 3.0)) * ray.step;
            precise vec3 p2 = start + (w + piece * (2.0 / 3.0)) * ray.step;
            precise vec3 p3 = start + nextW * ray.step;
            va = vNext;
            float v1 = 0.0;
            float v2 = 0.0;
            TURNS(4);
            for (int k = 0; k < 3; ++k) { // one place in the program, not three
                float v = valueAt(k == 0 ? p1 : k == 1 ? p2 : p3);
                if (k == 0) v1 = v;
                if (k == 1) v2 = v;
                if (k == 2) vNext = nextW < length ? v : back;
            }
            samples += nextW < length ? 3u : 2u;
            f = cellCubic(va, v1, v2, vNext);
            inPiece = mayCross(f, vNext);
            found = inPiece;
        }
        ONCE (found) {
            parts = monotoneParts(f);
            part = 0;
            surface = 0;
            a = 0.0;
            b = parts.x;
            vb = parts.count == 1 ? vNext : cubicAt(f, b);
        }
        // The next crossing of the piece: the surfaces between the values at its parts' ends, in the order in which
        // the ray meets them.
        while (inPiece && met < 0) {
            TURN;
            bool isOne = surface < uSurfaces; // else the last of this part was met in the turn before
            int number = isOne ? vb > va ? surface : uSurfaces - 1 - surface : 0;
            float isovalue = uIsovalues[number];
            if (isOne && (va < isovalue) != (vb < isovalue)) met = number;
            ++surface;
            ONCE (met < 0 && surface >= uSurfaces) {
                ++part;
                surface = 0;
                a = b;
                va = vb;
                b = part == 1 ? parts.y : 1.0;
                b = part + 1 == parts.count ? 1.0 : b;
                vb = part + 1 == parts.count ? vNext : cubicAt(f, b);
                inPiece = part < parts.count;
            }
        }
        ONCE (met >= 0) {
            precise float fa = va - uIsovalues[met];
            precise float fb = vb - uIsovalues[met];
            precise float piece = nextW - w;
            precise float place = w + bracketedRoot(f, uIsovalues[met], a, b, fa, fb) * piece;
            at = place;
        }
        // The part of the volume before it, or the remainder of the stride.
        bool isLast = solving && !inPiece && met < 0 && !(nextW < length);
        ONCE (isLast || met >= 0) {
            if (isLast) at = length;
            valueTo = isLast ? back : uIsovalues[max(met, 0)];
            precise float extent = at - from;
            bool shows = uVolumeShows != 0 && extent > 0.0;
            precise vec3 centre = start + (from + 0.5 * extent) * ray.step;
            middle = centre;
#if FEATURE_ENDS
            partFront = endOf(valueFrom);
            partBack = endOf(valueTo);
#else
            float value = 0.0;
            ONCE (shows) {
                value = valueAt(middle);
                ++samples;
            }
            partBack = endOf(value);
            partFront = partBack;
#endif
            extinction = shows ? segmentExtinction(partFront, partBack) : 0.0;
            adds = extinction > 0.0 || met >= 0;
#if FEATURE_PASSES
            adds = adds || gMissing || gNaming;
#endif
            ended = isLast;
            if (isLast && !adds) {
                ++segments;
                surfaceSamples += samples;
                i += n;
                front = back;
                known = true;
                solving = false;
            }
        }
#if FEATURE_PASSES
        adds = adds || (gMissing && !gNaming); // to take the stride again; naming goes on to its end
#endif
    }
    if (!adds) break; // at the ray's end, or its turns are spent
    // The volume, then the surface.
    bool done = false; // nothing behind is seen
    bool addsVolume = extinction > 0.0;
#if FEATURE_PASSES
    addsVolume = addsVolume || gNaming; // then also the gradient's bricks are named
#endif
    for (int todo = int(addsVolume) | int(met >= 0) << 1; todo != 0 && !done; todo &= todo - 1) {
        TURN;
        bool isVolume = (todo & 1) != 0;
        precise vec3 p = start + at * ray.step;
        if (isVolume) p = middle;
        vec3 colour = uSurfaceColours[max(met, 0)];
        float alpha = uSurfaceOpacities[max(met, 0)];
#if FEATURE_GRADIENT_OPACITY
        vec3 gradient = fieldGradient(p);
        if (isVolume) {
            precise float graded = extinction * gradientOpacity(gradient);
            extinction = graded;
        }
#if (FEATURE_SHADING || FEATURE_HITS) && FEATURE_SOBEL_GRADIENT
        ONCE (SMOOTHS) gradient = normalGradient(p);
#endif
#elif FEATURE_SHADING || FEATURE_HITS
        vec3 gradient = normalGradient(p);
#endif
        if (isVolume) {
            precise float depth = extinction * ((at - from) * ray.segmentMm);
            alpha = opacityOf(depth);
            colour = segmentColour(partFront, partBack, depth, alpha, n);
        }
#if FEATURE_HITS
        bool isHit = !isVolume && !hasHit;
#if FEATURE_PASSES
        isHit = isHit && !gMissing && !gNaming;
#endif
        if (isHit) {
            hasHit = true;
            precise float weight = 1.0 - sum.a;
            uHits[2 * slot] = vec4(p, weight);
            uHits[2 * slot + 1] = vec4(unitNormal(gradient, ray.direction), intBitsToFloat(met + 1));
        }
#endif
#if FEATURE_LIGHTS
        float materialAtP = isVolume ? materialPlace(partFront, partBack) : placeOf(uIsovalues[max(met, 0)]);
        colour = shadeByLights(colour, gradient, ray.direction, p, materialAtP, receivedLight(p));
#elif FEATURE_SHADING
        colour = shade(colour, gradient, ray.direction);
#endif
#if FEATURE_SHADING
        samples += kGradientValues;
#if FEATURE_GRADIENT_OPACITY
        samples += isVolume && SMOOTHS ? kGradientValues : 0u;
#endif
#elif FEATURE_GRADIENT_OPACITY
        samples += isVolume ? kGradientValues : 0u;
#endif
        compositeBehind(sum.rgb, sum.a, colour, alpha);
        precise float through = 1.0 - sum.a;
        done = !(through > 0.0);
#if FEATURE_TERMINATION
        done = done || through < uTermination;
#endif
    }
#if FEATURE_PASSES
    if (gNaming) {
        sum = before;
        waiting = ended;
        if (ended) break;
        done = false;
        gMissing = false; // it is being named; the rest of the stride is too
    }
    if (gMissing) { // take the same stride again, naming all that it needs
        sum = before;
        gMissing = false;
        gNaming = true;
        leaveBrick();
        known = false;
        solving = false;
        inPiece = false;
        left = max(left, 1);
        continue;
    }
#endif
    from = at;
    valueFrom = valueTo;
    ended = ended || done;
    if (ended) {
        ++segments;
        surfaceSamples += samples;
        front = back;
        known = needs;
        i = done ? ray.count : i + n;
        solving = false;
        inPiece = false;
    }
}
