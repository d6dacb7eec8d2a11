// SPDX-License-Identifier: Apache-2.0
// A technique's estimate of its time, for planning a picture within a budget (technique/budget_plan.h).
#pragma once
#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "lucarium/compute/device/device.h"

namespace lucarium {

/// Computing power of a machine, in cores of a processor of about 3 GHz. Counted and not measured: a plan must not
/// depend on a clock.
struct ComputePower {
  double device = 1;  ///< of the OpenCL device
  double host = 1;    ///< of the threads that a technique may start
};

inline ComputePower compute_power(const DeviceInfo& device) {
  constexpr double cores_of_unit = 8;  // of a GPU: an assumption on the safe side, no measurement
  const double units = std::max(1u, device.compute_units);
  return {device.type == DeviceType::cpu ? units : cores_of_unit * units,
          static_cast<double>(std::max(1u, std::thread::hardware_concurrency()))};
}

/// A parameter that may be lowered where time is short.
struct ParameterSaving {
  std::string parameter;
  std::vector<std::string> values;  ///< one after the other, each cheaper
  bool last_resort = false;         ///< only when the others save nothing any more
};

}  // namespace lucarium
