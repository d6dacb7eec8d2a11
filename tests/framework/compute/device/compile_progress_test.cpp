// SPDX-License-Identifier: Apache-2.0
// Reports of the first run with a fresh cache while kernels are compiled.
#include "lucarium/compute/device/compile_progress.h"

#include <doctest/doctest.h>

#include "lucarium/compute/schedule/scheduler.h"
#include "schedule_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

using Lines = std::vector<std::string>;

/// Lines heard from the device while `work` is done.
Lines heard_during(const std::function<void()>& work) {
  Lines lines;
  test_device()->compile_progress().listen([&](double, const std::string& text) { lines.push_back(text); });
  work();
  test_device()->compile_progress().listen({});
  return lines;
}

Schedule two_kernels(const KernelScheduler& scheduler, const Program& program) {
  const auto counter = make_buffer("counter", {2}), out = make_buffer("out", {1, 2, 3});
  ScheduleRecorder recorder = scheduler.record("two kernels", "test");
  for (const char* pass : {"first", "again"}) {
    recorder.pass(pass, program, "fill_counted")
        .global_by(counter)
        .arg("out", out)
        .arg("counter", counter)
        .arg("salt", 9u);
  }
  return recorder.compile();
}

}  // namespace

TEST_CASE("launches are counted once each, out of those announced since somebody listens") {
  CompileProgress progress;
  progress.announce("old");
  progress.launching("old");
  Lines lines;
  std::vector<double> fractions;
  progress.listen([&](double fraction, const std::string& text) {
    fractions.push_back(fraction);
    lines.push_back(text);
  });
  progress.build("a/b");
  for (const char* launch : {"x", "y", "y", "z"}) progress.announce(launch);
  for (const char* launch : {"x", "old", "z", "x"}) progress.launching(launch);
  CHECK(lines == Lines{"compiling program a/b", "compiling kernels 1/3", "compiling kernels 2/3"});
  CHECK(fractions == std::vector<double>{-1, 0, 1. / 3});
}

TEST_CASE("a warm-up reports which kernel of how many is compiled, a second one nothing") {
  SourceLibrary library;
  library.add(test_compute_kernels());
  const Program program(*test_device(), library, {"progress", {"test_compute/schedule/schedule_kernels.cl"}, {}});
  KernelScheduler scheduler(test_device());
  Schedule schedule;
  const Lines first = heard_during([&] {
    schedule = two_kernels(scheduler, program);  // two passes of one kernel: compiled once
    scheduler.warm_up(schedule);
  });
  REQUIRE(first.size() == 1);
  CHECK(first.front().starts_with("compiling kernels 1/"));
  CHECK(heard_during([&] { scheduler.warm_up(schedule); }).empty());
}
