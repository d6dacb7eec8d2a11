// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CL/cl.h>

#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "lucarium/compute/device/device.h"

namespace lucarium {

/// Device memory with a name and an owner, counted by the device's MemoryAccount. Copies share the memory; it is
/// released with the last copy. On CPU devices the memory is ours (64-byte aligned, zero-copy), so that running out
/// of it is an exception here and not an abort in the driver.
class Buffer {
 public:
  Buffer() = default;
  /// `remedy` completes the refusal when memory does not suffice ("lower --size"). A size of 0 is rounded up to 64
  /// bytes, since OpenCL has no empty buffers. Contents are zero.
  Buffer(Device& device, std::string owner, std::string name, size_t bytes, const std::string& remedy = "");

  explicit operator bool() const { return storage_ != nullptr; }
  cl_mem handle() const;
  size_t bytes() const;  ///< as asked for
  const std::string& name() const;
  const std::string& owner() const;
  Device& device() const;
  /// Whether two handles denote the same memory.
  bool same_memory(const Buffer& other) const { return storage_ == other.storage_; }

  /// Whether copies of this handle, as in recorded schedules, would keep the memory if this one let go of it.
  bool is_shared() const { return storage_.use_count() > 1; }

  /// Blocking copies through the device's in-order queue; throw Error{internal} when the range is outside.
  void write(const void* source, size_t bytes, size_t offset = 0);
  void read(void* target, size_t bytes, size_t offset = 0) const;
  void fill_zero();
  /// The contents for reading until the last handle goes, without a copy where the device shares the host's memory.
  /// Waits for the device's queue; nothing may write to the buffer meanwhile.
  std::shared_ptr<const void> map() const;

 protected:
  void require_range(const char* verb, size_t bytes, size_t offset) const;

 private:
  struct Storage;
  std::shared_ptr<Storage> storage_;
};

/// The same with an element type.
template <class T>
class TypedBuffer : public Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;
  TypedBuffer() = default;
  TypedBuffer(Device& device, std::string owner, std::string name, size_t count, const std::string& remedy = "")
      : Buffer(device, std::move(owner), std::move(name), bytes_of(count), remedy) {}
  TypedBuffer(Device& device, std::string owner, std::string name, const std::vector<T>& values,
              const std::string& remedy = "")
      : TypedBuffer(device, std::move(owner), std::move(name), values.size(), remedy) {
    if (!values.empty()) write(values.data(), values.size() * sizeof(T));
  }

  size_t count() const { return bytes() / sizeof(T); }
  void upload(const std::vector<T>& values, size_t first = 0) {
    if (!values.empty()) write(values.data(), values.size() * sizeof(T), bytes_of(first));
  }
  std::vector<T> download() const { return download(0, count()); }
  std::vector<T> download(size_t first, size_t elements) const {
    require_range("reading", bytes_of(elements), bytes_of(first));
    std::vector<T> values(elements);
    if (elements) read(values.data(), elements * sizeof(T), first * sizeof(T));
    return values;
  }
  /// As map().
  std::shared_ptr<const T[]> elements() const {
    const std::shared_ptr<const void> contents = map();
    return {contents, static_cast<const T*>(contents.get())};
  }

 private:
  /// Saturates, so that an absurd count is refused and not wrapped round.
  static size_t bytes_of(size_t count) {
    return count > std::numeric_limits<size_t>::max() / sizeof(T) ? std::numeric_limits<size_t>::max()
                                                                  : count * sizeof(T);
  }
};

}  // namespace lucarium
