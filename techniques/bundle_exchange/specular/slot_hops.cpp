// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/specular/slot_hops.h"

#include <algorithm>

#include "bundle_exchange/base/bundle_program.h"
#include "lucarium/base/luminance.h"

namespace lucarium::bundle {
namespace {

const char* const kOwner = "bundle_exchange";

HopTracer::Options tracer_options(uint32_t count, const Channels& channels, const SlotHops::Options& options) {
  HopTracer::Options result;
  result.targets = count;
  result.gains = channels.reflected();
  result.layout = channels.self_fed ? HOP_GAIN_ONE : HOP_GAIN_CHANNELS;
  result.punctual = options.punctual;
  result.what = "slots";
  return result;
}

}  // namespace

SlotHops::Lists SlotHops::specular_slots(const SurfaceAtlas& atlas, float alpha_ring) {
  Lists lists;
  const auto luminance = [](const float4& c) { return lucarium::luminance(c.x, c.y, c.z); };
  const std::vector<AtlasMaterial> materials = atlas.materials().download();
  for (uint32_t slot = 0; slot < materials.size(); ++slot) {
    // Schlick's Fresnel averaged over the cosine is f0 + (f90 - f0) / 21.
    const float f0 = luminance(materials[slot].f0), f90 = materials[slot].f0.w;
    const float transmittance = luminance(materials[slot].transmission);
    const float reflectance = f0 + (f90 - f0) / 21 + transmittance;
    if (!(reflectance > 0)) continue;
    const bool ideal = materials[slot].emission.w > 0, wide = materials[slot].diffuse.w >= alpha_ring;
    List& list = !ideal && wide && !(transmittance > 0) ? lists.glossy : lists.traced;
    list.slots.push_back(slot);
    list.reflectance.push_back(std::min(reflectance, 1.f));
  }
  return lists;
}

SlotHops::SlotHops(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                   const Intersector& intersector, const SurfaceAtlas& atlas, const SlotMeans& means, const List& list,
                   const Options& options)
    : scheduler_(&scheduler),
      program_(program),
      options_(options),
      count_(static_cast<uint32_t>(list.slots.size())),
      primitives_(device),
      list_(device, kOwner, "specular slots", list.slots),
      size_(device, kOwner, "number of specular slots", std::vector<uint32_t>{count_}),
      probabilities_(device, kOwner, "probabilities of chains", count_),
      tracer_(device, scheduler, program, scene, intersector, atlas, means.diffuse_sent(),
              tracer_options(count_, means.channels(), options)) {
  std::vector<float> probabilities = list.reflectance;
  for (float& p : probabilities) p *= options.share;
  probabilities_.upload(probabilities);
  record(scene, atlas, means);
}

size_t SlotHops::estimate_bytes(size_t slots, const Channels& channels) {
  return slots * (3 * sizeof(uint32_t) + sizeof(Ray) + sizeof(float4)) +
         HopTracer::estimate_bytes(slots, channels.reflected());
}

void SlotHops::record(const SceneBuffers& scene, const SurfaceAtlas& atlas, const SlotMeans& means) {
  ScheduleRecorder recorder = scheduler_->record("begin chains of slots", kOwner);
  omega_ = recorder.variable("omega", float4{});
  settings_ = recorder.variable("settings", ChainSettings{});
  const BufferRef shadow_rays = recorder.transient<Ray>("shadow rays", count_);
  const BufferRef shadow_light = recorder.transient<float4>("light behind them", count_);
  const BufferRef chosen = recorder.transient<uint32_t>("chosen", count_);
  recorder.pass("choose slots", program_, "choose_slots")
      .global(count_)
      .arg("count", count_)
      .arg("probabilities", probabilities_)
      .arg("settings", settings_)
      .arg("chosen", chosen)
      .arg("gain", tracer_.gain());
  primitives_.record_compact(recorder, "compact slots", chosen, tracer_.chains().queue(), tracer_.chains().active(), 0,
                             size_, 0, count_);
  PassBuilder begin = surface_pass(recorder, "begin chains of slots", program_, "begin_slot_hops", scene, atlas);
  begin.global_by(tracer_.chains().active())
      .arg("list", list_)
      .arg("probabilities", probabilities_)
      .arg("omega", omega_)
      .arg("settings", settings_)
      .arg("chains", tracer_.chains().chains())
      .arg("rays", tracer_.chains().first_rays())
      .arg("queue", tracer_.chains().queue())
      .arg("active", tracer_.chains().active())
      .arg("shadow_rays", shadow_rays)
      .arg("shadow_light", shadow_light);
  tracer_.chains().record_light(recorder, shadow_rays, shadow_light);
  begin_ = recorder.compile();
  ScheduleRecorder apply = scheduler_->record("send chains' light", kOwner);
  apply.pass("send chains' light", program_, "apply_slot_gains")
      .global(count_)
      .arg("count", count_)
      .arg("list", list_)
      .arg("diffuse", means.diffuse_sent())
      .arg("gain", tracer_.gain())
      .arg("records", means.records());
  apply_ = apply.compile();
}

bool SlotHops::find(const BundleDirection& direction, uint32_t seed, bool lit) {
  ChainSettings settings{};
  settings.seed = seed;
  settings.first_light = 1;
  settings.lit = lit;
  settings.max_vertices = options_.only_punctual ? 0 : SpecularChains::kMaxVertices;
  settings.limit = options_.max_bounces < 0 ? LUCARIUM_NONE : static_cast<uint32_t>(options_.max_bounces);
  begin_.set(settings_, settings);
  begin_.set(omega_, float4(direction.direction, 0.f));
  return scheduler_->run(begin_) == RunResult::done && (options_.only_punctual || tracer_.chains().follow(settings)) &&
         scheduler_->run(apply_) == RunResult::done;
}

void SlotHops::warm_up() {
  scheduler_->warm_up(begin_);
  tracer_.chains().warm_up();
  scheduler_->warm_up(apply_);
}

}  // namespace lucarium::bundle
