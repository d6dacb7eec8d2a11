// SPDX-License-Identifier: Apache-2.0
#include "rounds.h"

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>

namespace lucarium::bench {

namespace {

/// Spreads the process's threads, the driver's included, over the first `count` processors it may use, in turns, so
/// that workers started one after the other stand on different ones. Where that is all of them, threads are free then:
/// those that a contestant starts would all stand where the one stands that starts them. Without the spread before
/// that, threads that stood on one processor together share it for the whole of a short contest.
void pin(const std::vector<int>& cpus, unsigned count) {
  std::vector<int> threads;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task"))
    threads.push_back(std::stoi(entry.path().filename().string()));
  std::sort(threads.begin(), threads.end());
  cpu_set_t all;
  CPU_ZERO(&all);
  for (const int cpu : cpus) CPU_SET(cpu, &all);
  for (size_t i = 0; i < threads.size(); ++i) {
    cpu_set_t chosen;
    CPU_ZERO(&chosen);
    CPU_SET(cpus[i % std::min<size_t>(count, cpus.size())], &chosen);
    sched_setaffinity(threads[i], sizeof(chosen), &chosen);
    if (count >= cpus.size()) sched_setaffinity(threads[i], sizeof(all), &all);
  }
}

std::vector<int> allowed_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof(set), &set);
  std::vector<int> result;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
    if (CPU_ISSET(cpu, &set)) result.push_back(cpu);
  return result;
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void run_rounds(std::vector<Contestant>& contestants, int rounds) {
  static const std::vector<int> cpus = allowed_cpus();  // before anything is pinned
  for (int round = 0; round < rounds; ++round)
    for (Contestant& contestant : contestants) {
      pin(cpus, contestant.cpus);
      const double cpu = cpu_seconds();
      const auto wall = std::chrono::steady_clock::now();
      contestant.run();
      contestant.cpu.push_back(cpu_seconds() - cpu);
      contestant.wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count());
    }
}

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

double median_ratio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) ratios.push_back(a[i] / b[i]);
  return median(ratios);
}

}  // namespace lucarium::bench
