// render/contract/leaf_light.h: the effect of light on colours, and of gradients on opacities
// (docs/sampling.md, "Shading", "Gradient opacity"). For leaves.h and shaders alone: C++ and GLSL in one
// text.

LEAF V wholePower(V x, int n) {
    LEAF_VAR result = V(1.0f), square = x;
    for (; n > 0; n >>= 1) {
        if ((n & 1) != 0)
            result = result * square;
        square = square * square;
    }
    return result;
}

/// True if a vector of this squared length has a direction: not for 0, nor for more than V can hold.
LEAF Bool isDirection(V squared, V largest) {
    return both(squared > V(0.0f), squared <= largest);
}
/// Towards the viewer, unit; 0 where there is none.
/// @param g  a gradient
/// @param d  the ray's direction, in the space of g
LEAF_OF_VEC Vec facingNormal(LEAF_IN(Vec) g, LEAF_IN(Vec) d, V length, Bool isOne) {
    LEAF_LET zero = V(0.0f);
    LEAF_LET facing = select(dot3(g, d) > zero, V(-1.0f), V(1.0f)) / length;
    LEAF_LET x = g.x * facing, y = g.y * facing, z = g.z * facing;
    return LEAF_VEC3(select(isOne, x, zero), select(isOne, y, zero), select(isOne, z, zero));
}

/// Gradient opacity: the length of a gradient, also where it is no number.
LEAF_OF_VEC V steepness(LEAF_IN(Vec) g, V largest) {
    LEAF_LET squared = dot3(g, g);
    LEAF_LET length = sqrt(select(squared <= largest, squared, largest));
    return length;
}
/// The factor that it had by the points before, or that of the next one.
/// @param from, value, slope  of that point
LEAF V factorFrom(V factor, V steep, V from, V value, V slope) {
    LEAF_LET along = value + (steep - from) * slope;
    return select(from <= steep, along, factor);
}

/// The effect of a head light on colours: colour * scale + add.
LEAF_STRUCT HeadLight {
    V scale, add;
};
/// For places with light; elsewhere colours stay as they are.
/// @param g, d  gradient and direction, patient space, any scale
LEAF_OF_VEC Bool isHeadLit(LEAF_IN(Vec) g, LEAF_IN(Vec) d, V largest) {
    LEAF_LET lengths = dot3(g, g) * dot3(d, d);
    return isDirection(lengths, largest);
}
LEAF_OF_VEC LEAF_OF(HeadLight)
    headLight(LEAF_IN(Vec) g, LEAF_IN(Vec) d, V ambient, V diffuse, V specular, int power) {
    LEAF_LET lengths = dot3(g, g) * dot3(d, d);
    LEAF_LET cosine = min(V(1.0f), abs(dot3(g, d)) / sqrt(lengths));
    LEAF_LET mirrored = max(V(0.0f), V(2.0f) * cosine * cosine - V(1.0f)); // light and viewer on one line
    LEAF_LET scale = ambient + diffuse * cosine, add = specular * wholePower(mirrored, power);
    return LEAF_MAKE(HeadLight, (scale, add));
}

/// The geometry of a lit place: the share of a surface there, and the cosine of the viewer's direction to its
/// normal.
LEAF_STRUCT Met {
    V weight, towardsViewer;
};
/// The normal and the direction towards the viewer besides, both unit or 0.
LEAF_OF_VEC LEAF_OF(Met) meetLight(LEAF_IN(Vec) g, LEAF_IN(Vec) d, LEAF_IN(LightModel) model, V largest,
                                   LEAF_OUT(Vec) normal, LEAF_OUT(Vec) viewer) {
    LEAF_LET zero = V(0.0f);
    LEAF_LET squared = dot3(g, g), distance = dot3(d, d);
    Bool isSurface = both(isDirection(squared, largest), isDirection(distance, largest));
    LEAF_LET steep = sqrt(squared), far = sqrt(distance);
    LEAF_LET x = (zero - d.x) / far, y = (zero - d.y) / far, z = (zero - d.z) / far;
    LEAF_LET above = (steep - V(model.weightLow)) * V(model.weightScale), part = heldToOne(above);
    LEAF_LET share = part * part * (V(3.0f) - V(2.0f) * part);
    normal = facingNormal(g, d, steep, isSurface);
    viewer = LEAF_VEC3(select(isSurface, x, zero), select(isSurface, y, zero), select(isSurface, z, zero));
    LEAF_LET weight = select(isSurface, share, zero);
    LEAF_LET towardsViewer = dot3(normal, viewer);
    return LEAF_MAKE(Met, (weight, towardsViewer));
}
/// Of a light in a point: its direction, unit or 0, and the share that is left at a sample.
/// @param to  from the sample to the point, patient space, mm
LEAF_OF_VEC void meetPoint(LEAF_IN(Vec) to, V constant, V linear, V quadratic, V largest,
                           LEAF_OUT(Vec) direction, LEAF_OUT(V) share) {
    LEAF_LET zero = V(0.0f), squared = min(dot3(to, to), largest), away = sqrt(squared);
    Bool isAway = squared > zero;
    LEAF_LET x = to.x / away, y = to.y / away, z = to.z / away;
    LEAF_LET left = V(1.0f) / (constant + linear * away + quadratic * squared);
    direction = LEAF_VEC3(select(isAway, x, zero), select(isAway, y, zero), select(isAway, z, zero));
    share = left;
}
/// The base of a highlight's power.
/// @param slant  cosine of the light's direction to the normal
LEAF_OF_VEC V sharpness(LEAF_IN(Vec) normal, LEAF_IN(Vec) viewer, LEAF_IN(Vec) light, V slant,
                        LEAF_IN(LEAF_OF(Met)) met, LEAF_IN(LightModel) model) {
    LEAF_VAR sharp = V(0.0f);
    if (model.halfway != 0) {
        LEAF_LET3 h = LEAF_VEC3(light.x + viewer.x, light.y + viewer.y, light.z + viewer.z);
        LEAF_LET squared = dot3(h, h);
        LEAF_LET along = dot3(normal, h) / sqrt(squared);
        sharp = select(squared > V(0.0f), along, V(0.0f));
    } else {
        sharp = V(2.0f) * slant * met.towardsViewer - dot3(light, viewer);
    }
    return heldToOne(sharp);
}
/// The effect of lights on a channel: colour * scale + add.
/// @param everywhere, facing, mirrored  sums over lights: all of them, by their slant, by their highlights
LEAF V litScale(LEAF_IN(LEAF_OF(Met)) met, V ambient, V diffuse, V everywhere, V facing) {
    LEAF_LET volume = ambient + diffuse * everywhere, surface = ambient + diffuse * facing;
    LEAF_LET scale = volume + met.weight * (surface - volume);
    return scale;
}
LEAF V litAdd(LEAF_IN(LEAF_OF(Met)) met, V specular, V mirrored) {
    LEAF_LET add = met.weight * (specular * mirrored);
    return add;
}
