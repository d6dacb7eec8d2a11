// SPDX-License-Identifier: Apache-2.0
// Random schedules of passes that do not commute, against the same steps done one by one on the host.
#include <doctest/doctest.h>

#include <cstring>
#include <random>

#include "schedule_fixture.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t order_elements = 300;  // not a multiple of any local size

/// One random step, in a form that both sides can execute.
struct Operation {
  enum Kind { mix, overwrite, pattern, scramble, clear, host } kind = mix;
  size_t target = 0, source = 0;
  uint32_t number = 0, count = order_elements;
};

void apply_on_host(const Operation& op, std::vector<Uints>& memory, uint32_t factor) {
  Uints& target = memory[op.target];
  const Uints source = memory[op.source];
  switch (op.kind) {
    case Operation::mix:
      for (uint32_t i = 0; i < op.count; ++i) target[i] = target[i] * (op.number + factor) + source[(i + 1) % op.count];
      break;
    case Operation::overwrite:
      for (uint32_t i = 0; i < op.count; ++i) target[i] = (source[i] ^ op.number) * 2654435761u + i;
      break;
    case Operation::pattern:
      for (uint32_t i = 0; i < op.count; ++i) target[i] = i * 7u + op.number;
      break;
    case Operation::scramble: {
      uint32_t carry = 1;
      for (uint32_t round = 0; round < op.number; ++round) {
        for (uint32_t i = 0; i < op.count; ++i) target[i] = carry = (target[i] ^ carry) * 1664525u + round;
      }
      break;
    }
    case Operation::clear: target.assign(target.size(), 0); break;
    case Operation::host:
      for (uint32_t& value : target) value = value * 3 + op.number;
      break;
  }
}

/// Random operations over `real` callers' buffers followed by `transients`; a transient is written before it is read.
std::vector<Operation> random_operations(std::mt19937& random, size_t count, size_t real, size_t transients) {
  std::vector<Operation> operations;
  std::vector<bool> defined(real + transients, false);
  std::fill_n(defined.begin(), real, true);
  while (operations.size() < count) {
    Operation op;
    op.kind = static_cast<Operation::Kind>(random() % 6);
    op.target = random() % (real + transients);
    do op.source = random() % (real + transients);
    while (op.source == op.target || !defined[op.source]);
    op.number = static_cast<uint32_t>(op.kind == Operation::scramble ? 1 + random() % 20 : random());
    if (op.kind == Operation::mix) op.number &= 0xFFFF;
    const bool replaces =
        op.kind == Operation::overwrite || op.kind == Operation::pattern || op.kind == Operation::clear;
    if (!replaces && !defined[op.target]) continue;
    if (op.kind == Operation::host && op.target >= real) continue;  // host work has no access to transients
    if (!replaces && random() % 3 == 0) op.count = 40;              // a part of the buffer only
    defined[op.target] = true;
    operations.push_back(op);
  }
  return operations;
}

struct Graph {
  std::vector<TypedBuffer<uint32_t>> buffers;
  std::vector<BufferRef> refs;
  std::vector<std::pair<Variable<uint32_t>, uint32_t>> mixes;  ///< factors, and what they are in run 0
  Schedule schedule;
  std::vector<Uints> read_backs;
};

void record(ScheduleRecorder& recorder, const Operation& op, Graph& graph) {
  const Program& program = schedule_program();
  const BufferRef &target = graph.refs[op.target], &source = graph.refs[op.source];
  switch (op.kind) {
    case Operation::mix:
      graph.mixes.push_back({recorder.variable<uint32_t>("factor", op.number), op.number});
      recorder.pass("mix", program, "mix_in")
          .global(op.count)
          .local(16)
          .arg("target", target)
          .arg("source", source)
          .arg("factor", graph.mixes.back().first)
          .arg("count", op.count);
      break;
    case Operation::overwrite:
      recorder.pass("overwrite", program, "overwrite")
          .global(op.count)
          .local(64)
          .arg("target", target)
          .arg("source", source)
          .arg("salt", op.number)
          .arg("count", op.count)
          .discards("target");
      break;
    case Operation::pattern:
      recorder.pass("pattern", program, "write_pattern")
          .global(op.count)
          .local(64)
          .arg("target", target)
          .arg("salt", op.number)
          .arg("count", op.count)
          .discards("target");
      break;
    case Operation::scramble:
      recorder.pass("scramble", program, "scramble_alone")
          .global(1)
          .local(1)
          .arg("target", target)
          .arg("rounds", op.number)
          .arg("count", op.count);
      break;
    case Operation::clear: recorder.fill_zero("clear", target); break;
    case Operation::host: {
      TypedBuffer<uint32_t> buffer = graph.buffers[op.target];
      recorder.host_step("host", {target}, {target}, [buffer, number = op.number]() mutable {
        Uints values = buffer.download();
        for (uint32_t& value : values) value = value * 3 + number;
        buffer.upload(values);
      });
      break;
    }
  }
}

std::unique_ptr<Graph> make_graph(KernelScheduler& scheduler, const std::vector<Operation>& operations,
                                  const std::vector<Uints>& initial, size_t transients) {
  auto graph = std::make_unique<Graph>();
  ScheduleRecorder recorder = scheduler.record("random", "test");
  for (const Uints& values : initial) graph->refs.push_back(graph->buffers.emplace_back(make_buffer("real", values)));
  for (size_t i = 0; i < transients; ++i)
    graph->refs.push_back(recorder.transient<uint32_t>("temporary", order_elements));
  for (const Operation& op : operations) record(recorder, op, *graph);
  graph->read_backs.resize(initial.size());
  for (size_t i = 0; i < initial.size(); ++i) {
    Uints& result = graph->read_backs[i];
    recorder.read_back("read", graph->buffers[i], [&result](std::span<const std::byte> bytes) {
      result.resize(bytes.size() / sizeof(uint32_t));
      std::memcpy(result.data(), bytes.data(), bytes.size());
    });
  }
  graph->schedule = recorder.compile();
  return graph;
}

void check_random_graphs(const SchedulerOptions& options, unsigned seed, int trials) {
  KernelScheduler scheduler(test_device(), options);
  std::mt19937 random(seed);
  for (int trial = 0; trial < trials; ++trial) {
    const size_t real = 3, transients = 6;
    const std::vector<Operation> operations = random_operations(random, 10 + random() % 40, real, transients);
    std::vector<Uints> expected(real, Uints(order_elements));
    for (Uints& values : expected) {
      for (uint32_t& value : values) value = static_cast<uint32_t>(random());
    }
    const auto graph = make_graph(scheduler, operations, expected, transients);
    for (uint32_t run = 0; run < 3; ++run) {
      expected.resize(real + transients, Uints(order_elements));
      for (const auto& [variable, number] : graph->mixes) graph->schedule.set(variable, number + run);
      for (const Operation& op : operations) apply_on_host(op, expected, run);
      expected.resize(real);
      REQUIRE(scheduler.run(graph->schedule) == RunResult::done);
      for (size_t i = 0; i < real; ++i) {
        CAPTURE(trial);
        CAPTURE(run);
        CAPTURE(i);
        REQUIRE(graph->read_backs[i] == expected[i]);
        REQUIRE(graph->buffers[i].download() == expected[i]);
      }
    }
  }
}

int trials() { return full_run() ? 1000 : 60; }

}  // namespace

TEST_CASE("random graphs give the serial result on an in-order queue") {
  check_random_graphs({QueueMode::in_order, true, false}, 11, trials());
}

TEST_CASE("random graphs give the serial result when passes overlap") {
  REQUIRE(test_device()->overlap_queue() != nullptr);
  check_random_graphs({QueueMode::overlap, true, false}, 12, trials());
}

TEST_CASE("random graphs give the serial result with the automatic choice and without profile") {
  check_random_graphs({QueueMode::automatic, false, false}, 13, trials());
}

TEST_CASE("random graphs give the serial result in debug mode") {
  check_random_graphs({QueueMode::automatic, true, true}, 14, trials() / 3);
}

TEST_CASE("runs that nobody waits for keep their order among themselves and with other work") {
  for (const QueueMode mode : {QueueMode::in_order, QueueMode::overlap}) {
    KernelScheduler scheduler(test_device(), {mode, true, false});
    auto a = make_buffer("a", Uints(order_elements, 1)), b = make_buffer("b", Uints(order_elements, 2));
    const auto mix = [&](const char* name, const BufferRef& target, const BufferRef& source) {
      ScheduleRecorder recorder = scheduler.record(name, "test");
      recorder.pass("mix", schedule_program(), "mix_in")
          .global(order_elements)
          .local(16)
          .arg("target", target)
          .arg("source", source)
          .arg("factor", 5u)
          .arg("count", order_elements);
      recorder.pass("scramble", schedule_program(), "scramble_alone")
          .global(1)
          .local(1)
          .arg("target", target)
          .arg("rounds", 30u)
          .arg("count", order_elements);
      return recorder.compile();
    };
    Schedule forward = mix("forward", a, b), backward = mix("backward", b, a);
    std::vector<Uints> expected = {Uints(order_elements, 1), Uints(order_elements, 2)};
    for (int i = 0; i < 10; ++i) {
      scheduler.run(forward);
      scheduler.run(backward);
      for (const size_t target : {0, 1}) {
        apply_on_host({Operation::mix, target, 1 - target, 5}, expected, 0);
        apply_on_host({Operation::scramble, target, target, 30}, expected, 0);
      }
      if (i == 5) {  // through the device's own queue, without a finish() of the scheduler
        REQUIRE(a.download() == expected[0]);
        expected[1].assign(order_elements, 77);
        b.upload(expected[1]);
      }
    }
    CHECK(b.download() == expected[1]);
    CHECK(a.download() == expected[0]);
  }
}
