// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/layer_sums/layer_sums.h"

namespace lucarium::abuffer {

/// Layers that grow by whole passes (Hu et al. 2014, algorithm 1): a pass of λ samples is traced into buffers of its
/// own, `curr`, which become part of `sum` when all of it is there. The image is sum / (λ η) after η passes.
class PassSums {
 public:
  PassSums(KernelScheduler& scheduler, size_t pixels, const std::vector<std::string>& layers, uint32_t samples);

  /// Empties the buffers of the pass; false when cancelled.
  bool begin();
  /// What the pass adds to a layer: float4 per pixel, xyz.
  const TypedBuffer<float4>& pass(size_t layer) const { return pass_[layer]; }
  void commit();
  void clear();
  const LayerSums& sums() const { return sums_; }
  const TypedBuffer<float4>& sum(size_t layer) const { return sums_[names_[layer]]; }
  void warm_up();
  static size_t estimate_bytes(size_t pixels, size_t layers) { return 2 * LayerSums::estimate_bytes(pixels, layers); }

 private:
  KernelScheduler* scheduler_;
  std::vector<std::string> names_;
  LayerSums sums_;
  std::vector<TypedBuffer<float4>> pass_;
  Schedule begin_, commit_;
};

}  // namespace lucarium::abuffer
