// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/light_list.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "lucarium/scene/device/alias_table.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/device/environment_tables.h"

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
  if (light.kind == LUCARIUM_LIGHT_DIRECTIONAL) return bounds;
  bounds.lower = bounds.upper = glm::vec3(light.position.xyz());
  if (light.kind == LUCARIUM_LIGHT_SPOT) {
    bounds.axis = glm::vec3(light.direction.xyz());
    bounds.reach = std::acos(std::clamp(light.spot_cos_outer, -1.f, 1.f));
  } else {
    bounds.spread = pi;
  }
  return bounds;
}

LightBounds triangle_bounds(const glm::mat4& m, const Mesh& mesh, const glm::uvec3& t, bool two_sided, float power) {
  const auto at = [&](uint32_t v) { return glm::vec3(m * glm::vec4(mesh.positions[v], 1.f)); };
  const glm::vec3 a = at(t.x), b = at(t.y), c = at(t.z);
  LightBounds bounds;
  bounds.lower = glm::min(a, glm::min(b, c));
  bounds.upper = glm::max(a, glm::max(b, c));
  const glm::vec3 normal = glm::normalize(glm::cross(b - a, c - a));
  bounds.axis = glm::determinant(glm::mat3(m)) < 0 ? -normal : normal;
  bounds.spread = two_sided ? pi : 0;
  bounds.reach = 0.5f * pi;
  bounds.power = power;
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

void LightListBuilder::add_triangles(const Scene& scene, LightList& list) {
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
      list.bounds.push_back(triangle_bounds(instance.world_from_object, mesh, mesh.triangles[t], is_two_sided(material),
                                            area * channel_mean(radiance)));
    }
  }
}

LightList LightListBuilder::build(const Scene& scene, float scene_radius, LightChoice choice) {
  LightList list;
  for (const SceneLight& light : scene.lights) {
    if (light.intensity == glm::vec3(0)) continue;
    list.lights.push_back(punctual_light(light, scene_radius));
    list.bounds.push_back(punctual_bounds(list.lights.back()));
  }
  add_triangles(scene, list);
  if (scene.environment) {
    const glm::vec3 integral = environment_integral(*scene.environment);
    if (channel_mean(integral) > 0) {
      Light entry{};
      entry.intensity = float4(integral / (4 * pi), pi * scene_radius * scene_radius * channel_mean(integral));
      entry.kind = LUCARIUM_LIGHT_ENVIRONMENT;
      entry.triangle = LUCARIUM_NONE;
      list.environment_light = static_cast<uint>(list.lights.size());
      list.lights.push_back(entry);
      list.bounds.emplace_back().power = channel_mean(integral);
    }
  }
  list.table = light_choice_table(list.lights, choice, [](const Light&) { return true; });
  const auto has_place = [](const Light& light) {
    return light.kind != LUCARIUM_LIGHT_DIRECTIONAL && light.kind != LUCARIUM_LIGHT_ENVIRONMENT;
  };
  const auto with_place = std::count_if(list.lights.begin(), list.lights.end(), has_place);
  list.tree = make_light_tree(list.lights, list.bounds, choice == LightChoice::tree && with_place > few_lights);
  list.reach = lamp_reach(list);
  return list;
}

}  // namespace lucarium
