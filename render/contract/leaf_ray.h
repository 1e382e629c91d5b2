// render/contract/leaf_ray.h: a picture's ray and its clipping (docs/sampling.md, "Ray"). For leaves.h and
// shaders alone: C++ and GLSL in one text.

/// The line through a place on the picture, by a plane near the volume: voxels.
/// @param px, py, width, height  the place and the picture, pixels
/// @param distance  from the plane back to the eye
LEAF_OF_VEC void lineThrough(V px, V py, V width, V height, LEAF_IN(Vec) centre, LEAF_IN(Vec) right,
                             LEAF_IN(Vec) up, LEAF_IN(Vec) toCentre, bool perspective, LEAF_OUT(Vec) base,
                             LEAF_OUT(Vec) direction, LEAF_OUT(V) distance) {
    LEAF_LET x = V(2.0f) * px / width - V(1.0f);
    LEAF_LET y = V(1.0f) - V(2.0f) * py / height;
    LEAF_LET3 offset = x * right + y * up, on = centre + offset, slanted = toCentre + offset;
    LEAF_LET3 along = perspective ? slanted : toCentre;
    LEAF_LET far = length3(along);
    LEAF_LET3 unit = LEAF_VEC3(along.x / far, along.y / far, along.z / far);
    base = on;
    direction = unit;
    distance = far;
}

LEAF_OF_VEC Vec placeAlong(LEAF_IN(Vec) from, LEAF_IN(Vec) step, V steps) {
    LEAF_LET3 at = from + steps * step;
    return at;
}
/// From the start of segment i to the middle of a stride, segments.
LEAF V strideMiddle(V i, V length) {
    LEAF_LET middle = i + V(0.5f) * length;
    return middle;
}
/// Where a ray has seen nothing yet; of firstSeen.
const float kNothingSeen = -1.0e9f;
/// The stretch of a ray that is sought again for the place where a path of light begins: from where the ray
/// first saw something, and half a stride before, if that is near; else the stride alone. Segments.
/// @param i, length  the stride that holds the place
/// @param firstSeen  the start of the first stride that shows something
LEAF V soughtFrom(V i, V length, V firstSeen) {
    LEAF_LET early = max(V(0.0f), firstSeen - V(0.5f) * length), far = i - firstSeen;
    return select(far > V(2.0f) * length, i, early);
}
/// The share of the stretch's opacity in front of the place.
/// @param from  soughtFrom()
/// @param sought  opacity of the ray at the place
/// @param before  opacity in front of the stride
/// @param opacity, share  of the stride: all of it, and what is in front of the place
LEAF V soughtShare(V i, V from, V sought, V before, V opacity, V share) {
    LEAF_LET all = before + (V(1.0f) - before) * opacity;
    LEAF_LET ofStride = share / opacity, ofRay = min(V(1.0f), sought / all);
    return select(from < i, ofRay, ofStride);
}
/// Parts of the stretch.
const int kSoughtParts = 8;

/// Clips [t0, t1] to the part between two planes, of the volume's box or of a slab. True where a line runs
/// along them outside, or they are one plane. It divides and does not multiply by a reciprocal, which would
/// miss rays that lie in a face of the box.
/// @param o, d  of the line across the planes
LEAF Bool clip(V o, V d, V low, V high, LEAF_INOUT(V) t0, LEAF_INOUT(V) t1) {
    Bool runsAlong = d == V(0.0f);
    LEAF_LET a = (low - o) / d, b = (high - o) / d;
    LEAF_LET enters = max(t0, min(a, b)), leaves = min(t1, max(a, b));
    t0 = select(runsAlong, t0, enters);
    t1 = select(runsAlong, t1, leaves);
    return both(runsAlong, either(either(low > o, o > high), high <= low));
}

/// The phase of the ray at a column and row of an array of phased rays, in segments. The lattice begins by so
/// much behind (before, if negative) the ray's entry into the drawn part of the volume. It is -7/16 to 7/16,
/// so that the middle of the first segment is within. Of every eight rays that follow one another in a patch
/// of 4 x 4 (pixel_places.h) each has another one. Those of the first four lie between those of the last.
LEAF_PLAIN float phaseOf(int column, int row) {
    int k = (column & 1) + 2 * (row & 1) + 4 * ((column >> 1) & 1); // of eight
    return float(2 * (k & 3) + (k >> 2)) / 8.0f - 7.0f / 16.0f;
}
