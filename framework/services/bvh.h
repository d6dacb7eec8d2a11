// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "lucarium/services/intersector.h"

namespace lucarium {

struct BvhStatistics {
  uint32_t triangles = 0, nodes = 0, leaf_blocks = 0;
  double build_seconds = 0;
  size_t bytes = 0;
  double sah_cost = 0;  ///< expected node + triangle tests of a random ray that hits the root box
};

/// Wide bounding-volume hierarchy over the scene's world-space triangles. Built on the host (SAH, all cores), traversed
/// on the device. Owner "bvh" in the memory account.
class Bvh : public Intersector {
 public:
  Bvh(Device& device, const Scene& scene, const SceneBuffers& buffers);
  ~Bvh() override;

  /// Refits for moved or deformed vertices, rebuilds when topology changed or quality fell (SAH cost above 1.5× built).
  void update(const Scene& scene, const SceneBuffers& buffers, const SceneChange& change);

  std::string name() const override { return "bvh"; }
  void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const BufferRef& rays,
                      const BufferRef& hits, const BufferRef& counter, uint32_t counter_index,
                      uint32_t capacity) const override;
  void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const BufferRef& rays,
                  const BufferRef& occluded, const BufferRef& counter, uint32_t counter_index,
                  uint32_t capacity) const override;

  const BvhStatistics& statistics() const;
  static size_t estimate_bytes(const Scene& scene);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
