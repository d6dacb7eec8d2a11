// SPDX-License-Identifier: Apache-2.0
// A scene report as JSON. Declared in scene_report.h.
#include "lucarium/base/json.h"
#include "lucarium/scene/report/scene_report.h"

namespace lucarium {

namespace {

using Json = nlohmann::json;

Json triple_json(const glm::vec3& v) { return {v.x, v.y, v.z}; }

Json materials_json(const SceneReport& report) {
  Json list = Json::array();
  for (const SceneMaterial& m : report.materials) {
    list.push_back({{"name", m.name},
                    {"base_color", {m.base_color.r, m.base_color.g, m.base_color.b, m.base_color.a}},
                    {"textured", m.base_color_texture.texture != none},
                    {"metallic", m.metallic},
                    {"roughness", m.roughness},
                    {"ior", m.ior},
                    {"transmission", m.transmission},
                    {"emission_cd_per_m2", triple_json(m.emissive_factor * m.emissive_strength)},
                    {"unlit", m.unlit},
                    {"alpha_mode", alpha_mode_name(m.alpha_mode)},
                    {"double_sided", m.double_sided}});
  }
  return list;
}

Json lights_json(const SceneReport& r) {
  Json punctual = Json::array(), environment = nullptr;
  for (const SceneReport::Lamp& lamp : r.lamps) {
    punctual.push_back({{"name", lamp.name},
                        {"type", lamp.type},
                        {lamp.type == "directional" ? "illuminance_lx" : "intensity_cd", triple_json(lamp.intensity)},
                        {"flux_lm", triple_json(lamp.flux)},
                        {"position_m", triple_json(lamp.position)},
                        {"direction", triple_json(lamp.direction)}});
  }
  if (r.has_environment) {
    environment = {{"width", r.environment_width},
                   {"height", r.environment_height},
                   {"mean_radiance_cd_per_m2", triple_json(r.environment_radiance)}};
  }
  const Json triangles = {
      {"count", r.emissive_triangles}, {"area_m2", r.emissive_area}, {"flux_lm", triple_json(r.emissive_flux)}};
  return {{"punctual", punctual}, {"emissive_triangles", triangles}, {"environment", environment}};
}

Json cameras_json(const SceneReport& report) {
  Json list = Json::array();
  for (const SceneCamera& c : report.cameras) {
    list.push_back({{"name", c.name},
                    {"type", c.perspective ? "perspective" : "orthographic"},
                    {"yfov_degrees", glm::degrees(c.yfov)},
                    {"position_m", triple_json(glm::vec3(c.world_from_camera[3]))}});
  }
  return list;
}

/// Null without one.
Json camera_path_json(const SceneReport& report) {
  if (!report.camera_path) return nullptr;
  Json keys = Json::array();
  for (const CameraKey& key : report.camera_path->keys) {
    keys.push_back({{"seconds", key.seconds},
                    {"eye_m", triple_json(key.eye)},
                    {"target_m", triple_json(key.target)},
                    {"vfov_degrees", key.vfov_degrees}});
  }
  return {{"interpolation", interpolation_name(report.camera_path->interpolation)}, {"keys", keys}};
}

Json animations_json(const SceneReport& report) {
  Json list = Json::array();
  for (const Animation& a : report.animations) {
    list.push_back({{"name", a.name}, {"duration_seconds", a.duration}, {"channels", a.channels.size()}});
  }
  return list;
}

}  // namespace

std::string SceneReport::json() const {
  const Json root = {{"schema", "lucarium-scene-1"},
                     {"source", source},
                     {"triangles", triangles},
                     {"degenerate_triangles", degenerate_triangles},
                     {"vertices", vertices},
                     {"instances", instances},
                     {"meshes", meshes},
                     {"deformed_instances", deformed_instances},
                     {"skins", skins},
                     {"bounds", {{"min_m", triple_json(bounds.min)}, {"max_m", triple_json(bounds.max)}}},
                     {"materials", materials_json(*this)},
                     {"textures", {{"count", textures}, {"images", images}, {"texels", texels}}},
                     {"lights", lights_json(*this)},
                     {"cameras", cameras_json(*this)},
                     {"camera_path", camera_path_json(*this)},
                     {"camera_paths", camera_path_names},
                     {"animations", animations_json(*this)},
                     {"extensions", {{"used", extensions_used}, {"ignored", extensions_ignored}}},
                     {"device_memory_bytes", device_bytes},
                     {"warnings", warnings}};
  // Names in files need not be valid UTF-8.
  return root.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace lucarium
