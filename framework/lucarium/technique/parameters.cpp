// SPDX-License-Identifier: Apache-2.0
#include "lucarium/technique/parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>

#include "lucarium/base/text/nearest_name.h"
#include "lucarium/base/text/spelling.h"

namespace lucarium {

const ParameterTable::Entry& ParameterTable::find(std::string_view name) const {
  std::vector<std::string> names;
  const std::string american = american_spelling(name);
  for (const Entry& entry : entries_) {
    if (entry.info.name == american) return entry;
    names.push_back(entry.info.name);
  }
  throw_error(ErrorClass::usage, "no parameter is called '{}'{}", name, suggest_name(name, names));
}

void ParameterTable::set(std::string_view name, std::string_view value) {
  const Entry& entry = find(name);
  entry.set(value);
  if (entry.presets.empty()) return;
  for (const Entry& other : entries_) {
    if (other.presets.empty()) other.set(other.info.default_value);
  }
  for (const ParameterPreset& preset : entry.presets) {
    if (preset.name != entry.get()) continue;
    for (const auto& [key, text] : preset.values) find(key).set(text);
  }
}

void ParameterTable::set_all(const std::vector<std::pair<std::string, std::string>>& values) {
  for (const bool presets : {true, false}) {
    for (const auto& [name, value] : values) {
      const bool is_preset = !find(name).presets.empty();
      if (is_preset == presets) set(name, value);
    }
  }
}

std::string ParameterTable::get(std::string_view name) const { return find(name).get(); }

std::string ParameterTable::to_string() const {
  std::string text;
  for (const Entry& entry : entries_)
    text += fmt::format("{}{}={}", text.empty() ? "" : ",", entry.info.name, entry.get());
  return text;
}

void ParameterDescriber::flag(std::string name, bool& value, std::string doc) {
  const auto format = [](bool v) { return std::string(v ? "on" : "off"); };
  ParameterInfo info{name, "bool", format(value), "on|off", "", std::move(doc), {"on", "off"}};
  table_.mutable_entries().push_back({std::move(info), [&value, format] { return format(value); },
                                      [&value, name = std::move(name)](std::string_view text) {
                                        const std::vector<std::string> choices = {"on",  "true",  "1",
                                                                                  "off", "false", "0"};
                                        value = parse_parameter_choice(name, text, choices) < 3;
                                      }});
}

void ParameterDescriber::presets(std::vector<ParameterPreset> presets, std::string doc) {
  ParameterInfo info{"preset", "enum", "default", "default", "", std::move(doc), {"default"}};
  for (const ParameterPreset& preset : presets) {
    info.range += "|" + preset.name;
    info.choices.push_back(preset.name);
  }
  const auto chosen = std::make_shared<std::string>("default");
  const auto set = [chosen, names = info.choices](std::string_view text) {
    *chosen = names[parse_parameter_choice("preset", text, names)];
  };
  auto& entries = table_.mutable_entries();
  entries.insert(entries.begin(), {std::move(info), [chosen] { return *chosen; }, set, std::move(presets)});
}

void ParameterDescriber::basic(const std::vector<std::string>& names) {
  const auto& entries = table_.entries();
  for (const std::string& name : names) {
    const auto has_name = [&](const ParameterTable::Entry& entry) { return entry.info.name == name; };
    if (std::none_of(entries.begin(), entries.end(), has_name))
      throw_error(ErrorClass::internal, "basic() names '{}', which is no parameter", name);
  }
  for (ParameterTable::Entry& entry : table_.mutable_entries()) {
    const bool is_basic = std::find(names.begin(), names.end(), entry.info.name) != names.end();
    entry.info.advanced = !is_basic && entry.presets.empty();
  }
}

double parse_parameter_number(const std::string& name, std::string_view text, bool integral) {
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size() || (integral && value != std::floor(value))) {
    throw_error(ErrorClass::usage, "parameter {}: '{}' is not {} number", name, text, integral ? "a whole" : "a");
  }
  return value;
}

void throw_parameter_range(const std::string& name, std::string_view text, const std::string& low,
                           const std::string& high) {
  throw_error(ErrorClass::usage, "parameter {}: {} is outside {} … {}", name, text, low, high);
}

size_t parse_parameter_choice(const std::string& name, std::string_view text, const std::vector<std::string>& choices) {
  const std::string american = american_spelling(text);
  for (size_t i = 0; i < choices.size(); ++i) {
    if (choices[i] == american) return i;
  }
  throw_error(ErrorClass::usage, "parameter {}: no value is called '{}'{}", name, text, suggest_name(text, choices));
}

}  // namespace lucarium
