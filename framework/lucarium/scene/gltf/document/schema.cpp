// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/gltf/document/schema.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

namespace lucarium::gltf {

namespace {

constexpr int max_nesting = 100;  ///< tinygltf copies extensions recursively

/// For messages: the value in short.
std::string shown(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("an array of {}", value.size());
  const std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  return text.size() <= 40 ? text : text.substr(0, 37) + "...";
}

class Checker {
 public:
  Checker(Json& root, ImportContext& context) : root_(root), context_(context) {}

  void object(Json& value, const std::vector<Rule>& members, const std::string& path) {
    if (!value.is_object()) mismatch(path, "an object", value);
    for (const Rule& rule : members) {
      const auto member = value.find(rule.key);
      if (member != value.end()) {
        check(*member, rule, path + "/" + rule.key);
      } else if (rule.required) {
        context_.fail("{}: '{}' is missing", path.empty() ? "the document" : path, rule.key);
      }
    }
    const auto name = value.find("name");
    if (name != value.end() && !name->is_string()) mismatch(path + "/name", "a text", *name);
    const auto extensions = value.find("extensions");
    if (extensions == value.end()) return;
    if (!extensions->is_object()) mismatch(path + "/extensions", "an object", *extensions);
    for (const auto& [key, extension] : extensions->items()) {
      if (!extension.is_object()) mismatch(path + "/extensions/" + key, "an object", extension);
    }
  }

 private:
  [[noreturn]] void mismatch(const std::string& path, const std::string& expected, const Json& value) const {
    context_.fail("{} must be {}, but it is {}", path, expected, shown(value));
  }

  void check(Json& value, const Rule& rule, const std::string& path) {
    using Kind = Rule::Kind;
    switch (rule.kind) {
      case Kind::boolean:
        if (!value.is_boolean()) mismatch(path, "true or false", value);
        break;
      case Kind::integer: integer(value, rule.min, rule.max, path); break;
      case Kind::number: number(value, rule, path); break;
      case Kind::text:
        if (!value.is_string()) mismatch(path, "a text", value);
        break;
      case Kind::choice: choice(value, rule, path); break;
      case Kind::index: index(value, rule, path); break;
      case Kind::object: object(value, rule.members, path); break;
      case Kind::index_map: map(value, rule, path); break;
      default: array(value, rule, path);
    }
  }

  void array(Json& value, const Rule& rule, const std::string& path) {
    using Kind = Rule::Kind;
    if (!value.is_array()) mismatch(path, "an array", value);
    if (rule.length && value.size() != rule.length) {
      mismatch(path, fmt::format("an array of {} numbers", rule.length), value);
    }
    if (value.empty()) context_.warn("{} is an empty array, which glTF forbids", path);
    for (size_t i = 0; i < value.size(); ++i) {
      const std::string element = path + "/" + std::to_string(i);
      if (rule.kind == Kind::numbers) number(value[i], rule, element);
      if (rule.kind == Kind::indices) index(value[i], rule, element);
      if (rule.kind == Kind::index_maps) map(value[i], rule, element);
      if (rule.kind == Kind::objects) object(value[i], rule.members, element);
      if (rule.kind == Kind::texts && !value[i].is_string()) mismatch(element, "a text", value[i]);
    }
  }

  void map(Json& value, const Rule& rule, const std::string& path) {
    if (!value.is_object()) mismatch(path, "an object", value);
    for (auto& [key, element] : value.items()) index(element, rule, path + "/" + key);
  }

  void choice(Json& value, const Rule& rule, const std::string& path) const {
    std::string expected = "one of";
    for (const Json& allowed : rule.choices) {
      if (value == allowed) {
        value = allowed;  // 5126.0 → 5126
        return;
      }
      expected += fmt::format(" {}", allowed.dump());
    }
    mismatch(path, expected, value);
  }

  void number(const Json& value, const Rule& rule, const std::string& path) const {
    if (!value.is_number()) mismatch(path, "a number", value);
    const double x = value.get<double>();
    if (x >= rule.min && x <= rule.max) return;
    if (std::abs(x) > FLT_MAX) mismatch(path, "a number that single precision can hold", value);
    mismatch(path,
             rule.max == FLT_MAX ? fmt::format("at least {}", rule.min)
                                 : fmt::format("a number from {} to {}", rule.min, rule.max),
             value);
  }

  void integer(Json& value, double min, double max, const std::string& path) const {
    const bool whole = value.is_number_integer() ||
                       (value.is_number_float() && std::trunc(value.get<double>()) == value.get<double>());
    if (!whole) mismatch(path, "an integer", value);
    const double x = value.get<double>();
    if (x < min) mismatch(path, fmt::format("an integer of at least {:.0f}", min), value);
    if (x > max) mismatch(path, fmt::format("an integer of at most {:.0f}", max), value);
    if (value.is_number_float()) value = static_cast<int64_t>(x);
  }

  void index(Json& value, const Rule& rule, const std::string& path) {
    integer(value, 0, 9007199254740992.0, path);
    const size_t count = size_of(rule.target);
    if (value.get<uint64_t>() < count) return;
    context_.fail("{} refers to {}/{}, but there {} {}", path, rule.target, value.get<uint64_t>(),
                  count == 1 ? "is" : "are", count ? std::to_string(count) : "none");
  }

  /// Elements of the array at a JSON pointer of the document.
  size_t size_of(const std::string& target) {
    const auto [entry, fresh] = sizes_.try_emplace(target, 0);
    if (!fresh) return entry->second;
    const Json::json_pointer pointer(target);
    if (root_.contains(pointer) && root_[pointer].is_array()) entry->second = root_[pointer].size();
    return entry->second;
  }

  Json& root_;
  ImportContext& context_;
  std::map<std::string, size_t> sizes_;
};

/// Depth of brackets outside of strings.
void check_nesting(std::string_view text, const ImportContext& context) {
  int depth = 0;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      if (c == '"') quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      if (++depth > max_nesting) context.fail("the JSON is nested more than {} levels deep", max_nesting);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
}

}  // namespace

void check_json(Json& root, const std::vector<Rule>& rules, ImportContext& context) {
  Checker(root, context).object(root, rules, "");
}

Json parse_json(std::string_view text, const ImportContext& context) {
  check_nesting(text, context);
  try {
    return Json::parse(text);
  } catch (const Json::exception& error) {
    const std::string reason = error.what();
    const size_t end_of_tag = reason.find("] ");
    context.fail("the JSON is malformed: {}", end_of_tag == std::string::npos ? reason : reason.substr(end_of_tag + 2));
  }
}

}  // namespace lucarium::gltf
