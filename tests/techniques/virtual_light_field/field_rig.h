// SPDX-License-Identifier: Apache-2.0
// A scene and its light field, without the technique around them.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "device_fixture.h"
#include "lucarium/services/bvh/bvh.h"
#include "made_scene.h"
#include "virtual_light_field/field/field_surfaces.h"
#include "virtual_light_field/field/light_field.h"

namespace lucarium::test {

inline double min_of(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }
inline double max_of(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

/// Metal that reflects all light, ideally or by a GGX lobe.
inline SceneMaterial mirror(float reflectance = 1, float roughness = 0) {
  SceneMaterial material;
  material.base_color = glm::vec4(reflectance, reflectance, reflectance, 1);
  material.metallic = 1;
  material.roughness = roughness;
  return material;
}

/// The unit box, walls facing inwards: -x, +x, -y, +y, -z, +z. Walls without a material are left out.
inline Scene unit_box(const std::vector<std::pair<int, SceneMaterial>>& walls) {
  Scene scene;
  for (const auto& [wall, material] : walls) {
    const int axis = wall / 2;
    const float at = static_cast<float>(wall % 2);
    std::vector<glm::vec3> corners;
    for (const glm::vec2 c : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
      glm::vec3 p(0);
      p[axis] = at;
      p[(axis + 1) % 3] = c.x;
      p[(axis + 2) % 3] = c.y;
      corners.push_back(p);
    }
    if (wall % 2 == 1) std::swap(corners[1], corners[3]);
    add_polygon(scene, corners, add_material(scene, material));
  }
  return scene;
}

class FieldRig {
 public:
  struct Options {
    int max_bounces = -1;
    uint64_t seed = 1;
    uint32_t light_samples = 64;  ///< per texel side, at least
    size_t cache_bytes = 0;       ///< for kept fragments, instead of cache_visibility
    bool preview = false;         ///< instead of the parameter
  };
  FieldRig(Scene scene, const vlf::Parameters& parameters) : FieldRig(std::move(scene), parameters, Options()) {}
  FieldRig(Scene scene, const vlf::Parameters& parameters, const Options& options)
      : scene_(std::move(scene)),
        parameters_(parameters),
        options_(options),
        device_(test_device()),
        scheduler_(device_),
        buffers_(*device_, scene_),
        bvh_(*device_, scene_, buffers_),
        plan_(vlf::make_plan(parameters, scene_, settings(options))),
        surfaces_(*device_, scheduler_, scene_, buffers_, bvh_, parameters_, plan_, [](double, const std::string&) {}) {
    surfaces_.measure([](double, const std::string&) {});
    surfaces_.light.reset(static_cast<uint32_t>(options.seed));
    if (plan_.light_kinds != 0)
      for (uint64_t drawn = 0; drawn < uint64_t{options.light_samples} * sides();
           drawn += 65536 < sides() ? 65536 : sides()) {
        surfaces_.light.sample();
        surfaces_.light.commit();
      }
    restart();
  }

  /// Another field on the same surfaces, of which nothing is propagated yet.
  void restart() {
    field_.reset();
    vlf::LightField::Options field = vlf::field_options(plan_, parameters_);
    field.subfield = surfaces_.subfield;
    field.seed = options_.seed;
    field.line_seed = static_cast<uint32_t>(options_.seed);
    field.scatter_last = true;
    field.preview = options_.preview;
    if (options_.cache_bytes > 0) field.cache = options_.cache_bytes;
    field_ = std::make_unique<vlf::LightField>(*device_, scheduler_, scene_, buffers_, bvh_, surfaces_.atlas,
                                               surfaces_.patches, surfaces_.raster, surfaces_.interior,
                                               surfaces_.accessibility, surfaces_.light.light_samples(), field);
  }

  /// To its end, or to so many sweeps.
  void propagate(uint32_t sweeps = UINT32_MAX) {
    const bool all = sweeps == UINT32_MAX;
    while (!field_->done() && field_->sweeps() < sweeps) all ? field_->advance() : field_->advance(1);
    scheduler_.finish();
  }

  uint32_t sides() const { return surfaces_.atlas.info().texel_count; }
  const vlf::LightField& field() const { return *field_; }
  vlf::LightField& field() { return *field_; }
  const vlf::FieldSurfaces& surfaces() const { return surfaces_; }
  const Scene& scene() const { return scene_; }
  Device& device() { return *device_; }
  KernelScheduler& scheduler() { return scheduler_; }
  const SceneBuffers& buffers() const { return buffers_; }
  const Bvh& bvh() const { return bvh_; }

  /// Of the triangle behind each texel side.
  std::vector<uint32_t> instances() const {
    const std::vector<Triangle> triangles = buffers_.scene_triangles.download();
    std::vector<uint32_t> result;
    for (const AtlasTexel& texel : surfaces_.atlas.texels().download())
      result.push_back(triangles[texel.triangle].instance);
    return result;
  }

  /// What every cell sends of all light, red; 0 where a cell shows nothing.
  std::vector<double> cells() const {
    const std::vector<uint32_t> total = field_->total().download(), direct = field_->direct().download();
    std::vector<double> result(total.size(), 0);
    for (size_t cell = 0; cell < total.size(); ++cell) {
      if (total[cell] == FIELD_NO_CELL) continue;
      const auto red = [](uint32_t bits) {
        return static_cast<double>(bits & 511) * std::exp2(static_cast<double>(bits >> 27) - 24);
      };
      result[cell] =
          (red(total[cell]) + (field_->split() ? red(direct[cell]) : 0)) / static_cast<double>(field_->scale());
    }
    return result;
  }

  /// e of every texel side, red: all of it, direct, or that of later sweeps.
  std::vector<double> all() const { return sum(direct(), indirect()); }
  std::vector<double> direct() const { return red(field_->shown_direct()); }
  std::vector<double> indirect() const { return red(field_->shown()); }

  /// Mean by area of the texel sides of an instance; of two halves by what each of them counts.
  double mean(const std::vector<double>& values, int instance) const {
    const std::vector<AtlasTexel> texels = surfaces_.atlas.texels().download();
    const std::vector<Triangle> triangles = buffers_.scene_triangles.download();
    const std::vector<float> shares = surfaces_.accessibility.shares().download();
    double sum = 0, area = 0;
    for (uint32_t side = 0; side < sides(); ++side) {
      if (triangles[texels[side].triangle].instance != static_cast<uint32_t>(instance)) continue;
      double value = values[side];
      if (values.size() > sides()) {
        const auto open = static_cast<double>(shares[side]), covered = static_cast<double>(shares[sides() + side]);
        if (open + covered > 0) value = (open * value + covered * values[sides() + side]) / (open + covered);
      }
      sum += static_cast<double>(texels[side].area) * value;
      area += static_cast<double>(texels[side].area);
    }
    return sum / area;
  }
  /// Values of the texel sides of an instance.
  std::vector<double> of_instance(const std::vector<double>& values, int instance) const {
    const std::vector<AtlasTexel> texels = surfaces_.atlas.texels().download();
    const std::vector<Triangle> triangles = buffers_.scene_triangles.download();
    std::vector<double> result;
    for (uint32_t side = 0; side < sides(); ++side)
      if (triangles[texels[side].triangle].instance == static_cast<uint32_t>(instance)) result.push_back(values[side]);
    return result;
  }

 private:
  static RenderSettings settings(const Options& options) {
    RenderSettings result;
    result.width = result.height = 16;
    result.max_bounces = options.max_bounces;
    result.seed = options.seed;
    return result;
  }
  static std::vector<double> red(const TypedBuffer<float4>& values) {
    std::vector<double> result;
    for (const float4& v : values.download()) result.push_back(v.w > 0 ? static_cast<double>(v.x / v.w) : 0.);
    return result;
  }
  static std::vector<double> sum(std::vector<double> a, const std::vector<double>& b) {
    for (size_t i = 0; i < a.size(); ++i) a[i] += b[i];
    return a;
  }
  Scene scene_;
  vlf::Parameters parameters_;
  Options options_;
  std::shared_ptr<Device> device_;
  KernelScheduler scheduler_;
  SceneBuffers buffers_;
  Bvh bvh_;
  vlf::Plan plan_;
  vlf::FieldSurfaces surfaces_;
  std::unique_ptr<vlf::LightField> field_;
};

}  // namespace lucarium::test
