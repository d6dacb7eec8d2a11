// SPDX-License-Identifier: Apache-2.0
// The shim that lets C++ and OpenCL C compile the same functions (shared/hash.h, shared/sobol_points.h).
//
// They use uint, uint4, float2, the operators below, LUCARIUM_UINT4(x, y, z, w) for (uint4)(x, y, z, w) and
// LUCARIUM_FLOAT2(x, y); they stand between LUCARIUM_SHARED_BEGIN and LUCARIUM_SHARED_END, with
// LUCARIUM_SHARED_FUNCTION before each function and LUCARIUM_SHARED_TABLE before each constant array.
// tests/kernels/shared_functions_test compares their results on host and device.
#ifndef LUCARIUM_SHARED_FUNCTIONS_H
#define LUCARIUM_SHARED_FUNCTIONS_H
#include "lucarium/shared/dialect.h"

#if defined(__OPENCL_C_VERSION__) || defined(__OPENCL_VERSION__)

#define LUCARIUM_SHARED_BEGIN
#define LUCARIUM_SHARED_END
#define LUCARIUM_SHARED_FUNCTION
#define LUCARIUM_SHARED_TABLE constant
#define LUCARIUM_UINT4(x, y, z, w) ((uint4)(x, y, z, w))
#define LUCARIUM_FLOAT2(x, y) ((float2)(x, y))

#else

#define LUCARIUM_SHARED_BEGIN namespace lucarium {
#define LUCARIUM_SHARED_END }
#define LUCARIUM_SHARED_FUNCTION inline
#define LUCARIUM_SHARED_TABLE inline constexpr
#define LUCARIUM_UINT4(x, y, z, w) (uint4{x, y, z, w})
#define LUCARIUM_FLOAT2(x, y) (float2(x, y))

namespace lucarium {

// OpenCL's operators: component by component; a scalar stands for four.
#define LUCARIUM_UINT4_OPERATOR(op)                                                                          \
  constexpr uint4 operator op(uint4 a, uint4 b) { return {a.x op b.x, a.y op b.y, a.z op b.z, a.w op b.w}; } \
  constexpr uint4 operator op(uint4 a, uint b) { return {a.x op b, a.y op b, a.z op b, a.w op b}; }          \
  constexpr uint4& operator op##=(uint4& a, uint4 b) { return a = a op b; }
LUCARIUM_UINT4_OPERATOR(+)
LUCARIUM_UINT4_OPERATOR(*)
LUCARIUM_UINT4_OPERATOR(^)
LUCARIUM_UINT4_OPERATOR(&)
LUCARIUM_UINT4_OPERATOR(|)
LUCARIUM_UINT4_OPERATOR(<<)
LUCARIUM_UINT4_OPERATOR(>>)
#undef LUCARIUM_UINT4_OPERATOR

}  // namespace lucarium

#endif
#endif
