// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/status.h"

#include <algorithm>

#include "lucarium/base/json.h"
#include "lucarium/scene/camera_path.h"
#include "lucarium/scene/exposure.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

constexpr size_t max_passes = 20;

ordered_json to_json(const ViewTechnique& technique) {
  return {{"name", technique.name}, {"parameters", technique.parameters}};
}

ordered_json to_json(const ParameterTable::Entry& entry) {
  const ParameterInfo& p = entry.info;
  ordered_json json = {{"name", p.name}, {"type", p.type},   {"default", p.default_value}, {"range", p.range},
                       {"unit", p.unit}, {"meaning", p.doc}, {"choices", p.choices},       {"advanced", p.advanced}};
  if (!entry.presets.empty()) json["preset"] = true;
  return json;
}

ordered_json to_json(const TechniqueType& type) {
  const TechniqueInfo& info = type.info();
  ordered_json json = {{"name", info.name},         {"summary", info.summary},
                       {"citation", info.citation}, {"view_independent", info.capabilities.view_independent},
                       {"pixel_layer", nullptr},    {"parameters", ordered_json::array()}};
  if (const PixelLayer& shown = info.pixel_layer; !shown.layer.empty())
    json["pixel_layer"] = {{"x", shown.x_parameter}, {"y", shown.y_parameter}, {"layer", shown.layer}};
  const std::unique_ptr<Technique> technique = type.create();
  for (const ParameterTable::Entry& entry : technique->parameters().entries())
    json["parameters"].push_back(to_json(entry));
  return json;
}

/// What differs from all light paths, as `--path-set` reads it.
std::string short_text(const PathSet& paths) {
  std::string text = paths.max_bounces < 0 ? "" : fmt::format("max_bounces={}", paths.max_bounces);
  const auto values = paths.technique_parameters(), all = PathSet().technique_parameters();
  for (size_t i = 0; i < values.size(); ++i)
    if (values[i] != all[i]) text += fmt::format("{}{}={}", text.empty() ? "" : ",", values[i].first, values[i].second);
  return text;
}

}  // namespace

ordered_json to_json(const glm::vec3& v) { return {v.x, v.y, v.z}; }

ordered_json to_json(const CameraKey& key) {
  return {{"eye", to_json(key.eye)},
          {"target", to_json(key.target)},
          {"vfov", key.vfov_degrees},
          {"text", camera_text(key)}};
}

std::string dump_line(const ordered_json& json) {
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

CameraKey view_key_of(const SceneCamera& camera, const Bounds& bounds) {
  CameraKey key;
  key.eye = glm::vec3(camera.world_from_camera[3]);
  const glm::vec3 forward = -glm::normalize(glm::vec3(camera.world_from_camera[2]));
  const float radius = bounds.radius();
  const float distance = radius > 0 ? std::max(glm::dot(bounds.center() - key.eye, forward), 0.1f * radius) : 1;
  key.target = key.eye + distance * forward;
  if (camera.perspective) key.vfov_degrees = glm::degrees(camera.yfov);
  return key;
}

std::string describe_view(const Scene& scene, const TechniqueRegistry& registry,
                          const std::vector<ViewTechnique>& named, const RenderSettings& settings) {
  ordered_json view = {{"scene", scene.source},
                       {"size", {settings.width, settings.height}},
                       {"cameras", ordered_json::array()},
                       {"techniques", ordered_json::array()},
                       {"named", ordered_json::array()}};
  if (!is_automatic(scene.exposure)) view["exposure"] = scene.exposure;
  const Bounds bounds = scene.bounds();
  for (const SceneCamera& camera : scene.cameras) {
    ordered_json entry = to_json(view_key_of(camera, bounds));
    entry["name"] = camera.name;
    view["cameras"].push_back(std::move(entry));
  }
  for (const TechniqueType& type : registry.types()) view["techniques"].push_back(to_json(type));
  for (const ViewTechnique& technique : named) view["named"].push_back(to_json(technique));
  return dump_line({{"view", view}});
}

ordered_json describe_running(const ViewTechnique& technique, RenderSession& session) {
  ordered_json running = to_json(technique);
  ordered_json values = ordered_json::object();
  for (const ParameterTable::Entry& entry : session.technique().parameters().entries())
    values[entry.info.name] = entry.get();
  running["values"] = std::move(values);
  const PathSet paths = session.technique().path_set(session.scene(), session.settings()).simplified(session.scene());
  running["light"] = paths.light_transport();
  running["paths"] = short_text(paths);
  running["limitations"] = session.limitations();
  return running;
}

ordered_json describe_progress(const RenderSession& session, double seconds) {
  const IterationResult last = session.last();
  return {{"iterations", session.iterations()}, {"samples", last.samples}, {"seconds", seconds},
          {"progress", last.progress},          {"phase", last.phase},     {"converged", last.converged}};
}

ordered_json describe_machine(RenderSession& session) {
  ordered_json machine = {{"memory", session.scheduler().device().memory().by_owner()},
                          {"counters", session.technique().counters()},
                          {"passes", ordered_json::array()}};
  std::vector<PassProfile> passes = session.scheduler().profile().passes;
  std::sort(passes.begin(), passes.end(),
            [](const PassProfile& a, const PassProfile& b) { return a.device_seconds > b.device_seconds; });
  for (size_t i = 0; i < std::min(passes.size(), max_passes); ++i) {
    const PassProfile& pass = passes[i];
    if (pass.count > 0)
      machine["passes"].push_back({{"name", pass.name}, {"count", pass.count}, {"seconds", pass.device_seconds}});
  }
  return machine;
}

}  // namespace lucarium
