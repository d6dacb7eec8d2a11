// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/memory_account.h"

#include <algorithm>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/base/text/byte_size.h"

namespace lucarium {
namespace {

std::string advice(const std::string& remedy) { return remedy.empty() ? "" : "; " + remedy; }

}  // namespace

MemoryAccount::MemoryAccount(size_t total_bytes, size_t single_bytes)
    : total_(total_bytes), single_(std::min(single_bytes, total_bytes)) {}

void MemoryAccount::require(const std::string& owner, const std::string& what, size_t bytes,
                            const std::string& remedy) const {
  const std::lock_guard lock(mutex_);
  require_locked(owner, what, bytes, remedy);
}

void MemoryAccount::require_total(const std::string& owner, const std::string& what, size_t bytes,
                                  const std::string& remedy) const {
  const std::lock_guard lock(mutex_);
  require_total_locked(owner, what, bytes, remedy);
}

void MemoryAccount::add(const std::string& owner, const std::string& what, size_t bytes, const std::string& remedy) {
  const std::lock_guard lock(mutex_);
  require_locked(owner, what, bytes, remedy);
  owners_[owner] += bytes;
  used_ += bytes;
  peak_ = std::max(peak_, used_);
  ++allocations_;
}

void MemoryAccount::remove(const std::string& owner, size_t bytes) noexcept {
  const std::lock_guard lock(mutex_);
  const auto found = owners_.find(owner);
  if (found == owners_.end()) return;
  const size_t removed = std::min(bytes, found->second);
  found->second -= removed;
  used_ -= removed;
  if (found->second == 0) owners_.erase(found);
}

size_t MemoryAccount::used_bytes() const {
  const std::lock_guard lock(mutex_);
  return used_;
}

uint64_t MemoryAccount::allocations() const {
  const std::lock_guard lock(mutex_);
  return allocations_;
}

size_t MemoryAccount::peak_bytes() const {
  const std::lock_guard lock(mutex_);
  return peak_;
}

std::map<std::string, size_t> MemoryAccount::by_owner() const {
  const std::lock_guard lock(mutex_);
  return owners_;
}

std::string MemoryAccount::holders() const {
  const std::lock_guard lock(mutex_);
  return holders_locked();
}

std::string MemoryAccount::holders_locked() const {
  std::vector<std::pair<std::string, size_t>> sorted(owners_.begin(), owners_.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  if (sorted.empty()) return "";
  std::string text;
  constexpr size_t shown = 3;
  for (size_t i = 0; i < std::min(shown, sorted.size()); ++i) {
    text += fmt::format("{}{} {}", i ? ", " : "", sorted[i].first, format_bytes(sorted[i].second));
  }
  return fmt::format(" (held by {}{})", text, sorted.size() > shown ? ", …" : "");
}

void MemoryAccount::require_locked(const std::string& owner, const std::string& what, size_t bytes,
                                   const std::string& remedy) const {
  if (bytes > single_) {
    throw_error(ErrorClass::device,
                "not enough device memory for {} of {}: {} in one piece, while the limit for one allocation is {}{}",
                what, owner, format_bytes(bytes), format_bytes(single_), advice(remedy));
  }
  require_total_locked(owner, what, bytes, remedy);
}

void MemoryAccount::require_total_locked(const std::string& owner, const std::string& what, size_t bytes,
                                         const std::string& remedy) const {
  if (bytes > total_ - used_) {
    throw_error(ErrorClass::device, "not enough device memory for {} of {}: {}, while {} of {} are in use{}{}", what,
                owner, format_bytes(bytes), format_bytes(used_), format_bytes(total_), holders_locked(),
                advice(remedy));
  }
}

}  // namespace lucarium
