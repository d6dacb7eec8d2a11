// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/primitives/primitives.h"
#include "voxel_abuffer/modes/mode.h"
#include "voxel_abuffer/modes/pass_sums.h"
#include "voxel_abuffer/shared/tree_ray.h"

namespace lucarium::abuffer {

/// Ray casting through all surfaces, and Whitted's ray tracing: every camera ray grows a tree, and what its rays meet
/// emits and reflects direct light. Layers `emission`, `direct`, `ambient`, and `crossings`, the surfaces met.
///
/// Levels are wavefronts (the paper loops with a stack per work-item instead). Each has a queue; a chunk of rays is
/// traced and shaded at once, always from the deepest level that has some, so that no queue exceeds twice a chunk:
///
///   camera rays or load_rays            the chunk
///   closest hit        Intersector
///   shade_tree_rays                     points, and up to two rays that go on from each
///   DirectLight                         light samples and BSDF samples at the points
///   add_tree_light                      rays of a pixel stand next to each other: summed in their order
///   queue_rays                          what goes on joins the next level's queue
class EyeTrees : public Mode {
 public:
  struct Options {
    bool straight = false;  ///< rays go on behind every surface by its alpha, else they branch at ideal lobes
    uint32_t depth = 3;     ///< maximum ideal reflections and refractions of a branch
    float ambient = 0;      ///< constant light that every surface reflects, never in shadow [cd/m²]
    uint32_t samples = 1;   ///< λ
  };
  EyeTrees(const ModeContext& context, const Options& options);
  bool pass() override;
  void restart(const Frame& frame, uint64_t seed) override;
  void write(Film& film) override;
  void warm_up() override;
  std::map<std::string, double> counters() const override;
  static size_t estimate_bytes(size_t pixels, const Options& options, bool ray_ends);

 private:
  /// Rays that wait in a level's queue: [begin, end) of its places.
  struct Level {
    uint32_t begin = 0, end = 0;
  };
  uint32_t queues() const { return options_.straight ? 2 : options_.depth; }
  uint32_t place(uint32_t level) const;  ///< of the first ray in its queue
  /// What rays of trees go on with, two places for each, and whether they do.
  struct NextRays {
    BufferRef rays, tree_rays, ends, goes_on;
  };
  void record(const ModeContext& context);
  void record_camera(const Program& program);
  void record_load(const Program& program);
  void record_shade(const ModeContext& context, const Program& program);
  void record_queue(ScheduleRecorder& recorder, const Program& program, const NextRays& next);
  void record_add(const Program& program);
  bool sample(uint32_t index);
  bool grow(uint32_t sample_index);
  bool trace(const TreeRules& rules, uint32_t chunk);

  KernelScheduler* scheduler_;
  Options options_;
  uint32_t pixels_, chunk_;
  Frame frame_;
  uint32_t seed_ = 0;
  Primitives primitives_;
  DirectLight direct_light_;
  PassSums sums_;
  TypedBuffer<Ray> rays_, queued_rays_;
  TypedBuffer<RayEnds> ends_, queued_ends_;
  TypedBuffer<TreeRay> tree_rays_, queued_tree_rays_;
  TypedBuffer<uint32_t> counts_;      ///< rays of the chunk, and places for those that go on
  TypedBuffer<uint32_t> next_count_;  ///< one element: how many do
  TypedBuffer<GBufferPoint> points_;
  TypedBuffer<float4> lit_;
  Schedule camera_, load_, shade_, add_;
  Variable<Frame> camera_frame_;
  Variable<TreeRules> camera_rules_, load_rules_, shade_rules_, add_rules_;
  std::vector<Level> levels_;
  uint32_t next_rays_ = 0;  ///< read back after every chunk
  uint32_t passes_ = 0;
  double traced_ = 0, traced_in_pass_ = 0;
};

}  // namespace lucarium::abuffer
