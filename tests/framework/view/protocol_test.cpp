// SPDX-License-Identifier: Apache-2.0
// Messages of pages: good ones are understood, all others are refused with a reason, whatever they are.
#include "lucarium/view/protocol.h"

#include <doctest/doctest.h>

#include <random>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/view/hub.h"

using namespace lucarium;
using Kind = ViewMessage::Kind;

namespace {

const std::vector<std::string> good = {
    R"({"do": "shown", "picture": 0})",
    R"({"do": "control", "id": 7})",
    R"({"do": "camera", "eye": [0, 1.5, -2e1], "target": [0, 1, 0], "vfov": 40})",
    R"({"do": "scene_camera", "index": 1})",
    R"({"do": "technique", "name": "path_tracing", "parameters": [["nee", "off"], ["lights", "power"]], "id": 1})",
    R"({"do": "technique", "name": "path_tracing", "parameters": [], "side": 1})",
    R"({"do": "beside", "as": "flip"})",
    R"({"do": "inspect", "x": 3, "y": 4})",
    R"({"do": "reference", "on": true})",
    R"({"do": "scene", "lights": ["point:0,1,0:1,1,1"], "materials": ["a:roughness=0.5"], "environment": "none"})",
    R"({"do": "scene", "lights": null, "materials": [], "environment": ""})",
    R"({"do": "time", "seconds": 1.5})",
    R"({"do": "layer", "name": "direct"})",
    R"({"do": "pause", "on": true})",
    R"({"do": "restart"})",
    R"({"do": "save", "kind": "exr", "exposure": -1.5})"};

/// Whether it is understood; anything but an Error{usage} leaves.
bool is_understood(std::string_view text) {
  try {
    parse_view_message(text);
    return true;
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::usage);
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return false;
  }
}

/// A message with a few bytes, numbers or pieces changed.
std::string spoil(std::string text, std::mt19937& random) {
  static const std::vector<std::string> pieces = {
      "[",      "]",  "{",     "}",       "\"",   ",",    ":",    "null",
      "1e999",  "-1", "1e308", "\\u0000", "\xff", "true", "[[[[", "99999999999999999999",
      "\"do\":"};
  const auto below = [&random](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
  for (size_t i = 0; i <= below(4); ++i) {
    const size_t at = below(text.size());
    switch (below(5)) {
      case 0: text[at] = static_cast<char>(below(256)); break;
      case 1: text.erase(at, 1 + below(6)); break;
      case 2: text.insert(at, pieces[below(pieces.size())]); break;
      case 3: text.replace(at, 1, pieces[below(pieces.size())]); break;
      default: text += text.substr(at); break;
    }
    if (text.empty()) text = "{";
  }
  return text;
}

}  // namespace

TEST_CASE("good messages say what they mean") {
  for (const std::string& text : good) CHECK_MESSAGE(is_understood(text), text);
  const ViewMessage camera = parse_view_message(good[2]);
  CHECK(camera.kind == Kind::camera);
  CHECK(camera.camera.eye == glm::vec3(0, 1.5f, -20));
  CHECK(camera.camera.vfov_degrees == 40);
  CHECK_FALSE(camera.id.has_value());
  const ViewMessage technique = parse_view_message(good[4]);
  CHECK(technique.name == "path_tracing");
  CHECK(technique.parameters == decltype(technique.parameters){{"nee", "off"}, {"lights", "power"}});
  CHECK(technique.id == 1);
  CHECK(view_message_id(R"({"do": 5, "id": 12})") == 12);
  CHECK_FALSE(view_message_id("{").has_value());
}

TEST_CASE("messages with a mistake are refused") {
  for (const char* text : {"",
                           "[]",
                           "5",
                           "{}",
                           R"({"do": "dance"})",
                           R"({"do": 1})",
                           R"({"do": "pause"})",
                           R"({"do": "pause", "on": 1})",
                           R"({"do": "restart", "more": 1})",
                           R"({"do": "camera", "eye": [0, 0, 0], "target": [0, 0, 0], "vfov": 40})",
                           R"({"do": "camera", "eye": [0, 0], "target": [0, 0, 1], "vfov": 40})",
                           R"({"do": "camera", "eye": [0, 0, 1e30], "target": [0, 0, 1], "vfov": 40})",
                           R"({"do": "camera", "eye": [0, 0, 5], "target": [0, 0, 1], "vfov": 180})",
                           R"({"do": "technique", "name": "a", "parameters": {"b": "c"}})",
                           R"({"do": "technique", "name": "a", "parameters": [["b", 1]]})",
                           R"({"do": "scene_camera", "index": -1})",
                           R"({"do": "technique", "name": "a", "parameters": [], "side": 2})",
                           R"({"do": "beside", "as": "above"})",
                           R"({"do": "inspect", "x": -1, "y": 0})",
                           R"({"do": "reference", "on": 1})",
                           R"({"do": "time", "seconds": -1})",
                           R"({"do": "scene", "lights": ["bulb"], "materials": [], "environment": ""})",
                           R"({"do": "scene", "lights": null, "materials": ["a:shine=1"], "environment": ""})",
                           R"({"do": "scene", "lights": null, "materials": [], "environment": "/etc/passwd.hdr"})",
                           R"({"do": "save", "kind": "/etc/passwd", "exposure": 0})",
                           R"({"do": "shown", "picture": 0, "id": -4})"})
    CHECK_FALSE_MESSAGE(is_understood(text), text);
  CHECK_FALSE(is_understood(R"({"do": "layer", "name": ")" + std::string(500, 'x') + "\"}"));
  CHECK_FALSE(is_understood(R"({"do": "layer", "name": ")" + std::string(largest_view_message, 'x') + "\"}"));
  CHECK_FALSE(is_understood(std::string(largest_view_message, '[')));
}

TEST_CASE("spoiled messages are understood or refused, and the hub answers each with an error and lives on") {
  std::mt19937 random(20);
  ViewHub hub;
  size_t refused = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = good[i % good.size()];
    if (i >= static_cast<int>(good.size())) text = spoil(std::move(text), random);
    refused += is_understood(text) ? 0 : 1;
    if (i % 20 != 0) continue;
    const std::optional<uint64_t> page = hub.join();
    REQUIRE(page);
    while (hub.next(*page)) {
    }
    hub.receive(*page, text);
    if (!is_understood(text)) {
      const std::optional<ViewHub::Outgoing> answer = hub.next(*page);
      REQUIRE_MESSAGE(answer, text);
      CHECK(nlohmann::json::parse(*answer->data).contains("error"));
    }
    hub.leave(*page);
  }
  CHECK(refused > 10000);
  CHECK(refused < 19990);
}
