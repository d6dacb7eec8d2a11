// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/light_paths/light_paths.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/ray.h"

namespace lucarium {
namespace {

constexpr size_t kPathsPerSlice = 1 << 16;
// Work-items of a group, each with eight paths: PoCL keeps what is not in registers for all of a group.
constexpr size_t kItemsPerGroup = 16;
// Paths that are traced together, from their lights to their last vertices: rays, hits and states of so many stay in
// caches. More where there would be too many batches.
constexpr uint32_t kPathsPerBatch = 1 << 14, kMaxBatches = 16;
constexpr uint32_t kCountChunk = 1 << 12;

// Where their first rays are put into an order, which pays the more the more of them there are.
constexpr uint32_t kPathsPerOrderedBatch = 1 << 18;

uint32_t batch_of(uint32_t paths, bool ordered) {
  if (ordered) return std::min(paths, kPathsPerOrderedBatch);
  const uint32_t least = (paths + kMaxBatches - 1) / kMaxBatches;
  return std::min(paths, std::max(kPathsPerBatch, (least + 7) / 8 * 8));
}

size_t batch_bytes(uint32_t batch) { return size_t{batch} * (sizeof(Ray) + sizeof(Hit) + sizeof(LightPathState)); }

LightPathRules rules_of(const LightPathOptions& options) {
  LightPathRules rules{};
  rules.count = options.paths;
  rules.flags = (options.diffuse_only ? LUCARIUM_LIGHT_PATHS_DIFFUSE : 0u) |
                (options.opaque_blend ? LUCARIUM_LIGHT_PATHS_OPAQUE_BLEND : 0u);
  rules.kinds = options.kinds;
  rules.roulette_start = options.roulette_start;
  rules.hit_samples = options.hit_samples;
  rules.light_samples = options.light_samples;
  rules.connection_samples = options.connection_samples;
  rules.vertices = options.vertices;
  return rules;
}

}  // namespace

LightPaths::LightPaths(Device& device, const SceneBuffers& scene, const Intersector& intersector,
                       const LightPathOptions& options, const std::string& owner)
    : device_(device),
      scene_(scene),
      intersector_(intersector),
      options_(options),
      ordered_(options.order && FirstRays::pays(scene, intersector, options.paths, options.kinds)),
      batch_(batch_of(options.paths, ordered_)),
      count_(device, owner, "number of light paths", std::vector<uint32_t>{batch_, options.paths % batch_}),
      ray_counts_(device, owner, "rays of light paths, counted", std::vector<uint32_t>{0, 0}) {
  if (ordered_) first_rays_.emplace(device);
}

void LightPaths::record(ScheduleRecorder& recorder, const Variable<uint32_t>& run, const Variable<uint32_t>& seed,
                        const Program& program, const Bind& bind, const Bind& bind_emission,
                        const FirstHits& first_hits) const {
  if (options_.count_rays) recorder.fill_zero("no rays of light paths", ray_counts_);
  const Transients of{
      recorder.transient<Ray>("rays of light paths", batch_, options_.remedy),
      recorder.transient<Hit>("hits of light paths", batch_, options_.remedy),
      transient_ray_ends(recorder, intersector_, "ends of rays of light paths", batch_, options_.remedy),
      recorder.transient<LightPathState>("light paths", batch_, options_.remedy),
      FirstRays::keys(recorder, first_rays_ && !first_hits ? batch_ : 1, options_.remedy)};
  for (uint32_t base = 0; base < options_.paths; base += batch_)
    record_batch(recorder, base, of, run, seed, program, bind, bind_emission, first_hits);
}

void LightPaths::record_batch(ScheduleRecorder& recorder, uint32_t base, const Transients& of,
                              const Variable<uint32_t>& run, const Variable<uint32_t>& seed, const Program& program,
                              const Bind& bind, const Bind& bind_emission, const FirstHits& first_hits) const {
  const uint32_t paths = std::min(batch_, options_.paths - base), items = (paths + 7) / 8;
  const LightPathRules rules = rules_of(options_);
  PassBuilder emit = recorder.pass("emit light paths", program, "emit_light_paths");
  scene_.bind(emit);
  emit.global(items)
      .local(kItemsPerGroup)
      .slice(kPathsPerSlice / 8)
      .arg("rules", rules)
      .arg("base", base)
      .arg("count", paths)
      .arg("frame", run)
      .arg("seed", seed)
      .arg("rays", of.rays)
      .arg_if_present("ends", of.ends)
      .arg("states", of.states)
      .arg("ordered", first_rays_ && !first_hits ? 1u : 0u)
      .arg("keys", of.keys.keys)
      .arg("order", of.keys.order);
  if (bind_emission) bind_emission(emit);
  for (uint32_t number = 0; number < options_.vertices; ++number) {
    const RayBuffers edges{of.rays, count_, paths == batch_ ? 0u : 1u, paths, of.ends};
    BufferRef traced = of.rays;
    if (number == 0 && first_hits)
      traced = first_hits(recorder, edges, of.states, of.hits);
    else if (number == 0 && first_rays_)
      first_rays_->record(recorder, "first rays of light paths", intersector_, edges, of.keys, of.hits,
                          options_.remedy);
    else
      intersector_.record_closest(recorder, "trace light paths", edges, of.hits);
    if (options_.count_rays)
      recorder.pass("count rays of light paths", program, "count_light_rays")
          .global((paths + kCountChunk - 1) / kCountChunk)
          .arg("rays", traced)
          .arg("hits", of.hits)
          .arg("count", paths)
          .arg("chunk", kCountChunk)
          .arg("counts", ray_counts_);
    PassBuilder advance = recorder.pass("vertices of light paths", program, "advance_light_paths");
    scene_.bind(advance);
    advance.global(items)
        .local(kItemsPerGroup)
        .slice(kPathsPerSlice / 8)
        .arg("rules", rules)
        .arg("base", base)
        .arg("count", paths)
        .arg("frame", run)
        .arg("seed", seed)
        .arg("number", number)
        .arg("hits", of.hits)
        .arg("rays", of.rays)
        .arg_if_present("ends", of.ends)
        .arg("states", of.states);
    bind(advance);
  }
}

void LightPaths::record_virtual_lights(ScheduleRecorder& recorder, const Variable<uint32_t>& run,
                                       const Variable<uint32_t>& seed, const TypedBuffer<VirtualLight>& lights,
                                       uint32_t first, bool reflected) const {
  if (first > options_.vertices)
    throw_error(ErrorClass::internal, "LightPaths: first is {}, but paths have {} vertices", first, options_.vertices);
  if (lights.count() < virtual_lights(first))
    throw_error(ErrorClass::internal, "LightPaths: lights has {} elements, vertices from number {} on fill {}",
                lights.count(), first, virtual_lights(first));
  const Program program(device_, SourceLibrary(),
                        {"services/light_paths",
                         {"lucarium/services/light_paths/store_virtual_lights.cl"},
                         ray_end_defines(intersector_)});
  recorder.fill_zero("no virtual lights", lights);
  record(recorder, run, seed, program, [&](PassBuilder& pass) {
    pass.arg("lights", lights).arg("first", first).arg("paths", options_.paths).arg("reflected", reflected ? 1u : 0u);
  });
}

size_t LightPaths::estimate_bytes(uint32_t paths) {
  const size_t numbered = batch_bytes(batch_of(paths, false));
  if (paths < FirstRays::kFewest) return numbered;
  const uint32_t ordered = batch_of(paths, true);
  return std::max(numbered, batch_bytes(ordered) + FirstRays::estimate_bytes(ordered));
}

size_t LightPaths::estimate_bytes(uint32_t paths, const Scene& scene) {
  const bool places = std::any_of(scene.lights.begin(), scene.lights.end(), [](const SceneLight& light) {
    return light.type == LightType::point || light.type == LightType::spot;
  });
  return places ? estimate_bytes(paths) : batch_bytes(batch_of(paths, false));
}

}  // namespace lucarium
