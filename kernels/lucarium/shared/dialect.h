// SPDX-License-Identifier: Apache-2.0
// The shim that lets C++ and OpenCL C read the same struct definitions (kernels/lucarium/shared/*.h).
//
// Shared structs may hold float, int, uint, float2/4, int2/4, uint2/4, and other shared structs. Forbidden, because
// their size or alignment differs between the two languages: float3 and friends, bool, size_t, pointers, enums.
// Every shared struct ends with LUCARIUM_STRUCT_END(Name, bytes), which asserts its size on the host and names it
// for argument checks; tests/kernels/struct_layout_test compares size and offsets with the device's.
#ifndef LUCARIUM_SHARED_DIALECT_H
#define LUCARIUM_SHARED_DIALECT_H

#if defined(__OPENCL_C_VERSION__) || defined(__OPENCL_VERSION__)

#define LUCARIUM_STRUCT_BEGIN(Name) typedef struct Name {
#define LUCARIUM_STRUCT_END(Name, bytes) \
  }                                      \
  Name;

#else

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "lucarium/shared/opencl_type.h"

namespace lucarium {

using uint = uint32_t;

struct alignas(8) float2 {
  float x = 0, y = 0;
  float2() = default;
  float2(float x_, float y_) : x(x_), y(y_) {}
  float2(const glm::vec2& v) : x(v.x), y(v.y) {}
};
struct alignas(16) float4 {
  float x = 0, y = 0, z = 0, w = 0;
  float4() = default;
  float4(float x_, float y_, float z_, float w_) : x(x_), y(y_), z(z_), w(w_) {}
  float4(const glm::vec3& v, float w_) : x(v.x), y(v.y), z(v.z), w(w_) {}
  float4(const glm::vec4& v) : x(v.x), y(v.y), z(v.z), w(v.w) {}
  glm::vec3 xyz() const { return {x, y, z}; }
};
struct alignas(8) uint2 {
  uint x = 0, y = 0;
};
struct alignas(16) uint4 {
  uint x = 0, y = 0, z = 0, w = 0;
};
struct alignas(8) int2 {
  int x = 0, y = 0;
};
struct alignas(16) int4 {
  int x = 0, y = 0, z = 0, w = 0;
};

#define LUCARIUM_VECTOR_TYPE(T)                  \
  template <>                                    \
  struct OpenClType<T> {                         \
    static constexpr std::string_view name = #T; \
  }
LUCARIUM_VECTOR_TYPE(float2);
LUCARIUM_VECTOR_TYPE(float4);
LUCARIUM_VECTOR_TYPE(uint2);
LUCARIUM_VECTOR_TYPE(uint4);
LUCARIUM_VECTOR_TYPE(int2);
LUCARIUM_VECTOR_TYPE(int4);
#undef LUCARIUM_VECTOR_TYPE

}  // namespace lucarium

#define LUCARIUM_STRUCT_BEGIN(Name) \
  namespace lucarium {              \
  struct Name {
#define LUCARIUM_STRUCT_END(Name, bytes)                                                        \
  }                                                                                             \
  ;                                                                                             \
  static_assert(sizeof(Name) == (bytes), #Name " must have the same size in C++ and OpenCL C"); \
  template <>                                                                                   \
  struct OpenClType<Name> {                                                                     \
    static constexpr std::string_view name = #Name;                                             \
  };                                                                                            \
  }

#endif
#endif
