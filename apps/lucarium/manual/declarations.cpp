// SPDX-License-Identifier: Apache-2.0
#include "manual/declarations.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>

#include "grammar/option_texts.h"
#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/base/text/text_values.h"

namespace lucarium::app {
namespace {

OptionDeclaration read_option(const CLI::Option& option) {
  OptionDeclaration result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  result.value = option.get_type_name();
  result.value_optional = result.value.starts_with("[=");
  if (result.value_optional) result.value = result.value.substr(2, result.value.size() - 3);
  result.text = option.get_description();
  result.group = option.get_group();
  result.required = option.get_required();
  if (!result.is_flag()) {
    result.fallback = option.get_default_str();
    result.repeatable = option.get_positional() ? option.get_expected_max() > 1
                                                : option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  }
  result.name = option.get_positional() ? option.get_name() : result.names.back();
  const std::string words = option_text(result.name).words;
  if (!words.empty()) result.words = split(words, '|');
  return result;
}

/// The footer of --help, which Command::examples() wrote: a line "Examples", the examples, "More: PAGE".
void read_footer(const std::string& footer, CommandDeclaration& command) {
  constexpr std::string_view example = "  ", page = "More: ";
  for (const std::string& line : split(footer, '\n')) {
    if (line.starts_with(example)) command.examples.push_back(line.substr(example.size()));
    if (line.starts_with(page)) command.page = line.substr(page.size());
  }
}

CommandDeclaration read_command(const CLI::App& app) {
  CommandDeclaration command{app.get_name(), app.get_description(), {}, {}, {}, {}};
  const std::vector<const CLI::Option*> all = app.get_options({});
  for (const CLI::Option* option : all) {
    if (option->get_positional()) command.words.push_back(read_option(*option));
  }
  for (const std::string group : option_groups()) {
    for (const CLI::Option* option : all) {
      if (!option->get_positional() && option->get_group() == group) command.options.push_back(read_option(*option));
    }
  }
  read_footer(app.get_footer(), command);
  return command;
}

}  // namespace

bool OptionDeclaration::has(std::string_view wanted) const {
  return std::find(names.begin(), names.end(), wanted) != names.end();
}

std::string OptionDeclaration::usage() const {
  if (names.empty()) return value + (repeatable ? "…" : "");
  const std::string listed = fmt::format("{}", fmt::join(names, ", "));
  if (is_flag()) return listed;
  return value_optional ? fmt::format("{}[={}]", listed, value) : fmt::format("{} {}", listed, value);
}

std::vector<std::string> CommandDeclaration::groups() const {
  std::vector<std::string> result;
  for (const OptionDeclaration& option : options) {
    if (result.empty() || result.back() != option.group) result.push_back(option.group);
  }
  return result;
}

std::string CommandDeclaration::usage(const std::string& program) const {
  std::string line = program == name ? program + " COMMAND" : program + " " + name;
  for (const OptionDeclaration& word : words) line += word.required ? " " + word.usage() : " [" + word.usage() + "]";
  return line + " [OPTIONS]";
}

const CommandDeclaration& ProgramDeclaration::command(std::string_view name) const {
  std::vector<std::string> names;
  for (const CommandDeclaration& candidate : commands) {
    if (candidate.name == name) return candidate;
    names.push_back(candidate.name);
  }
  for (const CommandDeclaration& candidate : hidden) {
    if (candidate.name == name) return candidate;
  }
  throw_error(ErrorClass::usage, "unknown command '{}'{}", name, suggest_name(name, names));
}

ProgramDeclaration read_declarations(const CLI::App& app) {
  ProgramDeclaration result{read_command(app), {}, {}};
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    (command->get_group().empty() ? result.hidden : result.commands).push_back(read_command(*command));
  return result;
}

ValueKind value_kind(const OptionDeclaration& option) {
  static const std::map<std::string, ValueKind> by_name = {
      {"scene", ValueKind::scene},       {"technique", ValueKind::technique},
      {"test", ValueKind::file},         {"--technique", ValueKind::technique},
      {"reference", ValueKind::file},    {"--parameter", ValueKind::parameter},
      {"command", ValueKind::command},   {"experiment", ValueKind::experiment},
      {"--environment", ValueKind::file}};
  if (option.is_flag()) return ValueKind::nothing;
  if (!option.words.empty()) return ValueKind::words;
  if (const auto found = by_name.find(option.name); found != by_name.end()) return found->second;
  if (option.value.starts_with("FOLDER")) return ValueKind::folder;
  return option.value.starts_with("FILE") || option.value.starts_with("MAP") ? ValueKind::file : ValueKind::free;
}

std::string asked_kind(ValueKind kind) {
  switch (kind) {
    case ValueKind::scene: return "scene";
    case ValueKind::technique: return "technique";
    case ValueKind::parameter: return "parameter";
    case ValueKind::experiment: return "experiment";
    default: return "";
  }
}

}  // namespace lucarium::app
