// SPDX-License-Identifier: Apache-2.0
#include "lucarium/technique/state_header.h"

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"

namespace lucarium {

using nlohmann::ordered_json;

std::string state_header_text(const StateHeader& h) {
  ordered_json parameters = ordered_json::array();
  for (const auto& [name, value] : h.parameters) parameters.push_back(ordered_json::array({name, value}));
  const ordered_json json = {{"schema", "lucarium-state-1"},
                             {"program_version", h.program_version},
                             {"scene", h.scene},
                             {"scene_hash", h.scene_hash},
                             {"technique", h.technique},
                             {"technique_version", h.technique_version},
                             {"parameters", parameters},
                             {"path_set", h.path_set},
                             {"max_bounces", h.max_bounces},
                             {"seed", h.seed},
                             {"width", h.width},
                             {"height", h.height},
                             {"seconds", h.seconds}};
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);  // a scene's name may be any bytes
}

StateHeader parse_state_header(const std::string& text) {
  StateHeader h;
  try {
    const ordered_json json = ordered_json::parse(text);
    json.at("program_version").get_to(h.program_version);
    json.at("scene").get_to(h.scene);
    json.at("scene_hash").get_to(h.scene_hash);
    json.at("technique").get_to(h.technique);
    json.at("technique_version").get_to(h.technique_version);
    json.at("parameters").get_to(h.parameters);
    json.at("path_set").get_to(h.path_set);
    json.at("max_bounces").get_to(h.max_bounces);
    json.at("seed").get_to(h.seed);
    json.at("width").get_to(h.width);
    json.at("height").get_to(h.height);
    json.at("seconds").get_to(h.seconds);
  } catch (const ordered_json::exception& error) {
    throw Error(ErrorClass::input, "its header is not that of a state").with_details(error.what());
  }
  return h;
}

}  // namespace lucarium
