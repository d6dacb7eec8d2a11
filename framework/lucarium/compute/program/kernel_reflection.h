// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/compute/program/program.h"

namespace lucarium {

/// Signatures of all kernels of a program that was built with -cl-kernel-arg-info, in the driver's order. Throws
/// Error{device} when the program has no kernel or the driver gives no signatures.
std::vector<KernelSignature> reflect_kernels(const Device& device, cl_program program, const std::string& program_name);

}  // namespace lucarium
