// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/senders/side_means.h"
#include "bundle_exchange/shared/history_step.h"
#include "lucarium/services/bundles/direction_sequence.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium::bundle {

/// What glossy texel sides send: what they reflect, towards a bundle's direction, of the light that the directions
/// before it have brought (the transfer atlas of the paper, section 5.4, equation 4). Formulas: send_history.cl.
/// No rays are traced. Light of a direction is reflected by the next M ones only, so that every glossy bounce comes
/// about M / 2 directions later. With M = 1 and unlimited bounces variance is infinite where 2π ∫ f² cos² > 1, f the
/// lobe.
///
/// Pairs of successive directions must fill the product space: sequences that do not are biased (Halton points with a
/// window of 1 lose much of the light).
class DirectionHistory {
 public:
  struct Options {
    uint32_t window = 1;   ///< M: directions that are reflected
    uint32_t batch = 1;    ///< most directions of a batch
    bool by_share = true;  ///< normalized by the weights that came (less noise), else by their number
    bool by_area = true;   ///< rays per area; false where every texel side has one ray for a direction
    bool adds = false;     ///< records already hold other light when send() is called
  };
  /// `sides` must not be empty.
  DirectionHistory(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                   const SurfaceAtlas& atlas, const SideMeans& means, const std::vector<uint32_t>& sides,
                   const Options& options);

  /// Directions `first` … `first + count - 1` of the sequence are the next batch.
  void begin_batch(const DirectionSequence& sequence, uint64_t first, uint32_t count);
  /// Before direction i of the batch is exchanged (false when cancelled, and may be done again), and after.
  bool send(uint32_t i);
  void receive(uint32_t i);
  /// The batch counts.
  void commit();
  void reset();
  void warm_up();
  const TypedBuffer<uint32_t>& sides() const { return list_; }  ///< that have one
  static size_t estimate_bytes(size_t sides, const Channels& channels, const Options& options);

 private:
  void record(const Program& program, const SceneBuffers& scene, const SurfaceAtlas& atlas, const SideMeans& means);
  HistoryStep step(uint32_t i) const;
  KernelScheduler* scheduler_;
  Options options_;
  uint32_t count_, length_;
  TypedBuffer<uint32_t> list_;
  TypedBuffer<float4> directions_, before_, history_;
  std::vector<float4> batch_;  ///< directions of the batch
  uint64_t done_ = 0;          ///< directions committed so far
  Schedule send_, receive_;
  Variable<HistoryStep> send_step_, receive_step_;
  Variable<float4> omega_;
};

}  // namespace lucarium::bundle
