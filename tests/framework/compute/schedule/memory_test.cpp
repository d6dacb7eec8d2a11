// SPDX-License-Identifier: Apache-2.0
// Transients: sharing, sizes from counters, growth, refusal, guard zones.
#include <doctest/doctest.h>

#include <numeric>

#include "lucarium/compute/schedule/transient_memory.h"
#include "schedule_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t memory_elements = 1024;

PassBuilder write_pattern(ScheduleRecorder& recorder, const BufferRef& target, uint32_t salt) {
  return recorder.pass("pattern", schedule_program(), "write_pattern")
      .global(memory_elements)
      .arg("target", target)
      .arg("salt", salt)
      .arg("count", memory_elements)
      .discards("target");
}

void mix_in(ScheduleRecorder& recorder, const BufferRef& target, const BufferRef& source) {
  recorder.pass("mix", schedule_program(), "mix_in")
      .global(memory_elements)
      .arg("target", target)
      .arg("source", source)
      .arg("factor", 3u)
      .arg("count", memory_elements);
}

/// result = (((0·3 + p0)·3 + p1)·3 + …), each pattern in a transient of its own.
Schedule chain(KernelScheduler& scheduler, const BufferRef& result, uint32_t length) {
  ScheduleRecorder recorder = scheduler.record("chain", "test");
  recorder.fill_zero("clear", result);
  for (uint32_t i = 0; i < length; ++i) {
    const BufferRef pattern = recorder.transient<uint32_t>("pattern", memory_elements);
    write_pattern(recorder, pattern, i);
    mix_in(recorder, result, pattern);
  }
  return recorder.compile();
}

Uints chain_result(uint32_t length) {
  Uints values(memory_elements, 0);
  for (uint32_t step = 0; step < length; ++step) {
    for (uint32_t i = 0; i < memory_elements; ++i) values[i] = values[i] * 3 + ((i + 1) % memory_elements) * 7 + step;
  }
  return values;
}

/// Counts the multiples of `divisor` among 0 … 1023, then fills as many elements and sums them up.
struct CountedSchedule {
  TypedBuffer<uint32_t> numbers, sum;
  Variable<uint32_t> divisor;
  Schedule schedule;
  std::vector<uint32_t> sums;

  explicit CountedSchedule(KernelScheduler& scheduler, size_t elements_per_count = 1) {
    Uints values(memory_elements);
    std::iota(values.begin(), values.end(), 0u);
    numbers = make_buffer("numbers", values);
    sum = make_buffer("sum", {0});
    ScheduleRecorder recorder = scheduler.record("counted", "test");
    divisor = recorder.variable<uint32_t>("divisor", 16);
    const BufferRef counter = recorder.transient<uint32_t>("counter", 1);
    const BufferRef list =
        recorder.transient_sized_by<uint32_t>("list", counter, 0, elements_per_count, "lower the test's size");
    recorder.fill_zero("clear", counter);
    recorder.pass("count", schedule_program(), "count_multiples")
        .global(memory_elements)
        .arg("values", numbers)
        .arg("counter", counter)
        .arg("divisor", divisor)
        .arg("count", memory_elements);
    recorder.pass("fill", schedule_program(), "fill_counted")
        .global_by(counter)
        .arg("out", list)
        .arg("counter", counter)
        .arg("salt", 5u);
    recorder.pass("sum", schedule_program(), "sum_counted")
        .global(1)
        .local(1)
        .arg("values", list)
        .arg("counter", counter)
        .arg("sum", sum);
    recorder.read_back("read sum", sum, [this](std::span<const std::byte> bytes) {
      sums.push_back(*reinterpret_cast<const uint32_t*>(bytes.data()));
    });
    schedule = recorder.compile();
  }
  static uint32_t expected(uint32_t step) {
    const uint32_t count = (memory_elements + step - 1) / step;
    return 5 * (count * (count - 1) / 2);
  }
};

}  // namespace

TEST_CASE("transients whose lives do not meet share memory, and the result is right in every mode") {
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap, QueueMode::automatic}) {
    KernelScheduler scheduler(test_device(), {mode, true, false});
    const auto result = make_buffer("result", Uints(memory_elements, 9));
    Schedule schedule = chain(scheduler, result, 12);
    CHECK(schedule.transient_bytes() == memory_elements * sizeof(uint32_t));
    CHECK(schedule.transient_bytes_unshared() == 12 * memory_elements * sizeof(uint32_t));
    for (int run = 0; run < 3; ++run) {
      scheduler.run(schedule);
      REQUIRE(result.download() == chain_result(12));
    }
    // Sharing makes the patterns wait for each other: the graph is a chain.
    CHECK(schedule.edges().size() == schedule.pass_count() - 1);
    CHECK(contains(schedule.dot(), "style=dashed"));
  }
}

TEST_CASE("the account knows the transients and gets them back") {
  KernelScheduler scheduler(test_device());
  const auto result = make_buffer("result", Uints(memory_elements, 9));
  const auto before = test_device()->memory().used_bytes();
  {
    Schedule schedule = chain(scheduler, result, 4);
    CHECK(test_device()->memory().used_bytes() == before + schedule.transient_bytes());
    scheduler.run(schedule);
  }
  CHECK(test_device()->memory().used_bytes() == before);
}

TEST_CASE("a discarded transient may lie elsewhere afterwards") {
  KernelScheduler scheduler(test_device());
  const auto result = make_buffer("result", Uints(memory_elements, 0));
  ScheduleRecorder recorder = scheduler.record("lives", "test");
  const BufferRef first = recorder.transient<uint32_t>("first", memory_elements);
  const BufferRef second = recorder.transient<uint32_t>("second", memory_elements);
  for (uint32_t round = 0; round < 2; ++round) {
    write_pattern(recorder, first, round);
    mix_in(recorder, result, first);
    write_pattern(recorder, second, round + 10);
    mix_in(recorder, result, second);
  }
  Schedule schedule = recorder.compile();
  CHECK(schedule.transient_bytes() == memory_elements * sizeof(uint32_t));
  scheduler.run(schedule);
  Uints expected(memory_elements, 0);
  for (const uint32_t salt : {0u, 10u, 1u, 11u}) {
    for (uint32_t i = 0; i < memory_elements; ++i)
      expected[i] = expected[i] * 3 + ((i + 1) % memory_elements) * 7 + salt;
  }
  CHECK(result.download() == expected);
}

TEST_CASE("a transient sized by a counter of the same run grows to its high-water mark and loses nothing") {
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap}) {
    for (const bool debug : {false, true}) {
      KernelScheduler scheduler(test_device(), {mode, true, debug});
      CountedSchedule counted(scheduler);
      size_t high_water = 0;
      for (const uint32_t step : {16u, 4u, 1000u, 1u, 2u, 3u}) {
        counted.schedule.set(counted.divisor, step);
        scheduler.run(counted.schedule);
        REQUIRE(counted.sums.back() == CountedSchedule::expected(step));
        CHECK(counted.schedule.transient_bytes() >= high_water);
        high_water = counted.schedule.transient_bytes();
      }
      CHECK(high_water >= memory_elements * sizeof(uint32_t));
    }
  }
}

TEST_CASE("growth sets the arguments once; a run within the high-water mark sets none") {
  KernelScheduler scheduler(test_device());
  CountedSchedule counted(scheduler);
  scheduler.run(counted.schedule);
  const auto set_arguments = [&] {
    const uint64_t before = scheduler.api_calls().set_arguments;
    scheduler.run(counted.schedule);
    return scheduler.api_calls().set_arguments - before;
  };
  CHECK(set_arguments() == 0);
  counted.schedule.set(counted.divisor, 1);
  CHECK(set_arguments() == 3);  // the variable, and the list in both of its passes
  CHECK(set_arguments() == 0);
}

TEST_CASE("a count of zero leaves the pass out") {
  KernelScheduler scheduler(test_device());
  const auto counter = make_buffer("counter", {0}), out = make_buffer("out", {1, 2, 3});
  ScheduleRecorder recorder = scheduler.record("nothing", "test");
  recorder.pass("fill", schedule_program(), "write_pattern")
      .global_by(counter)
      .arg("target", out)
      .arg("salt", 5u)
      .arg("count", 3u);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  CHECK(out.download() == Uints{1, 2, 3});
  make_buffer("counter", {0});
  TypedBuffer<uint32_t>(counter).upload({3});
  scheduler.run(schedule);
  CHECK(out.download() == Uints{5, 12, 19});
}

TEST_CASE("who follows a pass that was left out waits for what that one would have waited for") {
  KernelScheduler scheduler(test_device(), {QueueMode::overlap, true, false});
  const auto counter = make_buffer("counter", {0}), data = make_buffer("data", Uints(memory_elements, 1));
  const auto copy = make_buffer("copy", Uints(memory_elements, 0));
  ScheduleRecorder recorder = scheduler.record("gap", "test");
  recorder.pass("slow", schedule_program(), "scramble_alone")
      .global(1)
      .local(1)
      .arg("target", data)
      .arg("rounds", 1000u)
      .arg("count", memory_elements);
  recorder.pass("left out", schedule_program(), "write_pattern")
      .global_by(counter)
      .arg("target", data)
      .arg("salt", 1u)
      .arg("count", memory_elements);
  recorder.pass("copy", schedule_program(), "overwrite")
      .global(memory_elements)
      .arg("target", copy)
      .arg("source", data)
      .arg("salt", 0u)
      .arg("count", memory_elements);
  Schedule schedule = recorder.compile();
  scheduler.warm_up(schedule);  // no compiler between the passes
  scheduler.run(schedule);
  Uints expected = data.download();
  for (uint32_t i = 0; i < memory_elements; ++i) expected[i] = expected[i] * 2654435761u + i;
  CHECK(copy.download() == expected);
}

TEST_CASE("what does not fit fails the run with the numbers and the remedy, and the schedule then refuses") {
  KernelScheduler scheduler(test_device());
  CountedSchedule counted(scheduler, size_t{1} << 36);
  const std::string message = error_message([&] { scheduler.run(counted.schedule); });
  CHECK(contains(message, "list"));
  CHECK(contains(message, "lower the test's size"));
  CHECK(contains(error_message([&] { scheduler.run(counted.schedule); }), "schedule 'counted' failed before"));
}

TEST_CASE("debug mode finds writes outside of a transient and names the pass") {
  for (const int index : {-1, static_cast<int>(memory_elements)}) {
    KernelScheduler scheduler(test_device(), {QueueMode::automatic, true, true});
    ScheduleRecorder recorder = scheduler.record("faulty", "test");
    const BufferRef victim = recorder.transient<uint32_t>("victim", memory_elements);
    write_pattern(recorder, victim, 1);
    recorder.pass("culprit", schedule_program(), "poke")
        .global(1)
        .local(1)
        .arg("out", victim)
        .arg("index", index)
        .arg("value", 0u);
    write_pattern(recorder, victim, 2);
    Schedule schedule = recorder.compile();
    CHECK(error_message([&] { scheduler.run(schedule); }) ==
          fmt::format("schedule 'faulty': pass 'culprit' wrote outside of transient 'victim' ({} its 4096 bytes)",
                      index < 0 ? "before" : "behind"));
  }
}

TEST_CASE("debug mode shares nothing and poisons what nobody wrote") {
  KernelScheduler scheduler(test_device(), {QueueMode::automatic, true, true});
  const auto result = make_buffer("result", Uints(memory_elements, 0));
  Schedule schedule = chain(scheduler, result, 3);
  CHECK(schedule.transient_bytes() > schedule.transient_bytes_unshared());
  scheduler.run(schedule);
  CHECK(result.download() == chain_result(3));

  ScheduleRecorder recorder = scheduler.record("careless", "test");
  const BufferRef unset = recorder.transient<uint32_t>("unset", memory_elements);
  recorder.pass("poke", schedule_program(), "poke")
      .global(1)
      .local(1)
      .arg("out", unset)
      .arg("index", 0)
      .arg("value", 0u);
  recorder.pass("overwrite", schedule_program(), "overwrite")
      .global(memory_elements)
      .arg("target", result)
      .arg("source", unset)
      .arg("salt", 0u)
      .arg("count", memory_elements)
      .discards("target");
  Schedule careless = recorder.compile();
  scheduler.run(careless);
  const Uints values = result.download();
  CHECK(values[0] == 0);
  CHECK(values[5] == 0x7FC0DEADu * 2654435761u + 5);
}

TEST_CASE("whole arenas: lives share one only after each other, none is part of another, and the ranges say so") {
  const std::vector<LiveRange> lives = {{0, 0, 1}, {1, 1, 2}, {2, 2, 3}};
  const TransientMemory memory(*test_device(), "whole", "test",
                               {{"first", 4000, false, ""}, {"second", 1000, false, ""}, {"third", 6000, false, ""}},
                               lives, TransientLayout::whole);
  CHECK(memory.memory_count() == 2);
  CHECK(memory.handle(0) == memory.handle(2));
  CHECK(memory.handle(0) != memory.handle(1));
  CHECK(memory.range(0).begin == 0);
  CHECK(memory.range(2).end == 6000);
  CHECK(memory.allocated_bytes() == 7000);
  for (int life = 0; life < 3; ++life) {
    cl_mem parent = nullptr;
    size_t bytes = 0;
    REQUIRE(clGetMemObjectInfo(memory.handle(life), CL_MEM_ASSOCIATED_MEMOBJECT, sizeof parent, &parent, nullptr) ==
            CL_SUCCESS);
    CHECK(parent == nullptr);
    REQUIRE(clGetMemObjectInfo(memory.handle(life), CL_MEM_SIZE, sizeof bytes, &bytes, nullptr) == CL_SUCCESS);
    CHECK(bytes >= (life == 1 ? 1000 : 6000));
  }
}
