// common_leaves.glsl: the words of render/contract/leaf_*.h in GLSL: as render/contract/leaves.h has them in C++.
// Needs nothing. Gives the words of those files, both(), either(), select(), powerOfTwo(), and their vectors.

#define LEAF
#define LEAF_OF_VEC
#define LEAF_OF_MATRIX
#define LEAF_OF_CODE
#define LEAF_PLAIN
#define LEAF_STRUCT struct
#define LEAF_OF(Struct) Struct
#define LEAF_LET precise float
#define LEAF_LET3 precise vec3
#define LEAF_VAR precise float
#define LEAF_VEC3(x, y, z) vec3(x, y, z)
#define LEAF_MAKE(Struct, parts) Struct parts
#define LEAF_IN(Type) Type
#define LEAF_OUT(Type) out Type
#define LEAF_INOUT(Type) inout Type
#define LEAF_DEFAULT(value)
#define V float
#define Vec vec3
#define Mat mat3
#define Bool bool
#define Code int

bool both(bool a, bool b) { return a && b; }
bool either(bool a, bool b) { return a || b; }
float select(bool condition, float a, float b) { return condition ? a : b; }
int select(bool condition, int a, int b) { return condition ? a : b; }
float powerOfTwo(float n) { return uintBitsToFloat(uint(int(n) + 127) << 23); }

#include "leaf_vector.h"
