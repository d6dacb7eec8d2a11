// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <map>
#include <string>

#include "bidirectional_vpl/base/plan.h"
#include "lucarium/services/light_paths/light_paths.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/shared/path_vertex.h"

namespace lucarium::bidirectional {

/// Light paths of an iteration: their vertices as virtual lights, the table to choose from, and their splats.
class LightVertices {
 public:
  /// `first_hits`: what first surfaces are looked up by; none where they are traced.
  LightVertices(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
                const Frame& frame, const Plan& plan, const LightPaths::FirstHits& first_hits,
                const std::string& owner);

  /// Traces the paths of iteration `index` and adds their splats to `sample` (Plan::layers() layers of all pixels),
  /// which must be empty. False when cancelled.
  bool trace(uint32_t index);
  /// Counts the iteration and learns from it, once its camera paths are complete, too.
  void complete();
  /// Counts paths that no camera path is connected to and whose splats enter no image: their only use is to guide.
  void complete_guiding();
  void set_frame(const Frame& frame) { frame_ = frame; }
  void warm_up() {
    scheduler_.warm_up(schedule_);
    if (plan_.learned) scheduler_.warm_up(learn_);
  }

  const TypedBuffer<PathVertex>& vertices() const { return vertices_; }
  const TypedBuffer<float2>& densities() const { return densities_; }  ///< of vertices, by slot (base/gloss.clh)
  const TypedBuffer<float>& table() const { return table_; }
  const TypedBuffer<uint32_t>& list() const { return list_; }              ///< indices of the vertices that are there
  const TypedBuffer<uint32_t>& count() const { return count_; }            ///< one element: how many
  const TypedBuffer<uint32_t>& slot_count() const { return slot_count_; }  ///< one element: of vertices()
  /// To connect to, of the last iteration.
  uint32_t vertex_count() const { return present_; }
  /// Of all iterations since clear_counters().
  const std::map<std::string, double>& counters() const { return counters_; }
  /// Forgets counters, and what lights have brought.
  void restart();
  /// What light paths are chosen by in this iteration (path_lights.clh).
  const TypedBuffer<float>& light_shares() const { return light_shares_; }
  /// Records that connections of `count` camera paths teach which lights bring light; nothing without Plan::learned.
  /// `paths`: the light path of each connection, `light`: its light, that of `occluded` ones left out.
  void record_learning(ScheduleRecorder& recorder, const BufferRef& active, const BufferRef& rays,
                       const BufferRef& occluded, const BufferRef& paths, const BufferRef& light, uint32_t count) const;
  /// Where splats are added, and the camera paths that bad ones mark.
  void record(const TypedBuffer<float4>& sample, const TypedBuffer<EyePathState>& states);
  static size_t estimate_bytes(const Plan& plan, const Scene& scene, bool ray_ends);

 private:
  void record_splats(ScheduleRecorder& recorder, const TypedBuffer<float4>& sample,
                     const TypedBuffer<EyePathState>& states);

  void count_paths();
  void record_learn();
  void record_sums_by_light(ScheduleRecorder& recorder, const std::string& of, const BufferRef& keys,
                            const BufferRef& values, const BufferRef& light, uint32_t count) const;

  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  const Intersector& intersector_;
  Frame frame_;
  Plan plan_;
  LightPaths::FirstHits first_hits_;
  std::string owner_;
  uint32_t table_capacity_;  ///< entries, full blocks
  Primitives primitives_;
  LightPaths paths_;
  Program store_, list_program_, splat_program_, learn_program_;
  TypedBuffer<PathVertex> vertices_;
  TypedBuffer<float2> densities_;  ///< empty where Plan::gloss is none
  TypedBuffer<float> table_, light_sums_, light_news_, light_shares_;
  TypedBuffer<uint32_t> path_lights_;  ///< of each light path with a vertex
  TypedBuffer<uint32_t> list_, count_, slot_count_, splat_count_, splat_events_;
  Schedule schedule_, learn_;
  Variable<uint32_t> run_, seed_;
  Variable<Frame> frame_variable_;
  uint32_t present_ = 0;
  std::array<uint32_t, 2> traced_{}, splats_{};  ///< rays and misses, rays and splats of the last iteration
  std::map<std::string, double> counters_;
};

}  // namespace lucarium::bidirectional
