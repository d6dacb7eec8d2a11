// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/specular/hop_tracer.h"

#include <cstring>

#include "bundle_exchange/bundle_program.h"

namespace lucarium::bundle {
namespace {

const char* const kOwner = "bundle_exchange";

}  // namespace

HopTracer::HopTracer(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                     const Intersector& intersector, const SurfaceAtlas& atlas, const TypedBuffer<float4>& diffuse,
                     const Options& options)
    : scheduler_(&scheduler),
      program_(program),
      intersector_(&intersector),
      primitives_(device),
      options_(options),
      gain_(device, kOwner, "gains of " + options.what, size_t{options.targets} * options.gains),
      hops_(device, kOwner, "chains of " + options.what, options.targets),
      rays_(device, kOwner, "rays of " + options.what, options.targets),
      queue_(device, kOwner, "queue of " + options.what, options.targets),
      active_(device, kOwner, "active chains", 1),
      counts_(device, kOwner, "rays of a segment", 2) {
  record(scene, atlas, diffuse);
}

size_t HopTracer::estimate_bytes(size_t targets, size_t gains) {
  // The transients of a segment and of the light samples among them.
  return targets * (gains * sizeof(float4) + sizeof(Hop) + 2 * sizeof(Ray) + sizeof(Hit) + sizeof(Ray) +
                    sizeof(float4) + 6 * sizeof(uint32_t));
}

void HopTracer::record_punctual(ScheduleRecorder& recorder, const Variable<HopSettings>& settings,
                                const BufferRef& shadow_rays, const BufferRef& shadow_light) const {
  if (!options_.punctual) return;
  const BufferRef occluded = recorder.transient<uint32_t>("occluded", options_.targets);
  intersector_->record_any(recorder, "shadow rays of " + options_.what, shadow_rays, occluded, active_, 0,
                           options_.targets);
  recorder.pass("punctual light of " + options_.what, program_, "add_punctual")
      .global(options_.targets)
      .arg("settings", settings)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("shadow_rays", shadow_rays)
      .arg("shadow_light", shadow_light)
      .arg("occluded", occluded)
      .arg("gain", gain_);
}

void HopTracer::record(const SceneBuffers& scene, const SurfaceAtlas& atlas, const TypedBuffer<float4>& diffuse) {
  const uint32_t targets = options_.targets;
  ScheduleRecorder recorder = scheduler_->record("follow " + options_.what, kOwner);
  settings_ = recorder.variable("settings", HopSettings{});
  const BufferRef hits = recorder.transient<Hit>("hits", targets),
                  next_rays = recorder.transient<Ray>("next rays", targets);
  const BufferRef next_queue = recorder.transient<uint32_t>("next queue", targets);
  const BufferRef alive = recorder.transient<uint32_t>("alive", targets);
  const BufferRef survivors = recorder.transient<uint32_t>("survivors", targets);
  const BufferRef next_active = recorder.transient<uint32_t>("next active", 1);
  const BufferRef shadow_rays = recorder.transient<Ray>("shadow rays", targets);
  const BufferRef shadow_light = recorder.transient<float4>("light behind them", targets);
  recorder.fill_zero("clear count", counts_);
  intersector_->record_closest(recorder, "hits of " + options_.what, rays_, hits, active_, 0, targets);
  PassBuilder advance = surface_pass(recorder, "advance " + options_.what, program_, "advance_hops", scene, atlas);
  advance.global_by(active_)
      .arg("diffuse", diffuse)
      .arg("settings", settings_)
      .arg("hits", hits)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg("alive", alive)
      .arg("shadow_rays", shadow_rays)
      .arg("shadow_light", shadow_light);
  advance.arg("gain", gain_).arg("hops", hops_).arg("rays", rays_).arg("queue", queue_).arg("active", active_);
  record_punctual(recorder, settings_, shadow_rays, shadow_light);
  primitives_.record_compact(recorder, "compact " + options_.what, alive, survivors, next_active, 0, active_, 0,
                             targets);
  recorder.pass("next " + options_.what, program_, "advance_queue")
      .global_by(active_)
      .arg("survivors", survivors)
      .arg("next_active", next_active)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg("rays", rays_)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("counts", counts_);
  recorder.read_back("rays of a segment", counts_, [this](std::span<const std::byte> bytes) {
    std::memcpy(segment_, bytes.data(), sizeof segment_);
  });
  follow_ = recorder.compile();
}

bool HopTracer::follow(const HopSettings& settings) {
  follow_.set(settings_, settings);
  do {
    if (scheduler_->run(follow_) == RunResult::cancelled) return false;
    rays_traced_ += segment_[0];
  } while (segment_[1] > 0);
  return true;
}

void HopTracer::warm_up() { scheduler_->warm_up(follow_); }

}  // namespace lucarium::bundle
