// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <thread>
#include <vector>

#include "lucarium/base/interrupt.h"

namespace lucarium::micro {

/// Calls work(i) for all i < count on up to `threads` threads, each a contiguous range. `work` must not throw, and no
/// call may depend on another. After an interrupt_requested() some are left out: ask throw_if_interrupted() behind it.
template <class Work>
void parallel_for(uint32_t count, int threads, Work work) {
  constexpr uint32_t worth_a_thread = 512;
  const uint32_t parts = std::max(1u, std::min(static_cast<uint32_t>(std::max(threads, 1)), count / worth_a_thread));
  const auto run = [&](uint32_t part) {
    const auto bound = [&](uint32_t p) { return static_cast<uint32_t>(uint64_t{count} * p / parts); };
    for (uint32_t i = bound(part); i < bound(part + 1) && !(i % 64 == 0 && interrupt_requested()); ++i) work(i);
  };
  std::vector<std::jthread> others;
  for (uint32_t part = 1; part < parts; ++part) others.emplace_back(run, part);
  run(0);
}

}  // namespace lucarium::micro
