// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/scene_report.h"

#include <fmt/ranges.h>

#include <glm/gtc/constants.hpp>
#include <nlohmann/json.hpp>

#include "lucarium/compute/byte_size.h"
#include "lucarium/scene/environment_tables.h"
#include "lucarium/scene/light_list.h"
#include "lucarium/scene/scene_buffers.h"
#include "lucarium/scene/scene_need.h"

namespace lucarium {

namespace {


nlohmann::json to_json(const glm::vec3& v) { return {v.x, v.y, v.z}; }
nlohmann::json to_json(const Bounds& b) { return {{"min_m", to_json(b.min)}, {"max_m", to_json(b.max)}}; }

std::string triple(const glm::vec3& v) { return fmt::format("{:.4g} {:.4g} {:.4g}", v.x, v.y, v.z); }

const char* type_name(LightType type) {
  return type == LightType::point ? "point" : type == LightType::spot ? "spot" : "directional";
}

const char* alpha_name(AlphaMode mode) {
  return mode == AlphaMode::opaque ? "opaque" : mode == AlphaMode::mask ? "mask" : "blend";
}

glm::vec3 camera_position(const SceneCamera& camera) { return glm::vec3(camera.world_from_camera[3]); }

void add_emission(const Scene& scene, SceneReport& report) {
  const float radius = report.bounds.radius();
  for (const SceneLight& light : scene.lights) {
    report.lamps.push_back({light.name, type_name(light.type), light.intensity, light_flux(light, radius),
                            glm::vec3(light.world_from_light[3]), -glm::vec3(light.world_from_light[2])});
  }
  LightListBuilder builder;
  glm::dvec3 flux(0);
  for (const Light& light : builder.build(scene, radius, LightChoice::power).lights) {
    if (light.kind != LUCARIUM_LIGHT_TRIANGLE) continue;
    const glm::dvec3 radiance(light.intensity.xyz());
    ++report.emissive_triangles;
    report.emissive_area += static_cast<double>(light.position.w);
    flux += radiance * (3 * static_cast<double>(light.intensity.w) / (radiance.x + radiance.y + radiance.z));
  }
  report.emissive_flux = glm::vec3(flux);
  if (!scene.environment) return;
  report.has_environment = true;
  report.environment_width = scene.environment->width;
  report.environment_height = scene.environment->height;
  report.environment_radiance = environment_integral(*scene.environment) / (4 * glm::pi<float>());
}

}  // namespace

SceneReport make_scene_report(const Scene& scene) {
  SceneReport report;
  report.source = scene.source;
  report.triangles = scene.triangle_count();
  report.instances = scene.instances.size();
  report.meshes = scene.meshes.size();
  report.textures = scene.textures.size();
  report.images = scene.images.size();
  report.texels = texel_count(scene);
  report.skins = scene.skins.size();
  for (const SceneInstance& instance : scene.instances) {
    report.vertices += scene.meshes[instance.mesh].positions.size();
    report.degenerate_triangles += degenerate_triangle_count(instance.shape(scene));
    report.deformed_instances += instance.pose != nullptr;
  }
  report.materials = scene.materials;
  report.cameras = scene.cameras;
  report.animations = scene.animations;
  report.bounds = scene.bounds();
  report.extensions_used = scene.extensions_used;
  report.extensions_ignored = scene.extensions_ignored;
  report.device_bytes = SceneBuffers::estimate_bytes(scene);
  report.warnings = scene_warnings(scene);
  add_emission(scene, report);
  return report;
}

std::string SceneReport::text() const {
  std::string out;
  const auto line = [&](fmt::string_view label, const std::string& value) {
    out += fmt::format("{:<14}{}\n", label, value);
  };
  line("scene", source);
  line("triangles", fmt::format("{} in {} instances of {} meshes, {} vertices{}", triangles, instances, meshes, vertices,
                                degenerate_triangles ? fmt::format(", {} without area", degenerate_triangles) : ""));
  const glm::vec3 extent = bounds.empty() ? glm::vec3(0) : bounds.max - bounds.min;
  line("bounds", fmt::format("({}) to ({}) m, {:.4g} x {:.4g} x {:.4g} m", triple(bounds.min), triple(bounds.max),
                             extent.x, extent.y, extent.z));
  line("materials", std::to_string(materials.size()));
  for (const SceneMaterial& m : materials) {
    std::string notes;
    if (m.emits()) notes += m.unlit ? ", unlit" : fmt::format(", emits {} cd/m2", triple(m.emissive_factor * m.emissive_strength));
    if (m.transmission > 0) notes += fmt::format(", transmits {:.3g}", m.transmission);
    if (m.alpha_mode != AlphaMode::opaque) notes += fmt::format(", {}", alpha_name(m.alpha_mode));
    if (m.double_sided) notes += ", double-sided";
    line("", fmt::format("{}: base {}{}, metallic {:.3g}, roughness {:.3g}{}", m.name, triple(glm::vec3(m.base_color)),
                         m.base_color_texture.texture == none ? "" : " x texture", m.metallic, m.roughness, notes));
  }
  line("textures", fmt::format("{} of {} images, {} texels", textures, images, texels));
  line("lights", fmt::format("{} punctual, {} emissive triangles, {}", lamps.size(), emissive_triangles,
                             has_environment ? "an environment" : "no environment"));
  for (const Lamp& lamp : lamps) {
    line("", fmt::format("{} {}: {} {}, flux {} lm", lamp.type, lamp.name, triple(lamp.intensity),
                         lamp.type == "directional" ? "lx" : "cd", triple(lamp.flux)));
  }
  if (emissive_triangles) {
    line("", fmt::format("emissive triangles: {:.4g} m2, flux {} lm", emissive_area, triple(emissive_flux)));
  }
  if (has_environment) {
    line("", fmt::format("environment {}: mean {} cd/m2",
                         environment_width ? fmt::format("{}x{}", environment_width, environment_height) : "constant",
                         triple(environment_radiance)));
  }
  line("cameras", std::to_string(cameras.size()));
  for (size_t i = 0; i < cameras.size(); ++i) {
    const SceneCamera& c = cameras[i];
    line("", fmt::format("{} {}: {} at ({})", i, c.name,
                         c.perspective ? fmt::format("{:.3g} degrees", glm::degrees(c.yfov)) : "orthographic",
                         triple(camera_position(c))));
  }
  if (!animations.empty()) line("animations", std::to_string(animations.size()));
  for (size_t i = 0; i < animations.size(); ++i) {
    line("", fmt::format("{} {}: {:.4g} s, {} channels", i, animations[i].name, animations[i].duration,
                         animations[i].channels.size()));
  }
  if (deformed_instances) line("deformed", fmt::format("{} instances ({} skins)", deformed_instances, skins));
  if (!extensions_used.empty()) line("extensions", fmt::format("{}", fmt::join(extensions_used, ", ")));
  if (!extensions_ignored.empty()) line("  ignored", fmt::format("{}", fmt::join(extensions_ignored, ", ")));
  line("device memory", format_bytes(device_bytes));
  for (const std::string& warning : warnings) line("warning", warning);
  return out;
}

std::string SceneReport::json() const {
  nlohmann::json root = {{"source", source}, {"triangles", triangles}, {"degenerate_triangles", degenerate_triangles},
               {"vertices", vertices}, {"instances", instances}, {"meshes", meshes},
               {"deformed_instances", deformed_instances}, {"skins", skins}, {"bounds", to_json(bounds)},
               {"textures", {{"count", textures}, {"images", images}, {"texels", texels}}},
               {"extensions", {{"used", extensions_used}, {"ignored", extensions_ignored}}},
               {"device_memory_bytes", device_bytes}, {"warnings", warnings}};
  nlohmann::json& list = root["materials"] = nlohmann::json::array();
  for (const SceneMaterial& m : materials) {
    list.push_back({{"name", m.name}, {"base_color", {m.base_color.r, m.base_color.g, m.base_color.b, m.base_color.a}},
                    {"textured", m.base_color_texture.texture != none}, {"metallic", m.metallic},
                    {"roughness", m.roughness}, {"ior", m.ior}, {"transmission", m.transmission},
                    {"emission_cd_per_m2", to_json(m.emissive_factor * m.emissive_strength)}, {"unlit", m.unlit},
                    {"alpha_mode", alpha_name(m.alpha_mode)}, {"double_sided", m.double_sided}});
  }
  nlohmann::json& lights = root["lights"] = {{"emissive_triangles", {{"count", emissive_triangles}, {"area_m2", emissive_area},
                                                           {"flux_lm", to_json(emissive_flux)}}},
                                   {"punctual", nlohmann::json::array()}, {"environment", nullptr}};
  for (const Lamp& lamp : lamps) {
    const bool directional = lamp.type == "directional";
    lights["punctual"].push_back({{"name", lamp.name}, {"type", lamp.type},
                                  {directional ? "illuminance_lx" : "intensity_cd", to_json(lamp.intensity)},
                                  {"flux_lm", to_json(lamp.flux)}, {"position_m", to_json(lamp.position)},
                                  {"direction", to_json(lamp.direction)}});
  }
  if (has_environment) {
    lights["environment"] = {{"width", environment_width}, {"height", environment_height},
                             {"mean_radiance_cd_per_m2", to_json(environment_radiance)}};
  }
  nlohmann::json& views = root["cameras"] = nlohmann::json::array();
  for (const SceneCamera& c : cameras) {
    views.push_back({{"name", c.name}, {"type", c.perspective ? "perspective" : "orthographic"},
                     {"yfov_degrees", glm::degrees(c.yfov)}, {"position_m", to_json(camera_position(c))}});
  }
  nlohmann::json& movements = root["animations"] = nlohmann::json::array();
  for (const Animation& a : animations) {
    movements.push_back({{"name", a.name}, {"duration_seconds", a.duration}, {"channels", a.channels.size()}});
  }
  return root.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace lucarium
