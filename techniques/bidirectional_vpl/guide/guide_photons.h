// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/light/light_vertices.h"
#include "bidirectional_vpl/shared/guide_photon.h"
#include "lucarium/services/primitives/primitives.h"

namespace lucarium::bidirectional {

/// Light vertices that ideal surfaces have lit, from all iterations of an image, by which camera paths are guided.
class GuidePhotons {
 public:
  GuidePhotons(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const std::string& owner);

  /// Records how `vertices` of an iteration are collected.
  Schedule record_collect(const LightVertices& vertices, const Plan& plan);
  /// Collects those of a whole iteration of `light_paths`; they guide from the next one on.
  void collect(Schedule& collect, uint32_t light_paths);
  void clear();
  uint32_t collected() const { return collected_; }
  /// Collects those of a round of light paths before the first sample.
  void prepare(Schedule& collect, uint32_t light_paths);
  uint32_t rounds() const { return rounds_; }  ///< so far
  bool prepared() const { return prepared_; }  ///< whether there are enough photons, or nothing to be found
  /// Whether light paths bring so many caustics of such small lamps that camera paths alone are no choice, though a few
  /// samples of theirs show no noise: they find hardly any of it.
  bool needs_light_paths() const;
  void warm_up(Schedule& collect) {
    scheduler_.warm_up(collect);
    scheduler_.warm_up(order_);
  }

  const TypedBuffer<GuidePhoton>& photons() const { return ordered_; }   ///< in the order of their keys
  const TypedBuffer<uint32_t>& keys() const { return keys_; }            ///< of Morton codes (guide_key.clh)
  const TypedBuffer<uint32_t>& count() const { return ordered_count_; }  ///< one element: how many
  static size_t estimate_bytes();
  static size_t estimate_collect_bytes(const Plan& plan);  ///< of record_collect()

 private:
  void record_order(const SceneBuffers& scene);

  KernelScheduler& scheduler_;
  std::string owner_;
  Primitives primitives_;
  Program program_;
  TypedBuffer<GuidePhoton> photons_, ordered_;
  TypedBuffer<uint32_t> keys_, stored_, ordered_count_, narrow_count_;
  Schedule order_;
  uint32_t collected_ = 0, last_ordered_ = 0;  ///< read back from stored_; how many of them are in order
  uint32_t narrow_ = 0;                        ///< read back from narrow_count_
  uint32_t rounds_ = 0;
  bool prepared_ = false;
  double light_paths_ = 0;  ///< that collected_ are of
};

}  // namespace lucarium::bidirectional
