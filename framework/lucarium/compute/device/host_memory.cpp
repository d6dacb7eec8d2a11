// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/host_memory.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace lucarium {
namespace {

constexpr size_t unknown = std::numeric_limits<size_t>::max();

size_t meminfo_available() {
  std::ifstream in("/proc/meminfo");
  for (std::string key; in >> key; in.ignore(256, '\n')) {
    if (key == "MemAvailable:") {
      size_t kib = 0;
      return in >> kib ? kib * 1024 : unknown;
    }
  }
  return unknown;
}

std::optional<size_t> read_number(const std::string& path) {
  std::ifstream in(path);
  size_t value = 0;
  if (in >> value) return value;
  return std::nullopt;  // absent, or "max"
}

/// Memory left below the limit of this process's control group; its page cache counts as used but can be dropped.
size_t control_group_available() {
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::")) continue;  // the unified hierarchy of cgroup v2
    const std::string folder = "/sys/fs/cgroup" + line.substr(3);
    const auto limit = read_number(folder + "/memory.max");
    const auto used = read_number(folder + "/memory.current");
    if (!limit || !used) return unknown;
    size_t reclaimable = 0;
    std::ifstream statistics(folder + "/memory.stat");
    for (std::string key; statistics >> key; statistics.ignore(256, '\n')) {
      size_t value = 0;
      if (key == "inactive_file" && statistics >> value) reclaimable = value;
    }
    const size_t held = *used - std::min(*used, reclaimable);
    return *limit - std::min(*limit, held);
  }
  return unknown;
}

}  // namespace

void give_back_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

size_t available_host_memory() { return std::min(meminfo_available(), control_group_available()); }

void* map_host_memory(size_t bytes) {
  // Large pages make scattered reads faster, and touching the memory faster still (docs/measurements/scheduler.md).
  // Only a hint: systems without them refuse it, and nothing changes. Memory of that size begins at a multiple of it,
  // since large pages do; what was mapped around it is given back.
  constexpr size_t large_page = size_t{2} << 20;
  const bool large = bytes >= large_page && bytes <= unknown - large_page;
  const size_t mapped = large ? bytes + large_page : bytes;
  void* address = mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (address == MAP_FAILED) return nullptr;
  if (!large) return address;
  char* first = static_cast<char*>(address);
  const size_t before = (large_page - reinterpret_cast<uintptr_t>(first) % large_page) % large_page;
  if (before > 0) munmap(first, before);
  // What is left behind it, by whole pages.
  const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  const size_t kept = (bytes + page - 1) / page * page, whole = (mapped + page - 1) / page * page - before;
  if (whole > kept) munmap(first + before + kept, whole - kept);
  madvise(first + before, kept, MADV_HUGEPAGE);
  return first + before;
}

void unmap_host_memory(void* address, size_t bytes) noexcept {
  if (address) munmap(address, bytes);
}

}  // namespace lucarium
