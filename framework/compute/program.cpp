// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program.h"

#include <algorithm>
#include <chrono>

#include "lucarium/base/error.h"
#include "lucarium/base/nearest_name.h"
#include "lucarium/compute/cl_handle.h"
#include "lucarium/compute/kernel_reflection.h"

namespace lucarium {
namespace {

/// Defines stand in the source and not on the driver's command line, so that any value is passed on untouched.
std::string preamble(const ProgramSpec& spec) {
  std::string text = fmt::format("#line 1 \"<defines of {}>\"\n", spec.name);
  // OpenCL C contracts a*b+c by default; the options offer no way to forbid it.
  if (!spec.mad_enable) text += "#pragma OPENCL FP_CONTRACT OFF\n";
  for (const auto& [name, value] : spec.defines) {
    if (value.find('\n') != std::string::npos) {
      throw_error(ErrorClass::internal, "program {}: the value of define {} has a line break", spec.name, name);
    }
    text += fmt::format("#define {} {}\n", name, value.empty() ? "1" : value);
  }
  return text;
}

std::string build_options(const ProgramSpec& spec) {
  return std::string("-cl-std=CL1.2 -cl-kernel-arg-info") + (spec.mad_enable ? " -cl-mad-enable" : "");
}

std::string build_log(cl_program program, const Device& device) {
  size_t bytes = 0;
  if (clGetProgramBuildInfo(program, device.id(), CL_PROGRAM_BUILD_LOG, 0, nullptr, &bytes) != CL_SUCCESS) return "";
  std::string log(bytes, '\0');
  clGetProgramBuildInfo(program, device.id(), CL_PROGRAM_BUILD_LOG, bytes, log.data(), nullptr);
  log.resize(std::min(log.find('\0'), log.size()));
  return log;
}

/// The compiler's first error with file and line, or the first line that says anything.
std::string first_error(const std::string& log) {
  std::string fallback;
  for (std::string_view rest = log; !rest.empty();) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.find("error:") != std::string_view::npos) return std::string(line);
    if (fallback.empty() && line.find_first_not_of(" \t\r") != std::string_view::npos) fallback = line;
  }
  return fallback.empty() ? "the driver gives no reason" : fallback;
}

ClProgram compile(const Device& device, const ProgramSpec& spec, const std::string& source) {
  const char* text = source.c_str();
  const size_t length = source.size();
  cl_int code = CL_SUCCESS;
  ClProgram program(clCreateProgramWithSource(device.context(), 1, &text, &length, &code));
  check_opencl(code, "clCreateProgramWithSource", "program " + spec.name, device);
  const cl_device_id id = device.id();
  code = clBuildProgram(program.get(), 1, &id, build_options(spec).c_str(), nullptr, nullptr);
  if (code == CL_BUILD_PROGRAM_FAILURE) {
    const std::string log = build_log(program.get(), device);
    throw Error(ErrorClass::device, fmt::format("program {} does not compile: {}", spec.name, first_error(log)))
        .with_details(fmt::format("build log of {} on {}:\n{}", spec.name, device.info().name, log));
  }
  check_opencl(code, "clBuildProgram", "program " + spec.name, device);
  return program;
}

}  // namespace

struct Program::State {
  std::shared_ptr<Device> device;
  std::string name;
  ClProgram program;
  std::map<std::string, KernelSignature, std::less<>> signatures;
  bool from_cache = false;
  double build_seconds = 0;
};

Program::Program(Device& device, const SourceLibrary& library, const ProgramSpec& spec)
    : state_(std::make_shared<State>()) {
  const auto start = std::chrono::steady_clock::now();
  state_->device = device.shared_from_this();
  state_->name = spec.name;
  const std::string source = preamble(spec) + library.preprocess(spec.files);
  state_->program = compile(device, spec, source);
  for (KernelSignature& signature : reflect_kernels(device, state_->program.get(), spec.name)) {
    std::string name = signature.name;
    state_->signatures.emplace(std::move(name), std::move(signature));
  }
  state_->build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

const std::string& Program::name() const { return state_->name; }
Device& Program::device() const { return *state_->device; }
cl_program Program::handle() const { return state_->program.get(); }
bool Program::from_cache() const { return state_->from_cache; }
double Program::build_seconds() const { return state_->build_seconds; }

const KernelSignature& Program::signature(std::string_view kernel) const {
  const auto found = state_->signatures.find(kernel);
  if (found != state_->signatures.end()) return found->second;
  throw_error(ErrorClass::device, "program {} has no kernel '{}'{}", name(), kernel,
              suggest_name(kernel, kernel_names()));
}

std::vector<std::string> Program::kernel_names() const {
  std::vector<std::string> names;
  for (const auto& [name, signature] : state_->signatures) names.push_back(name);
  return names;
}

}  // namespace lucarium
