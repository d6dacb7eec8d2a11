// SPDX-License-Identifier: Apache-2.0
//
// The schedules of camera paths. Declared in bidirectional_vpl/eye/eye_paths.h.
#include <cstring>

#include "bidirectional_vpl/base/slices.h"
#include "bidirectional_vpl/eye/eye_paths.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/path_settings.h"
#include "lucarium/shared/ray.h"

namespace lucarium::bidirectional {

void EyePaths::record_begin() {
  ScheduleRecorder recorder = scheduler_.record("begin camera paths", owner_);
  begin_frame_ = recorder.variable("frame", frame_);
  begin_index_ = recorder.variable("sample", 0u);
  const uint32_t values = plan_.settings.pixels * plan_.layers();
  recorder.pass("clear sample", program_, "clear_sample")
      .global(values)
      .slice(kSlice)
      .arg("sample", sample_)
      .arg("count", values);
  recorder.fill_zero("no events of camera paths", counts_);
  PassBuilder begin = recorder.pass("begin camera paths", program_, "begin_eye_paths");
  if (caches_) begin.arg("reused", caches_->reused());
  begin.global(plan_.settings.pixels)
      .slice(kSlice)
      .arg("frame", begin_frame_)
      .arg("settings", plan_.settings)
      .arg("sample_index", begin_index_)
      .arg_if_present("ends", ends_)
      .arg("rays", rays_)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("states", states_)
      .arg("eye_mis", mis_);
  begin_ = recorder.compile();
}

EyePaths::ShadowedLight EyePaths::shadowed_light(ScheduleRecorder& recorder, const std::string& name) const {
  const uint32_t capacity = plan_.settings.pixels;
  const std::string rays = "shadow rays of " + name;
  return {name,
          recorder.transient<Ray>(rays, capacity, remedies::lower_size),
          transient_ray_ends(recorder, intersector_, "ends of " + rays, capacity, remedies::lower_size),
          recorder.transient<float4>(name, capacity, remedies::lower_size),
          recorder.transient<uint32_t>("sources of " + name, capacity, remedies::lower_size),
          recorder.transient<uint32_t>("hidden " + name, capacity, remedies::lower_size)};
}

void EyePaths::record_shadowed(ScheduleRecorder& recorder, const ShadowedLight& light, const BufferRef& hits,
                               const std::string& kernel, uint32_t count, uint32_t tests) const {
  const uint32_t capacity = plan_.settings.pixels;
  const bool direct = tests == BIDIRECTIONAL_COUNT_LIGHT_TESTS;
  const bool mapped = direct ? plan_.direct_maps : plan_.vpl_maps,
             alone = mapped && !direct && maps_.vpls()->answers_all();
  BufferRef traced = light.rays;
  if (mapped && !alone)
    traced =
        recorder.transient<Ray>("shadow rays of " + light.name + " that are traced", capacity, remedies::lower_size);
  if (mapped) {
    const ShadowRays rays = {light.rays, active_,      hits,     light.sources, light.values,
                             traced,     light.hidden, capacity, light.number};
    if (direct)
      maps_.direct()->record_test(recorder, rays);
    else
      maps_.vpls()->record_test(recorder, rays);
    count_rays(recorder, light, light.rays, tests);
  }
  if (!alone) {
    intersector_.record_any(recorder, "shadow rays of " + light.name, {traced, active_, 0, capacity, light.ends},
                            light.hidden);
    count_rays(recorder, light, traced, count);
  }
  recorder.pass("add " + light.name, program_, kernel)
      .global_by(active_)
      .arg("settings", plan_.settings)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("rays", light.rays)
      .arg("light", light.values)
      .arg("occluded", light.hidden)
      .arg("sample", sample_);
}

void EyePaths::count_rays(ScheduleRecorder& recorder, const ShadowedLight& light, const BufferRef& rays,
                          uint32_t index) const {
  // Choices are counted once: with the connection rays, or, where maps answer all connections, with the look-ups.
  const bool connections = index == BIDIRECTIONAL_COUNT_CONNECTION_RAYS ||
                           (index == BIDIRECTIONAL_COUNT_CONNECTION_TESTS && maps_.vpls()->answers_all());
  const uint32_t choices = connections && plan_.has_table() ? 1 : 0;
  recorder.pass("count shadow rays", program_, "count_shadow_rays")
      .global((plan_.settings.pixels + kCountChunk - 1) / kCountChunk)
      .arg("active", active_)
      .arg("rays", rays)
      .arg("light", light.values)
      .arg("index", index)
      .arg("choices", choices)
      .arg("chunk", kCountChunk)
      .arg("counts", counts_);
}

void EyePaths::record_connections(ScheduleRecorder& recorder, const ShadowedLight& light, const BufferRef& hits) const {
  record_shadowed(recorder, light, hits, "add_connections", BIDIRECTIONAL_COUNT_CONNECTION_RAYS,
                  BIDIRECTIONAL_COUNT_CONNECTION_TESTS);
  vertices_->record_learning(recorder, active_, light.rays, light.hidden, light.sources, light.values,
                             plan_.settings.pixels);
}

void EyePaths::record_closest() {
  ScheduleRecorder recorder = scheduler_.record("surfaces of camera paths", owner_);
  intersector_.record_closest(recorder, "closest hit", {rays_, active_, 0, plan_.settings.pixels, ends_, frame_.width},
                              hits_);
  closest_ = recorder.compile();
}

void EyePaths::record_connect_to_all() {
  ScheduleRecorder recorder = scheduler_.record("connections to a virtual light", owner_);
  connect_seed_ = recorder.variable("seed", 0u);
  connect_index_ = recorder.variable("sample", 0u);
  connect_number_ = recorder.variable("virtual light", 0u);
  ShadowedLight light = shadowed_light(recorder, "connections");
  light.number = connect_number_;
  PassBuilder connect = recorder.pass("connect camera paths", program_, "connect_to_all");
  scene_.bind(connect);
  connect.global_by(active_)
      .slice(kSlice)
      .arg("seed", connect_seed_)
      .arg("settings", plan_.settings)
      .arg("sample_index", connect_index_)
      .arg("number", connect_number_)
      .arg("vertices", vertices_->vertices())
      .arg_if_present("vertex_densities", vertices_->densities())
      .arg("vertex_list", vertices_->list())
      .arg("rays", rays_)
      .arg("hits", hits_)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("states", states_)
      .arg("eye_mis", mis_)
      .arg_if_present("connection_ends", light.ends)
      .arg("connection_rays", light.rays)
      .arg("connections", light.values)
      .arg("connection_paths", light.sources);
  record_connections(recorder, light, hits_);
  connect_ = recorder.compile();
}

void EyePaths::record_bounce() {
  ScheduleRecorder recorder = scheduler_.record("bounce of camera paths", owner_);
  bounce_seed_ = recorder.variable("seed", 0u);
  bounce_index_ = recorder.variable("sample", 0u);
  const uint32_t capacity = plan_.settings.pixels;
  BufferRef hits = hits_;
  if (!keeps_hits()) hits = recorder.transient<Hit>("hits", capacity, remedies::lower_size);
  const NextRays next = {
      recorder.transient<Ray>("next rays", capacity, remedies::lower_size),
      transient_ray_ends(recorder, intersector_, "ends of next rays", capacity, remedies::lower_size),
      recorder.transient<uint32_t>("next queue", capacity, remedies::lower_size),
      recorder.transient<uint32_t>("alive", capacity, remedies::lower_size)};
  const ShadowedLight samples = shadowed_light(recorder, "light samples");
  const ShadowedLight connections = shadowed_light(recorder, "connections");

  if (!keeps_hits())
    intersector_.record_closest(recorder, "closest hit", {rays_, active_, 0, capacity, ends_, frame_.width}, hits);
  record_shade(recorder, hits, next, samples, connections);
  if (plan_.lights)
    record_shadowed(recorder, samples, hits, "add_eye_light_samples", BIDIRECTIONAL_COUNT_LIGHT_RAYS,
                    BIDIRECTIONAL_COUNT_LIGHT_TESTS);
  if (plan_.vpl && !plan_.connects_to_all()) record_connections(recorder, connections, hits);
  record_advance(recorder, next);
  bounce_ = recorder.compile();
}

void EyePaths::record_shade(ScheduleRecorder& recorder, const BufferRef& hits, const NextRays& next,
                            const ShadowedLight& samples, const ShadowedLight& connections) const {
  const BufferRef numbers = recorder.transient<float>(
      "random numbers", size_t{(plan_.settings.pixels + 7) / 8} * 8 * LUCARIUM_PATH_NUMBER_ROWS, remedies::lower_size);
  recorder.pass("draw numbers of camera paths", program_, "draw_eye_numbers")
      .global_by(active_, 0, 1.0 / 8)
      .arg("settings", plan_.settings)
      .arg("seed", bounce_seed_)
      .arg("sample_index", bounce_index_)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("states", states_)
      .arg("numbers", numbers);
  PassBuilder shade = recorder.pass("shade camera paths", program_, "shade_eye_vertices");
  scene_.bind(shade);
  shade.global_by(active_)
      .slice(kSlice)
      .arg("seed", bounce_seed_)
      .arg("settings", plan_.settings)
      .arg("sample_index", bounce_index_)
      .arg("vertices", vertices_ ? vertices_->vertices() : no_vertices_)
      .arg_if_present("vertex_densities", vertices_ ? vertices_->densities() : no_densities_)
      .arg_if_present("first_vertices", first_vertices_)
      .arg("vertex_list", vertices_ ? vertices_->list() : no_list_)
      .arg("vertex_count", vertices_ ? vertices_->count() : no_list_)
      .arg("candidate_table", vertices_ ? vertices_->table() : no_table_)
      .arg("shares", vertices_ ? vertices_->light_shares() : no_table_)
      .arg("rays", rays_)
      .arg("hits", hits)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("numbers", numbers)
      .arg("states", states_)
      .arg("eye_mis", mis_)
      .arg("sample", sample_)
      .arg_if_present("next_ends", next.ends)
      .arg_if_present("light_ends", samples.ends)
      .arg_if_present("connection_ends", connections.ends)
      .arg("next_rays", next.rays)
      .arg("next_queue", next.queue)
      .arg("alive", next.alive)
      .arg("light_rays", samples.rays)
      .arg("light_samples", samples.values)
      .arg("connection_rays", connections.rays)
      .arg("connections", connections.values)
      .arg("connection_paths", connections.sources);
  if (plan_.direct_maps) shade.arg("light_numbers", samples.sources);
  if (plan_.guide)
    shade.arg("guide_photons", guide_->photons()).arg("guide_keys", guide_->keys()).arg("guide_count", guide_->count());
}

void EyePaths::record_advance(ScheduleRecorder& recorder, const NextRays& next) {
  const uint32_t capacity = plan_.settings.pixels;
  const BufferRef survivors = recorder.transient<uint32_t>("survivors", capacity, remedies::lower_size);
  const BufferRef next_active = recorder.transient<uint32_t>("next active", 1);
  primitives_.record_compact(recorder, "compact camera paths", next.alive, survivors, next_active, 0, active_, 0,
                             capacity);
  recorder.pass("advance camera paths", program_, "advance_paths")
      .global_by(active_)
      .arg("survivors", survivors)
      .arg("next_active", next_active)
      .arg("next_rays", next.rays)
      .arg("next_queue", next.queue)
      .arg_if_present("next_ends", next.ends)
      .arg_if_present("ends", ends_)
      .arg("rays", rays_)
      .arg("queue", queue_)
      .arg("active", active_);
  recorder.read_back("active camera paths", active_, [this](std::span<const std::byte> bytes) {
    std::memcpy(&remaining_, bytes.data(), sizeof remaining_);
  });
}

void EyePaths::record_add() {
  ScheduleRecorder recorder = scheduler_.record("add iteration", owner_);
  if (caches_) caches_->record_keep(recorder, sample_, BIDIRECTIONAL_INDIRECT);
  const uint32_t pixels = plan_.settings.pixels;
  const auto add = [&](uint32_t layer, const TypedBuffer<float4>& sums) {
    recorder.pass("add layer", program_, "add_layer")
        .global(pixels)
        .arg("sample", sample_)
        .arg("layer", layer)
        .arg("pixels", pixels)
        .arg("sums", sums);
  };
  add(BIDIRECTIONAL_EMISSION, sums_.direct["emission"]);
  add(BIDIRECTIONAL_DIRECT, sums_.direct["direct"]);
  add(BIDIRECTIONAL_INDIRECT, sums_.indirect["indirect"]);
  uint32_t layer = BIDIRECTIONAL_LAYERS;
  for (const std::string& name : plan_.strategy_names()) add(layer++, sums_.strategies[name]);
  recorder.pass("count ends of paths", program_, "count_path_ends")
      .global((pixels + kCountChunk - 1) / kCountChunk)
      .arg("states", states_)
      .arg("pixels", pixels)
      .arg("chunk", kCountChunk)
      .arg("counts", counts_);
  recorder.read_back("events of camera paths", counts_, [this](std::span<const std::byte> bytes) {
    std::memcpy(counted_.data(), bytes.data(), sizeof counted_);
  });
  add_ = recorder.compile();
}

}  // namespace lucarium::bidirectional
