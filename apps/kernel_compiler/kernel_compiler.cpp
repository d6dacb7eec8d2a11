// SPDX-License-Identifier: Apache-2.0
// Compiles kernels for the process that started it: `lucarium_kernel_compiler PLATFORM DEVICE`. Each line of standard
// input is a JSON object that describes one launch (lucarium/compute/device/kernel_compilers.h); the answer "done" says
// that its launch code lies in PoCL's folder, which both processes share (POCL_CACHE_DIR). Any failure ends it.
//
// PoCL compiles launch code when a kernel is launched, and there is no other way to ask for it. So kernels are launched
// here, without memory, and PoCL is given a function that does nothing in place of what it has compiled.
#include <CL/cl.h>
#include <dlfcn.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace {

std::atomic<bool> handed_out = false;
void do_nothing() {}

using Lookup = void* (*)(void*, const char*);

Lookup real_lookup() {
  for (const char* version : {"GLIBC_2.34", "GLIBC_2.2.5", "GLIBC_2.17"}) {
    if (void* found = dlvsym(RTLD_NEXT, "dlsym", version)) return reinterpret_cast<Lookup>(found);
  }
  std::abort();
}

}  // namespace

/// Stands before the system's function of this name: the driver looks up here what it has compiled.
extern "C" [[gnu::visibility("default")]] void* dlsym(void* library, const char* name) noexcept {
  static const Lookup look_up = real_lookup();
  const std::string_view text = name;
  if (text.find("pocl_kernel_") != text.npos && text.ends_with("_workgroup")) {
    handed_out = true;
    return reinterpret_cast<void*>(&do_nothing);
  }
  return look_up(library, name);
}

namespace {

void check(cl_int code) {
  if (code != CL_SUCCESS) throw std::runtime_error("OpenCL error " + std::to_string(code));
}

template <class Object, class Query>
std::string text_of(Query query, Object object, cl_uint key) {
  size_t bytes = 0;
  check(query(object, key, 0, nullptr, &bytes));
  std::string text(bytes, '\0');
  check(query(object, key, bytes, text.data(), nullptr));
  return text.substr(0, text.find_last_not_of(std::string(" \0", 2)) + 1);
}

cl_device_id find_device(const std::string& platform_name, const std::string& device_name) {
  cl_uint count = 0;
  check(clGetPlatformIDs(0, nullptr, &count));
  std::vector<cl_platform_id> platforms(count);
  check(clGetPlatformIDs(count, platforms.data(), nullptr));
  for (const cl_platform_id platform : platforms) {
    if (text_of(clGetPlatformInfo, platform, CL_PLATFORM_NAME) != platform_name) continue;
    check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count));
    std::vector<cl_device_id> devices(count);
    check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, devices.data(), nullptr));
    for (const cl_device_id device : devices) {
      if (text_of(clGetDeviceInfo, device, CL_DEVICE_NAME) == device_name) return device;
    }
  }
  throw std::runtime_error("no such device");
}

class Compiler {
 public:
  explicit Compiler(cl_device_id device) : device_(device) {
    cl_int code = CL_SUCCESS;
    context_ = clCreateContext(nullptr, 1, &device_, nullptr, nullptr, &code);
    check(code);
    queue_ = clCreateCommandQueue(context_, device_, 0, &code);
    check(code);
  }

  void compile(const nlohmann::json& request) {
    cl_int code = CL_SUCCESS;
    const cl_kernel kernel = clCreateKernel(program(request.at("source"), request.at("options")),
                                            request.at("kernel").get<std::string>().c_str(), &code);
    check(code);
    cl_uint position = 0;
    for (const nlohmann::json& argument : request.at("arguments")) {
      const std::string kind = argument.at("kind");
      std::vector<char> zeros(kind == "value" ? argument.at("bytes").get<size_t>() : 0);
      const size_t bytes = kind == "buffer" ? sizeof(cl_mem) : argument.at("bytes").get<size_t>();
      check(clSetKernelArg(kernel, position++, bytes, kind == "value" ? zeros.data() : nullptr));
    }
    const std::array<size_t, 3> global = request.at("global"), local = request.at("local");
    check(clEnqueueNDRangeKernel(queue_, kernel, 3, nullptr, global.data(), local.data(), 0, nullptr, nullptr));
    check(clFinish(queue_));
    check(clReleaseKernel(kernel));
    if (!handed_out) throw std::runtime_error("the driver does not look up its code here");
  }

 private:
  /// Built as the other process built it, so that the driver finds the program in its folder.
  cl_program program(const std::string& file, const std::string& options) {
    cl_program& program = programs_[file];
    if (program) return program;
    std::ifstream in(file, std::ios::binary);
    const std::string source{std::istreambuf_iterator<char>(in), {}};
    const char* text = source.c_str();
    const size_t length = source.size();
    cl_int code = CL_SUCCESS;
    program = clCreateProgramWithSource(context_, 1, &text, &length, &code);
    check(code);
    check(clBuildProgram(program, 1, &device_, options.c_str(), nullptr, nullptr));
    return program;
  }

  cl_device_id device_;
  cl_context context_ = nullptr;
  cl_command_queue queue_ = nullptr;
  std::map<std::string, cl_program> programs_;
};

/// A kernel may take seconds, and nobody wants it when the other process is gone.
void end_with_other_process() {
  pollfd input{STDIN_FILENO, 0, 0};  // hang-ups are always reported
  while (::poll(&input, 1, -1) < 0 || !(input.revents & (POLLHUP | POLLERR))) {
  }
  ::_exit(0);
}

}  // namespace

int main(int count, char** arguments) try {
  if (count != 3) throw std::runtime_error("started by the framework, with the names of a platform and a device");
  std::thread(end_with_other_process).detach();
  Compiler compiler(find_device(arguments[1], arguments[2]));
  for (std::string line; std::getline(std::cin, line);) {
    compiler.compile(nlohmann::json::parse(line));
    std::cout << "done" << std::endl;
  }
  return 0;
} catch (const std::exception& error) {
  std::cerr << "lucarium_kernel_compiler: " << error.what() << '\n';
  return 1;
}
