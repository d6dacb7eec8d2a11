// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/points/coverage.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/parallel.h"
#include "lucarium/scene/device/texture_sampling.h"
#include "micro_rendering/points/scene_sides.h"

namespace lucarium::micro {
namespace {

constexpr int64_t kMaxCells = 1 << 22;        // up to which an image has as many as 4 × 4 per texel
constexpr int kMinRows = 8, kMaxRows = 4096;  // along which a triangle is summed
// Points per edge of a triangle at which coverage is looked up where no map holds it: two per texel, within these.
constexpr int kMinGrid = 4, kMaxGrid = 128;

float covered(const SceneMaterial& material, float alpha) {
  if (material.alpha_mode == AlphaMode::mask) return alpha >= material.alpha_cutoff ? 1.f : 0.f;
  return std::clamp(alpha, 0.f, 1.f);
}

/// Cell that stands for cell i, which may lie outside.
int64_t wrapped(int64_t i, int64_t size, Wrap mode) {
  if (mode == Wrap::clamp) return std::clamp<int64_t>(i, 0, size - 1);
  const int64_t period = mode == Wrap::repeat ? size : 2 * size, folded = (i % period + period) % period;
  return folded < size ? folded : period - 1 - folded;
}

}  // namespace

CoverageMap::CoverageMap(const Scene& scene, const SceneMaterial& material, float factor, int threads) {
  const SceneTexture& texture = scene.textures[static_cast<size_t>(material.base_color_texture.texture)];
  const Image& image = scene.images[static_cast<size_t>(texture.image)];
  int64_t cells = 4;  // per texel's edge
  while (cells > 1 && cells * cells * image.width * image.height > kMaxCells) cells /= 2;
  wrap_u_ = texture.wrap_u, wrap_v_ = texture.wrap_v;
  width_ = cells * image.width, height_ = cells * image.height;
  sums_.resize(static_cast<size_t>((width_ + 1) * height_));
  parallel_for(static_cast<uint32_t>(height_), threads, [&](uint32_t row) {
    float* const sums = sums_.data() + static_cast<size_t>(row) * static_cast<size_t>(width_ + 1);
    for (int64_t i = 0; i < width_; ++i) {
      const glm::vec2 at((static_cast<float>(i) + 0.5f) / static_cast<float>(width_),
                         (static_cast<float>(row) + 0.5f) / static_cast<float>(height_));
      sums[i + 1] = sums[i] + covered(material, factor * sample_texture(scene, texture, at).a);
    }
  });
}

/// Sum over the cells of a row from 0 to x, below 0 for x < 0; of parts of a cell in proportion.
double CoverageMap::sum_to(size_t row, double x) const {
  const float* const sums = sums_.data() + row * static_cast<size_t>(width_ + 1);
  const auto within = [&](double at) {
    const auto i = static_cast<int64_t>(std::clamp(at, 0.0, static_cast<double>(width_ - 1)));
    const double before = static_cast<double>(sums[i]);
    return before +
           (at - static_cast<double>(i)) * (static_cast<double>(sums[i + 1]) - before);  // goes on beyond the ends
  };
  if (wrap_u_ == Wrap::clamp) return within(x);
  const double all = static_cast<double>(sums[width_]), size = static_cast<double>(width_);
  const double turns = std::floor(x / size), rest = x - turns * size;
  const bool mirrored = wrap_u_ != Wrap::repeat && std::fmod(std::abs(turns), 2) == 1;
  return turns * all + (mirrored ? all - within(size - rest) : within(rest));
}

float CoverageMap::mean(const std::array<glm::vec2, 3>& at) const {
  std::array<glm::dvec2, 3> p;
  for (size_t k = 0; k < 3; ++k) p[k] = glm::dvec2(at[k]) * glm::dvec2(width_, height_);
  std::sort(p.begin(), p.end(), [](const glm::dvec2& a, const glm::dvec2& b) { return a.y < b.y; });
  const double height = p[2].y - p[0].y;
  if (!(height > 1e-9) || !(height < 1e9)) return -1;
  const int rows = std::clamp(static_cast<int>(std::ceil(height)), kMinRows, kMaxRows);
  double sum = 0, length = 0;
  for (int k = 0; k < rows; ++k) {
    const double y = p[0].y + height * (k + 0.5) / rows;
    const glm::dvec2 &from = y < p[1].y ? p[0] : p[1], &to = y < p[1].y ? p[1] : p[2];
    const double x0 = p[0].x + (p[2].x - p[0].x) * (y - p[0].y) / height;
    const double x1 = to.y > from.y ? from.x + (to.x - from.x) * (y - from.y) / (to.y - from.y) : from.x;
    const auto row = static_cast<size_t>(wrapped(static_cast<int64_t>(std::floor(y)), height_, wrap_v_));
    sum += std::abs(sum_to(row, x1) - sum_to(row, x0));
    length += std::abs(x1 - x0);
  }
  return length > 1e-9 ? static_cast<float>(std::clamp(sum / length, 0.0, 1.0)) : -1.f;
}

TriangleCoverage::Key TriangleCoverage::key_of(const SceneMaterial& material) {
  return {material.base_color_texture.texture, material.alpha_mode, material.base_color.a, material.alpha_cutoff};
}

TriangleCoverage::TriangleCoverage(const ScenePoints& points, int threads) : points_(points) {
  for (const SceneInstance& instance : points.scene->instances) {
    const SceneMaterial& material = points.scene->materials[static_cast<size_t>(instance.material)];
    if (material.alpha_mode == AlphaMode::opaque || material.base_color_texture.texture == none) continue;
    const Key key = key_of(material);
    if (!maps_.contains(key)) maps_.try_emplace(key, *points.scene, material, material.base_color.a, threads);
  }
}

float TriangleCoverage::operator()(uint32_t triangle) const {
  const SceneMaterial& material = points_.material(triangle);
  if (material.alpha_mode == AlphaMode::opaque) return 1;
  const auto map = maps_.find(key_of(material));
  std::array<glm::vec2, 3> at;
  if (map != maps_.end() && points_.alpha_corners(triangle, at)) {
    if (const float mean = map->second.mean(at); mean >= 0) return mean;
  }
  return mean_of_points(triangle);
}

/// Over a grid of points.
float TriangleCoverage::mean_of_points(uint32_t triangle) const {
  const SceneMaterial& material = points_.material(triangle);
  float sum = 0;
  int count = 0;
  const int grid = std::clamp(static_cast<int>(std::ceil(2 * points_.texels(triangle))), kMinGrid, kMaxGrid);
  const float step = 1 / static_cast<float>(grid);
  for (int i = 0; i < grid; ++i) {
    for (int j = 0; i + j < grid; ++j, ++count) {
      const glm::vec2 weights((static_cast<float>(i) + 1 / 3.f) * step, (static_cast<float>(j) + 1 / 3.f) * step);
      sum += covered(material, points_.alpha(triangle, weights));
    }
  }
  return sum / static_cast<float>(count);
}

}  // namespace lucarium::micro
