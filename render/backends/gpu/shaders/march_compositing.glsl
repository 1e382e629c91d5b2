// march_compositing.glsl: laying a colour under what a ray has gathered; twin of render/contract/compositing.h.
// Needs nothing. Gives composite(sum, colour, alpha).

// Front to back. The weight is what alpha really grew by: near 1 it no longer grows, and colour must not either.
void composite(inout vec4 sum, vec3 colour, float alpha) {
    precise float after = sum.a + (1.0 - sum.a) * alpha; // exactly 1 where alpha is
    precise float weight = after - sum.a;
    precise vec3 gathered = sum.rgb + weight * colour;
    sum = vec4(gathered, after);
}
