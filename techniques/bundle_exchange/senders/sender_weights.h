// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "bundle_exchange/base/parameters.h"

namespace lucarium::bundle {

/// How a batch enters the two means of every texel side. The interleaved light transfer of the paper (section 5.5),
/// read literally (interleave=fixed), adds each direction with weight 1/N to what the next one sends; light of k
/// scatterings then counts 1/(k+1)! (limit (e^ρ - 1)/ρ instead of 1/(1-ρ), ρ the albedo). Here a mean is Σ v w L / Σ v
/// w n with growing weights v, so that texel sides which no ray hits need no step of their own.
///
/// S, which senders use, discounts old batches: batch k has weight γ_k = k^-step_exponent, hence v_k = γ_k e^l_k with
/// l_k = l_{k-1} - ln(1 - γ_k), l_1 = 0 (relative deficit after N batches exp(-(1-ρ) Σγ) instead of N^-(1-ρ)). D, which
/// is displayed, is nearly a plain mean: v_i = i^average_exponent.
class SenderWeights {
 public:
  struct Step {
    double sender_scale = 1;    ///< what S so far is multiplied with, before
    double sender_weight = 1;   ///< v of S
    double display_weight = 1;  ///< v of D
  };

  SenderWeights() = default;
  explicit SenderWeights(const Parameters& parameters);
  /// Weights of the next batch: directions `first` … `first + count - 1`, from 0.
  Step next(uint64_t first, uint32_t count) const;
  /// The batch has been added.
  void advance();
  /// From now on S counts for `batches` at most, so that later ones change it faster. Returns the factor by
  /// which S must be multiplied.
  double forget(uint64_t batches);
  uint64_t batches() const { return batch_; }

 private:
  bool plain_ = false;  ///< running mean for both
  double step_exponent_ = 0.5, average_exponent_ = 0.5;
  uint64_t batch_ = 0;     ///< done
  double log_growth_ = 0;  ///< l
};

}  // namespace lucarium::bundle
