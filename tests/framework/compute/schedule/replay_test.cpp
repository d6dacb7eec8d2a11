// SPDX-License-Identifier: Apache-2.0
// Replays: API calls, variables, warm-up, determinism, profile.
#include <doctest/doctest.h>

#include <algorithm>

#include "lucarium/base/json.h"
#include "schedule_fixture.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t replay_elements = 4096;

/// Twenty passes of which ten are independent of the other ten.
struct TwoChains {
  TypedBuffer<uint32_t> a = make_buffer("a", Uints(replay_elements, 1)),
                        b = make_buffer("b", Uints(replay_elements, 2));
  TypedBuffer<uint32_t> source = make_buffer("source", Uints(replay_elements, 3));
  Variable<uint32_t> factor;
  Schedule schedule;

  TwoChains(KernelScheduler& scheduler, bool with_read_back) {
    ScheduleRecorder recorder = scheduler.record("chains", "test");
    factor = recorder.variable<uint32_t>("factor", 3);
    for (int i = 0; i < 10; ++i) {
      for (const auto& target : {a, b}) {
        recorder.pass(i < 5 ? "early" : "late", schedule_program(), "mix_in")
            .global(replay_elements)
            .local(64)
            .arg("target", target)
            .arg("source", source)
            .arg("factor", factor)
            .arg("count", replay_elements)
            .moves_bytes(3 * sizeof(uint32_t) * replay_elements);
      }
    }
    if (with_read_back) recorder.read_back("read", a, [](std::span<const std::byte>) {});
    schedule = recorder.compile();
  }
};

struct Calls {
  uint64_t enqueues, set_arguments, waits, flushes;
};

Calls calls_of_a_run(KernelScheduler& scheduler, Schedule& schedule) {
  const ApiCalls before = scheduler.api_calls();
  scheduler.run(schedule);
  const ApiCalls& now = scheduler.api_calls();
  return {now.enqueues - before.enqueues, now.set_arguments - before.set_arguments, now.waits - before.waits,
          now.flushes - before.flushes};
}

}  // namespace

TEST_CASE("a replay on the in-order queue makes one enqueue per pass, one flush, and sets no argument") {
  KernelScheduler scheduler(test_device(), {QueueMode::in_order, true, false});
  TwoChains chains(scheduler, false);
  for (int i = 0; i < 3; ++i) scheduler.run(chains.schedule);  // until durations are known
  scheduler.finish();
  // On a busy machine passes take so long that what is enqueued is limited (ScheduleRun::limit_queued_work), and a run
  // waits more often: the quickest runs count.
  uint64_t min_waits = 20;
  for (int i = 0; i < 40; ++i) {
    const Calls calls = calls_of_a_run(scheduler, chains.schedule);
    CHECK(calls.enqueues == 20);
    CHECK(calls.set_arguments == 0);
    CHECK(calls.flushes == 1);
    if (i >= 2) min_waits = std::min(min_waits, calls.waits);
  }
  CHECK(min_waits == 1);                  // for the run before the last one
  chains.schedule.set(chains.factor, 3);  // no change
  CHECK(calls_of_a_run(scheduler, chains.schedule).set_arguments == 0);
  chains.schedule.set(chains.factor, 4);
  CHECK(calls_of_a_run(scheduler, chains.schedule).set_arguments == 20);
  CHECK(calls_of_a_run(scheduler, chains.schedule).set_arguments == 0);
}

TEST_CASE("a read-back adds one copy and one wait; overlap adds a barrier before and one behind") {
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap}) {
    KernelScheduler scheduler(test_device(), {mode, true, false});
    TwoChains chains(scheduler, true);
    for (int i = 0; i < 3; ++i) scheduler.run(chains.schedule);
    uint64_t min_waits = 20;
    for (int i = 0; i < 40; ++i) {
      const Calls calls = calls_of_a_run(scheduler, chains.schedule);
      CHECK(calls.enqueues == (mode == QueueMode::in_order ? 21 : 23));
      CHECK(calls.set_arguments == 0);
      CHECK(calls.flushes == (mode == QueueMode::in_order ? 1 : 2));
      min_waits = std::min(min_waits, calls.waits);
    }
    CHECK(min_waits == 1);
  }
}

TEST_CASE("the graph of two chains has no edge between them") {
  KernelScheduler scheduler(test_device());
  TwoChains chains(scheduler, false);
  CHECK(chains.schedule.pass_count() == 20);
  const auto edges = chains.schedule.edges();
  CHECK(edges.size() == 18);
  for (const auto& [from, to] : edges) CHECK(to == from + 2);
  const std::string dot = chains.schedule.dot();
  CHECK(contains(dot, "digraph \"chains\""));
  CHECK(contains(dot, "p0 -> p2"));
  CHECK(contains(dot, "label=\"early (mix_in)\""));
}

TEST_CASE("the same schedule gives the same bits in every mode, again and again") {
  std::vector<Uints> results;
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap, QueueMode::automatic, QueueMode::overlap}) {
    KernelScheduler scheduler(test_device(), {mode, true, false});
    TwoChains chains(scheduler, false);
    for (uint32_t i = 0; i < 20; ++i) {
      chains.schedule.set(chains.factor, i);
      scheduler.run(chains.schedule);
    }
    results.push_back(chains.b.download());
    CHECK(results.back() == results.front());
  }
}

TEST_CASE("large fills reach from the first byte to the last in every mode") {
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap})
    for (const size_t count : {size_t{1} << 16, (size_t{1} << 16) + 1, (size_t{3} << 16) + 7}) {
      KernelScheduler scheduler(test_device(), {mode, true, false});
      const auto words = make_buffer("words", Uints(count, 5));
      ScheduleRecorder recorder = scheduler.record("large fill", "test");
      recorder.fill_zero("clear", words);
      Schedule schedule = recorder.compile();
      scheduler.run(schedule);
      scheduler.finish();
      CHECK(words.download() == Uints(count, 0));
      REQUIRE(scheduler.profile().passes.size() == 1);
      CHECK(scheduler.profile().passes[0].count == 1);
      CHECK(scheduler.profile().passes[0].bytes == 4.0 * static_cast<double>(count));
    }
}

TEST_CASE("warm_up touches no caller's buffer and runs no host step, and the first run is right") {
  KernelScheduler scheduler(test_device());
  TwoChains chains(scheduler, true);
  const auto counter = make_buffer("counter", {0}), out = make_buffer("out", {1, 2, 3});
  int host_steps = 0, read_backs = 0;
  ScheduleRecorder recorder = scheduler.record("warm", "test");
  recorder.pass("fill", schedule_program(), "fill_counted")
      .global_by(counter)
      .arg("out", out)
      .arg("counter", counter)
      .arg("salt", 9u);
  recorder.fill_zero("clear", chains.a);
  recorder.host_step("host", {out}, {}, [&] { ++host_steps; });
  recorder.read_back("read", out, [&](std::span<const std::byte>) { ++read_backs; });
  Schedule schedule = recorder.compile();
  const ApiCalls before = scheduler.api_calls();
  const size_t used = test_device()->memory().used_bytes();
  scheduler.warm_up(schedule);
  scheduler.warm_up(chains.schedule);
  CHECK(test_device()->memory().used_bytes() == used);
  CHECK(scheduler.api_calls().enqueues == before.enqueues);
  CHECK(scheduler.profile().runs == 0);
  CHECK(host_steps + read_backs == 0);
  CHECK(chains.a.download() == Uints(replay_elements, 1));
  CHECK(out.download() == Uints{1, 2, 3});

  TypedBuffer<uint32_t>(counter).upload({2});
  scheduler.run(schedule);
  CHECK(out.download() == Uints{0, 9, 3});
  CHECK(chains.a.download() == Uints(replay_elements, 0));
  CHECK((host_steps == 1 && read_backs == 1));
}

TEST_CASE("the profile counts passes, and prints as table, JSON and trace") {
  KernelScheduler scheduler(test_device());
  TwoChains chains(scheduler, true);
  for (int i = 0; i < 4; ++i) scheduler.run(chains.schedule);
  const Profile& profile = scheduler.profile();
  CHECK(profile.runs == 4);
  REQUIRE(profile.passes.size() == 3);  // passes of the same name and kernel are one line
  CHECK(profile.passes[0].name == "early");
  CHECK(profile.passes[0].kernel == "mix_in");
  CHECK(profile.passes[0].count == 40);
  CHECK(profile.passes[0].bytes == 40.0 * 3 * 4 * replay_elements);
  CHECK(profile.passes[2].bytes == 4.0 * 4 * replay_elements);
  double busy = 0;
  for (const PassProfile& pass : profile.passes) {
    CHECK(pass.device_seconds > 0);
    busy += pass.device_seconds;
  }
  CHECK(profile.wall_seconds > 0);
  CHECK(profile.events.size() == 4 * 21);
  for (const PassEvent& event : profile.events) {
    REQUIRE(event.queued_ns <= event.started_ns);
    REQUIRE(event.started_ns <= event.ended_ns);
  }

  CHECK(contains(profile.table(), "chains/early"));
  const auto json = nlohmann::json::parse(profile.json());
  CHECK(json["passes"].size() == 3);
  CHECK(json["passes"][1]["count"] == 40);
  CHECK(json["wall_seconds"].get<double>() == test::relative(profile.wall_seconds));
  const auto trace = nlohmann::json::parse(profile.chrome_trace());
  REQUIRE(trace["traceEvents"].size() == 4 * 21);
  double traced = 0;
  std::map<int, double> lane_end;
  for (const auto& event : trace["traceEvents"]) {
    const double start = event["ts"], duration = event["dur"];
    CHECK(start >= lane_end[event["tid"].get<int>()] - 1e-3);
    lane_end[event["tid"].get<int>()] = start + duration;
    traced += duration * 1e-6;
  }
  CHECK(traced == test::relative(busy));

  scheduler.reset_profile();
  CHECK(profile.runs == 0);
  scheduler.run(chains.schedule);
  CHECK(scheduler.profile().passes[0].count == 10);
}

TEST_CASE("without profiling nothing is kept") {
  KernelScheduler scheduler(test_device(), {QueueMode::automatic, false, false});
  TwoChains chains(scheduler, true);
  scheduler.run(chains.schedule);
  CHECK(scheduler.profile().passes.empty());
  CHECK(scheduler.profile().runs == 0);
}
