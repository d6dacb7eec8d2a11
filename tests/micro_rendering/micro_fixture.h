// SPDX-License-Identifier: Apache-2.0
// What the tests of micro_rendering share: the device, programs of this folder, one-shot launches.
#pragma once
#include <map>
#include <string>

#include "lucarium/compute/scheduler.h"

const lucarium::EmbeddedSources& test_micro_rendering_kernels();  // of this folder
const lucarium::EmbeddedSources& micro_rendering_kernels();       // of the technique

namespace lucarium::test {

inline Device& micro_device() {
  static const std::shared_ptr<Device> device = Device::open();
  return *device;
}

/// The file of that virtual name ("test_micro_rendering/node.cl"), compiled.
inline Program micro_program(const std::string& file, const std::map<std::string, std::string>& defines = {}) {
  SourceLibrary library;
  library.add(micro_rendering_kernels());
  library.add(test_micro_rendering_kernels());
  return Program(micro_device(), library, {file, {file}, defines});
}

/// Runs `kernel` over `items` work-items (rounded up to `group`) with the arguments that `bind(PassBuilder&)` gives.
template <class Bind>
void run_kernel(const Program& program, const std::string& kernel, size_t items, size_t group, Bind bind) {
  KernelScheduler scheduler(micro_device().shared_from_this());
  ScheduleRecorder recorder = scheduler.record(kernel, "test");
  PassBuilder pass = recorder.pass(kernel, program, kernel);
  pass.global(items).local(group);
  bind(pass);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
}

template <class T>
TypedBuffer<T> test_buffer(size_t count) {
  return TypedBuffer<T>(micro_device(), "test", "values", count);
}
template <class T>
TypedBuffer<T> test_buffer(const std::vector<T>& values) {
  return TypedBuffer<T>(micro_device(), "test", "values", values);
}

}  // namespace lucarium::test
