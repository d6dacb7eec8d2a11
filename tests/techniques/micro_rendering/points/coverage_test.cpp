// SPDX-License-Identifier: Apache-2.0
// How much of a triangle its alpha leaves, against many points.
#include "micro_rendering/points/coverage.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "lucarium/scene/device/texture_sampling.h"
#include "micro_rendering/points/point_sampling.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::micro;

namespace {

/// Blobs on 64 × 48 texels.
Scene scene_with_alpha(Wrap wrap_u, Wrap wrap_v, AlphaMode mode) {
  Scene scene;
  Image image;
  image.width = 64, image.height = 48;
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const double value = 0.5 + 0.3 * std::sin(0.4 * x + 1) + 0.2 * std::cos(0.37 * y - 0.1 * x);
      for (int c = 0; c < 4; ++c) image.rgba.push_back(static_cast<uint8_t>(255 * value));
    }
  }
  scene.images.push_back(image);
  SceneTexture texture;
  texture.image = 0, texture.wrap_u = wrap_u, texture.wrap_v = wrap_v;
  scene.textures.push_back(texture);
  SceneMaterial material;
  material.base_color_texture.texture = 0;
  material.alpha_mode = mode;
  material.alpha_cutoff = 0.4f;
  scene.materials.push_back(material);
  return scene;
}

double mean_of_points(const Scene& scene, const std::array<glm::vec2, 3>& at) {
  constexpr int grid = 400;
  double sum = 0;
  int count = 0;
  for (int i = 0; i < grid; ++i) {
    for (int j = 0; i + j < grid; ++j, ++count) {
      const float b = (static_cast<float>(i) + 1 / 3.f) / grid, c = (static_cast<float>(j) + 1 / 3.f) / grid;
      const float alpha = sample_texture(scene, scene.textures[0], (1 - b - c) * at[0] + b * at[1] + c * at[2]).a;
      sum += scene.materials[0].alpha_mode == AlphaMode::mask ? alpha >= 0.4f : static_cast<double>(alpha);
    }
  }
  return sum / count;
}

}  // namespace

TEST_CASE("coverage is the mean over the triangle, however its texture is wrapped") {
  std::mt19937 random(3);
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp}) {
    for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
      const Scene scene = scene_with_alpha(wrap, wrap == Wrap::mirror ? Wrap::repeat : wrap, mode);
      const CoverageMap map(scene, scene.materials[0], 1, 1);
      for (const float size : {0.1f, 0.7f, 3.f}) {
        constexpr int triangles = 12;
        std::uniform_real_distribution<float> offset(-2, 2), corner(0, size);
        double error = 0, squares = 0;
        for (int k = 0; k < triangles; ++k) {
          const glm::vec2 from(offset(random), offset(random));
          std::array<glm::vec2, 3> at;
          for (glm::vec2& p : at) p = from + glm::vec2(corner(random), corner(random));
          const double difference = static_cast<double>(map.mean(at)) - mean_of_points(scene, at);
          error += difference / triangles, squares += difference * difference / triangles;
        }
        CAPTURE(static_cast<int>(wrap));
        CAPTURE(static_cast<int>(mode));
        CAPTURE(size);
        // Rims of blobs are known to half a cell, an eighth of a texel; the smallest triangles have about 3 × 2 texels.
        const double rims = mode == AlphaMode::blend ? 0.01 : size < 0.5f ? 0.04 : size < 1 ? 0.015 : 0.005;
        CHECK(std::sqrt(squares) < rims);
        CHECK(std::abs(error) < 0.5 * rims);
      }
    }
  }
}

TEST_CASE("coverage of triangles that are thin in their texture") {
  const Scene scene = scene_with_alpha(Wrap::repeat, Wrap::repeat, AlphaMode::mask);
  const CoverageMap map(scene, scene.materials[0], 1, 1);
  const std::array<glm::vec2, 3> flat = {glm::vec2(0.1f, 0.3f), {0.9f, 0.302f}, {0.9f, 0.3f}};
  const std::array<glm::vec2, 3> upright = {glm::vec2(0.3f, 0.1f), {0.302f, 0.9f}, {0.3f, 0.9f}};
  CHECK(std::abs(static_cast<double>(map.mean(flat)) - mean_of_points(scene, flat)) < 0.02);
  CHECK(std::abs(static_cast<double>(map.mean(upright)) - mean_of_points(scene, upright)) < 0.02);
  CHECK(map.mean({glm::vec2(0.5f), glm::vec2(0.5f), glm::vec2(0.5f)}) < 0);  // no area
}

TEST_CASE("where little is covered no point lies beside it") {
  // 1 % of the triangle's area, next to its first corner.
  const std::vector<SurfaceSide> sides = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0, 0.01f}};
  const auto corner = [](const void*, uint32_t, glm::vec2 weights, float) { return weights.x + weights.y < 0.1f; };
  const SampledSurface sampled = sample_surface(sides, 1 << 10, 3, 1, corner, nullptr);
  CHECK(sampled.area == test::relative(0.005));
  for (const SampledPoint& p : sampled.points) CHECK(p.weights.x + p.weights.y < 0.1f);
}
