// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/kernel_reflection.h"

#include <algorithm>
#include <sstream>

#include "lucarium/base/error.h"
#include "lucarium/compute/device/cl_handle.h"

namespace lucarium {
namespace {

/// "const struct Camera" → "Camera", "float4 *" → "float4*".
std::string plain_type(const std::string& reported) {
  std::string type;
  std::istringstream words(reported);
  for (std::string word; words >> word;) {
    if (word == "const" || word == "volatile" || word == "restrict" || word == "struct" || word.starts_with("__"))
      continue;
    if (!type.empty() && word[0] != '*') type += ' ';
    type += word;
  }
  return type;
}

class KernelReader {
 public:
  KernelReader(const Device& device, cl_kernel kernel, const std::string& program) : device_(device), kernel_(kernel) {
    about_ = "program " + program;
    name_ = text(CL_KERNEL_FUNCTION_NAME);
    about_ = fmt::format("kernel {} of {}", name_, program);
  }

  KernelSignature read() const {
    KernelSignature signature;
    signature.name = name_;
    cl_uint count = 0;
    check_opencl(clGetKernelInfo(kernel_, CL_KERNEL_NUM_ARGS, sizeof count, &count, nullptr), "clGetKernelInfo", about_,
                 device_);
    for (cl_uint i = 0; i < count; ++i) signature.arguments.push_back(argument(i));
    check_opencl(clGetKernelWorkGroupInfo(kernel_, device_.id(), CL_KERNEL_COMPILE_WORK_GROUP_SIZE,
                                          sizeof signature.required_work_group_size, signature.required_work_group_size,
                                          nullptr),
                 "clGetKernelWorkGroupInfo", about_, device_);
    return signature;
  }

 private:
  KernelArgument argument(cl_uint index) const {
    KernelArgument result;
    result.name = argument_text(index, CL_KERNEL_ARG_NAME);
    result.type = plain_type(argument_text(index, CL_KERNEL_ARG_TYPE_NAME));
    const auto address = argument_value<cl_kernel_arg_address_qualifier>(index, CL_KERNEL_ARG_ADDRESS_QUALIFIER);
    const auto qualifier = argument_value<cl_kernel_arg_type_qualifier>(index, CL_KERNEL_ARG_TYPE_QUALIFIER);
    if (address == CL_KERNEL_ARG_ADDRESS_LOCAL) {
      result.access = ArgumentAccess::local;
    } else if (address == CL_KERNEL_ARG_ADDRESS_PRIVATE) {
      result.access = ArgumentAccess::value;
    } else {
      const bool constant = address == CL_KERNEL_ARG_ADDRESS_CONSTANT || (qualifier & CL_KERNEL_ARG_TYPE_CONST);
      result.access = constant ? ArgumentAccess::read : ArgumentAccess::read_write;
    }
    return result;
  }

  std::string text(cl_kernel_info key) const {
    size_t bytes = 0;
    check_opencl(clGetKernelInfo(kernel_, key, 0, nullptr, &bytes), "clGetKernelInfo", about_, device_);
    std::string value(bytes, '\0');
    check_opencl(clGetKernelInfo(kernel_, key, bytes, value.data(), nullptr), "clGetKernelInfo", about_, device_);
    value.resize(std::min(value.find('\0'), value.size()));
    return value;
  }

  std::string argument_text(cl_uint index, cl_kernel_arg_info key) const {
    size_t bytes = 0;
    check_opencl(clGetKernelArgInfo(kernel_, index, key, 0, nullptr, &bytes), "clGetKernelArgInfo", about_, device_);
    std::string value(bytes, '\0');
    check_opencl(clGetKernelArgInfo(kernel_, index, key, bytes, value.data(), nullptr), "clGetKernelArgInfo", about_,
                 device_);
    value.resize(std::min(value.find('\0'), value.size()));
    return value;
  }

  template <class T>
  T argument_value(cl_uint index, cl_kernel_arg_info key) const {
    T value{};
    check_opencl(clGetKernelArgInfo(kernel_, index, key, sizeof value, &value, nullptr), "clGetKernelArgInfo", about_,
                 device_);
    return value;
  }

  const Device& device_;
  cl_kernel kernel_;
  std::string name_, about_;
};

}  // namespace

std::vector<KernelSignature> reflect_kernels(const Device& device, cl_program program,
                                             const std::string& program_name) {
  cl_uint count = 0;
  const cl_int counted = clCreateKernelsInProgram(program, 0, nullptr, &count);
  if (counted == CL_SUCCESS && count == 0) {
    throw_error(ErrorClass::device, "program {} has no kernels", program_name);
  }
  check_opencl(counted, "clCreateKernelsInProgram", "program " + program_name, device);
  std::vector<cl_kernel> created(count);
  check_opencl(clCreateKernelsInProgram(program, count, created.data(), nullptr), "clCreateKernelsInProgram",
               "program " + program_name, device);
  std::vector<ClKernel> kernels;
  for (const cl_kernel kernel : created) kernels.emplace_back(kernel);
  std::vector<KernelSignature> signatures;
  for (const ClKernel& kernel : kernels) signatures.push_back(KernelReader(device, kernel.get(), program_name).read());
  return signatures;
}

}  // namespace lucarium
