// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/layer_sums/layer_sums.h"

#include <algorithm>

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
  for (size_t i = 0; i < names_.size(); ++i)
    add_mean(film, names_[i], forgotten_ ? std::vector<float4>(film.pixel_count()) : sums_[i].download(), additive);
}

void add_mean(Film& film, const std::string& name, const std::vector<float4>& sums, bool additive) {
  if (sums.size() != film.pixel_count())
    throw_error(ErrorClass::internal, "{} sums for a film of {} pixels", sums.size(), film.pixel_count());
  FilmLayer& layer = film.layer(name, {"R", "G", "B"}, additive);
  for (size_t p = 0; p < sums.size(); ++p) {
    const float scale = sums[p].w > 0 ? 1 / sums[p].w : 0.f;
    for (size_t c = 0; c < 3; ++c) layer.pixels[3 * p + c] += (&sums[p].x)[c] * scale;
  }
}

}  // namespace lucarium
