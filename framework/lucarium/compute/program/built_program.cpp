// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/built_program.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/compute/device/pocl_folder.h"
#include "lucarium/compute/device/program_cache.h"
#include "lucarium/compute/program/built_ins.h"
#include "lucarium/compute/program/identifiers.h"
#include "lucarium/compute/program/kernel_reflection.h"
#include "lucarium/compute/program/line_names.h"
#include "lucarium/compute/program/pocl_files.h"

namespace lucarium {
namespace {

/// Defines stand in the source and not on the driver's command line, so that any value is passed on untouched.
/// Those that nothing names are left out: what differs only by them is one program.
std::string preamble(const ProgramSpec& spec, const std::string& sources) {
  std::string text = fmt::format("#line 1 \"<defines of {}>\"\n", spec.name);
  // clang warns of every 64-byte vector that a function takes or returns on a processor without AVX-512, and PoCL has
  // it print how often. All of a program is compiled for the same processor, so that nothing disagrees.
  text +=
      "#if defined(__clang__) && defined(__has_warning)\n#if __has_warning(\"-Wpsabi\")\n"
      "#pragma clang diagnostic ignored \"-Wpsabi\"\n#endif\n#endif\n";
  // OpenCL C contracts a*b+c by default; the options offer no way to forbid it.
  if (!spec.mad_enable) text += "#pragma OPENCL FP_CONTRACT OFF\n";
  for (const auto& [name, value] : spec.defines) {
    if (value.find('\n') != std::string::npos) {
      throw_error(ErrorClass::internal, "program {}: the value of define {} has a line break", spec.name, name);
    }
  }
  for (const auto& [name, value] : named_defines(spec.defines, sources)) {
    text += fmt::format("#define {} {}\n", name, value.empty() ? "1" : value);
  }
  return text;
}

std::string build_options(const ProgramSpec& spec) {
  return std::string("-cl-std=CL1.2 -cl-kernel-arg-info") + (spec.mad_enable ? " -cl-mad-enable" : "");
}

/// The same program in the way in which the driver builds it faster; none where there is no such way.
std::optional<ProgramText> faster_text(const Device& device, const ProgramText& text) {
  if (!can_declare_built_ins(device.info())) return std::nullopt;
  const std::optional<std::string> declarations = declare_built_ins(text.source);
  if (!declarations) return std::nullopt;
  return ProgramText{*declarations + text.source, text.options + without_built_ins};
}

/// What the compiler said of `source`.
std::string build_log(cl_program program, const Device& device, const std::string& source) {
  size_t bytes = 0;
  if (clGetProgramBuildInfo(program, device.id(), CL_PROGRAM_BUILD_LOG, 0, nullptr, &bytes) != CL_SUCCESS) return "";
  std::string log(bytes, '\0');
  clGetProgramBuildInfo(program, device.id(), CL_PROGRAM_BUILD_LOG, bytes, log.data(), nullptr);
  log.resize(std::min(log.find('\0'), log.size()));
  return name_lines(log, source);
}

/// The compiler's first error with file and line, or the first line that says anything.
std::string first_error(const std::string& log) {
  std::string fallback;
  for (std::string_view rest = log; !rest.empty();) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const bool is_error = line.find("error:") != std::string_view::npos;
    if (constexpr std::string_view prefix = "error: "; line.starts_with(prefix)) line.remove_prefix(prefix.size());
    if (is_error) return std::string(line);
    if (fallback.empty() && line.find_first_not_of(" \t\r") != std::string_view::npos) fallback = line;
  }
  return fallback.empty() ? "the driver gives no reason" : fallback;
}

void build(cl_program program, const Device& device, const ProgramSpec& spec, const ProgramText& text) {
  const cl_device_id id = device.id();
  const cl_int code = clBuildProgram(program, 1, &id, text.options.c_str(), nullptr, nullptr);
  if (code == CL_BUILD_PROGRAM_FAILURE) {
    const std::string log = build_log(program, device, text.source);
    throw Error(ErrorClass::device, fmt::format("program {} does not compile: {}", spec.name, first_error(log)))
        .with_details(fmt::format("build log of {} on {}:\n{}", spec.name, device.info().name, log));
  }
  check_opencl(code, "clBuildProgram", "program " + spec.name, device);
  const std::string log = build_log(program, device, text.source);
  if (log.find("warning:") != std::string::npos) log_debug("program {}: {}", spec.name, log);
}

ClProgram create_from_source(const Device& device, const ProgramSpec& spec, const std::string& source) {
  const char* text = source.c_str();
  const size_t length = source.size();
  cl_int code = CL_SUCCESS;
  ClProgram program(clCreateProgramWithSource(device.context(), 1, &text, &length, &code));
  check_opencl(code, "clCreateProgramWithSource", "program " + spec.name, device);
  return program;
}

ClProgram create_from_binary(const Device& device, const ProgramSpec& spec, const std::string& binary) {
  const cl_device_id id = device.id();
  const size_t length = binary.size();
  const auto* bytes = reinterpret_cast<const unsigned char*>(binary.data());
  cl_int status = CL_SUCCESS, code = CL_SUCCESS;
  ClProgram program(clCreateProgramWithBinary(device.context(), 1, &id, &length, &bytes, &status, &code));
  check_opencl(code, "clCreateProgramWithBinary", "program " + spec.name, device);
  check_opencl(status, "clCreateProgramWithBinary", "program " + spec.name, device);
  return program;
}

/// The driver's binary of a built program, or empty when it gives none.
std::string binary_of(cl_program program) {
  size_t length = 0;
  if (clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof length, &length, nullptr) != CL_SUCCESS) return "";
  std::string binary(length, '\0');
  auto* bytes = reinterpret_cast<unsigned char*>(binary.data());
  if (length == 0 || clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof bytes, &bytes, nullptr) != CL_SUCCESS)
    return "";
  return binary;
}

/// Whether PoCL keeps what it compiles in a folder that is ours.
bool has_driver_files(const Device& device) { return device.info().is_pocl && driver_folder() != nullptr; }

}  // namespace

ProgramText program_text(const ProgramSpec& spec, const std::string& sources) {
  return {preamble(spec, sources) + sources, build_options(spec)};
}

void BuiltProgram::make(Device& device, const ProgramSpec& spec, const ProgramText& whole) {
  const std::optional<ProgramText> faster = faster_text(device, whole);
  from_cache = (faster && load_text(device, spec, *faster)) || load_text(device, spec, whole);
  if (from_cache) return;
  device.compile_progress().build(spec.name);
  if (faster) {
    try {
      use(device, *faster);
      return compile(device, spec);
    } catch (const std::exception& error) {
      log_debug("program {}: compiled with the driver's own declarations: {}", spec.name, error.what());
    }
  }
  use(device, whole);
  compile(device, spec);
}

void BuiltProgram::use(Device& device, const ProgramText& given) {
  text = given;
  declares_built_ins = given.options.ends_with(without_built_ins);
  key = device.program_cache().key(text.source, text.options);
}

bool BuiltProgram::load_text(Device& device, const ProgramSpec& spec, const ProgramText& given) {
  use(device, given);
  return load(device, spec);
}

bool BuiltProgram::load(Device& device, const ProgramSpec& spec) {
  const std::optional<CachedProgram> entry = device.program_cache().load(key);
  if (!entry) return false;
  try {
    if (has_driver_files(device)) restore_driver_files(key, *entry);
    program = entry->binary.empty() ? create_from_source(device, spec, text.source)
                                    : create_from_binary(device, spec, entry->binary);
    build(program.get(), device, spec, text);
  } catch (const std::exception& error) {
    log_debug("program cache: {} is rebuilt: {}", spec.name, error.what());
    program = ClProgram();
    device.program_cache().discard(key);
    return false;
  }
  set_signatures(entry->signatures);
  driver_program = entry->driver_program;
  for (const DriverFile& file : entry->driver_files) kept_files.insert(file.path);
  return true;
}

void BuiltProgram::compile(Device& device, const ProgramSpec& spec) {
  program = create_from_source(device, spec, text.source);
  if (has_driver_files(device)) {
    driver_program = program_made_by(key, [&] { build(program.get(), device, spec, text); });
  } else {
    build(program.get(), device, spec, text);
  }
  CachedProgram entry;
  entry.signatures = reflect_kernels(device, program.get(), spec.name);
  set_signatures(entry.signatures);
  if (!device.program_cache().enabled()) return;
  if (has_driver_files(device)) {
    if (driver_program.empty()) return;
    entry.driver_program = driver_program;
    kept_files = list_driver_files(driver_program);
    entry.driver_files = read_driver_files(kept_files);
  } else {
    entry.binary = binary_of(program.get());
    if (entry.binary.empty()) return;
  }
  device.program_cache().store(key, entry);
}

void BuiltProgram::cache_specialized_kernels(Device& device) noexcept {
  if (driver_program.empty()) return;
  try {
    const ProgramCache& cache = device.program_cache();
    if (!cache.enabled() || !has_driver_files(device)) return;
    const std::set<std::string> present = list_driver_files(driver_program);
    if (std::includes(kept_files.begin(), kept_files.end(), present.begin(), present.end())) return;
    std::optional<CachedProgram> entry = cache.load(key);
    if (!entry) return;
    std::set<std::string> missing = present;  // another process may have added some
    for (const DriverFile& file : entry->driver_files) missing.erase(file.path);
    for (DriverFile& file : read_driver_files(missing)) entry->driver_files.push_back(std::move(file));
    if (entry->binary.empty()) {
      without_generic_variants(driver_program, kernel_names(), [&] { entry->binary = binary_of(program.get()); });
    }
    cache.store(key, *entry);
    kept_files = present;
  } catch (const std::exception& error) {
    log_debug("program cache: launch code of {} is not kept: {}", name, error.what());
  }
}

std::vector<std::string> BuiltProgram::kernel_names() const {
  std::vector<std::string> list;
  for (const auto& [kernel, signature] : signatures) list.push_back(kernel);
  return list;
}

void BuiltProgram::set_signatures(const std::vector<KernelSignature>& list) {
  for (const KernelSignature& signature : list) signatures.emplace(signature.name, signature);
}

}  // namespace lucarium
