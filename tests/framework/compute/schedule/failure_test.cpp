// SPDX-License-Identifier: Apache-2.0
// Failing kernels, failing host steps, cancellation, budgets, slices.
#include <dlfcn.h>
#include <doctest/doctest.h>

#include "schedule_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

int arguments_until_refusal = -1;  ///< clSetKernelArg calls that still pass; negative: all do
int arguments_refused = 0;

/// The driver then refuses one argument, the one after `calls` more; negative: none. Returns how many it has refused
/// since the last call.
int refuse_kernel_arguments_after(int calls) {
  arguments_until_refusal = calls;
  return std::exchange(arguments_refused, 0);
}

}  // namespace

/// Stands before the driver's function of this name, in this executable alone.
extern "C" __attribute__((visibility("default"))) cl_int clSetKernelArg(cl_kernel kernel, cl_uint index, size_t bytes,
                                                                        const void* value) {
  static const auto next = reinterpret_cast<decltype(&clSetKernelArg)>(dlsym(RTLD_NEXT, "clSetKernelArg"));
  if (arguments_until_refusal == 0) {
    arguments_until_refusal = -1;
    ++arguments_refused;
    return CL_OUT_OF_HOST_MEMORY;
  }
  if (arguments_until_refusal > 0) --arguments_until_refusal;
  return next(kernel, index, bytes, value);
}

namespace {

void add_to_counter(ScheduleRecorder& recorder, const BufferRef& counter, uint32_t amount) {
  recorder.pass("count", schedule_program(), "add_to_counter")
      .global(1)
      .local(1)
      .arg("counter", counter)
      .arg("amount", amount);
}

}  // namespace

TEST_CASE("a launch that the device refuses stops the schedule and names pass, kernel, sizes and device") {
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap}) {
    KernelScheduler scheduler(test_device(), {mode, true, false});
    const auto counter = make_buffer("counter", {0}), out = make_buffer("out", Uints(16, 7));
    const size_t too_many = 4 * test_device()->info().max_work_group_size;
    ScheduleRecorder recorder = scheduler.record("doomed", "test");
    add_to_counter(recorder, counter, 1);
    recorder.pass("bad launch", schedule_program(), "write_pattern")
        .global(16)
        .local(too_many)
        .arg("target", out)
        .arg("salt", 1u)
        .arg("count", 16u);
    add_to_counter(recorder, counter, 100);
    Schedule schedule = recorder.compile();
    const std::string message = error_message([&] { scheduler.run(schedule); });
    CHECK(contains(message, "schedule 'doomed': pass 'bad launch' (kernel 'write_pattern')"));
    CHECK(contains(message, test_device()->info().name));
    CHECK(contains(message, "CL_INVALID_WORK_GROUP_SIZE"));
    CHECK(contains(message, std::to_string(test_device()->info().max_work_group_size)));
    CHECK(counter.download() == Uints{1});  // drained, and nothing behind the failure ran
    CHECK(out.download() == Uints(16, 7));
    CHECK(contains(error_message([&] { scheduler.run(schedule); }),
                   "schedule 'doomed' failed before and cannot run again"));
    CHECK(counter.download() == Uints{1});

    ScheduleRecorder other = scheduler.record("fine", "test");  // the scheduler itself goes on
    add_to_counter(other, counter, 1);
    Schedule fine = other.compile();
    scheduler.run(fine);
    CHECK(counter.download() == Uints{2});
  }
}

TEST_CASE("what a host step throws comes out, and the schedule has failed") {
  KernelScheduler scheduler(test_device());
  const auto counter = make_buffer("counter", {0});
  ScheduleRecorder recorder = scheduler.record("doomed", "test");
  add_to_counter(recorder, counter, 1);
  recorder.host_step("host", {counter}, {}, [] { throw std::runtime_error("the disk is full"); });
  Schedule schedule = recorder.compile();
  CHECK_THROWS_WITH_AS(scheduler.run(schedule), "the disk is full", std::runtime_error);
  CHECK(contains(error_message([&] { scheduler.run(schedule); }), "the disk is full"));
}

TEST_CASE("a host step sees what passes before it wrote, also in earlier runs") {
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap}) {
    KernelScheduler scheduler(test_device(), {mode, true, false});
    auto counter = make_buffer("counter", {0});
    Uints seen;
    ScheduleRecorder recorder = scheduler.record("watched", "test");
    recorder.host_step("before", {counter}, {}, [&] { seen.push_back(counter.download()[0]); });
    for (int i = 0; i < 50; ++i) add_to_counter(recorder, counter, 1);
    recorder.host_step("reset", {}, {counter}, [&] {
      seen.push_back(counter.download()[0]);
      counter.upload({1000});
    });
    add_to_counter(recorder, counter, 5);
    Schedule schedule = recorder.compile();
    scheduler.run(schedule);
    scheduler.run(schedule);
    scheduler.finish();
    CHECK(seen == Uints{0, 50, 1005, 1055});
    CHECK(counter.download() == Uints{1005});
  }
}

TEST_CASE("a host step waits for earlier runs, not only when it happens to use the same queue") {
  const std::shared_ptr<Device>& device = test_device();
  KernelScheduler scheduler(device, {QueueMode::in_order, true, false});
  const auto data = make_buffer("data", Uints(4096, 1));
  uint32_t seen = 0;
  ScheduleRecorder slow = scheduler.record("slow", "test"), watch = scheduler.record("watch", "test");
  slow.pass("scramble", schedule_program(), "scramble_alone")
      .global(1)
      .local(1)
      .arg("target", data)
      .arg("rounds", 2000u)
      .arg("count", 4096u);
  watch.host_step("look", {data}, {}, [&] {
    REQUIRE(clEnqueueReadBuffer(device->overlap_queue(), data.handle(), CL_TRUE, 0, sizeof(seen), &seen, 0, nullptr,
                                nullptr) == CL_SUCCESS);
  });
  Schedule first = slow.compile(), second = watch.compile();
  scheduler.run(first);
  scheduler.run(second);
  CHECK(seen == data.download()[0]);
}

TEST_CASE("cancellation is felt between passes; the schedule can run again") {
  KernelScheduler scheduler(test_device());
  auto counter = make_buffer("counter", {0});
  bool stop = false;
  int consumed = 0;
  scheduler.set_cancel([&] { return stop; });
  ScheduleRecorder recorder = scheduler.record("long", "test");
  add_to_counter(recorder, counter, 1);
  recorder.host_step("Ctrl-C", {counter}, {counter}, [&] { stop = true; });
  add_to_counter(recorder, counter, 100);
  recorder.read_back("read", counter, [&](std::span<const std::byte>) { ++consumed; });
  Schedule schedule = recorder.compile();
  CHECK(scheduler.run(schedule) == RunResult::cancelled);
  CHECK(counter.download() == Uints{1});
  CHECK(scheduler.run(schedule) == RunResult::cancelled);
  CHECK(counter.download() == Uints{1});  // the flag was still up: nothing ran
  CHECK(scheduler.run(schedule, Budget{0, 10}) == 0);
  CHECK(consumed == 0);
  CHECK(scheduler.profile().runs == 0);
  scheduler.run_to_end(schedule);
  CHECK(counter.download() == Uints{102});
  CHECK(consumed == 1);
}

TEST_CASE("passes known to be long are not all enqueued ahead, so that cancellation is felt") {
  KernelScheduler scheduler(test_device());
  const auto data = make_buffer("data", Uints(4096, 1));
  ScheduleRecorder recorder = scheduler.record("long", "test");
  for (int i = 0; i < 8; ++i) {
    recorder.pass("scramble", schedule_program(), "scramble_alone")
        .global(1)
        .local(1)
        .arg("target", data)
        .arg("rounds", 5000u)
        .arg("count", 4096u);
  }
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  // 20 million dependent steps each: two of them fill what may be enqueued ahead.
  const uint64_t before = scheduler.api_calls().waits;
  scheduler.run(schedule);
  CHECK(scheduler.api_calls().waits - before >= 5);
  int asked = 0;
  scheduler.set_cancel([&] { return ++asked > 4; });
  CHECK(scheduler.run(schedule) == RunResult::cancelled);
}

TEST_CASE("budgets count iterations, and seconds end them") {
  KernelScheduler scheduler(test_device());
  const auto counter = make_buffer("counter", {0});
  ScheduleRecorder recorder = scheduler.record("loop", "test");
  add_to_counter(recorder, counter, 1);
  Schedule schedule = recorder.compile();
  CHECK(scheduler.run(schedule, Budget{0, 25}) == 25);
  CHECK(counter.download() == Uints{25});
  const uint64_t timed = scheduler.run(schedule, Budget{0.02, 0});
  CHECK(timed > 0);
  CHECK(counter.download()[0] == 25 + timed);
  int asked = 0;
  scheduler.set_cancel([&] { return ++asked > 10; });
  CHECK(scheduler.run(schedule, Budget{}) == 10);
  CHECK(counter.download()[0] == 35 + timed);
}

TEST_CASE("a sliced pass gives the result of the whole one, and can be cancelled inside") {
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap}) {
    KernelScheduler scheduler(test_device(), {mode, true, false});
    const uint32_t count = 1000;
    const auto out = make_buffer("out", Uints(count, 1));
    ScheduleRecorder recorder = scheduler.record("sliced", "test");
    recorder.pass("slices", schedule_program(), "add_index")
        .global(count)
        .local(16)
        .slice(100)
        .arg("out", out)
        .arg("count", count);
    recorder.pass("whole", schedule_program(), "add_index").global(count).local(16).arg("out", out).arg("count", count);
    Schedule schedule = recorder.compile();
    Uints expected(count, 1);
    for (int run = 0; run < 2; ++run) {
      scheduler.run(schedule);
      for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t i = 0; i < count; ++i) expected[i] = expected[i] * 3 + i;
      }
      REQUIRE(out.download() == expected);
    }
    scheduler.finish();
    CHECK(scheduler.profile().passes[0].count == 2);
    CHECK(scheduler.api_calls().enqueues >= 2 * (9 + 1));  // slices of 112 items: rounded up to groups

    int asked = 0;
    scheduler.set_cancel([&] { return ++asked > 3; });
    CHECK(scheduler.run(schedule) == RunResult::cancelled);
    scheduler.finish();
    const Uints partial = out.download();
    for (uint32_t i = 0; i < count; ++i) REQUIRE(partial[i] == (i < 3 * 112 ? expected[i] * 3 + i : expected[i]));
    scheduler.set_cancel([] { return false; });
    CHECK(scheduler.run(schedule) == RunResult::done);  // the base starts at 0 again
    REQUIRE(out.download()[0] == (partial[0] * 3) * 3);
  }
}

TEST_CASE("who follows a sliced pass waits for all of its slices") {
  const uint32_t count = 1024;
  std::vector<Uints> results;
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap}) {
    KernelScheduler scheduler(test_device(), {mode, true, false});
    const auto out = make_buffer("out", Uints(count, 1)), copy = make_buffer("copy", Uints(count, 0));
    ScheduleRecorder recorder = scheduler.record("sliced", "test");
    recorder.pass("slices", schedule_program(), "add_index_late")
        .global(count)
        .local(16)
        .slice(256)
        .arg("out", out)
        .arg("rounds", 1000000u)
        .arg("count", count);
    recorder.pass("copy", schedule_program(), "overwrite")
        .global(count)
        .local(16)
        .arg("target", copy)
        .arg("source", out)
        .arg("salt", 0u)
        .arg("count", count);
    Schedule schedule = recorder.compile();
    scheduler.warm_up(schedule);  // no compiler between the passes
    scheduler.run(schedule);
    results.push_back(copy.download());
  }
  CHECK(results[0] == results[1]);
}

TEST_CASE("a schedule may be destroyed while it runs, and an empty one runs") {
  KernelScheduler scheduler(test_device());
  const auto data = make_buffer("data", Uints(4096, 1));
  {
    ScheduleRecorder recorder = scheduler.record("short-lived", "test");
    const BufferRef temporary = recorder.transient<uint32_t>("temporary", 1 << 18);
    recorder.fill_zero("clear", temporary);
    for (int i = 0; i < 3; ++i) {
      recorder.pass("scramble", schedule_program(), "scramble_alone")
          .global(1)
          .local(1)
          .arg("target", temporary)
          .arg("rounds", 20u)
          .arg("count", 1u << 18);
    }
    Schedule schedule = recorder.compile();
    scheduler.run(schedule);
  }
  Schedule empty = scheduler.record("empty", "test").compile();
  CHECK(scheduler.run(empty) == RunResult::done);
  CHECK(empty.pass_count() == 0);
  scheduler.finish();
}

TEST_CASE("a warm-up that cannot bind a copy leaves the callers' buffers bound") {
  KernelScheduler scheduler(test_device());
  const auto first = make_buffer("first", Uints(64, 1)), second = make_buffer("second", Uints(64, 2));
  ScheduleRecorder recorder = scheduler.record("bound", "test");
  for (const auto& [buffer, salt] : {std::pair{first, 10u}, std::pair{second, 20u}}) {
    recorder.pass("write", schedule_program(), "write_pattern")
        .global(64)
        .arg("target", buffer)
        .arg("salt", salt)
        .arg("count", 64u);
  }
  Schedule schedule = recorder.compile();
  refuse_kernel_arguments_after(1);  // the first pass writes to its copy by then
  scheduler.warm_up(schedule);
  CHECK(refuse_kernel_arguments_after(-1) == 1);
  CHECK(first.download() == Uints(64, 1));
  scheduler.run(schedule);
  scheduler.finish();
  CHECK(first.download()[3] == 31);
  CHECK(second.download()[3] == 41);
}

TEST_CASE("a sliced pass of more work-items than a slice's base can name is refused") {
  KernelScheduler scheduler(test_device());
  const auto out = make_buffer("out", Uints(16, 1));
  int asked = 0;
  scheduler.set_cancel([&] { return ++asked > 3; });
  ScheduleRecorder recorder = scheduler.record("sliced", "test");
  recorder.pass("endless", schedule_program(), "add_index")
      .global((size_t{1} << 32) + 1)
      .local(16)
      .slice(16)
      .arg("out", out)
      .arg("count", 16u);
  Schedule schedule = recorder.compile();
  const std::string message = error_message([&] { scheduler.run(schedule); });
  CHECK(contains(message, "schedule 'sliced': pass 'endless' (kernel 'add_index')"));
  CHECK(contains(message, "at most 2^32 work-items along x, not 4294967312"));
  CHECK(out.download() == Uints(16, 1));
}
