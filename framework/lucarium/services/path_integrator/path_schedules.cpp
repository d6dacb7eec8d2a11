// SPDX-License-Identifier: Apache-2.0
// The passes of PathIntegrator: generate once per batch, bounce as often as paths live, finish once per batch. Declared
// in path_integrator_state.h.
#include <cstring>

#include "lucarium/services/path_integrator/path_integrator_state.h"
#include "lucarium/services/ray_ends.h"

namespace lucarium {
namespace {

const char* const kLowerBatch = "lower the technique's batch_paths";

}  // namespace

void PathIntegrator::State::bind_scene(PassBuilder& pass) const {
  // SceneBuffers::bind(), but with the light table and trees of the path set.
  const auto bind = [&](std::string_view name, const Buffer& own) {
    const bool table = light_table && name == "scene_light_table", trees = light_trees && name == "scene_light_trees";
    pass.arg_if_present(name, table ? Buffer(light_table) : trees ? Buffer(light_trees) : own);
  };
#define LUCARIUM_BIND_SCENE_BUFFER(type, name, meaning) bind(#name, scene.name);
  LUCARIUM_SCENE_BUFFERS(LUCARIUM_BIND_SCENE_BUFFER)
#undef LUCARIUM_BIND_SCENE_BUFFER
}

void PathIntegrator::State::record_generate() {
  ScheduleRecorder recorder = scheduler.record("generate paths", owner);
  generate_frame = recorder.variable("frame", frame);
  generate_batch = recorder.variable("batch", PathBatch());
  generate_settings = recorder.variable("settings", settings);
  recorder.pass("generate camera paths", program, "generate_camera_paths")
      .global(plan.paths())
      .arg("frame", generate_frame)
      .arg("settings", generate_settings)
      .arg("batch", generate_batch)
      .arg("rays", paths.rays)
      .arg_if_present("ends", paths.ends)
      .arg("queue", paths.queue)
      .arg("active", paths.active)
      .arg("path_throughput", paths.throughput)
      .arg("path_state", paths.state)
      .arg("path_side", paths.side)
      .arg("path_radiance", paths.radiance);
  generate = recorder.compile();
}

void PathIntegrator::State::record_bounce() {
  ScheduleRecorder recorder = scheduler.record("bounce", owner);
  bounce_batch = recorder.variable("batch", PathBatch());
  bounce_settings = recorder.variable("settings", settings);
  const uint32_t capacity = plan.paths();
  const BufferRef numbers = recorder.transient<float>(
      "random numbers", size_t{(capacity + 7) / 8} * 8 * LUCARIUM_PATH_NUMBER_ROWS, kLowerBatch);
  const BufferRef hits = recorder.transient<Hit>("hits", capacity, kLowerBatch);
  const BufferRef next_rays = recorder.transient<Ray>("next rays", capacity, kLowerBatch);
  const BufferRef next_queue = recorder.transient<uint32_t>("next queue", capacity, kLowerBatch);
  const BufferRef alive = recorder.transient<uint32_t>("alive", capacity, kLowerBatch);
  const BufferRef survivors = recorder.transient<uint32_t>("survivors", capacity, kLowerBatch);
  const BufferRef next_active = recorder.transient<uint32_t>("next active", 1);
  const BufferRef shadow_rays = recorder.transient<Ray>("shadow rays", capacity, kLowerBatch);
  const BufferRef shadow_light = recorder.transient<float4>("light behind the shadow rays", capacity, kLowerBatch);
  const BufferRef occluded = recorder.transient<uint32_t>("occluded", capacity, kLowerBatch);
  const BufferRef next_ends = transient_ray_ends(recorder, intersector, "ends of next rays", capacity, kLowerBatch);
  const BufferRef shadow_ends = transient_ray_ends(recorder, intersector, "ends of shadow rays", capacity, kLowerBatch);

  intersector.record_closest(recorder, "closest hit", {paths.rays, paths.active, 0, capacity, paths.ends, frame.width},
                             hits);
  recorder.pass("draw numbers", program, "draw_vertex_numbers")
      .global_by(paths.active, 0, 1.0 / 8)
      .arg("settings", bounce_settings)
      .arg("batch", bounce_batch)
      .arg("queue", paths.queue)
      .arg("active", paths.active)
      .arg("path_state", paths.state)
      .arg("numbers", numbers);
  PassBuilder shade = recorder.pass("shade surface", program, "shade_surface");
  bind_scene(shade);
  shade.global_by(paths.active)
      .arg("settings", bounce_settings)
      .arg("batch", bounce_batch)
      .arg("rays", paths.rays)
      .arg("hits", hits)
      .arg("queue", paths.queue)
      .arg("active", paths.active)
      .arg("numbers", numbers)
      .arg("path_throughput", paths.throughput)
      .arg("path_state", paths.state)
      .arg("path_side", paths.side)
      .arg("path_radiance", paths.radiance)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg("alive", alive)
      .arg("shadow_rays", shadow_rays)
      .arg("shadow_light", shadow_light)
      .arg_if_present("next_ends", next_ends)
      .arg_if_present("shadow_ends", shadow_ends);
  if (samples_lights()) {
    intersector.record_any(recorder, "shadow rays", {shadow_rays, paths.active, 0, capacity, shadow_ends}, occluded);
    recorder.pass("add unoccluded light", program, "add_unoccluded_light")
        .global_by(paths.active)
        .arg("batch", bounce_batch)
        .arg("queue", paths.queue)
        .arg("active", paths.active)
        .arg("shadow_rays", shadow_rays)
        .arg("shadow_light", shadow_light)
        .arg("occluded", occluded)
        .arg("path_radiance", paths.radiance);
  }
  primitives.record_compact(recorder, "compact paths", alive, survivors, next_active, 0, paths.active, 0, capacity);
  recorder.pass("advance paths", program, "advance_paths")
      .global_by(paths.active)
      .arg("survivors", survivors)
      .arg("next_active", next_active)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg_if_present("next_ends", next_ends)
      .arg_if_present("ends", paths.ends)
      .arg("rays", paths.rays)
      .arg("queue", paths.queue)
      .arg("active", paths.active);
  recorder.read_back("active paths", paths.active,
                     [this](std::span<const std::byte> bytes) { std::memcpy(&active, bytes.data(), sizeof active); });
  bounce = recorder.compile();
}

void PathIntegrator::State::record_finish() {
  ScheduleRecorder recorder = scheduler.record("accumulate samples", owner);
  finish_batch = recorder.variable("batch", PathBatch());
  finish_settings = recorder.variable("settings", settings);
  recorder.pass("accumulate layers", program, "accumulate_layers")
      .global(plan.pixels_per_batch)
      .arg("settings", finish_settings)
      .arg("batch", finish_batch)
      .arg("pixels", plan.pixels)
      .arg("path_state", paths.state)
      .arg("path_radiance", paths.radiance)
      .arg("layer_sums", sums.layers)
      .arg("pixel_shadow_rays", sums.shadow_rays)
      .arg("counts", sums.counts);
  for (uint32_t replicate = 0; replicate < sums.replicates.size(); ++replicate)
    recorder.pass("accumulate replicate", program, "accumulate_replicate")
        .global(plan.pixels_per_batch)
        .arg("settings", finish_settings)
        .arg("batch", finish_batch)
        .arg("replicate", replicate)
        .arg("path_radiance", paths.radiance)
        .arg("replicate_sums", sums.replicates[replicate]);
  recorder.read_back("nonfinite samples", sums.counts, [this](std::span<const std::byte> bytes) {
    std::memcpy(&nonfinite, bytes.data() + LUCARIUM_PATH_COUNT_NONFINITE * sizeof nonfinite, sizeof nonfinite);
  });
  finish = recorder.compile();
}

}  // namespace lucarium
