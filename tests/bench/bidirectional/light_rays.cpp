// SPDX-License-Identifier: Apache-2.0
// Rays of light paths beside the hierarchy alone: the same paths twice, once with first rays as paths are numbered, of
// which the passes of the hierarchy count, and once as the technique traces them, of which everything counts.
#include "device_fixture.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/light_paths/light_paths.h"
#include "lucarium/shared/path_vertex.h"
#include "measures.h"
#include "rounds.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bench {
namespace {

constexpr uint32_t kPaths = 1 << 18, kVertices = 4;

Program storing_program(Device& device) {
  SourceLibrary library;
  library.add(bidirectional_vpl_kernels());
  return {
      device,
      library,
      {.name = "bidirectional_vpl/light/store_light_vertices",
       .files = {"bidirectional_vpl/light/store_light_vertices.cl"},
       .defines = {
           {"LUCARIUM_LIGHT_PATH_MIS", "1"}, {"LUCARIUM_PATH_MIS_POWER", "1"}, {"LUCARIUM_LIGHTS_FROM_TABLE", ""}}}};
}

class LightRays {
 public:
  LightRays(const SceneBuffers& buffers, const Bvh& bvh, bool order)
      : scheduler_(test::test_device()),
        vertices_(*test::test_device(), "bench", "light vertices", size_t{kPaths} * kVertices),
        lights_(*test::test_device(), "bench", "lights of light paths", kPaths),
        shares_(*test::test_device(), "bench", "shares of lights", 1) {
    LightPathOptions options;
    options.paths = kPaths;
    options.vertices = kVertices;
    options.light_samples = 0;
    options.hit_samples = 0;
    options.roulette_start = 4;
    options.order = order;
    const LightPaths paths(*test::test_device(), buffers, bvh, options, "bench");
    ScheduleRecorder recorder = scheduler_.record("light paths", "bench");
    const Variable<uint32_t> seed = recorder.variable("seed", 1u);
    run_ = recorder.variable("run", 0u);
    paths.record(
        recorder, run_, seed, storing_program(*test::test_device()),
        [&](PassBuilder& pass) {
          pass.arg("vertices", vertices_)
              .arg("vertices_per_path", kVertices)
              .arg("streamed", 1u)
              .arg("path_lights", lights_);
        },
        [&](PassBuilder& pass) { pass.arg("shares", shares_); });
    schedule_ = recorder.compile();
  }
  /// Device seconds of a run's passes; of the hierarchy's alone.
  double seconds(bool hierarchy) {
    schedule_.set(run_, ++runs_);
    scheduler_.reset_profile();
    scheduler_.run(schedule_);
    scheduler_.finish();
    double sum = 0;
    for (const PassProfile& pass : scheduler_.profile().passes)
      if (!hierarchy || pass.name == "trace light paths") sum += pass.device_seconds;
    return sum;
  }

 private:
  KernelScheduler scheduler_;
  TypedBuffer<PathVertex> vertices_;
  TypedBuffer<uint32_t> lights_;
  TypedBuffer<float> shares_;
  Variable<uint32_t> run_;
  uint32_t runs_ = 0;
  Schedule schedule_;
};

}  // namespace

void measure_light_rays(Bars& bars, const Effort& effort) {
  const Scene scene = make_lit_room();
  const SceneBuffers buffers(*test::test_device(), scene);
  const Bvh bvh(*test::test_device(), scene, buffers);
  LightRays numbered(buffers, bvh, false), ordered(buffers, bvh, true);
  numbered.seconds(true);
  ordered.seconds(true);
  std::vector<double> traced, whole, without;
  for (int round = 0; round < effort.rounds; ++round) {
    traced.push_back(numbered.seconds(true));
    whole.push_back(ordered.seconds(false));
    without.push_back(numbered.seconds(false));
  }
  bars.note("light paths of 262 144, a run's rays by the hierarchy", 1e3 * median(traced), "ms");
  bars.note("light paths of 262 144, a run", 1e3 * median(whole), "ms");
  bars.note("rate with first rays as paths are numbered", median_ratio(traced, without), "");
  bars.add("rate of light paths' rays over that of the hierarchy alone", 0.8, 0.95, median_ratio(traced, whole));
}

}  // namespace lucarium::bench
