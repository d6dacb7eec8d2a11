// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/reference_cache.h"

#include "lucarium/base/hash.h"
#include "lucarium/compare/metrics.h"
#include "lucarium/version.h"

namespace lucarium {

std::string ReferenceKey::file_name() const {
  Hasher hasher;
  hasher.add(LUCARIUM_VERSION).add(scene_hash).add(camera).add(path_set).add(renderer);
  hasher.add(width).add(height).add(pixel_sampling).add(samples);
  return hasher.finish().hex() + ".exr";
}

std::string describe_camera(const SceneCamera& camera) {
  std::string text = fmt::format("{} {} {} {}", camera.perspective, camera.yfov, camera.xmag, camera.ymag);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) text += fmt::format(" {}", camera.world_from_camera[column][row]);
  }
  return text;
}

void estimate_reference_error(const Film& reference, ReferenceResult& result) {
  const FilmLayer* variance = reference.find("Variance");
  result.error_known = variance != nullptr;
  if (!variance) return;
  const std::vector<float> image = reference.image();
  const double luminance = mean_luminance(image);
  const double floor = 0.01 * luminance * luminance;
  double mse = 0, relmse = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    mse += variance->pixels[i];
    relmse += variance->pixels[i] / (double{image[i]} * image[i] + floor);
  }
  result.mse = mse / static_cast<double>(image.size());
  result.relmse = relmse / static_cast<double>(image.size());
}

}  // namespace lucarium
