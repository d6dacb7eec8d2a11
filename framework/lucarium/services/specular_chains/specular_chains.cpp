// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/specular_chains/specular_chains.h"

#include <cstring>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/ray_ends.h"

namespace lucarium {

SpecularChains::SpecularChains(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                               const Intersector& intersector, Options options, Consumer consumer)
    : scheduler_(&scheduler),
      intersector_(&intersector),
      primitives_(device),
      options_(std::move(options)),
      consumer_(std::move(consumer)),
      program_(
          device, SourceLibrary(),
          {"specular chains", {"lucarium/services/specular_chains/specular_chains.cl"}, ray_end_defines(intersector)}),
      chains_(device, options_.owner, "chains of " + options_.what, options_.targets),
      rays_(device, options_.owner, "rays of " + options_.what, options_.targets),
      ends_(make_ray_ends(device, intersector, options_.owner, "ends of rays of " + options_.what, options_.targets)),
      queue_(device, options_.owner, "queue of " + options_.what, options_.targets),
      active_(device, options_.owner, "active chains", 1),
      counts_(device, options_.owner, "rays of a segment", 2) {
  record(scene);
}

size_t SpecularChains::estimate_bytes(size_t targets) {
  // The transients of a segment and of the light samples among them.
  return targets *
         (sizeof(SpecularChain) + 2 * sizeof(Ray) + sizeof(Hit) + sizeof(Ray) + sizeof(float4) + 6 * sizeof(uint32_t));
}

void SpecularChains::record_light(ScheduleRecorder& recorder, const BufferRef& shadow_rays,
                                  const BufferRef& shadow_light, const BufferRef& shadow_ends) const {
  if (!options_.punctual) return;
  const BufferRef occluded = recorder.transient<uint32_t>("occluded", options_.targets);
  intersector_->record_any(recorder, "shadow rays of " + options_.what,
                           {shadow_rays, active_, 0, options_.targets, shadow_ends}, occluded);
  PassBuilder add = recorder.pass("punctual light of " + options_.what, consumer_.program, consumer_.add_light);
  add.global(options_.targets)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("shadow_rays", shadow_rays)
      .arg("shadow_light", shadow_light)
      .arg("occluded", occluded);
  consumer_.bind_add_light(add);
}

void SpecularChains::record(const SceneBuffers& scene) {
  const uint32_t targets = options_.targets;
  ScheduleRecorder recorder = scheduler_->record("follow " + options_.what, options_.owner);
  settings_ = recorder.variable("settings", ChainSettings{});
  const BufferRef hits = recorder.transient<Hit>("hits", targets),
                  next_rays = recorder.transient<Ray>("next rays", targets),
                  next_queue = recorder.transient<uint32_t>("next queue", targets),
                  alive = recorder.transient<uint32_t>("alive", targets),
                  survivors = recorder.transient<uint32_t>("survivors", targets),
                  next_active = recorder.transient<uint32_t>("next active", 1),
                  shadow_rays = recorder.transient<Ray>("shadow rays", targets),
                  shadow_light = recorder.transient<float4>("light behind them", targets),
                  next_ends = transient_ray_ends(recorder, *intersector_, "ends of next rays", targets),
                  shadow_ends = transient_ray_ends(recorder, *intersector_, "ends of shadow rays", targets);
  recorder.fill_zero("clear count", counts_);
  intersector_->record_closest(recorder, "hits of " + options_.what, {rays_, active_, 0, targets, ends_}, hits);
  PassBuilder advance = recorder.pass("advance " + options_.what, consumer_.program, consumer_.advance);
  scene.bind(advance);
  advance.global_by(active_)
      .arg("settings", settings_)
      .arg("rays", rays_)
      .arg("hits", hits)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("chains", chains_)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg("alive", alive)
      .arg("shadow_rays", shadow_rays)
      .arg("shadow_light", shadow_light)
      .arg_if_present("next_ends", next_ends)
      .arg_if_present("shadow_ends", shadow_ends);
  consumer_.bind_advance(advance);
  record_light(recorder, shadow_rays, shadow_light, shadow_ends);
  primitives_.record_compact(recorder, "compact " + options_.what, alive, survivors, next_active, 0, active_, 0,
                             targets);
  recorder.pass("next " + options_.what, program_, "advance_queue")
      .global_by(active_)
      .arg("survivors", survivors)
      .arg("next_active", next_active)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg_if_present("next_ends", next_ends)
      .arg_if_present("ends", ends_)
      .arg("rays", rays_)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("counts", counts_);
  recorder.read_back("rays of a segment", counts_, [this](std::span<const std::byte> bytes) {
    std::memcpy(segment_, bytes.data(), sizeof segment_);
  });
  follow_ = recorder.compile();
}

bool SpecularChains::follow(const ChainSettings& settings) {
  follow_.set(settings_, settings);
  do {
    if (scheduler_->run(follow_) == RunResult::cancelled) return false;
    rays_traced_ += segment_[0];
  } while (segment_[1] > 0);
  return true;
}

void SpecularChains::warm_up() { scheduler_->warm_up(follow_); }

}  // namespace lucarium
