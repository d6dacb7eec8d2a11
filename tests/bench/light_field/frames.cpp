// SPDX-License-Identifier: Apache-2.0
// Frames of settled fields: what they cost beside rays and paths, and what that depends on.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>

#include "field_rig.h"
#include "lucarium/technique/state_file.h"
#include "ray_subject.h"
#include "rendering.h"
#include "rounds.h"
#include "traced_batch.h"

namespace lucarium::bench {
namespace {

constexpr uint32_t kPicturesEach = 8;  // of a contestant and round, so that a round takes long enough to be measured

/// Device time of the pass that makes surfaces and looks up, in `frames` frames from one camera [s].
double look_up_seconds(RenderSession& session, uint32_t frames) {
  session.scheduler().finish();
  session.scheduler().reset_profile();
  for (uint32_t i = 0; i < frames; ++i) session.iterate();
  session.scheduler().finish();
  double seconds = 0;
  for (const PassProfile& pass : session.scheduler().profile().passes)
    if (pass.name == "show field") seconds += pass.device_seconds;
  return seconds / frames;
}

/// Largest over smallest of the medians of what contestants measure in turns.
double spread(const std::vector<std::function<double()>>& contestants, int rounds) {
  std::vector<std::vector<double>> values(contestants.size());
  for (int round = 0; round < rounds; ++round)
    for (size_t i = 0; i < contestants.size(); ++i) values[i].push_back(contestants[i]());
  std::vector<double> medians;
  for (const auto& of_one : values) medians.push_back(median(of_one));
  return *std::max_element(medians.begin(), medians.end()) / *std::min_element(medians.begin(), medians.end());
}

double spread_of_sessions(const std::vector<std::unique_ptr<RenderSession>>& sessions, int rounds) {
  std::vector<std::function<double()>> contestants;
  for (const auto& session : sessions)
    contestants.emplace_back([&session] { return look_up_seconds(*session, kPicturesEach); });
  return spread(contestants, rounds);
}

/// What a look-up does not depend on.
void measure_look_ups(Bars& bars, const Sizes& sizes) {
  std::vector<std::unique_ptr<RenderSession>> bounces, lamps, triangles;
  for (const int count : {0, 1, 8, -1})
    bounces.push_back(settled(load_scene("builtin:cornell"), sizes, walkthrough(sizes), count));
  bars.add("pass of surfaces and look-ups, longest over shortest: 0, 1, 8, unlimited bounces", 1.1, 1.05,
           spread_of_sessions(bounces, sizes.rounds), true);
  bounces.clear();
  for (const char* count : {"1", "10", "100"})
    lamps.push_back(settled(load_scene(std::string("builtin:lamps-") + count), sizes, walkthrough(sizes)));
  bars.add("pass of surfaces and look-ups, longest over shortest: 1, 10, 100 lamps", 1.1, 1.05,
           spread_of_sessions(lamps, sizes.rounds), true);
  lamps.clear();
  Sizes few = sizes;
  few.dir_n = 2;
  for (const char* count : {"1000", "10000", "100000"})
    triangles.push_back(settled(load_scene(std::string("builtin:blocks:triangles=") + count), sizes, walkthrough(few)));
  bars.add("pass of surfaces and look-ups, longest over shortest: 1000 to 100 000 triangles", 1.5, 1.2,
           spread_of_sessions(triangles, sizes.rounds), true);
}

/// Elapsed time of whole frames of a walk, each the median of its rounds.
void measure_evenness(Bars& bars, const Sizes& sizes) {
  const auto field = settled(load_scene("builtin:cornell-mirror"), sizes, walkthrough(sizes));
  std::vector<std::vector<double>> seconds(kFrames);
  for (int round = 0; round <= sizes.rounds; ++round)
    for (uint32_t frame = 0; frame < kFrames; ++frame) {
      uint32_t next = frame;
      const auto begin = std::chrono::steady_clock::now();
      next_frame(*field, &next);
      if (round > 0)  // the first warms up
        seconds[frame].push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
  std::vector<double> medians;
  for (const auto& of_frame : seconds) medians.push_back(median(of_frame));
  bars.add("frames of a walk, longest over median (elapsed)", 1.5, 1.2,
           *std::max_element(medians.begin(), medians.end()) / median(medians), true);
}

/// A loaded field's first picture beside its propagation.
void measure_loading(Bars& bars, const Sizes& sizes) {
  const Scene scene = load_scene("builtin:cornell-mirror");
  const auto file = std::filesystem::temp_directory_path() / fmt::format("lucarium_field_bench-{}.state", getpid());
  const auto by = settled(scene, sizes, walkthrough(sizes));
  by->save_state(file, false);
  std::vector<double> first;
  for (int round = 0; round < sizes.rounds; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    const StateFile state(file);
    const double open = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const auto session = make_session("virtual_light_field", scene, sizes.width, walkthrough(sizes), -1, 1, &state);
    session->run({.samples = 1});
    first.push_back(open + session->clocks().load + session->clocks().iterate);
  }
  std::filesystem::remove(file);
  bars.note("propagation of builtin:cornell-mirror, elapsed", by->clocks().light, "s");
  bars.add("load to first frame over propagation (elapsed)", 0.05, 0.01, median(first) / by->clocks().light, true);
}

/// Memory of cells with their index.
void measure_bytes(Bars& bars) {
  vlf::Parameters parameters;
  parameters.split_layers = false;
  parameters.preview = false;
  test::FieldRig::Options options;
  options.light_samples = 1;
  const test::FieldRig rig(load_scene("builtin:cornell-mirror"), parameters, options);
  const auto counts = rig.field().counts();
  const double cells = rig.field().maps().cells(), directions = 2. * rig.field().maps().info().lines;
  const auto propagating = static_cast<double>(counts.propagating_bytes),
             rendering = static_cast<double>(counts.rendering_bytes);
  bars.note("cells of builtin:cornell-mirror, dir_n=16", 1e-6 * cells, "M");
  bars.add("bytes per cell with index, propagating", 18, 16.5, propagating / cells, true);
  bars.add("bytes per cell with index, rendering", 4.6, 4.3, rendering / cells, true);
  bars.note("bytes per direction, propagating", 1e-3 * propagating / directions, "kB", 43.7);
  bars.note("bytes per direction, rendering", 1e-3 * rendering / directions, "kB", 5.5);
}

}  // namespace

void measure_walk(Bars& bars, const Sizes& sizes) {
  const Scene scene = load_scene("builtin:cornell-mirror");
  const auto field = settled(scene, sizes, walkthrough(sizes));
  const auto paths = make_session("path_tracing", scene, sizes.width);
  KernelScheduler scheduler(test::test_device());
  const SceneBuffers buffers(*test::test_device(), scene);
  const Bvh bvh(*test::test_device(), scene, buffers, BvhTraversal::wide);
  const RaySubject subject(*test::test_device(), scheduler, scene, sizes.width, sizes.width, false);
  TracedBatch rays(*test::test_device(), scheduler, bvh, subject.primary, false, {}, sizes.width);
  uint32_t frame_of_field = 0, frame_of_paths = 0;
  const auto each = [](auto run) {
    return [run] {
      for (uint32_t i = 0; i < kPicturesEach; ++i) run();
    };
  };
  std::vector<Contestant> all;
  all.push_back({.name = "field", .run = each([&] { next_frame(*field, &frame_of_field); }), .cpus = 2});
  all.push_back({.name = "paths", .run = each([&] { next_frame(*paths, &frame_of_paths); }), .cpus = 2});
  all.push_back({.name = "rays", .run = each([&] { rays.run(); }), .cpus = 2});
  run_rounds(all, 1);
  for (Contestant& c : all) c.cpu.clear(), c.wall.clear();
  run_rounds(all, sizes.rounds);
  bars.note("walk frame, processor time", 1e3 * median(all[0].cpu) / kPicturesEach, "ms");
  bars.add("walk frame over a path-traced frame of one sample", 0.4, 0.15, median_ratio(all[0].cpu, all[1].cpu), true);
  bars.add("walk frame over its camera rays alone", 5, 2.5, median_ratio(all[0].cpu, all[2].cpu), true);
}

void measure_frames(Bars& bars, const Sizes& sizes) {
  measure_walk(bars, sizes);
  measure_look_ups(bars, sizes);
  measure_evenness(bars, sizes);
  measure_loading(bars, sizes);
  measure_bytes(bars);
}

}  // namespace lucarium::bench
