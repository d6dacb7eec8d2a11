// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/image.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lucarium/base/error.h"

namespace lucarium {
namespace {

constexpr uint64_t max_pixels = 1u << 28;

}  // namespace

// Charts in shelves, highest first.
SurfaceAtlasImage::SurfaceAtlasImage(const SurfaceAtlas& atlas) : info_(atlas.info()) {
  const std::vector<AtlasChart>& charts = atlas.charts();
  std::vector<uint32_t> order(charts.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return charts[a].height != charts[b].height ? charts[a].height > charts[b].height
                                                : charts[a].width > charts[b].width;
  });
  uint32_t widest = 1;
  for (const AtlasChart& chart : charts) widest = std::max(widest, chart.width);
  width_ = std::max(widest, static_cast<uint32_t>(std::ceil(std::sqrt(1.05 * double(info_.cell_count)))));
  std::vector<uint2> corner(charts.size());
  uint32_t x = 0, y = 0, shelf = 0;
  for (const uint32_t c : order) {
    if (x + charts[c].width > width_) y += shelf, x = 0, shelf = 0;
    corner[c] = {x, y};
    x += charts[c].width;
    shelf = std::max(shelf, charts[c].height);
  }
  height_ = std::max(1u, y + shelf);
  if (uint64_t{width_} * height_ > max_pixels) {
    throw_error(ErrorClass::usage, "a picture of the atlas would have {}x{} pixels: ask for fewer texels", width_,
                height_);
  }
  texels_.assign(size_t{width_} * height_, LUCARIUM_NONE);
  const std::vector<uint32_t> table = atlas.table().download();
  for (size_t c = 0; c < charts.size(); ++c) {
    for (uint32_t row = 0; row < charts[c].height; ++row) {
      const auto from = table.begin() + charts[c].first_cell + size_t{row} * charts[c].width;
      std::copy(from, from + charts[c].width, texels_.begin() + (size_t{corner[c].y} + row) * width_ + corner[c].x);
    }
  }
}

void SurfaceAtlasImage::add_layer(Film& film, const std::string& name, const std::vector<float4>& values,
                                  bool backs) const {
  if (values.size() != info_.texel_count || film.width() != width_ || film.height() != height_) {
    throw Error(ErrorClass::internal, "SurfaceAtlasImage: values or film are of another size");
  }
  FilmLayer& layer = film.layer(name);
  layer.pixels.assign(texels_.size() * 3, 0.f);
  for (size_t i = 0; i < texels_.size(); ++i) {
    uint32_t side = texels_[i];
    if (side == LUCARIUM_NONE || (backs && side >= info_.double_sided_count)) continue;
    if (backs) side += info_.double_sided_count;
    const float4& value = values[side];
    layer.pixels[3 * i] = value.x, layer.pixels[3 * i + 1] = value.y, layer.pixels[3 * i + 2] = value.z;
  }
}

Film SurfaceAtlasImage::draw(const SurfaceAtlas& atlas) const {
  Film film(width_, height_);
  film.layer("atlas").additive = true;
  const std::vector<AtlasTexel> texels = atlas.texels().download();
  const std::vector<SurfacePoint> points = atlas.surface_points().download();
  const std::vector<AtlasMaterial> materials = atlas.materials().download();
  const auto add = [&](const char* name, const auto& value_of) {
    std::vector<float4> values(texels.size());
    for (uint32_t side = 0; side < values.size(); ++side) values[side] = value_of(side);
    add_layer(film, name, values);
  };
  add_layer(film, "atlas", atlas.side_colors());
  add("Albedo", [&](uint32_t side) { return materials[side].diffuse; });
  add("Emission", [&](uint32_t side) { return materials[side].emission; });
  add("P", [&](uint32_t side) { return points[side].position; });
  add("N", [&](uint32_t side) { return points[side].normal; });
  add("Area", [&](uint32_t side) { return float4(texels[side].area, texels[side].area, texels[side].area, 0.f); });
  return film;
}

}  // namespace lucarium
