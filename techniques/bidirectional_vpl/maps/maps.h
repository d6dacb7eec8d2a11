// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <memory>
#include <string>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/maps/light_maps.h"
#include "bidirectional_vpl/maps/vpl_maps.h"

namespace lucarium::bidirectional {

/// The rasterized maps of an iteration, those that Plan asks for: reflective shadow maps (light_trace=rsm), shadow maps
/// of lights (direct=maps) and of virtual lights (vpl_visibility=map).
class Maps {
 public:
  /// `scene` must outlive this; `owner` pays for the memory.
  Maps(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Plan& plan,
       const std::string& owner);
  /// Makes room for maps of virtual lights. `vertices` must outlive this.
  void add_vpl_maps(Device& device, const Plan& plan, const LightVertices& vertices);

  const LightMaps* rsm() const { return rsm_.get(); }        ///< null without light_trace=rsm
  const LightMaps* direct() const { return direct_.get(); }  ///< null without direct=maps
  const VplMaps* vpls() const { return vpls_.get(); }        ///< null without vpl_visibility=map

  /// Maps of lights, before light paths. False when cancelled.
  bool fill_lights(uint32_t seed, uint32_t sample);
  /// Maps of virtual lights, which are there. False when cancelled.
  bool fill_vpls(uint32_t seed, uint32_t sample);
  /// Counts the iteration, once it is complete.
  void complete();
  void clear_counters() { faces_ = 0; }
  /// Faces of complete iterations since clear_counters().
  std::map<std::string, double> counters() const;
  /// Follows a change of the scene. False where this must be built again.
  bool update();
  void warm_up();
  static size_t estimate_bytes(const Plan& plan, const Scene& scene);

 private:
  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  std::string owner_;
  std::unique_ptr<LightMaps> rsm_, direct_;
  std::unique_ptr<VplMaps> vpls_;
  double faces_ = 0;
};

}  // namespace lucarium::bidirectional
