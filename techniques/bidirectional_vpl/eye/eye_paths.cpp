// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/eye/eye_paths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/base/luminance.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/scene/device/scene_layout.h"
#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/path_settings.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

std::map<std::string, std::string> EyePaths::defines() const {
  std::map<std::string, std::string> all = ray_end_defines(intersector_);
  all.merge(eye_defines(plan_));
  all.emplace("LUCARIUM_JOINED", "1");
  return all;
}

EyeSums::EyeSums(Device& device, const Plan& plan, const std::string& owner)
    : direct(device, owner, plan.settings.pixels, {"emission", "direct"}),
      indirect(device, owner, plan.settings.pixels, {"indirect"}),
      strategies(device, owner, plan.settings.pixels, plan.strategy_names()) {}

void EyeSums::clear() {
  for (LayerSums* sums : {&direct, &indirect, &strategies}) sums->clear();
}

EyePaths::EyePaths(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                   const Intersector& intersector, const Frame& frame, const Plan& plan, const LightVertices* vertices,
                   EyeSums& sums, const Maps& maps, const GuidePhotons* guide, const std::string& owner)
    : scheduler_(scheduler),
      scene_(scene),
      intersector_(intersector),
      frame_(frame),
      plan_(plan),
      vertices_(vertices),
      maps_(maps),
      guide_(guide),
      owner_(owner),
      primitives_(device),
      program_(make_program(device, bidirectional_vpl_kernels(),
                            {"bidirectional_vpl/eye/begin_eye_paths", "bidirectional_vpl/eye/connect_to_all",
                             "bidirectional_vpl/eye/draw_eye_numbers", "bidirectional_vpl/eye/shade_eye_vertices",
                             "bidirectional_vpl/eye/add_eye_light", "bidirectional_vpl/eye/add_iteration",
                             "bidirectional_vpl/eye/count_rays", "lucarium/services/path_integrator/advance_paths"},
                            defines())),
      rays_(device, owner, "rays of camera paths", plan.settings.pixels, remedies::lower_size),
      ends_(make_ray_ends(device, intersector, owner, "ends of rays of camera paths", plan.settings.pixels,
                          remedies::lower_size)),
      queue_(device, owner, "queue of camera paths", plan.settings.pixels, remedies::lower_size),
      active_(device, owner, "active camera paths", 1),
      counts_(device, owner, "events of camera paths", BIDIRECTIONAL_COUNTS),
      states_(device, owner, "camera paths", plan.settings.pixels, remedies::lower_size),
      mis_(device, owner, "weights of camera paths", size_t{plan.settings.pixels} * std::max(plan.light_vertices, 1u),
           remedies::lower_size),
      sample_(device, owner, "light of a sample", size_t{plan.settings.pixels} * plan.layers(), remedies::lower_size),
      hits_(device, owner, "hits of camera paths", keeps_hits() ? plan.settings.pixels : 1, remedies::lower_size),
      first_vertices_(device, owner, "first vertices of camera paths",
                      plan.gloss == Gloss::none ? 1 : plan.settings.pixels, remedies::lower_size),
      no_vertices_(device, owner, "no light vertices", 1),
      no_densities_(device, owner, "no densities", 1),
      no_list_(device, owner, "no list", std::vector<uint32_t>{0}),
      no_table_(device, owner, "no candidates", 1),
      sums_(sums) {
  counts_.fill_zero();
  if (plan.caches) caches_ = std::make_unique<Caches>(device, scheduler, scene, intersector, frame, plan, owner);
  if (plan.filter)
    filter_ = std::make_unique<PixelFilter>(device, scheduler, scene, intersector, frame, plan,
                                            sums.indirect["indirect"], owner);
  record_begin();
  if (keeps_hits()) record_closest();
  if (plan_.connects_to_all()) record_connect_to_all();
  if (plan_.stores_bundles())
    bundles_ = std::make_unique<BundleEdges>(device, scheduler, scene, plan,
                                             BundleRays{rays_, queue_, active_, states_, hits_}, owner);
  record_bounce();
  record_add();
}

void EyePaths::set_frame(const Frame& frame) {
  frame_ = frame;
  if (filter_) filter_->set_frame(frame);
}

bool EyePaths::begin(uint32_t index) {
  if (filter_ && !filter_->find_surfaces()) return false;
  if (caches_ && !caches_->look_up(index)) return false;
  begin_.set(begin_frame_, frame_);
  begin_.set(begin_index_, index);
  return scheduler_.run(begin_) != RunResult::cancelled;
}

bool EyePaths::trace(uint32_t index) {
  bounce_.set(bounce_seed_, frame_.seed);
  bounce_.set(bounce_index_, index);
  if (plan_.connects_to_all()) {
    connect_.set(connect_seed_, frame_.seed);
    connect_.set(connect_index_, index);
  }
  remaining_ = plan_.settings.pixels;
  double segments = 0;
  for (uint32_t depth = 0; remaining_ > 0; ++depth) {
    segments += remaining_;
    if (keeps_hits() && !find_surfaces(index, depth)) return false;
    if (plan_.connects_to_all() && !connect_to_all()) return false;
    if (scheduler_.run(bounce_) == RunResult::cancelled) return false;
  }
  segments_ += segments;
  paths_ += plan_.settings.pixels;
  return true;
}

bool EyePaths::find_surfaces(uint32_t index, uint32_t depth) {
  if (scheduler_.run(closest_) == RunResult::cancelled) return false;
  return !bundles_ || depth == 0 || bundles_->trace(frame_.seed, index, depth - 1);
}

bool EyePaths::connect_to_all() {
  for (uint32_t number = 0; number < vertices_->vertex_count(); ++number) {
    connect_.set(connect_number_, number);
    if (scheduler_.run(connect_) == RunResult::cancelled) return false;
  }
  return true;
}

void EyePaths::add(uint64_t iterations) {
  if (caches_) caches_->prepare_keep(add_);
  scheduler_.run_to_end(add_);
  scheduler_.finish();
  if (filter_) filter_->apply(iterations);
  for (size_t i = 0; i < counted_.size(); ++i) totals_[i] += counted_[i];
  // Where there are fewer virtual lights than candidates all are compared.
  if (plan_.has_table())
    candidates_ += static_cast<double>(counted_[BIDIRECTIONAL_COUNT_CHOICES]) *
                   std::min(plan_.settings.candidates, vertices_->vertex_count());
  if (bundles_) bundles_->complete();
  const uint32_t bad = counted_[BIDIRECTIONAL_COUNT_BAD];
  if (bad > 0)
    throw_error(ErrorClass::technique, "{} camera paths brought light that is NaN, infinite or negative", bad);
}

void EyePaths::clear(bool moves_on) {
  scheduler_.finish();
  if (caches_) moves_on ? caches_->next_frame(frame_) : caches_->clear(frame_);
  sums_.clear();
  totals_ = {};
  candidates_ = 0;
  paths_ = segments_ = 0;
  if (bundles_) bundles_->clear_counters();
}

void EyePaths::warm_up() {
  for (Schedule* schedule : {&begin_, &bounce_, &add_}) scheduler_.warm_up(*schedule);
  if (keeps_hits()) scheduler_.warm_up(closest_);
  if (plan_.connects_to_all()) scheduler_.warm_up(connect_);
  if (bundles_) bundles_->warm_up();
  if (caches_) caches_->warm_up();
  if (filter_) filter_->warm_up();
}

void EyePaths::write(Film& film) const {
  sums_.direct.write(film);
  if (filter_ && filter_->shows())
    add_mean(film, "indirect", filter_->filtered());
  else
    sums_.indirect.write(film);
  sums_.strategies.write(film, false);
}

InspectedValues EyePaths::describe_strategies(uint32_t pixel) const {
  if (!plan_.shows_strategies) return {{"strategies", "show_strategies=on shows what each brings here"}};
  InspectedValues rows;
  std::vector<glm::vec3> means;
  float all = 0;
  for (const std::string& name : plan_.strategy_names()) {
    const float4 sum = sums_.strategies[name].download(pixel, 1).front();
    means.push_back(sum.w > 0 ? glm::vec3(sum.x, sum.y, sum.z) / sum.w : glm::vec3(0));
    all += luminance(means.back().x, means.back().y, means.back().z);
  }
  for (size_t k = 0; k < means.size(); ++k) {
    const glm::vec3& mean = means[k];
    const float share = all > 0 ? luminance(mean.x, mean.y, mean.z) / all : 0;
    rows.emplace_back("by " + plan_.strategy_names()[k],
                      fmt::format("{:.4g}  {:.4g}  {:.4g} cd/m², {:.3g} %", mean.x, mean.y, mean.z, 100 * share));
  }
  return rows;
}

std::map<std::string, double> EyePaths::counters() const {
  std::map<std::string, double> all = {{"paths", paths_},
                                       {"camera_rays", segments_},
                                       {"light_sample_rays", totals_[BIDIRECTIONAL_COUNT_LIGHT_RAYS]},
                                       {"connection_rays", totals_[BIDIRECTIONAL_COUNT_CONNECTION_RAYS]},
                                       {"nonfinite", totals_[BIDIRECTIONAL_COUNT_BAD]},
                                       {"terminated_by_cap", totals_[BIDIRECTIONAL_COUNT_CAPPED]},
                                       {"terminated_in_mirrors", totals_[BIDIRECTIONAL_COUNT_MIRRORS]}};
  if (bundles_)
    for (const auto& [name, count] : bundles_->counters()) all[name] = count;
  // Tests that were no rays.
  double look_ups = 0;
  if (plan_.direct_maps) look_ups += totals_[BIDIRECTIONAL_COUNT_LIGHT_TESTS] - totals_[BIDIRECTIONAL_COUNT_LIGHT_RAYS];
  if (plan_.vpl_maps)
    look_ups += totals_[BIDIRECTIONAL_COUNT_CONNECTION_TESTS] - totals_[BIDIRECTIONAL_COUNT_CONNECTION_RAYS];
  if (plan_.direct_maps || plan_.vpl_maps) all["map_look_ups"] = look_ups;
  if (plan_.has_table()) all["candidates"] = candidates_;
  return all;
}

size_t EyePaths::estimate_bytes(const Plan& plan, const Scene& scene, bool ray_ends) {
  const size_t ends = ray_ends ? sizeof(RayEnds) : 0, ray = sizeof(Ray) + ends;
  const size_t kept = ray + sizeof(uint32_t) + sizeof(EyePathState) +
                      sizeof(float) * std::max(plan.light_vertices, 1u) + sizeof(float4) * plan.layers() * 2;
  const size_t transient = sizeof(Hit) + 3 * ray + 2 * sizeof(float4) + (plan.learned ? 11 : 7) * sizeof(uint32_t) +
                           LUCARIUM_PATH_NUMBER_ROWS * sizeof(float);
  const size_t first = plan.gloss == Gloss::none ? 0 : sizeof(PathVertex);
  // The schedule of connections to all virtual lights has memory of its own.
  const size_t connections = plan.connects_to_all() ? (plan.vpl_maps ? 2 : 1) * ray + sizeof(float4) +
                                                          (plan.learned ? 6 : 2) * sizeof(uint32_t)
                                                    : 0;
  size_t vertices = 0;
  if (plan.caches) vertices = SceneLayout(scene).world_vertices;
  const auto triangles = static_cast<size_t>(scene.triangle_count());
  return plan.settings.pixels * (kept + first + transient + connections) + 4096 +
         (plan.stores_bundles() ? BundleEdges::estimate_bytes(plan, triangles) : 0) +
         (plan.filter ? PixelFilter::estimate_bytes(plan, ray_ends) : 0) +
         (plan.caches ? Caches::estimate_bytes(plan, vertices, ray_ends) : 0);
}

}  // namespace lucarium::bidirectional
