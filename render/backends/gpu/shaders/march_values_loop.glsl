// march_values_loop.glsl: the loop of march.comp for rays that keep one of the values along them, or their mean: the
// same as keepAlong() in render/backends/mirror/mirror.h. Part of main(): reads and writes its i, sum, left
// and counters. Until a ray's end sum holds the kept value, of means the length too. Its alpha says whether the ray
// has met the drawn part of the volume.

float keptLast = float(uTableLast);
float keptEnd = uReduction == kLeast ? 0.0 : keptLast; // beyond it no value can change it
if (i < ray.count && sum.a == 0.0) {
    sum.a = 1.0;
    if (uReduction == kLeast) sum.r = keptLast;
}
while (i < ray.count && left > 0 && TURNS_LEFT) {
    TURN;
    --left;
    ++iterations;
    bool starts = startsInCurrentBrick(ray, i);
    int n = starts ? currentBrickStride(i) : strideAt(ray, i);
    float length = strideLength(ray, i, n);
    vec3 p = stridePosition(ray, i, length);
    int next = nextContributing(ray, i, n, p, sum.r);
    if (next > i) {
        i = next;
        continue;
    }
    float value = 0.0;
    if (starts && inCurrentBrick(p)) {
        value = currentBrickValue(p);
    } else {
        enterBrick(p);
        value = fieldValue(p);
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
            continue;
        }
#endif
    }
    ++segments;
    if (uReduction == kMean) {
        sum.r = sum.r + length * value;
        sum.g = sum.g + length;
    } else {
        float place = tablePlace(value);
        sum.r = uReduction == kLeast ? min(sum.r, place) : max(sum.r, place);
        if (sum.r == keptEnd) {
            i = ray.count;
            break;
        }
    }
    i += n;
}
#if !FEATURE_INTERVALS // else it has no colour until all of them are drawn (GpuCaster::image())
if (i >= ray.count && sum.a > 0.0) {
    precise float mean = sum.r / sum.g;
    sum.rgb = colourAt(uReduction == kMean ? tablePlace(mean) : sum.r);
}
#endif
