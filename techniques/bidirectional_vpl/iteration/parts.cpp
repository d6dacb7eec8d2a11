// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/iteration/parts.h"

#include <utility>

#include "bidirectional_vpl/light/describe_vertices.h"

namespace lucarium::bidirectional {

namespace {

// Numbers of light paths before the first sample, apart from all samples'.
constexpr uint32_t kGuideRun = 1u << 31;

/// Without a guide where there is none.
Plan plan_with(const GuidePhotons* guide, const Plan& plan) {
  Plan possible = plan;
  possible.guide = plan.guide && guide;
  return possible;
}

}  // namespace

Parts::Parts(const PartsContext& c, const Plan& wanted, const Frame& frame, EyeSums& sums)
    : plan_(plan_with(c.guide, wanted)), frame_(frame), guide_(plan_.guide ? c.guide : nullptr) {
  const Plan& plan = plan_;
  maps_ = std::make_unique<Maps>(c.device, c.scheduler, c.scene, plan, c.owner);
  if (plan.light_vertices > 0) {
    LightPaths::FirstHits first_hits;  // of light paths, with light_trace=rsm
    if (maps_->rsm())
      first_hits = [maps = maps_.get(), &intersector = c.intersector](ScheduleRecorder& recorder,
                                                                      const RayBuffers& rays, const BufferRef& states,
                                                                      const BufferRef& hits) {
        return maps->rsm()->record_light_paths(recorder, intersector, states, rays, hits);
      };
    vertices_ = std::make_unique<LightVertices>(c.device, c.scheduler, c.scene, c.intersector, frame, plan, first_hits,
                                                c.owner);
    maps_->add_vpl_maps(c.device, plan, *vertices_);
  }
  eye_ = std::make_unique<EyePaths>(c.device, c.scheduler, c.scene, c.intersector, frame, plan, vertices_.get(), sums,
                                    *maps_, guide_, c.owner);
  if (guide_) collect_ = guide_->record_collect(*vertices_, plan);
  if (vertices_) vertices_->record(eye_->sample(), eye_->states());
}

bool Parts::trace(uint32_t index) {
  if (!eye_->begin(index)) return false;
  if (!maps_->fill_lights(frame_.seed, index)) return false;
  if (vertices_ && !vertices_->trace(index)) return false;
  if (!maps_->fill_vpls(frame_.seed, index)) return false;
  return eye_->trace(index);
}

bool Parts::prepare_guide() {
  if (!guide_ || guide_->prepared()) return true;
  if (!eye_->begin(kGuideRun)) return false;  // what splats are added to
  while (!guide_->prepared()) {
    const uint32_t run = kGuideRun + guide_->rounds();
    if (!maps_->fill_lights(frame_.seed, run) || !vertices_->trace(run)) return false;
    vertices_->complete_guiding();
    guide_->prepare(collect_, plan_.settings.light_paths);
  }
  return true;
}

void Parts::add(uint64_t iterations) {
  eye_->add(iterations);
  if (vertices_) vertices_->complete();
  maps_->complete();
}

void Parts::restart(const Frame& frame, bool moves_on) {
  frame_ = frame;
  if (vertices_) {
    vertices_->set_frame(frame);
    vertices_->restart();
  }
  eye_->set_frame(frame);
  eye_->clear(moves_on);
  maps_->clear_counters();
}

void Parts::warm_up() {
  if (vertices_) vertices_->warm_up();
  if (guide_) guide_->warm_up(collect_);
  eye_->warm_up();
  maps_->warm_up();
}

std::map<std::string, double> Parts::counters() const {
  std::map<std::string, double> all = eye_->counters();
  if (vertices_)
    for (const auto& [name, count] : vertices_->counters()) all[name] = count;
  all.merge(maps_->counters());
  return all;
}

InspectedValues Parts::inspect(const SeenPoint& point) const {
  InspectedValues rows = eye_->describe_strategies(point.y * frame_.width + point.x);
  for (auto& row : describe_weights(plan_)) rows.push_back(std::move(row));
  if (vertices_)
    for (auto& row : describe_vertices(*vertices_, plan_, point)) rows.push_back(std::move(row));
  return rows;
}

size_t Parts::estimate_bytes(const Plan& plan, const Scene& scene) {
  return EyePaths::estimate_bytes(plan, scene, false) + Maps::estimate_bytes(plan, scene) +
         (plan.guide ? GuidePhotons::estimate_collect_bytes(plan) : 0) +
         (plan.light_vertices > 0 ? LightVertices::estimate_bytes(plan, scene, false) : 0);
}

}  // namespace lucarium::bidirectional
