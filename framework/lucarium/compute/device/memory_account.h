// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace lucarium {

/// Bytes of device memory, by owner ("scene", "bvh", "path_tracing", …), against the device's limits. OpenCL
/// implementations on CPUs allocate lazily and abort at first use when the host runs out, so the budget is enforced
/// here, before anything is created. Thread-safe.
class MemoryAccount {
 public:
  /// `total_bytes`: all allocations together; `single_bytes`: the largest one.
  MemoryAccount(size_t total_bytes, size_t single_bytes);

  /// Refuses with Error{device} that gives the numbers, the owner, the largest other owners and `remedy`
  /// (the option or parameter that would lower the need), without changing the account.
  void require(const std::string& owner, const std::string& what, size_t bytes, const std::string& remedy = "") const;

  /// The same for what will be several allocations, each of which is held to the limit for one by itself.
  void require_total(const std::string& owner, const std::string& what, size_t bytes,
                     const std::string& remedy = "") const;

  void add(const std::string& owner, const std::string& what, size_t bytes, const std::string& remedy = "");
  void remove(const std::string& owner, size_t bytes) noexcept;

  size_t used_bytes() const;
  size_t peak_bytes() const;
  uint64_t allocations() const;  ///< made so far
  size_t total_bytes() const { return total_; }
  size_t single_bytes() const { return single_; }
  std::map<std::string, size_t> by_owner() const;
  /// " (held by scene 1.20 GiB, bvh 300 MiB)" for messages; empty when nothing is held.
  std::string holders() const;

 private:
  void require_locked(const std::string& owner, const std::string& what, size_t bytes, const std::string& remedy) const;
  void require_total_locked(const std::string& owner, const std::string& what, size_t bytes,
                            const std::string& remedy) const;
  std::string holders_locked() const;
  mutable std::mutex mutex_;
  size_t total_, single_, used_ = 0, peak_ = 0;
  uint64_t allocations_ = 0;
  std::map<std::string, size_t> owners_;
};

}  // namespace lucarium
