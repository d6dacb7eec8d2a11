// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/light_list.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "lucarium/scene/device/alias_table.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/device/environment_tables.h"
#include "lucarium/scene/device/scene_layout.h"

namespace lucarium {

namespace {

constexpr float pi = glm::pi<float>();

float channel_mean(const glm::vec3& v) { return (v.r + v.g + v.b) / 3.f; }

Light punctual_light(const SceneLight& light, float scene_radius) {
  Light entry{};
  entry.intensity = float4(light.intensity, channel_mean(light_flux(light, scene_radius)));
  entry.position = float4(glm::vec3(light.world_from_light[3]), 0.f);
  const glm::vec3 axis = -glm::vec3(light.world_from_light[2]);
  const glm::vec3 direction = glm::length(axis) > 0 ? glm::normalize(axis) : glm::vec3(0, 0, -1);
  entry.direction = float4(direction, 0.f);
  entry.triangle = LUCARIUM_NONE;
  switch (light.type) {
    case LightType::point: entry.kind = LUCARIUM_LIGHT_POINT; break;
    case LightType::directional: entry.kind = LUCARIUM_LIGHT_DIRECTIONAL; break;
    case LightType::spot: {
      const glm::vec2 ramp = spot_ramp(light);
      entry.kind = LUCARIUM_LIGHT_SPOT;
      entry.direction.w = ramp.x;
      entry.spot_offset = ramp.y;
      entry.spot_cos_outer = std::cos(light.outer_angle);
    }
  }
  return entry;
}

LightBounds punctual_bounds(const Light& light) {
  LightBounds bounds;
  bounds.power = channel_mean(glm::vec3(light.intensity.xyz()));
  if (light.kind != LUCARIUM_LIGHT_POINT) bounds.axis = glm::vec3(light.direction.xyz());
  if (light.kind == LUCARIUM_LIGHT_DIRECTIONAL) return bounds;
  bounds.lower = bounds.upper = glm::vec3(light.position.xyz());
  if (light.kind == LUCARIUM_LIGHT_SPOT) {
    bounds.reach = std::acos(std::clamp(light.spot_cos_outer, -1.f, 1.f));
  } else {
    bounds.spread = pi;
  }
  return bounds;
}

/// power: in one direction [cd].
LightBounds triangle_bounds(const SceneInstance& instance, const Mesh& mesh, const glm::uvec3& t, bool two_sided,
                            float power) {
  const glm::mat4& m = instance.world_from_object;
  const glm::mat3 sizes(glm::abs(glm::vec3(m[0])), glm::abs(glm::vec3(m[1])), glm::abs(glm::vec3(m[2])));
  glm::vec3 corners[3], largest(0);
  for (int i = 0; i < 3; ++i) {
    const glm::vec3& p = mesh.positions[t[i]];
    corners[i] = glm::vec3(m * glm::vec4(p, 1.f));
    largest = glm::max(largest, sizes * glm::abs(p) + glm::abs(glm::vec3(m[3])));
  }
  // The device rounds other than the host does.
  const float rounding = 4e-7f * std::max(largest.x, std::max(largest.y, largest.z));
  LightBounds bounds;
  bounds.lower = glm::min(corners[0], glm::min(corners[1], corners[2])) - rounding;
  bounds.upper = glm::max(corners[0], glm::max(corners[1], corners[2])) + rounding;
  bounds.reach = 0.5f * pi;
  bounds.power = power;
  const glm::dvec3 u(corners[1] - corners[0]), v(corners[2] - corners[0]);
  const glm::dvec3 across = glm::cross(u, v);
  const double area = glm::length(across),
               side = std::max(glm::length(u), std::max(glm::length(v), glm::length(u - v)));
  // By so much may rounding turn a sliver.
  const double turn = area > 0 ? 4 * static_cast<double>(rounding) * side / area : 1;
  bounds.spread = two_sided || turn > 0.5 ? pi : static_cast<float>(turn);
  if (area > 0) bounds.axis = glm::vec3((is_flipped(instance) ? -1.0 : 1.0) / area * across);
  return bounds;
}

double world_area(const glm::mat4& m, const Mesh& mesh, const glm::uvec3& t) {
  const glm::dmat3 linear{glm::mat3(m)};
  const glm::dvec3 a(mesh.positions[t.x]);
  const glm::dvec3 u = linear * (glm::dvec3(mesh.positions[t.y]) - a),
                   v = linear * (glm::dvec3(mesh.positions[t.z]) - a);
  return 0.5 * glm::length(glm::cross(u, v));
}

bool hit_by_rays(const glm::mat4& m, const Mesh& mesh, const glm::uvec3& t) {
  const auto at = [&](uint32_t v) { return glm::vec3(m * glm::vec4(mesh.positions[v], 1.f)); };
  return !is_degenerate(at(t.x), at(t.y), at(t.z));
}

/// Whether there is something to choose by place: many lights, or several kinds.
bool needs_tree(const std::vector<Light>& lights) {
  int with_place = 0;
  uint kinds = 0;
  for (const Light& light : lights) {
    with_place += light.kind != LUCARIUM_LIGHT_DIRECTIONAL && light.kind != LUCARIUM_LIGHT_ENVIRONMENT;
    kinds |= 1u << light.kind;
  }
  return lights.size() <= max_tree_lights && (with_place > few_lights || std::popcount(kinds) > 1);
}

float lamp_reach(const LightList& list) {
  float square = 0;
  for (size_t i = 0; i < list.lights.size(); ++i)
    if (list.lights[i].kind == LUCARIUM_LIGHT_TRIANGLE)
      square = std::max(square, list.lights[i].position.w / (pi * list.table[i].pmf));
  return std::sqrt(square);
}

}  // namespace

std::vector<AliasEntry> light_choice_table(const std::vector<Light>& lights, LightChoice choice,
                                           const std::function<bool(const Light&)>& is_included) {
  double power = 0, count = 0;
  for (const Light& light : lights) {
    if (!is_included(light)) continue;
    power += double{light.intensity.w};
    count += 1;
  }
  const bool even = choice == LightChoice::uniform || !(power > 0);
  std::vector<double> weights;
  weights.reserve(lights.size());
  for (const Light& light : lights) {
    const double weight =
        even ? 1 : (1 - even_light_share) * double{light.intensity.w} / power + even_light_share / count;
    weights.push_back(is_included(light) ? weight : 0);
  }
  return make_alias_table(weights);
}

glm::vec3 light_flux(const SceneLight& light, float scene_radius) {
  if (light.type == LightType::point) return 4 * pi * light.intensity;
  if (light.type == LightType::spot) return static_cast<float>(spot_solid_angle(light)) * light.intensity;
  return pi * scene_radius * scene_radius * light.intensity;
}

void LightListBuilder::add_triangles(const Scene& scene, LightList& list, std::vector<LightBounds>& bounds) {
  EmissionEstimator estimator(scene);
  radiance_.resize(scene.instances.size());
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const SceneInstance& instance = scene.instances[i];
    const SceneMaterial& material = scene.materials[instance.material];
    const Mesh& mesh = instance.shape(scene);
    const size_t first = list.triangle_lights.size();
    list.triangle_lights.resize(first + mesh.triangles.size(), LUCARIUM_NONE);
    if (!material.emits()) continue;
    if (radiance_[i].size() != mesh.triangles.size()) {
      radiance_[i].clear();
      for (const glm::uvec3& t : mesh.triangles) radiance_[i].push_back(estimator.mean_radiance(mesh, t, material));
    }
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (!hit_by_rays(instance.world_from_object, mesh, mesh.triangles[t])) continue;
      const float area = static_cast<float>(world_area(instance.world_from_object, mesh, mesh.triangles[t]));
      const glm::vec3& radiance = radiance_[i][t];
      if (!(area > 0) || radiance == glm::vec3(0)) continue;
      Light entry{};
      const float sides = is_two_sided(material) ? 2.f : 1.f;
      entry.intensity = float4(radiance, sides * pi * area * channel_mean(radiance));
      entry.position.w = area;
      entry.kind = LUCARIUM_LIGHT_TRIANGLE;
      entry.triangle = static_cast<uint>(first + t);
      list.triangle_lights[first + t] = static_cast<uint>(list.lights.size());
      list.lights.push_back(entry);
      bounds.push_back(
          triangle_bounds(instance, mesh, mesh.triangles[t], is_two_sided(material), area * channel_mean(radiance)));
    }
  }
}

LightList LightListBuilder::build(const Scene& scene, float scene_radius, LightChoice choice) {
  LightList list;
  std::vector<LightBounds> bounds;
  for (const SceneLight& light : scene.lights) {
    if (light.intensity == glm::vec3(0)) continue;
    list.lights.push_back(punctual_light(light, scene_radius));
    bounds.push_back(punctual_bounds(list.lights.back()));
  }
  add_triangles(scene, list, bounds);
  if (scene.environment) {
    const glm::vec3 integral = environment_integral(*scene.environment);
    if (channel_mean(integral) > 0) {
      Light entry{};
      entry.intensity = float4(integral / (4 * pi), pi * scene_radius * scene_radius * channel_mean(integral));
      entry.kind = LUCARIUM_LIGHT_ENVIRONMENT;
      entry.triangle = LUCARIUM_NONE;
      list.environment_light = static_cast<uint>(list.lights.size());
      list.lights.push_back(entry);
      bounds.emplace_back().power = 0.25f * channel_mean(integral);  // of all planes, the mean
    }
  }
  list.table = light_choice_table(list.lights, choice, [](const Light&) { return true; });
  list.tree = make_light_tree(list.lights, bounds, choice == LightChoice::tree && needs_tree(list.lights));
  list.reach = lamp_reach(list);
  return list;
}

}  // namespace lucarium
