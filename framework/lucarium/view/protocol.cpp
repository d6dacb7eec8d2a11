// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/protocol.h"

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/scene/look_at.h"

namespace lucarium {

using nlohmann::json;
using Kind = ViewMessage::Kind;

namespace {

constexpr size_t longest_text = 400, max_parameters = 200;
constexpr double largest_exposure = 100;  // [stops]
constexpr double farthest = 1e15;         // [m]
constexpr double longest_time = 1e6;      // [s]
constexpr uint64_t largest_side = 1u << 20;
constexpr size_t max_edits = 200;

json parse(std::string_view text) {
  if (text.size() > largest_view_message)
    throw_error(ErrorClass::usage, "a message has at most {} bytes", largest_view_message);
  json message = json::parse(std::string(text), nullptr, false);
  if (!message.is_object()) throw_error(ErrorClass::usage, "a message is a JSON object");
  return message;
}

/// Reads the members of a message, and remembers which: what is left over is a mistake.
class Members {
 public:
  explicit Members(const json& message) : message_(message) {}

  bool has(const char* name) const { return message_.contains(name); }
  const json& at(const char* name) {
    read_.insert(name);
    const auto found = message_.find(name);
    if (found == message_.end()) throw_error(ErrorClass::usage, "the message has no \"{}\"", name);
    return *found;
  }
  std::string text(const char* name) { return text_of(at(name), name); }
  static std::string text_of(const json& value, const char* name) {
    if (!value.is_string() || value.get_ref<const std::string&>().size() > longest_text)
      throw_error(ErrorClass::usage, "\"{}\" is not a text of at most {} bytes", name, longest_text);
    return value.get<std::string>();
  }
  uint64_t count(const char* name, uint64_t largest) {
    const json& value = at(name);
    if (!value.is_number_unsigned() || value.get<uint64_t>() > largest)
      throw_error(ErrorClass::usage, "\"{}\" is not a whole number from 0 to {}", name, largest);
    return value.get<uint64_t>();
  }
  double number(const char* name, double low, double high) { return number_of(at(name), name, low, high); }
  static double number_of(const json& value, const char* name, double low, double high) {
    const double number = value.is_number() ? value.get<double>() : NAN;
    if (!(number >= low && number <= high))
      throw_error(ErrorClass::usage, "\"{}\" is not a number from {} to {}", name, low, high);
    return number;
  }
  glm::vec3 point(const char* name) {
    const json& value = at(name);
    if (!value.is_array() || value.size() != 3) throw_error(ErrorClass::usage, "\"{}\" is not three numbers", name);
    glm::vec3 point(0);
    for (int i = 0; i < 3; ++i)
      point[i] = static_cast<float>(number_of(value[static_cast<size_t>(i)], name, -farthest, farthest));
    return point;
  }
  bool flag(const char* name) {
    const json& value = at(name);
    if (!value.is_boolean()) throw_error(ErrorClass::usage, "\"{}\" is neither true nor false", name);
    return value.get<bool>();
  }
  void require_no_others() const {
    for (const auto& [name, value] : message_.items()) {
      if (!read_.contains(name)) throw_error(ErrorClass::usage, "the message has an unknown member");
    }
  }

 private:
  const json& message_;
  std::set<std::string> read_ = {"do", "id"};
};

CameraKey read_camera(Members& members) {
  CameraKey camera;
  camera.eye = members.point("eye");
  camera.target = members.point("target");
  camera.vfov_degrees = static_cast<float>(members.number("vfov", 0.1, 179));
  const glm::vec3 direction = camera.target - camera.eye;
  const float length = glm::length(direction);
  if (!(length > 0) || !std::isfinite(length)) throw_error(ErrorClass::usage, "eye and target are the same point");
  return camera;
}

std::vector<std::pair<std::string, std::string>> read_parameters(const json& list) {
  if (!list.is_array() || list.size() > max_parameters)
    throw_error(ErrorClass::usage, "\"parameters\" is not a list of at most {} pairs", max_parameters);
  std::vector<std::pair<std::string, std::string>> parameters;
  for (const json& pair : list) {
    if (!pair.is_array() || pair.size() != 2)
      throw_error(ErrorClass::usage, "\"parameters\" is not a list of pairs [key, value]");
    parameters.emplace_back(Members::text_of(pair[0], "parameters"), Members::text_of(pair[1], "parameters"));
  }
  return parameters;
}

std::vector<std::string> read_texts(const json& list, const char* name) {
  if (!list.is_array() || list.size() > max_edits)
    throw_error(ErrorClass::usage, "\"{}\" is not a list of at most {} texts", name, max_edits);
  std::vector<std::string> texts;
  for (const json& text : list) texts.push_back(Members::text_of(text, name));
  return texts;
}

SceneEdits read_edits(Members& members) {
  SceneEdits edits;
  if (const json& lights = members.at("lights"); !lights.is_null()) edits.lights = read_texts(lights, "lights");
  edits.materials = read_texts(members.at("materials"), "materials");
  edits.environment = members.text("environment");
  check_scene_edits(edits);
  return edits;
}

void read_members(ViewMessage& message, Members& members) {
  switch (message.kind) {
    case Kind::shown: message.picture = members.count("picture", UINT64_MAX); break;
    case Kind::control:
    case Kind::restart: break;
    case Kind::camera: message.camera = read_camera(members); break;
    case Kind::scene_camera: message.index = static_cast<uint32_t>(members.count("index", 1000000)); break;
    case Kind::technique:
      message.name = members.text("name");
      message.parameters = read_parameters(members.at("parameters"));
      if (members.has("side")) message.index = static_cast<uint32_t>(members.count("side", view_sides - 1));
      break;
    case Kind::beside:
      message.name = members.text("as");
      if (message.name != "none" && message.name != "pictures" && message.name != "flip")
        throw_error(ErrorClass::usage, "\"as\" is neither none, pictures nor flip");
      break;
    case Kind::layer: message.name = members.text("name"); break;
    case Kind::inspect:
      message.x = static_cast<uint32_t>(members.count("x", largest_side));
      message.y = static_cast<uint32_t>(members.count("y", largest_side));
      break;
    case Kind::scene: message.edits = read_edits(members); break;
    case Kind::time: message.edits.seconds = members.number("seconds", 0, longest_time); break;
    case Kind::reference:
    case Kind::pause: message.on = members.flag("on"); break;
    case Kind::save:
      message.name = members.text("kind");
      if (message.name != "exr" && message.name != "png")
        throw_error(ErrorClass::usage, "\"kind\" is neither exr nor png");
      message.exposure = static_cast<float>(members.number("exposure", -largest_exposure, largest_exposure));
      break;
  }
}

}  // namespace

ViewMessage parse_view_message(std::string_view text) {
  static const std::map<std::string, Kind, std::less<>> kinds = {
      {"shown", Kind::shown},         {"control", Kind::control},
      {"camera", Kind::camera},       {"scene_camera", Kind::scene_camera},
      {"technique", Kind::technique}, {"beside", Kind::beside},
      {"layer", Kind::layer},         {"inspect", Kind::inspect},
      {"reference", Kind::reference}, {"scene", Kind::scene},
      {"time", Kind::time},           {"pause", Kind::pause},
      {"restart", Kind::restart},     {"save", Kind::save}};
  const json object = parse(text);
  Members members(object);
  const auto kind = kinds.find(members.text("do"));
  if (kind == kinds.end()) throw_error(ErrorClass::usage, "\"do\" says nothing that the viewer does");
  ViewMessage message;
  message.kind = kind->second;
  if (members.has("id")) message.id = static_cast<int64_t>(members.count("id", INT64_MAX));
  read_members(message, members);
  members.require_no_others();
  return message;
}

std::optional<int64_t> view_message_id(std::string_view text) {
  if (text.size() > largest_view_message) return std::nullopt;
  const json message = json::parse(std::string(text), nullptr, false);
  if (!message.is_object()) return std::nullopt;
  const auto id = message.find("id");
  if (id == message.end() || !id->is_number_unsigned() || id->get<uint64_t>() > INT64_MAX) return std::nullopt;
  return static_cast<int64_t>(id->get<uint64_t>());
}

}  // namespace lucarium
