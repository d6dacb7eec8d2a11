// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lucarium/compute/device/buffer.h"
#include "lucarium/film/film.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// The layers of an image that a technique sums over its samples: per pixel xyz the sum [cd/m²], w the number of
/// samples, or the sum of their weights. Kernels add to them by layer_sums.clh. So that a cancelled iteration leaves no
/// trace, all layers change in one schedule behind everything that may be cancelled, and KernelScheduler::run_to_end()
/// runs it.
class LayerSums {
 public:
  LayerSums() = default;
  /// `owner` pays for the memory. Begins at zero.
  LayerSums(Device& device, const std::string& owner, size_t pixels, std::vector<std::string> layers);

  /// The sums of a layer; throws Error{internal} for one that is not there.
  const TypedBuffer<float4>& operator[](std::string_view layer) const;
  /// Back to no samples. The device must have finished with them.
  void clear();
  /// The same without touching memory: the next pass is to write all of it without reading.
  void forget() { forgotten_ = true; }
  /// For that pass: whether it is, once.
  bool take_forgotten() { return std::exchange(forgotten_, false); }
  /// Adds every layer's mean to the film's additive layer of the same name; black where there is no sample. The device
  /// must have finished, and no run may begin meanwhile. Not `additive`: the layers show parts of others, and are none
  /// of the image.
  void write(Film& film, bool additive = true) const;
  static size_t estimate_bytes(size_t pixels, size_t layers) { return pixels * layers * sizeof(float4); }

 private:
  std::vector<std::string> names_;
  std::vector<TypedBuffer<float4>> sums_;
  bool forgotten_ = false;
};

/// Adds the means of sums to the film's layer `name`, as LayerSums::write().
void add_mean(Film& film, const std::string& name, std::span<const float4> sums, bool additive = true);
void add_mean(Film& film, const std::string& name, const TypedBuffer<float4>& sums, bool additive = true);

}  // namespace lucarium
