// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/film/film.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium {

/// The charts of an atlas packed into a picture, one pixel per cell, like a lightmap. Only for looking at atlases and
/// for exporting what a technique keeps in one: kernels look texels up in the table.
class SurfaceAtlasImage {
 public:
  /// Reads the look-up table back from the device. Throws Error{usage} when the picture would be too large.
  explicit SurfaceAtlasImage(const SurfaceAtlas& atlas);

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  /// Adds values (one per texel side, xyz) as a layer: fronts, or with `backs` the backs of double-sided texels; 0
  /// where there is nothing. Around a chart lie the texels beyond its smooth seams, elsewhere in its rectangle the
  /// nearest texel's values.
  void add_layer(Film& film, const std::string& name, const std::vector<float4>& values, bool backs = false) const;
  /// The atlas itself: `atlas` (texel sides as colours; the picture), Albedo, Emission, P, N, Area [m²].
  Film draw(const SurfaceAtlas& atlas) const;

 private:
  uint32_t width_ = 0, height_ = 0;
  AtlasInfo info_{};
  std::vector<uint32_t> texels_;  ///< per pixel, rows from the top: texel or LUCARIUM_NONE
};

}  // namespace lucarium
