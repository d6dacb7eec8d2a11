// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <ctime>

namespace lucarium {

/// Processor time of all threads of this process until now [s].
inline double processor_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace lucarium
