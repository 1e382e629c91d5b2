// render/verify/verify_plan.cpp: see verify_plan.h.
#include "render/verify/verify_plan.h"
