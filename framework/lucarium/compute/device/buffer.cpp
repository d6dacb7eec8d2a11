// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/buffer.h"

#include <algorithm>
#include <array>
#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/compute/device/cl_handle.h"
#include "lucarium/compute/device/host_memory.h"

namespace lucarium {
namespace {

constexpr size_t granule = 64;  // also the pattern size of fill_zero

size_t rounded_up(size_t bytes) {
  constexpr size_t largest = std::numeric_limits<size_t>::max() / granule * granule;
  if (bytes > largest - granule) return largest;  // refused by the account
  return std::max(granule, (bytes + granule - 1) / granule * granule);
}

/// Memory that the driver uses in place (CL_MEM_USE_HOST_PTR). It is given back when the driver drops the memory
/// object, which may be after the last Buffer is gone if commands are still in flight.
struct HostMemory {
  void* address = nullptr;
  size_t bytes = 0;
  ~HostMemory() { unmap_host_memory(address, bytes); }
};

void CL_CALLBACK release_host_memory(cl_mem, void* memory) { delete static_cast<HostMemory*>(memory); }

}  // namespace

struct Buffer::Storage {
  std::shared_ptr<Device> device;
  std::string owner, name;
  size_t bytes = 0;      // as asked for
  size_t allocated = 0;  // multiple of `granule`, as accounted
  ClMem memory;

  std::string about() const { return fmt::format("buffer '{}' of {} ({})", name, owner, format_bytes(bytes)); }

  ~Storage() { device->memory().remove(owner, allocated); }

  void create_in_host_memory(const std::string& remedy) {
    const std::string advice = remedy.empty() ? "" : "; " + remedy;
    size_t available = available_host_memory();
    if (allocated > available) {
      device->kept_programs().clear();
      give_back_freed_memory();
      available = available_host_memory();
    }
    if (allocated > available) {
      throw_error(ErrorClass::device, "not enough host memory: {} of {} needs {}, the machine has {} left{}{}", name,
                  owner, format_bytes(allocated), format_bytes(available), device->memory().holders(), advice);
    }
    auto host = std::make_unique<HostMemory>();
    host->address = map_host_memory(allocated);
    if (!host->address) {
      throw_error(ErrorClass::device, "not enough host memory: the system refuses {} for {} of {}{}",
                  format_bytes(allocated), name, owner, advice);
    }
    host->bytes = allocated;
    cl_int code = CL_SUCCESS;
    memory = ClMem(
        clCreateBuffer(device->context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, allocated, host->address, &code));
    check_opencl(code, "clCreateBuffer", about(), *device);
    code = clSetMemObjectDestructorCallback(memory.get(), release_host_memory, host.get());
    check_opencl(code, "clSetMemObjectDestructorCallback", about(), *device);
    host.release();  // NOLINT: owned by the callback now
  }

  void create_in_device_memory() {
    cl_int code = CL_SUCCESS;
    memory = ClMem(clCreateBuffer(device->context(), CL_MEM_READ_WRITE, allocated, nullptr, &code));
    check_opencl(code, "clCreateBuffer", about(), *device);
  }
};

Buffer::Buffer(Device& device, std::string owner, std::string name, size_t bytes, const std::string& remedy) {
  const size_t allocated = rounded_up(bytes);
  device.memory().add(owner, name, allocated, remedy);
  storage_ = std::make_shared<Storage>();  // its destructor takes the bytes off the account again
  storage_->device = device.shared_from_this();
  storage_->owner = std::move(owner);
  storage_->name = std::move(name);
  storage_->bytes = bytes;
  storage_->allocated = allocated;
  if (device.info().type == DeviceType::cpu) {
    storage_->create_in_host_memory(remedy);
  } else {
    storage_->create_in_device_memory();
    fill_zero();
  }
}

cl_mem Buffer::handle() const { return storage_ ? storage_->memory.get() : nullptr; }
size_t Buffer::bytes() const { return storage_ ? storage_->bytes : 0; }
const std::string& Buffer::name() const { return storage_->name; }
const std::string& Buffer::owner() const { return storage_->owner; }
Device& Buffer::device() const { return *storage_->device; }

void Buffer::require_range(const char* verb, size_t bytes, size_t offset) const {
  if (!storage_) throw_error(ErrorClass::internal, "{} a buffer that was never created", verb);
  if (offset > storage_->bytes || bytes > storage_->bytes - offset) {
    throw_error(ErrorClass::internal, "{} {} bytes at {} is outside {}", verb, bytes, offset, storage_->about());
  }
}

void Buffer::write(const void* source, size_t bytes, size_t offset) {
  require_range("writing", bytes, offset);
  if (bytes == 0) return;
  // Waits by an event: Intel's runtime returns from a blocking write before other queues see what was written.
  cl_event written = nullptr;
  check_opencl(clEnqueueWriteBuffer(device().queue(), handle(), CL_FALSE, offset, bytes, source, 0, nullptr, &written),
               "clEnqueueWriteBuffer", storage_->about(), device());
  const ClEvent event(written);
  check_opencl(clWaitForEvents(1, &written), "clWaitForEvents", storage_->about(), device());
}

void Buffer::read(void* target, size_t bytes, size_t offset) const {
  require_range("reading", bytes, offset);
  if (bytes == 0) return;
  check_opencl(clEnqueueReadBuffer(device().queue(), handle(), CL_TRUE, offset, bytes, target, 0, nullptr, nullptr),
               "clEnqueueReadBuffer", storage_->about(), device());
}

std::shared_ptr<const void> Buffer::map() const {
  require_range("mapping", 0, 0);
  cl_int code = CL_SUCCESS;
  void* contents = clEnqueueMapBuffer(device().queue(), handle(), CL_TRUE, CL_MAP_READ, 0, storage_->allocated, 0,
                                      nullptr, nullptr, &code);
  check_opencl(code, "clEnqueueMapBuffer", storage_->about(), device());
  return {contents, [storage = storage_](void* mapped) {
            cl_event given_back = nullptr;
            const cl_int failure = clEnqueueUnmapMemObject(storage->device->queue(), storage->memory.get(), mapped, 0,
                                                           nullptr, &given_back);
            const ClEvent event(given_back);
            if (failure != CL_SUCCESS || clWaitForEvents(1, &given_back) != CL_SUCCESS)
              log_warning("giving back {} failed", storage->about());
          }};
}

void Buffer::fill_zero() {
  constexpr std::array<unsigned char, granule> zeros{};
  check_opencl(clEnqueueFillBuffer(device().queue(), handle(), zeros.data(), granule, 0, storage_->allocated, 0,
                                   nullptr, nullptr),
               "clEnqueueFillBuffer", storage_->about(), device());
}

}  // namespace lucarium
