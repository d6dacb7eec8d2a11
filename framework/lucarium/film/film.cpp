// SPDX-License-Identifier: Apache-2.0
#include "lucarium/film/film.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

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
  constexpr size_t block = 4096;  // stays in a processor's cache while all layers are added
  std::vector<float> sum(pixel_count() * 3);
  for (size_t first = 0; first < sum.size(); first += block) {
    const size_t end = std::min(first + block, sum.size());
    for (const FilmLayer& layer : layers_) {
      if (!layer.additive) continue;
      for (size_t i = first; i < end; ++i) sum[i] += layer.pixels[i];
    }
  }
  return sum;
}

namespace {

/// Finite, and not below zero where `additive`. By integers and without branches, so that compilers make vectors of it.
bool are_good(std::span<const float> values, bool additive) {
  constexpr uint32_t sign = 0x80000000u, infinite = 0x7f800000u;
  const uint32_t refused = additive ? sign : 0;
  uint32_t bad = 0;
  for (const float value : values) {
    const auto bits = std::bit_cast<uint32_t>(value);
    const uint32_t size = bits & ~sign;
    bad |= static_cast<uint32_t>(size >= infinite) | (bits & refused & (0 - size));
  }
  return bad == 0;
}

}  // namespace

BadPixels Film::count_bad_pixels() const {
  BadPixels bad;
  for (const FilmLayer& layer : layers_) {
    if (are_good(layer.pixels, layer.additive)) continue;
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
