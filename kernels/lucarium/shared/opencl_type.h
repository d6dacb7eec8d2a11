// SPDX-License-Identifier: Apache-2.0
// For C++ only.
#pragma once
#if !defined(__OPENCL_C_VERSION__) && !defined(__OPENCL_VERSION__)
#include <cstdint>
#include <string_view>

namespace lucarium {

/// The OpenCL name of a C++ type that is passed by value, so that a mistyped argument is found when the pass is
/// recorded. Shared structs specialise it through LUCARIUM_STRUCT_END (kernels/lucarium/shared/dialect.h).
template <class T>
struct OpenClType;

#define LUCARIUM_OPENCL_TYPE(cpp, cl)            \
  template <>                                    \
  struct OpenClType<cpp> {                       \
    static constexpr std::string_view name = cl; \
  }
LUCARIUM_OPENCL_TYPE(int32_t, "int");
LUCARIUM_OPENCL_TYPE(uint32_t, "uint");
LUCARIUM_OPENCL_TYPE(int64_t, "long");
LUCARIUM_OPENCL_TYPE(uint64_t, "ulong");
LUCARIUM_OPENCL_TYPE(float, "float");
LUCARIUM_OPENCL_TYPE(double, "double");
#undef LUCARIUM_OPENCL_TYPE

}  // namespace lucarium

#endif
