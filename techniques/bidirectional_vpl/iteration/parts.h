// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <memory>
#include <string>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/eye/eye_paths.h"
#include "bidirectional_vpl/guide/guide_photons.h"
#include "bidirectional_vpl/light/light_vertices.h"
#include "bidirectional_vpl/maps/maps.h"

namespace lucarium::bidirectional {

/// What runs on. All must outlive the parts.
struct PartsContext {
  Device& device;
  KernelScheduler& scheduler;
  const SceneBuffers& scene;
  const Intersector& intersector;
  GuidePhotons* guide;  ///< null where no plan has one
  std::string owner;    ///< pays for the memory
};

/// Maps, light paths and camera paths of iterations of one plan.
class Parts {
 public:
  /// `sums` must be of the same plan's pixels and layers, and outlive this.
  Parts(const PartsContext& context, const Plan& plan, const Frame& frame, EyeSums& sums);

  /// Computes the sample of iteration `index`. False when cancelled. The sums stay as they are.
  bool trace(uint32_t index);
  /// Adds it to the sums, `iterations` with it.
  void add(uint64_t iterations);
  /// Before the first sample: light paths whose only use is to guide. Goes on where it was cancelled; false when it is.
  bool prepare_guide();
  /// Lets the light paths of the iteration that was added guide further ones.
  void teach() {
    if (guide_) guide_->collect(collect_, plan_.settings.light_paths);
  }
  /// Follows a change of the scene. False where this must be built again.
  bool update() { return eye_->update() && maps_->update(); }
  /// Back to no samples. `moves_on`: with the next frame of a moving picture.
  void restart(const Frame& frame, bool moves_on);
  void warm_up();
  /// Of all iterations since restart().
  std::map<std::string, double> counters() const;
  /// What is held at a pixel (Technique::inspect).
  InspectedValues inspect(const SeenPoint& point) const;
  const EyePaths& eye() const { return *eye_; }
  void write(Film& film) const { eye_->write(film); }
  static size_t estimate_bytes(const Plan& plan, const Scene& scene);

 private:
  Plan plan_;
  Frame frame_;
  std::unique_ptr<Maps> maps_;
  std::unique_ptr<LightVertices> vertices_;  ///< null where no strategy needs light paths
  GuidePhotons* guide_;
  std::unique_ptr<EyePaths> eye_;
  Schedule collect_;  ///< of what guides, with Plan::guide
};

}  // namespace lucarium::bidirectional
