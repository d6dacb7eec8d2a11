// SPDX-License-Identifier: Apache-2.0
#include "commands/view_again.h"

#include <unistd.h>

#include <cstdlib>
#include <vector>

#include "commands/watch.h"
#include "lucarium/base/error.h"
#include "lucarium/base/json.h"

namespace lucarium::app {

using nlohmann::json;

namespace {

const char* const state_variable = "LUCARIUM_VIEW_STATE";

json to_json(const glm::vec3& v) { return {v.x, v.y, v.z}; }
glm::vec3 to_vector(const json& v) { return {v.at(0), v.at(1), v.at(2)}; }

json to_json(const ViewRequest& request) {
  json sides = json::array();
  for (const ViewRequest::Side& side : request.sides)
    sides.push_back({{"technique", side.technique}, {"parameters", side.parameters}});
  const SceneEdits& e = request.edits;
  json edits = {{"materials", e.materials}, {"environment", e.environment}};
  if (e.lights) edits["lights"] = *e.lights;
  if (e.seconds) edits["seconds"] = *e.seconds;
  json all = {{"sides", sides},
              {"beside", request.beside},
              {"flip", request.flip},
              {"layer", request.layer},
              {"paused", request.paused},
              {"scene_camera", request.scene_camera},
              {"edits", std::move(edits)},
              {"reference", request.reference}};
  if (request.camera) {
    const CameraKey& key = *request.camera;
    all["camera"] = {{"eye", to_json(key.eye)}, {"target", to_json(key.target)}, {"vfov", key.vfov_degrees}};
  }
  return all;
}

ViewRequest to_request(const json& all) {
  ViewRequest request;
  for (size_t i = 0; i < request.sides.size(); ++i) {
    const json& side = all.at("sides").at(i);
    request.sides.at(i) = {side.at("technique"), side.at("parameters"), 1};
  }
  request.beside = all.at("beside");
  request.flip = all.at("flip");
  request.layer = all.at("layer");
  request.paused = all.at("paused");
  request.reference = all.at("reference");
  request.scene_camera = all.at("scene_camera");
  const json& edits = all.at("edits");
  request.edits.materials = edits.at("materials").get<std::vector<std::string>>();
  request.edits.environment = edits.at("environment");
  if (edits.contains("lights")) request.edits.lights = edits.at("lights").get<std::vector<std::string>>();
  if (edits.contains("seconds")) request.edits.seconds = edits.at("seconds").get<double>();
  if (request.edits.any()) request.scene_number = 1;
  if (all.contains("camera")) {
    const json& key = all.at("camera");
    CameraKey camera;
    camera.eye = to_vector(key.at("eye"));
    camera.target = to_vector(key.at("target"));
    camera.vfov_degrees = key.at("vfov");
    request.camera = camera;
  }
  request.camera_number = 1;
  return request;
}

}  // namespace

std::optional<ViewState> state_of_earlier_view() {
  const char* const text = std::getenv(state_variable);
  if (!text) return std::nullopt;
  const std::string kept = text;
  ::unsetenv(state_variable);
  try {
    const json all = json::parse(kept);
    ViewState state;
    state.port = all.at("port");
    state.token = all.at("token");
    state.request = to_request(all.at("request"));
    return state;
  } catch (const std::exception&) {
    return std::nullopt;  // somebody else's variable
  }
}

void start_again(std::vector<std::string> words, const ViewState& state) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const json all = {{"port", state.port}, {"token", state.token}, {"request", to_json(state.request)}};
  ::setenv(state_variable, all.dump().c_str(), 1);
  ::execv(pointers.front(), pointers.data());
  throw_error(ErrorClass::internal, "{} cannot be started again", words.front());
}

}  // namespace lucarium::app
