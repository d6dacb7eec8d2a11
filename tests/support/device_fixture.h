// SPDX-License-Identifier: Apache-2.0
// The device of the tests, and one-shot launches on it.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"

namespace lucarium::test {

/// The default device, opened once per process.
inline const std::shared_ptr<Device>& test_device() {
  static const std::shared_ptr<Device> device = Device::open();
  return device;
}

template <class T>
TypedBuffer<T> test_buffer(size_t count) {
  return TypedBuffer<T>(*test_device(), "test", "values", count);
}
template <class T>
TypedBuffer<T> test_buffer(const std::vector<T>& values) {
  return TypedBuffer<T>(*test_device(), "test", "values", values);
}

/// Runs `kernel` over `items` work-items (rounded up to `group`) with the arguments that `bind(PassBuilder&)` gives.
template <class Bind>
void run_kernel(const Program& program, const std::string& kernel, size_t items, size_t group, Bind bind) {
  KernelScheduler scheduler(test_device());
  ScheduleRecorder recorder = scheduler.record(kernel, "test");
  PassBuilder pass = recorder.pass(kernel, program, kernel);
  pass.global(items).local(group);
  bind(pass);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
}

}  // namespace lucarium::test
