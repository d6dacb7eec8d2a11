// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace lucarium {

/// One named image of the film: interleaved floats, rows from the top.
struct FilmLayer {
  std::string name;                   ///< "direct", "Albedo", "micro_buffer"
  std::vector<std::string> channels;  ///< {"R","G","B"}, {"X","Y","Z"}, {"Y"}
  std::vector<float> pixels;          ///< width · height · channels
  bool additive = false;              ///< part of the sum that is the image (emission, direct, indirect)
};

/// Non-finite or negative pixels, found by Film::count_bad_pixels().
struct BadPixels {
  uint64_t nan = 0, infinite = 0, negative = 0;
  uint64_t first_x = 0, first_y = 0;
  std::string first_layer;
  uint64_t total() const { return nan + infinite + negative; }
};

/// The result of a technique: linear Rec.709 radiance layers [cd/m²] and any further named layers. The image is the sum
/// of the additive layers. Host memory; metadata is written into EXR headers and results.
class Film {
 public:
  Film(uint32_t width, uint32_t height);
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  size_t pixel_count() const { return size_t{width_} * height_; }

  /// Adds or returns the layer; throws Error{internal} if it exists with other channels.
  FilmLayer& layer(const std::string& name, const std::vector<std::string>& channels = {"R", "G", "B"},
                   bool additive = false);
  const FilmLayer* find(std::string_view name) const;
  const std::deque<FilmLayer>& layers() const { return layers_; }

  /// Sum of the additive layers, 3 floats per pixel.
  std::vector<float> image() const;
  BadPixels count_bad_pixels() const;

  std::map<std::string, std::string> metadata;  ///< technique, parameters, scene_hash, samples, seconds, seed, …

 private:
  uint32_t width_, height_;
  std::deque<FilmLayer> layers_;  // references to layers stay valid
};

}  // namespace lucarium
