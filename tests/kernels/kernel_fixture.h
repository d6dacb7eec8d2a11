// SPDX-License-Identifier: Apache-2.0
// What the tests of the device library share: the device, programs of this folder, one-shot launches.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lucarium/compute/scheduler.h"
#include "lucarium/scene/scene_buffers.h"

const lucarium::EmbeddedSources& test_kernels_kernels();

namespace lucarium::test {

inline Device& kernel_device() {
  static const std::shared_ptr<Device> device = Device::open();
  return *device;
}

/// tests/kernels/NAME.cl, compiled with extra definitions.
inline Program kernel_program(const std::string& name, const std::map<std::string, std::string>& defines = {}) {
  SourceLibrary library;
  library.add(test_kernels_kernels());
  ProgramSpec spec;
  spec.name = "test_kernels/" + name;
  spec.files = {"test_kernels/" + name + ".cl"};
  spec.defines = defines;
  return Program(kernel_device(), library, spec);
}

/// Runs `kernel` over `items` work-items (rounded up to `group`) with the arguments that `bind(PassBuilder&)` gives.
template <class Bind>
void run_kernel(const Program& program, const std::string& kernel, size_t items, size_t group, Bind bind) {
  KernelScheduler scheduler(kernel_device().shared_from_this());
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
  return TypedBuffer<T>(kernel_device(), "test", "values", count);
}
template <class T>
TypedBuffer<T> test_buffer(const std::vector<T>& values) {
  return TypedBuffer<T>(kernel_device(), "test", "values", values);
}

}  // namespace lucarium::test
