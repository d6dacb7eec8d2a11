// SPDX-License-Identifier: Apache-2.0
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS  // clCreateCommandQueue, for drivers before OpenCL 2.0
#include "lucarium/compute/device/device.h"

#include <CL/cl_ext.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/compute/device/host_memory.h"
#include "lucarium/compute/device/kernel_compilers.h"
#include "lucarium/compute/device/pocl_folder.h"
#include "lucarium/compute/device/program_cache.h"
#include "lucarium/compute/device/registered_drivers.h"

namespace lucarium {
namespace {

struct FoundDevice {
  cl_device_id id = nullptr;
  DeviceInfo info;
};

template <class Object, class Query>
std::string text_of(Query query, Object object, cl_uint key) {
  size_t bytes = 0;
  if (query(object, key, 0, nullptr, &bytes) != CL_SUCCESS || bytes == 0) return "";
  std::string text(bytes, '\0');
  if (query(object, key, bytes, text.data(), nullptr) != CL_SUCCESS) return "";
  text.resize(std::min(text.find('\0'), text.size()));
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  return text;
}

template <class T>
T value_of(cl_device_id device, cl_device_info key) {
  T value{};
  clGetDeviceInfo(device, key, sizeof value, &value, nullptr);
  return value;
}

DeviceType type_of(cl_device_id device) {
  const auto type = value_of<cl_device_type>(device, CL_DEVICE_TYPE);
  if (type & CL_DEVICE_TYPE_CPU) return DeviceType::cpu;
  if (type & CL_DEVICE_TYPE_GPU) return DeviceType::gpu;
  if (type & CL_DEVICE_TYPE_ACCELERATOR) return DeviceType::accelerator;
  return DeviceType::other;
}

/// Major · 10 + minor of "OpenCL 3.0 PoCL …".
int version_number(const std::string& version) {
  int major = 0, minor = 0;
  if (std::sscanf(version.c_str(), "OpenCL %d.%d", &major, &minor) != 2) return 0;
  return major * 10 + minor;
}

DeviceInfo describe(cl_platform_id platform, cl_device_id device) {
  DeviceInfo info;
  info.platform = text_of(clGetPlatformInfo, platform, CL_PLATFORM_NAME);
  info.platform_version = text_of(clGetPlatformInfo, platform, CL_PLATFORM_VERSION);
  info.name = text_of(clGetDeviceInfo, device, CL_DEVICE_NAME);
  info.vendor = text_of(clGetDeviceInfo, device, CL_DEVICE_VENDOR);
  info.driver_version = text_of(clGetDeviceInfo, device, CL_DRIVER_VERSION);
  info.opencl_version = text_of(clGetDeviceInfo, device, CL_DEVICE_VERSION);
  info.type = type_of(device);
  info.compute_units = value_of<cl_uint>(device, CL_DEVICE_MAX_COMPUTE_UNITS);
  info.global_memory_bytes = value_of<cl_ulong>(device, CL_DEVICE_GLOBAL_MEM_SIZE);
  info.max_allocation_bytes = value_of<cl_ulong>(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  info.local_memory_bytes = value_of<cl_ulong>(device, CL_DEVICE_LOCAL_MEM_SIZE);
  info.max_work_group_size = value_of<size_t>(device, CL_DEVICE_MAX_WORK_GROUP_SIZE);
  info.native_float_lanes = value_of<cl_uint>(device, CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT);
  info.base_alignment_bytes = std::max<size_t>(value_of<cl_uint>(device, CL_DEVICE_MEM_BASE_ADDR_ALIGN) / 8, 1);
  info.overlapping_parts = info.platform != "NVIDIA CUDA";
  info.is_pocl = info.platform == "Portable Computing Language" || info.platform.find("PoCL") != std::string::npos;
  return info;
}

[[noreturn]] void throw_no_platform() {
  const char* chosen = std::getenv("OCL_ICD_VENDORS");
  const std::string vendors = chosen ? chosen : "/etc/OpenCL/vendors";
  std::string refused;
  for (const UnloadableDriver& driver : unloadable_drivers(vendors))
    refused += fmt::format("{}{} ({})", refused.empty() ? "" : ", ", driver.file, driver.reason);
  if (!refused.empty())
    throw_error(ErrorClass::device,
                "no OpenCL driver loads; registered in {}: {}; install the libraries that the driver needs, or for the "
                "CPU the Debian package pocl-opencl-icd",
                vendors, refused);
  throw_error(ErrorClass::device,
              "no OpenCL driver is installed (none is registered in {}); install the driver of your GPU, or for the "
              "CPU the Debian package pocl-opencl-icd: apt install pocl-opencl-icd",
              vendors);
}

std::vector<cl_platform_id> platforms() {
  cl_uint count = 0;
  const cl_int code = clGetPlatformIDs(0, nullptr, &count);
  if (code == CL_PLATFORM_NOT_FOUND_KHR || (code == CL_SUCCESS && count == 0)) throw_no_platform();
  if (code != CL_SUCCESS) {
    throw_error(ErrorClass::device, "clGetPlatformIDs failed with {} ({})", opencl_error_name(code), code);
  }
  std::vector<cl_platform_id> found(count);
  clGetPlatformIDs(count, found.data(), nullptr);
  return found;
}

std::vector<FoundDevice> find_devices(const DeviceOptions& options) {
  prepare_opencl_environment(options);
  std::vector<FoundDevice> found;
  std::string rejected;
  for (const cl_platform_id platform : platforms()) {
    cl_uint count = 0;
    const cl_int code = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count);
    if (code != CL_SUCCESS || count == 0) {
      rejected += fmt::format("; {} has no devices ({})", text_of(clGetPlatformInfo, platform, CL_PLATFORM_NAME),
                              opencl_error_name(code));
      continue;
    }
    std::vector<cl_device_id> ids(count);
    clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, ids.data(), nullptr);
    for (const cl_device_id id : ids) {
      DeviceInfo info = describe(platform, id);
      if (version_number(info.opencl_version) < 12 || !value_of<cl_bool>(id, CL_DEVICE_COMPILER_AVAILABLE)) {
        rejected += fmt::format("; {} ({}) is too old or has no compiler", info.name, info.opencl_version);
        continue;
      }
      info.index = static_cast<int>(found.size());
      found.push_back({id, std::move(info)});
    }
  }
  if (found.empty()) {
    throw_error(ErrorClass::device,
                "no OpenCL device of version 1.2 or later{}; for the CPU install the Debian package pocl-opencl-icd",
                rejected);
  }
  return found;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool matches(const DeviceInfo& info, const std::string& selector) {
  if (std::all_of(selector.begin(), selector.end(), [](unsigned char c) { return std::isdigit(c); })) {
    return std::to_string(info.index) == selector;
  }
  const std::string wanted = lower(selector);
  if (wanted == "cpu") return info.type == DeviceType::cpu;
  if (wanted == "gpu") return info.type == DeviceType::gpu;
  if (wanted == "accelerator") return info.type == DeviceType::accelerator;
  return lower(info.name).find(wanted) != std::string::npos || lower(info.platform).find(wanted) != std::string::npos;
}

const FoundDevice& select(const std::vector<FoundDevice>& devices, const std::string& selector) {
  if (selector.empty()) {
    const auto gpu = std::find_if(devices.begin(), devices.end(),
                                  [](const FoundDevice& device) { return device.info.type == DeviceType::gpu; });
    return gpu != devices.end() ? *gpu : devices.front();
  }
  for (const FoundDevice& device : devices) {
    if (matches(device.info, selector)) return device;
  }
  std::string known;
  for (const FoundDevice& device : devices) {
    known += fmt::format("{}'{}: {}'", known.empty() ? "" : ", ", device.info.index, device.info.name);
  }
  throw_error(
      ErrorClass::device,
      "no OpenCL device matches '{}'; give an index, part of a name, cpu, gpu or accelerator: this machine has {}",
      selector, known);
}

size_t limit_of(size_t option, const char* variable) {
  if (option) return option;
  const char* value = std::getenv(variable);
  return value && *value ? parse_bytes(value, variable) : 0;
}

/// The device's own limits, what the host really has where device memory is host memory, and the artificial caps.
std::unique_ptr<MemoryAccount> open_account(const DeviceInfo& info, const DeviceOptions& options) {
  size_t total = info.global_memory_bytes, single = info.max_allocation_bytes;
  if (info.type == DeviceType::cpu) total = std::min(total, available_host_memory());
  if (const size_t cap = limit_of(options.memory_limit_bytes, "LUCARIUM_MEMORY_LIMIT")) total = std::min(total, cap);
  if (const size_t cap = limit_of(options.allocation_limit_bytes, "LUCARIUM_ALLOCATION_LIMIT")) {
    single = std::min(single, cap);
  }
  return std::make_unique<MemoryAccount>(total, single);
}

void CL_CALLBACK report_context_error(const char* message, const void*, size_t, void*) {
  log_debug("OpenCL driver: {}", message ? message : "");
}

cl_command_queue create_queue(const Device& device, cl_command_queue_properties flags, cl_int& code) {
  if (version_number(device.info().opencl_version) < 20 || version_number(device.info().platform_version) < 20) {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"  // a driver of OpenCL 1.2 has no other
    return clCreateCommandQueue(device.context(), device.id(), flags, &code);
#pragma GCC diagnostic pop
  }
  const cl_queue_properties properties[] = {CL_QUEUE_PROPERTIES, flags, 0};
  return clCreateCommandQueueWithProperties(device.context(), device.id(), properties, &code);
}

void report_release(cl_int code, const char* call) {
  if (code != CL_SUCCESS) log_warning("{} failed with {}", call, opencl_error_name(code));
}

}  // namespace

std::vector<DeviceInfo> list_devices(const DeviceOptions& options) {
  std::vector<DeviceInfo> infos;
  for (FoundDevice& device : find_devices(options)) infos.push_back(std::move(device.info));
  return infos;
}

std::shared_ptr<Device> Device::open(const DeviceOptions& options) {
  const std::vector<FoundDevice> devices = find_devices(options);
  const FoundDevice& chosen = select(devices, options.selector);
  require_linker(chosen.info);
  const std::shared_ptr<Device> device(new Device);
  device->info_ = chosen.info;
  device->id_ = chosen.id;
  device->memory_ = open_account(chosen.info, options);
  device->cache_ = std::make_unique<ProgramCache>(options, chosen.info);
  device->kernel_compilers_ = make_kernel_compilers(chosen.info, options);

  cl_int code = CL_SUCCESS;
  device->context_ = clCreateContext(nullptr, 1, &chosen.id, report_context_error, nullptr, &code);
  check_opencl(code, "clCreateContext", "the context", *device);
  device->queue_ = create_queue(*device, CL_QUEUE_PROFILING_ENABLE, code);
  check_opencl(code, "clCreateCommandQueue", "the in-order queue", *device);
  const auto supported = value_of<cl_command_queue_properties>(chosen.id, CL_DEVICE_QUEUE_PROPERTIES);
  if (supported & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE) {
    device->overlap_queue_ =
        create_queue(*device, CL_QUEUE_PROFILING_ENABLE | CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, code);
    check_opencl(code, "clCreateCommandQueue", "the out-of-order queue", *device);
  }
  log_info("device {}: {} ({}, driver {}), {} of memory", chosen.info.index, chosen.info.name, chosen.info.platform,
           chosen.info.driver_version, format_bytes(device->memory_->total_bytes()));
  return device;
}

Device::~Device() {
  kept_programs_.clear();
  if (overlap_queue_) report_release(clReleaseCommandQueue(overlap_queue_), "clReleaseCommandQueue");
  if (queue_) report_release(clReleaseCommandQueue(queue_), "clReleaseCommandQueue");
  if (context_) report_release(clReleaseContext(context_), "clReleaseContext");
}

void Device::finish() {
  check_opencl(clFinish(queue_), "clFinish", "the in-order queue", *this);
  if (overlap_queue_) check_opencl(clFinish(overlap_queue_), "clFinish", "the out-of-order queue", *this);
}

}  // namespace lucarium
