// SPDX-License-Identifier: Apache-2.0
// Host work on several threads. The result never depends on how many there are: each piece of work writes to places of
// its own. Where the system refuses to start a thread, those that run do the rest.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "lucarium/base/interrupt.h"

namespace lucarium {

/// Runs work(thread) on up to `threads` threads, 0 on this one, and waits for all. `work` must not throw.
template <class Work>
void on_threads(unsigned threads, const Work& work) {
  std::vector<std::jthread> others;
  try {
    for (unsigned i = 1; i < threads; ++i) others.emplace_back([&work, i] { work(i); });
  } catch (const std::system_error&) {  // no more threads to be had
  }
  work(0u);
}

/// Runs job(0 … count-1), each thread with a worker of its own, job = make_worker(). This thread takes part and alone
/// calls tick(job), which may throw; the first exception ends the work and is thrown again.
template <class MakeWorker>
void parallel_jobs(size_t count, unsigned threads, const MakeWorker& make_worker,
                   const std::function<void(size_t)>& tick) {
  std::atomic<size_t> next{0};
  std::atomic<bool> stop{false};
  std::exception_ptr failure;
  std::mutex failure_lock;
  on_threads(threads, [&](unsigned thread) {
    try {
      auto job = make_worker();
      for (size_t i = next++; i < count && !stop; i = next++) {
        if (thread == 0) tick(i);
        job(i);
      }
    } catch (...) {
      const std::lock_guard lock(failure_lock);
      if (!failure) failure = std::current_exception();
      stop = true;
    }
  });
  if (failure) std::rethrow_exception(failure);
}

/// Calls work(i) for all i < count. `work` must not throw, and no call may depend on another. After an
/// interrupt_requested() some are left out: ask throw_if_interrupted() behind it.
template <class Work>
void parallel_for(uint32_t count, unsigned threads, const Work& work) {
  constexpr uint32_t worth_a_thread = 512, run = 64;
  const uint32_t runs = count / run + (count % run ? 1 : 0);
  std::atomic<uint32_t> next{0};
  on_threads(std::min(threads, count / worth_a_thread), [&](unsigned) {
    for (uint32_t r = next++; r < runs && !interrupt_requested(); r = next++)
      for (uint32_t i = r * run, end = r + 1 < runs ? i + run : count; i < end; ++i) work(i);
  });
}

/// Runs the two halves of a divide-and-conquer step, in parallel while threads are free.
class ForkJoin {
 public:
  explicit ForkJoin(unsigned threads) : free_(static_cast<int>(threads) - 1) {}

  template <class First, class Second>
  void run(bool worthwhile, First&& first, Second&& second) {
    if (worthwhile && free_.fetch_sub(1) > 0) {
      std::future<void> other;
      try {
        other = std::async(std::launch::async, [&] {
          first();
          free_.fetch_add(1);
        });
      } catch (const std::system_error&) {  // no more threads to be had
        first();
        free_.fetch_add(1);
      }
      second();
      if (other.valid()) other.get();
      return;
    }
    if (worthwhile) free_.fetch_add(1);
    first();
    second();
  }

 private:
  std::atomic<int> free_;
};

}  // namespace lucarium
