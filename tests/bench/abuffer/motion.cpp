// SPDX-License-Identifier: Apache-2.0
#include "motion.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "contest.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::bench {

namespace {

struct Moving {
  const char* scene;
  const char* name;
  int animation;
};

constexpr Moving animations[] = {
    {"builtin:solids", "solids, turn (rigid)", 0},
    {"builtin:solids", "solids, swell (morph)", 1},
    {"builtin:debris:pieces=500", "debris, 500 pieces", 0},
    {"builtin:debris", "debris, 4000 pieces", 0},
    {"builtin:debris:pieces=20000", "debris, 20 000 pieces", 0},
};
constexpr uint32_t sizes[] = {320, 640, 1280};
constexpr double start_seconds = 0.9, frame_seconds = 1.0 / 30;

/// Rays per frame up to which building in `build` [s] and tracing in `ray` [s] each beats the other way, in text.
std::string pays_until(double build, double ray, double other_build, double other_ray) {
  if (build >= other_build) return "never";
  if (ray <= other_ray) return "always";
  return fmt::format("{:.3g} M", 1e-6 * (other_build - build) / (ray - other_ray));
}

/// One animation. Every round is a frame; the scene on the device has moved before anything is timed.
void measure(KernelScheduler& scheduler, const Moving& moving, int rounds, uint32_t width, uint32_t height) {
  const double duration = 4;
  Stage stage(scheduler, posed(load_scene(moving.scene), start_seconds, moving.animation));
  Bvh refitted(scheduler.device(), stage.scene, stage.buffers, BvhTraversal::wide);
  std::vector<std::unique_ptr<abuffer::VoxelAbuffer>> ours;
  for (const uint32_t size : sizes)
    ours.push_back(std::make_unique<abuffer::VoxelAbuffer>(
        scheduler, stage.scene, stage.buffers,
        abuffer::VoxelAbufferOptions{.abuffer_size = size, .intersect = abuffer::Intersect::exact}));
  SceneChange change;
  double seconds = start_seconds;
  std::vector<Contestant> builds;
  builds.push_back({.name = "move", .run = [&] {
                      seconds = std::fmod(seconds + frame_seconds, duration);
                      change = evaluate(stage.scene, seconds, moving.animation);
                      stage.buffers.update(stage.scene, change);
                      scheduler.finish();
                    }});
  builds.push_back({.name = "rebuilt", .run = [&] { stage.bvh.update(stage.scene, stage.buffers, everything()); }});
  builds.push_back({.name = "refitted", .run = [&] { refitted.update(stage.scene, stage.buffers, change); }});
  for (auto& structure : ours)
    builds.push_back({.name = "ours", .run = [&] { structure->update(stage.scene, change); }});
  for (Contestant& contestant : builds) contestant.cpus = 2;
  run_rounds(builds, rounds + 1);
  for (Contestant& contestant : builds) contestant.cpu.erase(contestant.cpu.begin());  // first use of kernels

  const RaySubject subject(scheduler.device(), scheduler, stage.scene, width, height, false);
  Contest rays(scheduler.device(), scheduler, rounds);
  rays.add_rays("rebuilt", stage.bvh, subject, RayKind::diffuse);
  rays.add_rays("refitted", refitted, subject, RayKind::diffuse);
  for (auto& structure : ours) rays.add_rays("ours", *structure, subject, RayKind::diffuse);
  rays.run();
  const auto per_ray = [&](size_t i) { return rays.seconds(i) / static_cast<double>(subject.diffuse.size()); };
  const double rebuild = median(builds[1].cpu), refit = median(builds[2].cpu);
  for (size_t i = 0; i < ours.size(); ++i) {
    const double build = median(builds[3 + i].cpu), ray = per_ray(2 + i);
    fmt::print("| {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.3f} | {:.3f} | {:.3f} | {} | {} |\n", moving.name,
               stage.scene.triangle_count(), sizes[i], 1e3 * build, 1e3 * rebuild, 1e3 * refit, 1e6 * ray,
               1e6 * per_ray(0), 1e6 * per_ray(1), pays_until(build, ray, rebuild, per_ray(0)),
               pays_until(build, ray, refit, per_ray(1)));
    std::fflush(stdout);
  }
}

}  // namespace

void measure_motion(KernelScheduler& scheduler, int rounds, uint32_t width, uint32_t height, const std::string& only) {
  fmt::print("milliseconds per frame, microseconds per bounce ray, of processor time\n");
  fmt::print(
      "| animation | triangles | n | exact build | `Bvh` rebuilt | refitted | exact ray | rebuilt | refitted | pays "
      "against "
      "rebuilds until | against refits until |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n");
  for (const Moving& moving : animations)
    if (std::string(moving.name).find(only) != std::string::npos) measure(scheduler, moving, rounds, width, height);
}

}  // namespace lucarium::bench
