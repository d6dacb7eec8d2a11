// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace lucarium {

enum class ArgumentAccess { value, read, read_write, local };

/// One kernel argument as the compiler reports it (-cl-kernel-arg-info).
struct KernelArgument {
  std::string name;
  std::string type;  ///< OpenCL type name without qualifiers: "float4*", "uint", "Camera"
  ArgumentAccess access = ArgumentAccess::value;
};

/// Signature of one kernel; obtained from Program::kernel(). Every pass creates its own cl_kernel from it, because
/// argument values live in the kernel object.
struct KernelSignature {
  std::string name;
  std::vector<KernelArgument> arguments;
  size_t required_work_group_size[3] = {0, 0, 0};  ///< 0: none
};

}  // namespace lucarium
