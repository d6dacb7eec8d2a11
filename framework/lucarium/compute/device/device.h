// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CL/cl.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/compute/device/compile_progress.h"
#include "lucarium/compute/device/kept_programs.h"
#include "lucarium/compute/device/memory_account.h"

namespace lucarium {

enum class DeviceType { cpu, gpu, accelerator, other };

/// What `lucarium devices` prints.
struct DeviceInfo {
  int index = 0;  ///< position in list_devices()
  std::string name, vendor, platform, platform_version, driver_version, opencl_version;
  DeviceType type = DeviceType::other;
  unsigned compute_units = 0;
  size_t global_memory_bytes = 0, max_allocation_bytes = 0, local_memory_bytes = 0;
  size_t max_work_group_size = 0;
  unsigned native_float_lanes = 1;    ///< of a vector register: 16 with AVX-512, 8 with AVX2
  size_t base_alignment_bytes = 128;  ///< of sub-buffers
  bool overlapping_parts = true;      ///< sub-buffers of one buffer may overlap; NVIDIA's driver crashes with them
  bool is_pocl = false;
};

/// Everything that must be known before the first OpenCL call of the process.
struct DeviceOptions {
  std::string
      selector;     ///< index, part of the name or platform, or cpu|gpu|accelerator; empty: the first GPU, else first
  int threads = 0;  ///< worker threads of a CPU device (PoCL); 0: all
  size_t memory_limit_bytes = 0;      ///< artificial cap on all allocations together; 0: the device's own
  size_t allocation_limit_bytes = 0;  ///< artificial cap on one allocation; 0: the device's own
  std::filesystem::path
      cache_dir;  ///< of compiled programs; empty: LUCARIUM_CACHE_DIR, XDG_CACHE_HOME/lucarium, ~/.cache/lucarium
  bool use_cache = true;
};

/// Prepares the environment of the OpenCL drivers (PoCL's cache folder and thread count). Called by list_devices()
/// and Device::open(); only the first call of a process has an effect, since drivers read it once.
void prepare_opencl_environment(const DeviceOptions& options);

/// All OpenCL devices ≥ 1.2, in a stable order. Throws Error{device} that says what to install when no ICD is found.
std::vector<DeviceInfo> list_devices(const DeviceOptions& options = {});

class KernelCompilers;
class ProgramCache;

/// One OpenCL device with its context, an in-order queue, memory account and program cache.
class Device : public std::enable_shared_from_this<Device> {
 public:
  /// Throws Error{device} that lists the devices there are when `options.selector` matches none.
  static std::shared_ptr<Device> open(const DeviceOptions& options = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const { return info_; }
  cl_context context() const { return context_; }
  cl_device_id id() const { return id_; }
  /// In-order, profiled; for uploads, read-backs and everything outside a schedule.
  cl_command_queue queue() const { return queue_; }
  /// Out-of-order queue for schedules that overlap passes; null where the device has none.
  cl_command_queue overlap_queue() const { return overlap_queue_; }

  MemoryAccount& memory() { return *memory_; }
  ProgramCache& program_cache() { return *cache_; }

  /// Wall time spent compiling or loading programs, and waiting for launch code, so far [s]; clocks of comparisons
  /// leave it out.
  double program_seconds() const { return program_seconds_; }
  void add_program_seconds(double seconds) { program_seconds_ += seconds; }
  CompileProgress& compile_progress() { return compile_progress_; }
  /// Null where compiling in other processes would be of no use.
  KernelCompilers* kernel_compilers() { return kernel_compilers_.get(); }
  KeptPrograms& kept_programs() { return kept_programs_; }

  /// Waits for everything enqueued. The only place besides read-backs where the host waits.
  void finish();

 private:
  Device() = default;
  DeviceInfo info_;
  cl_context context_ = nullptr;
  cl_device_id id_ = nullptr;
  cl_command_queue queue_ = nullptr, overlap_queue_ = nullptr;
  std::unique_ptr<MemoryAccount> memory_;
  std::unique_ptr<ProgramCache> cache_;
  double program_seconds_ = 0;
  CompileProgress compile_progress_;
  std::unique_ptr<KernelCompilers> kernel_compilers_;
  KeptPrograms kept_programs_;
};

/// "CL_INVALID_KERNEL_ARGS" for -52.
std::string opencl_error_name(cl_int code);

/// Throws Error{device} naming the call, what it was about (kernel, buffer) and the device unless `code` is CL_SUCCESS.
void check_opencl(cl_int code, const char* call, const std::string& about, const Device& device);

}  // namespace lucarium
