// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "bundle_exchange/specular/side_specular.h"

namespace lucarium::bundle {

/// What to do when memory does not suffice.
inline constexpr const char* no_debug_layers = "set debug_layers=off";

/// What texel sides hold and send, for DebugLayers. What is sent differs from batch to batch, so that means are kept,
/// in which the i-th value counts i², as in the image (CameraLight). Directions that carry emission only are not in
/// them, nor are those of pixels only.
class SideState {
 public:
  /// `shares`: accessibility of texel sides. `specular` may be null. All must outlive this.
  SideState(Device& device, KernelScheduler& scheduler, const SideMeans& means, const TypedBuffer<float>& shares,
            const SideSpecular* specular);

  /// When senders are made for a batch that carries reflected light: adds what the balance brings to it.
  void add_balance();
  /// When texel sides have sent along a direction of that batch: adds what their direction history brought to it.
  void add_history();
  void reset();
  void warm_up();

  // Per texel side, of its halves:
  const TypedBuffer<float>& accessibility() const { return *accessibility_; }  ///< its mean [1]
  /// xyz: mean over batches of the radiance that the balance adds, c (s - 1) e_S.
  const TypedBuffer<float4>& balance() const { return balance_; }
  /// xyz: mean over directions of the radiance that is reflected from earlier directions.
  const TypedBuffer<float4>& history() const { return history_; }
  static size_t estimate_bytes(size_t sides) { return sides * 2 * sizeof(float4); }

 private:
  KernelScheduler* scheduler_;
  const TypedBuffer<float>* accessibility_;
  bool has_history_;
  TypedBuffer<float4> balance_, history_, no_light_;
  Schedule add_balance_, add_history_;
  Variable<float> batch_weight_, direction_weight_;
  uint32_t batches_ = 0, directions_ = 0;
};

}  // namespace lucarium::bundle
