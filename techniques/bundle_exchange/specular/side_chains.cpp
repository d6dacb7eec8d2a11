// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/specular/side_chains.h"

#include <algorithm>

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/base/name.h"
#include "lucarium/base/luminance.h"

namespace lucarium::bundle {
namespace {

ChainTracer::Options tracer_options(uint32_t count, const Channels& channels, const SideChains::Options& options) {
  ChainTracer::Options result;
  result.targets = count;
  result.contributions = channels.reflected();
  result.layout = channels.self_fed ? CONTRIBUTION_ONE : CONTRIBUTION_CHANNELS;
  result.punctual = options.punctual;
  result.what = "sides";
  return result;
}

}  // namespace

SideChains::Lists SideChains::specular_sides(const SurfaceAtlas& atlas, float history_alpha) {
  Lists lists;
  const auto luminance = [](const float4& c) { return lucarium::luminance(c.x, c.y, c.z); };
  const std::vector<AtlasMaterial> materials = atlas.materials().download();
  for (uint32_t side = 0; side < materials.size(); ++side) {
    // Schlick's Fresnel averaged over the cosine is f0 + (f90 - f0) / 21.
    const float f0 = luminance(materials[side].f0), f90 = materials[side].f0.w;
    const float transmittance = luminance(materials[side].transmission);
    const float reflectance = f0 + (f90 - f0) / 21 + transmittance;
    if (!(reflectance > 0)) continue;
    const bool ideal = materials[side].emission.w > 0, wide = materials[side].diffuse.w >= history_alpha;
    List& list = !ideal && wide && !(transmittance > 0) ? lists.glossy : lists.traced;
    list.sides.push_back(side);
    list.reflectance.push_back(std::min(reflectance, 1.f));
  }
  return lists;
}

SideChains::SideChains(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                       const Intersector& intersector, const SurfaceAtlas& atlas, const SideMeans& means,
                       const List& list, const Options& options)
    : scheduler_(&scheduler),
      program_(program),
      options_(options),
      count_(static_cast<uint32_t>(list.sides.size())),
      primitives_(device),
      list_(device, technique_name, "specular texel sides", list.sides),
      size_(device, technique_name, "number of specular texel sides", std::vector<uint32_t>{count_}),
      probabilities_(device, technique_name, "probabilities of chains", count_),
      tracer_(device, scheduler, program, scene, intersector, atlas, means.diffuse_sent(), means.halves(),
              tracer_options(count_, means.channels(), options)) {
  std::vector<float> probabilities = list.reflectance;
  for (float& p : probabilities) p *= options.share;
  probabilities_.upload(probabilities);
  record(scene, atlas, means);
}

size_t SideChains::estimate_bytes(size_t sides, const Channels& channels) {
  return sides * (3 * sizeof(uint32_t) + sizeof(Ray) + sizeof(float4)) +
         ChainTracer::estimate_bytes(sides, channels.reflected());
}

void SideChains::record(const SceneBuffers& scene, const SurfaceAtlas& atlas, const SideMeans& means) {
  ScheduleRecorder recorder = scheduler_->record("begin chains of texel sides", technique_name);
  omega_ = recorder.variable("omega", float4{});
  settings_ = recorder.variable("settings", ChainSettings{});
  const BufferRef shadow_rays = recorder.transient<Ray>("shadow rays", count_);
  const BufferRef shadow_light = recorder.transient<float4>("light behind them", count_);
  const BufferRef chosen = recorder.transient<uint32_t>("chosen", count_);
  recorder.pass("choose texel sides", program_, "choose_sides")
      .global(count_)
      .arg("count", count_)
      .arg("probabilities", probabilities_)
      .arg("settings", settings_)
      .arg("chosen", chosen)
      .arg("contribution", tracer_.contribution());
  primitives_.record_compact(recorder, "compact texel sides", chosen, tracer_.chains().queue(),
                             tracer_.chains().active(), 0, size_, 0, count_);
  PassBuilder begin =
      surface_pass(recorder, "begin chains of texel sides", program_, "begin_side_chains", scene, atlas);
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
  ScheduleRecorder apply = scheduler_->record("send chains' light", technique_name);
  apply.pass("send chains' light", program_, "apply_contributions")
      .global(count_)
      .arg("count", count_)
      .arg("sides", means.halves().sides)
      .arg("half_count", means.halves().count)
      .arg("list", list_)
      .arg("diffuse", means.diffuse_sent())
      .arg("contribution", tracer_.contribution())
      .arg("records", means.records());
  apply_ = apply.compile();
}

bool SideChains::find(const BundleDirection& direction, uint32_t seed, bool lit) {
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

void SideChains::warm_up() {
  scheduler_->warm_up(begin_);
  tracer_.chains().warm_up();
  scheduler_->warm_up(apply_);
}

}  // namespace lucarium::bundle
