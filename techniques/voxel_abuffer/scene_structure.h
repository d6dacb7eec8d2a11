// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/intersector.h"
#include "lucarium/technique/technique.h"
#include "voxel_abuffer/parameters.h"
#include "voxel_abuffer/structure/voxel_abuffer.h"

namespace lucarium::abuffer {

/// The structure that the parameters name, over a scene: what differs between the five is said here once.
class SceneStructure {
 public:
  /// Builds it. `scheduler` and `buffers` must outlive this.
  SceneStructure(KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                 const AbufferParameters& parameters);

  const Intersector& intersector() const { return *intersector_; }
  /// Follows a change; after SceneBuffers::update(). As a new one, bit for bit.
  void update(const Scene& scene, const SceneChange& change) { update_(scene, change); }
  /// Builds again although nothing has changed.
  void rebuild();
  /// Grows when passes that trace rays must be recorded again.
  uint64_t generation() const { return generation_(); }
  /// Those of the structure, and `fastest_build_seconds`: of all that rebuild() made and the first, which other
  /// programs and the first start of kernels disturb least.
  std::map<std::string, double> counters() const;

  /// For Technique::inspect(); nothing of structures that are only compared with.
  InspectedValues inspect(const SeenPoint& point) const { return inspect_ ? inspect_(point) : InspectedValues(); }

  /// Device bytes, from the expected numbers of what the scene's triangles touch.
  static size_t estimate_bytes(const Scene& scene, const AbufferParameters& parameters);
  static bool wants_ends(const AbufferParameters& parameters);

 private:
  template <class T>
  T& own(std::unique_ptr<T> structure);
  std::unique_ptr<Intersector> intersector_;
  std::function<void(const Scene&, const SceneChange&)> update_;
  std::function<void()> rebuild_;
  std::function<uint64_t()> generation_;
  std::function<std::map<std::string, double>()> counters_;
  std::function<InspectedValues(const SeenPoint&)> inspect_;  ///< may be empty
  double fastest_build_ = 0;                                  ///< [s]
};

VoxelAbufferOptions abuffer_options(const AbufferParameters& parameters);

}  // namespace lucarium::abuffer
