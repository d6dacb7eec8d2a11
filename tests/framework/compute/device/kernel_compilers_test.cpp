// SPDX-License-Identifier: Apache-2.0
// Launch code that other processes compile. Each case has a program of its own, compiled by none before it.
#include "lucarium/compute/device/kernel_compilers.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <set>

#include "../compute_fixture.h"
#include "lucarium/compute/device/pocl_folder.h"
#include "lucarium/compute/schedule/scheduler.h"

using namespace lucarium;
using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

const EmbeddedSources compiler_sources = {
    {"squares.cl",
     "kernel void squares(global uint* v, uint factor) { const uint i = get_global_id(0); v[i] = i * i * factor * "
     "SALT; }\n"
     "kernel void counted(global const uint* count, global uint* v) { const uint i = get_global_id(0); if (i < "
     "*count) v[i] = SALT; }"}};

/// A device without a cache, or none where nothing is compiled by other processes.
std::shared_ptr<Device> device_with_compilers() {
  DeviceOptions options;
  options.use_cache = false;
  options.threads = 2;
  const auto device = Device::open(options);
  if (!device->kernel_compilers()) skip("PoCL on a CPU, and the program that compiles kernels");
  return device->kernel_compilers() ? device : nullptr;
}

Program build_squares(Device& device, const std::string& salt) {
  SourceLibrary library;
  library.add(compiler_sources);
  return Program(device, library, {"squares", {"squares.cl"}, {{"SALT", salt}}});
}

/// Folders of the launch code of a kernel, such as "64-1-1-goffs0-smallgrid", over all programs.
std::set<std::string> launch_code(const std::string& kernel, const std::set<std::string>& known = {}) {
  std::set<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(driver_folder()->path())) {
    const fs::path& path = entry.path();
    if (path.filename() == kernel + ".so" && !known.contains(path.string())) found.insert(path.string());
  }
  return found;
}

LaunchCode squares_of(const Program& program, const std::string& id, size_t local) {
  using Kind = LaunchCode::Argument::Kind;
  LaunchCode code{id, program.source().file, program.source().options, "squares"};
  code.global = code.local = {local, 1, 1};
  code.arguments = {{Kind::buffer, 0}, {Kind::value, sizeof(cl_uint)}};
  return code;
}

}  // namespace

TEST_CASE("what another process compiled lies where the driver looks for it") {
  const auto device = device_with_compilers();
  if (!device) return;
  const Program program = build_squares(*device, "3");
  REQUIRE(fs::exists(program.source().file));
  const std::set<std::string> known = launch_code("squares");
  KernelCompilers& compilers = *device->kernel_compilers();
  compilers.want(squares_of(program, "a", 16));
  compilers.want(squares_of(program, "b", 32));
  compilers.wait_for("a");
  compilers.wait_for("b");
  compilers.wait_for("never asked for");
  const std::set<std::string> made = launch_code("squares", known);
  REQUIRE(made.size() == 2);
  CHECK(has(*made.begin(), "/16-1-1-goffs0-smallgrid/"));
  CHECK(has(*made.rbegin(), "/32-1-1-goffs0-smallgrid/"));
}

TEST_CASE("a process that fails is no harm: the driver compiles at the launch") {
  const auto device = device_with_compilers();
  if (!device) return;
  const Program program = build_squares(*device, "5");
  KernelCompilers& compilers = *device->kernel_compilers();
  for (int i = 0; i < 20; ++i) {  // more than there are processes
    LaunchCode code = squares_of(program, "wrong " + std::to_string(i), 16);
    code.kernel = "no_such_kernel";
    compilers.want(code);
  }
  for (int i = 0; i < 20; ++i) compilers.wait_for("wrong " + std::to_string(i));
  compilers.want(squares_of(program, "right", 16));
  compilers.wait_for("right");
  KernelScheduler scheduler(device);
  const TypedBuffer<uint32_t> values(*device, "test", "values", 64);
  ScheduleRecorder recorder = scheduler.record("squares", "test");
  recorder.pass("squares", program, "squares").global(64).arg("v", values).arg("factor", 2u);
  Schedule schedule = recorder.compile();
  scheduler.warm_up(schedule);
  scheduler.run(schedule);
  CHECK(values.download()[7] == 7u * 7u * 2u * 5u);
}

TEST_CASE("a pass that a counter sizes is compiled once, for large grids") {
  const auto device = device_with_compilers();
  if (!device) return;
  const Program program = build_squares(*device, "7");
  const std::set<std::string> known = launch_code("counted");
  KernelScheduler scheduler(device);
  const TypedBuffer<uint32_t> count(*device, "test", "count", std::vector<uint32_t>{3});
  const TypedBuffer<uint32_t> values(*device, "test", "values", 64);
  ScheduleRecorder recorder = scheduler.record("counted", "test");
  recorder.pass("counted", program, "counted").global_by(count, 0).arg("count", count).arg("v", values);
  Schedule schedule = recorder.compile();
  scheduler.warm_up(schedule);
  scheduler.run(schedule);
  scheduler.finish();
  CHECK(values.download()[2] == 7);
  CHECK(values.download()[3] == 0);
  const std::set<std::string> made = launch_code("counted", known);
  REQUIRE(made.size() == 1);
  CHECK(has(*made.begin(), "-goffs0/"));
}

TEST_CASE("a first run waits for what another process compiles, and counts that as compiling") {
  const auto device = device_with_compilers();
  if (!device) return;
  const Program program = build_squares(*device, "11");
  KernelScheduler scheduler(device);
  const TypedBuffer<uint32_t> values(*device, "test", "values", 64);
  ScheduleRecorder recorder = scheduler.record("squares", "test");
  recorder.pass("squares", program, "squares").global(64).arg("v", values).arg("factor", 2u);
  const std::set<std::string> known = launch_code("squares");
  Schedule schedule = recorder.compile();
  const double built = device->program_seconds();
  scheduler.run(schedule);
  scheduler.finish();
  CHECK(values.download()[3] == 3u * 3u * 2u * 11u);
  CHECK(launch_code("squares", known).size() == 1);
  const double first = device->program_seconds();
  CHECK(first > built);
  scheduler.run(schedule);
  scheduler.finish();
  CHECK(device->program_seconds() == first);
}
