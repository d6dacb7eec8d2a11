// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/layer_sums/layer_sums.h"

#include <algorithm>
#include <memory>

#include "lucarium/base/error.h"
#include "lucarium/compute/device/remedies.h"

namespace lucarium {

LayerSums::LayerSums(Device& device, const std::string& owner, size_t pixels, std::vector<std::string> layers)
    : names_(std::move(layers)) {
  for (const std::string& name : names_)
    sums_.emplace_back(device, owner, "sums of " + name, pixels, remedies::lower_size);
  clear();
}

const TypedBuffer<float4>& LayerSums::operator[](std::string_view layer) const {
  const auto found = std::find(names_.begin(), names_.end(), layer);
  if (found == names_.end()) throw_error(ErrorClass::internal, "there are no sums of a layer '{}'", layer);
  return sums_[static_cast<size_t>(found - names_.begin())];
}

void LayerSums::clear() {
  for (TypedBuffer<float4>& sums : sums_) sums.fill_zero();
  forgotten_ = false;
}

void LayerSums::write(Film& film, bool additive) const {
  for (size_t i = 0; i < names_.size(); ++i) {
    if (forgotten_)
      film.layer(names_[i], {"R", "G", "B"}, additive);
    else
      add_mean(film, names_[i], sums_[i], additive);
  }
}

void add_mean(Film& film, const std::string& name, std::span<const float4> sums, bool additive) {
  if (sums.size() != film.pixel_count())
    throw_error(ErrorClass::internal, "{} sums for a film of {} pixels", sums.size(), film.pixel_count());
  float* mean = film.layer(name, {"R", "G", "B"}, additive).pixels.data();
  for (const float4& sum : sums) {
    const float scale = sum.w > 0 ? 1 / sum.w : 0.f;
    mean[0] += sum.x * scale;
    mean[1] += sum.y * scale;
    mean[2] += sum.z * scale;
    mean += 3;
  }
}

void add_mean(Film& film, const std::string& name, const TypedBuffer<float4>& sums, bool additive) {
  const std::shared_ptr<const float4[]> elements = sums.elements();
  add_mean(film, name, std::span(elements.get(), sums.count()), additive);
}

}  // namespace lucarium
