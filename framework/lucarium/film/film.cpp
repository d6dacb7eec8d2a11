// SPDX-License-Identifier: Apache-2.0
#include "lucarium/film/film.h"

#include <cmath>

#include "lucarium/base/error.h"

namespace lucarium {

Film::Film(uint32_t width, uint32_t height) : width_(width), height_(height) {}

FilmLayer& Film::layer(const std::string& name, const std::vector<std::string>& channels, bool additive) {
  for (FilmLayer& existing : layers_) {
    if (existing.name != name) continue;
    if (existing.channels != channels) {
      throw_error(ErrorClass::internal, "film layer {} exists with {} channels, not {}", name, existing.channels.size(),
                  channels.size());
    }
    return existing;
  }
  layers_.push_back({name, channels, std::vector<float>(pixel_count() * channels.size()), additive});
  return layers_.back();
}

const FilmLayer* Film::find(std::string_view name) const {
  for (const FilmLayer& layer : layers_) {
    if (layer.name == name) return &layer;
  }
  return nullptr;
}

std::vector<float> Film::image() const {
  std::vector<float> sum(pixel_count() * 3);
  for (const FilmLayer& layer : layers_) {
    if (!layer.additive) continue;
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += layer.pixels[i];
  }
  return sum;
}

BadPixels Film::count_bad_pixels() const {
  BadPixels bad;
  for (const FilmLayer& layer : layers_) {
    for (size_t i = 0; i < layer.pixels.size(); ++i) {
      const float value = layer.pixels[i];
      if (std::isfinite(value) && (value >= 0 || !layer.additive)) continue;
      if (bad.total() == 0) {
        const size_t pixel = i / layer.channels.size();
        bad.first_x = pixel % width_;
        bad.first_y = pixel / width_;
        bad.first_layer = layer.name;
      }
      (std::isnan(value) ? bad.nan : std::isinf(value) ? bad.infinite : bad.negative) += 1;
    }
  }
  return bad;
}

}  // namespace lucarium
