// SPDX-License-Identifier: Apache-2.0
// lucarium_abuffer_bench: rays per second and builds of voxel_abuffer's structure beside those of the hierarchy, on the
// same triangles and the same rays, in turns within one run. Ratios are medians over the rounds of processor time.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "lucarium/scene/load/load_scene.h"
#include "motion.h"
#include "ratios.h"
#include "ray_subject.h"
#include "rounds.h"
#include "structure.h"
#include "traced_batch.h"

namespace {

using namespace lucarium;
using namespace lucarium::bench;

struct Options {
  std::vector<std::string> scenes = {"builtin:atrium"};
  int rounds = 5;
  uint32_t width = 640, height = 360;
  uint32_t size = 1280, grid = 0, threads = 1;
  std::vector<std::string> modes = {"exact"};
  bool profile = false, ratios = false, motion = false;
  std::string only;
};

/// One scene with the hierarchy and a structure per mode.
struct Field {
  Field(KernelScheduler& scheduler, const std::string& name, const Options& options)
      : scene(load_scene(name, {})),
        buffers(scheduler.device(), scene),
        bvh(scheduler.device(), scene, buffers, BvhTraversal::wide) {
    for (const std::string& mode : options.modes)
      structures.push_back(make_structure(mode, scheduler, scene, buffers, options.size, options.grid));
  }
  Scene scene;
  SceneBuffers buffers;
  Bvh bvh;
  std::vector<Structure> structures;
};

/// One hits and the other misses, or distances differ by more than 1e-3 of themselves.
size_t differences(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i)
    count += (a[i].triangle == LUCARIUM_NO_HIT) != (b[i].triangle == LUCARIUM_NO_HIT) ||
             std::fabs(a[i].distance - b[i].distance) > 1e-3f * b[i].distance;
  return count;
}

size_t differences(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
  return count;
}

void measure_rays(Device& device, KernelScheduler& scheduler, const Field& field, const RaySubject& subject,
                  RayKind kind, const Options& options) {
  const std::vector<Ray>& rays = subject.rays(kind);
  const bool any = kind == RayKind::shadow;
  std::vector<RayEnds> ends = subject.starts;
  if (kind == RayKind::primary) ends.assign(rays.size(), {LUCARIUM_NONE, LUCARIUM_NONE});
  const uint32_t row = kind == RayKind::primary ? options.width : 0;
  std::vector<std::unique_ptr<TracedBatch>> batches;
  std::vector<Contestant> contestants;
  const auto add = [&](const std::string& name, const Intersector& intersector) {
    TracedBatch* batch =
        batches.emplace_back(std::make_unique<TracedBatch>(device, scheduler, intersector, rays, any, ends, row)).get();
    contestants.push_back({.name = name, .run = [batch] { batch->run(); }, .cpus = options.threads});
  };
  add("wide", field.bvh);
  for (size_t i = 0; i < options.modes.size(); ++i) add(options.modes[i], *field.structures[i].intersector);
  run_rounds(contestants, options.rounds);
  for (size_t i = 0; i < contestants.size(); ++i) {
    const Contestant& c = contestants[i];
    const size_t different = any ? differences(batches[i]->occluded(), batches[0]->occluded())
                                 : differences(batches[i]->hits(), batches[0]->hits());
    fmt::print("| {} | {} | {:.3f} | {:.3f} | {} |\n", to_string(kind), c.name,
               1e-6 * static_cast<double>(rays.size()) / median(c.cpu), median_ratio(contestants[0].cpu, c.cpu),
               different);
    std::fflush(stdout);
  }
}

void measure_builds(KernelScheduler& scheduler, Field& field, const Options& options) {
  std::vector<Contestant> contestants;
  SceneChange everything;
  everything.topology = true;
  contestants.push_back({.name = "wide",
                         .run = [&] { field.bvh.update(field.scene, field.buffers, everything); },
                         .cpus = options.threads});
  for (size_t i = 0; i < options.modes.size(); ++i)
    contestants.push_back(
        {.name = options.modes[i], .run = [&field, i] { field.structures[i].rebuild(); }, .cpus = options.threads});
  run_rounds(contestants, options.rounds);
  for (const Contestant& c : contestants)
    fmt::print("| build | {} | {:.4f} s, {:.4f} s elapsed | {:.3f} |\n", c.name, median(c.cpu), median(c.wall),
               median_ratio(contestants[0].wall, c.wall));
  for (size_t i = 0; i < options.modes.size(); ++i)
    fmt::print("{}: {} (hierarchy: {} bytes)\n", options.modes[i], field.structures[i].summary(),
               field.bvh.statistics().bytes);
  if (!options.profile) return;
  scheduler.reset_profile();
  for (int i = 0; i < options.rounds; ++i)
    for (const Structure& structure : field.structures) structure.rebuild();
  fmt::print("{}\n", scheduler.profile().table());
}

void run(const Options& options) {
  DeviceOptions device_options;
  device_options.threads = static_cast<int>(options.threads);
  const std::shared_ptr<Device> device = Device::open(device_options);
  KernelScheduler scheduler(device);
  if (options.ratios) measure_ratios(scheduler, options.rounds, options.width, options.height);
  if (options.motion) measure_motion(scheduler, options.rounds, options.width, options.height, options.only);
  if (options.ratios || options.motion) return;
  for (const std::string& name : options.scenes) {
    const RaySubject subject(*device, scheduler, name, options.width, options.height, false);
    Field field(scheduler, name, options);
    fmt::print("{}: {} triangles, {} rays, {} threads\n| rays | kernel | Mrays/s cpu | over wide | differ |\n", name,
               field.bvh.statistics().triangles, subject.diffuse.size(), options.threads);
    for (const RayKind kind : {RayKind::primary, RayKind::diffuse, RayKind::shadow})
      measure_rays(*device, scheduler, field, subject, kind, options);
    measure_builds(scheduler, field, options);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Rays per second and builds beside the hierarchy's");
  app.add_option("scenes", options.scenes, "scene files or built-in scenes");
  app.add_option("--rounds", options.rounds, "measurements of each contestant")->check(CLI::Range(1, 1000));
  app.add_option("--width", options.width, "pixels")->check(CLI::Range(16, 8192));
  app.add_option("--height", options.height, "pixels")->check(CLI::Range(16, 8192));
  app.add_option("--size", options.size, "abuffer_size");
  app.add_option("--grid", options.grid, "grid_size");
  app.add_option("--threads", options.threads, "of the device");
  app.add_option("--modes", options.modes, structure_modes);
  app.add_flag("--profile", options.profile, "the passes of as many builds as rounds");
  app.add_flag("--ratios", options.ratios, "what voxel_abuffer is judged by, with bars; take --threads 2");
  app.add_flag("--motion", options.motion, "frames of animations, rebuilt, refitted and through the structure");
  app.add_option("--only", options.only, "of --motion: animations whose names hold this");
  CLI11_PARSE(app, argc, argv);
  try {
    run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
