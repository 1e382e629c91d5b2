// render/contract/leaf_light_model.h: the numbers of a scene that what any light makes of a surface depends
// on. For scene_numbers.h and shaders alone: a row is a member in both, and a member of the shader's uniform.
//   halfway      highlights follow the direction halfway between light and viewer: 0 or 1
//   weightLow    of gradients, stored units per mm: none of a surface
//   weightScale  of the excess above that; 1 is all of a surface
#define LIGHT_MODEL(ROW)                                                                                     \
    ROW(int, halfway, 0)                                                                                     \
    ROW(float, weightLow, 0.0f)                                                                              \
    ROW(float, weightScale, 3.402823466e38f)

#define LIGHT_MODEL_MEMBER(type, name, otherwise) type name LEAF_DEFAULT(otherwise);
struct LightModel {
    LIGHT_MODEL(LIGHT_MODEL_MEMBER)
};
