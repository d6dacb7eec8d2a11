// SPDX-License-Identifier: Apache-2.0
// What the tests of the device layer share.
#pragma once
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "device_fixture.h"
#include "lucarium/base/error.h"
#include "lucarium/compute/device/buffer.h"
#include "lucarium/compute/device/cl_handle.h"
#include "lucarium/compute/program/program.h"
#include "scoped_variable.h"
#include "test_support.h"

namespace lucarium::test {

/// The Error that `action` throws; class check_failed when it throws none.
inline Error error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error;
  }
  return Error(ErrorClass::check_failed, "nothing was thrown");
}

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A kernel `void NAME(global uint* values, …)` over `count` values, launched with this local size; returns the values.
inline std::vector<uint32_t> launch(const Program& program, const std::string& kernel, size_t count, size_t local) {
  Device& device = program.device();
  TypedBuffer<uint32_t> values(device, "test", "values", count);
  cl_int code = CL_SUCCESS;
  const ClKernel object(clCreateKernel(program.handle(), kernel.c_str(), &code));
  check_opencl(code, "clCreateKernel", kernel, device);
  const cl_mem memory = values.handle();
  check_opencl(clSetKernelArg(object.get(), 0, sizeof memory, &memory), "clSetKernelArg", kernel, device);
  check_opencl(clEnqueueNDRangeKernel(device.queue(), object.get(), 1, nullptr, &count, &local, 0, nullptr, nullptr),
               "clEnqueueNDRangeKernel", kernel, device);
  return values.download();
}

/// Runs one test case of this executable, marked skip(), in a process of its own. `environment` as for a shell.
inline ProgramResult run_case(const std::string& name, const std::string& environment = "") {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  return run_program(environment + " '" + self + "' --no-skip --no-intro --test-case='" + name + "'", 120);
}

}  // namespace lucarium::test
