// render/verify/verify_plan.h
#pragma once
