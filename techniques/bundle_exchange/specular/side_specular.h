// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "bundle_exchange/senders/direction_history.h"
#include "bundle_exchange/specular/side_chains.h"

namespace lucarium::bundle {

/// What texel sides send by their specular lobes, direction by direction: narrow lobes and glass by rays (SideChains),
/// wide ones by rays too or by what the last directions have brought (DirectionHistory).
class SideSpecular {
 public:
  /// `punctual`: there are point, spot or directional lights; `by_area` as in DirectionHistory::Options.
  SideSpecular(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
               const Intersector& intersector, const SurfaceAtlas& atlas, const SideMeans& means,
               const Parameters& parameters, bool punctual, int max_bounces, bool by_area);

  /// Whether the parameters ask for a direction history; the least GGX width of lobes that bundles meet often enough
  /// (without a direction history: those of pixels).
  static bool uses_history(const Parameters& parameters) { return parameters.glossy_window > 0; }
  static float min_alpha(const Parameters& parameters);
  /// Whether some texel side reflects directions, which then must be independent of each other.
  bool has_history() const { return history_ != nullptr; }
  /// The texel sides that do (where has_history()), or their open halves and then their covered ones, and what light
  /// samples bring to what each of the sides sends, as SideChains::contribution(): null without punctual lights.
  const TypedBuffer<uint32_t>& history_sides() const { return history_->sides(); }
  const TypedBuffer<float4>* history_light() const { return light_ ? &light_->contribution() : nullptr; }
  uint32_t lit_sides() const { return light_ ? light_->count() : 0; }  ///< that light samples are brought to

  /// The next batch; a batch that was cancelled may be begun again.
  void begin_batch(const DirectionSequence& sequence, uint64_t first, uint32_t count);
  /// Before direction i of the batch is exchanged; false when cancelled, and may be done again. `lit`: chains find
  /// lights.
  bool send(const BundleDirection& direction, uint32_t i, uint32_t seed, bool lit);
  /// After it.
  void receive(uint32_t i);
  void commit();
  void reset();
  void warm_up();
  uint64_t rays() const { return (chains_ ? chains_->rays() : 0) + (light_ ? light_->rays() : 0); }
  static size_t estimate_bytes(size_t sides, uint32_t halves, const Channels& channels, const Parameters& parameters);

 private:
  std::unique_ptr<SideChains> chains_, light_;  ///< chains; light samples of texel sides of the direction history
  std::unique_ptr<DirectionHistory> history_;
};

}  // namespace lucarium::bundle
