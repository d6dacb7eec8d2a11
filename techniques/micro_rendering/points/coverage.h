// SPDX-License-Identifier: Apache-2.0
// How much of a triangle is there, by the alpha of its material.
#pragma once
#include <array>
#include <glm/vec2.hpp>
#include <map>
#include <tuple>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium::micro {

struct ScenePoints;

/// Coverage of a material's alpha texture: cells, and their sums along rows, so that the mean over a triangle costs as
/// many steps as it has rows.
class CoverageMap {
 public:
  /// `factor`: of the texture's alpha.
  CoverageMap(const Scene& scene, const SceneMaterial& material, float factor, int threads);
  /// Mean over the triangle of these texture coordinates [1]; below 0 where it has no area there.
  float mean(const std::array<glm::vec2, 3>& at) const;

 private:
  double sum_to(size_t row, double x) const;
  Wrap wrap_u_, wrap_v_;
  int64_t width_, height_;   ///< cells
  std::vector<float> sums_;  ///< rows of width_ + 1: of the cells before
};

/// Coverage of a scene's triangles.
class TriangleCoverage {
 public:
  TriangleCoverage(const ScenePoints& points, int threads);
  /// Mean coverage of a triangle [1]. From several threads.
  float operator()(uint32_t triangle) const;

 private:
  using Key = std::tuple<int, AlphaMode, float, float>;  ///< texture, mode, alpha's factor, cutoff
  static Key key_of(const SceneMaterial& material);
  float mean_of_points(uint32_t triangle) const;
  const ScenePoints& points_;
  std::map<Key, CoverageMap> maps_;
};

}  // namespace lucarium::micro
