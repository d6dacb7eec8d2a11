// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace lucarium {

struct DeviceInfo;

/// Whether the driver lets a program declare OpenCL C's functions itself (declare_built_ins()). PoCL 3.1 has clang read
/// 14500 declarations for every program, twice, which takes longer than most programs; it leaves them out where their
/// header's guard is defined.
bool can_declare_built_ins(const DeviceInfo& device);

/// The option of clBuildProgram that leaves out the driver's own declarations.
inline constexpr const char* without_built_ins = " -D_OPENCL_H_";

/// Declarations of those functions of OpenCL C 1.2 whose names stand in `source`, each with all its overloads and as
/// the driver declares them, so that the same code comes out. None where `source` may name one that is not known here.
std::optional<std::string> declare_built_ins(std::string_view source);

}  // namespace lucarium
