// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/parallel.h"

#include <doctest/doctest.h>
#include <pthread.h>

#include <numeric>
#include <stdexcept>

using namespace lucarium;

TEST_CASE("parallel_for calls every index once, whatever the number of threads") {
  for (const unsigned threads : {0u, 1u, 2u, 7u}) {
    for (const uint32_t count : {0u, 1u, 63u, 64u, 65u, 5000u}) {
      std::vector<int> calls(count);
      parallel_for(count, threads, [&](uint32_t i) { ++calls[i]; });
      CHECK(std::count(calls.begin(), calls.end(), 1) == count);
    }
  }
}

TEST_CASE("parallel_for leaves the rest out after an interrupt") {
  uint32_t calls = 0;
  parallel_for(1000, 1, [&](uint32_t) {
    ++calls;
    set_interrupt_requested(true);
  });
  set_interrupt_requested(false);
  CHECK(calls < 1000);
}

TEST_CASE("parallel_jobs: a worker for each thread, progress on this one, the first exception comes out") {
  std::vector<int> done(100);
  std::atomic<int> workers{0};
  const auto here = std::this_thread::get_id();
  bool elsewhere = false;
  const auto make_worker = [&] {
    ++workers;
    return [&](size_t i) { ++done[i]; };
  };
  parallel_jobs(done.size(), 3, make_worker, [&](size_t) { elsewhere |= std::this_thread::get_id() != here; });
  CHECK(std::accumulate(done.begin(), done.end(), 0) == 100);
  CHECK(*std::max_element(done.begin(), done.end()) == 1);
  CHECK(workers == 3);
  CHECK_FALSE(elsewhere);

  const auto failing = [] {
    return [](size_t i) {
      if (i == 5) throw std::runtime_error("five");
    };
  };
  CHECK_THROWS_WITH(parallel_jobs(10, 2, failing, [](size_t) {}), "five");
}

namespace {
int sum_by_halves(const int* values, size_t count, ForkJoin& fork_join) {
  if (count == 1) return *values;
  int left = 0, right = 0;
  fork_join.run(
      count > 4, [&] { left = sum_by_halves(values, count / 2, fork_join); },
      [&] { right = sum_by_halves(values + count / 2, count - count / 2, fork_join); });
  return left + right;
}
}  // namespace

TEST_CASE("ForkJoin runs both halves, with and without threads") {
  std::vector<int> values(1000);
  std::iota(values.begin(), values.end(), 1);
  for (const unsigned threads : {1u, 4u}) {
    ForkJoin fork_join(threads);
    CHECK(sum_by_halves(values.data(), values.size(), fork_join) == 500500);
  }
}

TEST_CASE("a thread that could not be started ended the work") {
  pthread_attr_t before, huge;
  REQUIRE(pthread_getattr_default_np(&before) == 0);
  REQUIRE(pthread_attr_init(&huge) == 0);
  REQUIRE(pthread_attr_setstacksize(&huge, size_t{1} << 47) == 0);  // more than there are addresses
  REQUIRE(pthread_setattr_default_np(&huge) == 0);
  std::vector<int> values(5000, 1), calls(5000);
  int sum = 0;
  CHECK_THROWS_AS(std::thread([] {}).join(), std::system_error);
  CHECK_NOTHROW(parallel_for(5000, 4, [&](uint32_t i) { ++calls[i]; }));
  CHECK_NOTHROW(parallel_jobs(
      5000, 4, [&] { return [&](size_t i) { ++calls[i]; }; }, [](size_t) {}));
  ForkJoin fork_join(4);
  CHECK_NOTHROW(sum = sum_by_halves(values.data(), values.size(), fork_join));
  REQUIRE(pthread_setattr_default_np(&before) == 0);
  CHECK(std::count(calls.begin(), calls.end(), 2) == 5000);
  CHECK(sum == 5000);
}
