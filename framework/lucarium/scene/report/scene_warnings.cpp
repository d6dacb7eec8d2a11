// SPDX-License-Identifier: Apache-2.0
// What looks wrong with a scene. Declared in scene_report.h.
#include <fmt/format.h>

#include <algorithm>

#include "lucarium/base/text/text_values.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/device/texture_sampling.h"
#include "lucarium/scene/report/scene_report.h"

namespace lucarium {

namespace {

/// Largest channel of the mean base colour.
float mean_base_color(const Scene& scene, const SceneMaterial& material) {
  glm::vec3 color(material.base_color);
  const int texture_index = material.base_color_texture.texture;
  if (texture_index != none) {
    const SceneTexture& texture = scene.textures[texture_index];
    const Image& image = scene.images[texture.image];
    // A regular subset of at most 64 x 64 texels is enough for a warning.
    const uint32_t columns = std::min(image.width, 64u), rows = std::min(image.height, 64u);
    glm::vec3 sum(0);
    for (uint32_t j = 0; j < rows; ++j) {
      for (uint32_t i = 0; i < columns; ++i) {
        sum += glm::vec3(
            fetch_texel(scene, texture, int64_t{i} * image.width / columns, int64_t{j} * image.height / rows));
      }
    }
    color *= sum / static_cast<float>(rows * columns);
  }
  return std::max({color.r, color.g, color.b});
}

void warn_of_materials(const Scene& scene, std::vector<std::string>& warnings) {
  std::vector<bool> used(scene.materials.size(), false);
  for (const SceneInstance& instance : scene.instances) used[instance.material] = true;
  std::vector<std::string> white, bright, emissive;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const SceneMaterial& material = scene.materials[i];
    if (!used[i]) continue;
    const std::string name = material.name.empty() ? fmt::format("#{}", i) : material.name;
    const glm::vec3& e = material.emissive_factor;
    if (std::min({e.r, e.g, e.b}) < 0 || std::max({e.r, e.g, e.b}) > 1) emissive.push_back(name);
    if (material.unlit || material.transmission > 0) continue;
    const float albedo = mean_base_color(scene, material);
    if (albedo >= 1)
      white.push_back(name);
    else if (albedo > 0.95f)
      bright.push_back(name);
  }
  constexpr const char* advice = "light barely fades there and converges slowly; --material NAME:base_color=0.8 helps";
  if (!white.empty())
    warnings.push_back(fmt::format("base colour 1 (a perfect reflector) in {}: {}", list_names(white), advice));
  if (!bright.empty()) warnings.push_back(fmt::format("base colour above 0.95 in {}: {}", list_names(bright), advice));
  if (!emissive.empty()) {
    warnings.push_back(fmt::format("emissive factor outside 0 to 1 in {}: taken as it is", list_names(emissive)));
  }
}

}  // namespace

std::vector<std::string> scene_warnings(const Scene& scene) {
  std::vector<std::string> warnings = scene.warnings;
  if (!scene.has_light()) {
    warnings.emplace_back("there is no light: give one with --environment or --light");
  }
  warn_of_materials(scene, warnings);

  const Bounds bounds = scene.bounds();
  const glm::vec3 extent = bounds.empty() ? glm::vec3(0) : bounds.max - bounds.min;
  const float largest = std::max({extent.x, extent.y, extent.z});
  constexpr float kilometres = 10'000, centimetre = 0.01f;
  if (largest > kilometres || largest < centimetre) {
    warnings.push_back(
        fmt::format("the scene is {:.4g} m large, which hints at a wrong unit: glTF's unit is the metre", largest));
  }
  const uint64_t degenerate = degenerate_triangle_count(scene);
  if (degenerate) warnings.push_back(fmt::format("without area, never hit: {}", counted(degenerate, "triangle")));
  return warnings;
}

}  // namespace lucarium
