// SPDX-License-Identifier: Apache-2.0
// Candidates per second and processor; two threads beside one.
#include <algorithm>
#include <random>

#include "lucarium/compute/program/source_library.h"
#include "measures.h"
#include "rendering.h"
#include "rounds.h"

const lucarium::EmbeddedSources& lucarium_bidirectional_bench_kernels();
const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bench {
namespace {

void measure_candidates(Bars& bars, const Effort& effort) {
  constexpr uint32_t kCapacity = 1 << 15, kRows = 8, kCompared = 32, kSurfaces = 1 << 20;
  const std::shared_ptr<Device> device = test::test_device();
  KernelScheduler scheduler(device);
  SourceLibrary library;
  library.add(bidirectional_vpl_kernels());
  library.add(lucarium_bidirectional_bench_kernels());
  const Program program(*device, library, {.name = "bench/candidates", .files = {"bench/bidirectional/candidates.cl"}});
  std::vector<float> table(size_t{kRows} * kCapacity);
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> uniform(0.01f, 1);
  for (float& value : table) value = uniform(engine);
  const TypedBuffer<float> entries(*device, "bench", "table", table), sums(*device, "bench", "sums", kSurfaces);
  ScheduleRecorder recorder = scheduler.record("candidates", "bench");
  recorder.pass("compare candidates", program, "compare_candidates")
      .global(kSurfaces)
      .local(64)
      .arg("table", entries)
      .arg("blocks", kCapacity / 8)
      .arg("compared", kCompared / 8)
      .arg("sums", sums);
  Schedule schedule = recorder.compile();
  std::vector<Contestant> all{{.name = "candidates",
                               .run =
                                   [&] {
                                     scheduler.run(schedule);
                                     scheduler.finish();
                                   },
                               .cpus = 1}};
  run_rounds(all, 1);
  all[0].cpu.clear();
  run_rounds(all, effort.rounds);
  bars.add("candidates, millions per second and processor", 60, 200, 1e-6 * kSurfaces * kCompared / median(all[0].cpu));
}

void measure_threads(Bars& bars, const Effort& effort) {
  const auto session = make_session("bidirectional_vpl", make_lit_room(), 256, {{"adapt", "off"}}, 4);
  session->run({.iterations = 1});
  const auto run = [&] { session->run({.iterations = 2}); };
  std::vector<Contestant> all{{.name = "one", .run = run, .cpus = 1}, {.name = "two", .run = run, .cpus = 2}};
  run_rounds(all, effort.rounds);
  const auto fastest = [](const Contestant& c) { return *std::min_element(c.wall.begin(), c.wall.end()); };
  bars.add("an iteration, two threads over one (elapsed, fastest)", 1.6, 1.9, fastest(all[0]) / fastest(all[1]));
}

}  // namespace

void measure_rates(Bars& bars, const Effort& effort) {
  measure_candidates(bars, effort);
  measure_light_rays(bars, effort);
  measure_threads(bars, effort);
}

}  // namespace lucarium::bench
