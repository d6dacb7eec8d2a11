// SPDX-License-Identifier: Apache-2.0
#include "grammar/mistakes.h"

#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "lucarium/base/text/nearest_name.h"

namespace lucarium::app {
namespace {

using Options = std::vector<const CLI::Option*>;

bool is_option(const std::string& word) { return word.size() > 1 && word.front() == '-'; }

/// "--size" of "--size=8x8".
std::string name_of(const std::string& word) { return word.substr(0, word.find('=')); }

/// The subcommand that was named, else the program itself.
const CLI::App& chosen_command(const CLI::App& program) {
  const auto commands = program.get_subcommands();
  return commands.empty() ? program : *commands.front();
}

/// "(see lucarium render --help)".
std::string see_help(const CLI::App& command) {
  return fmt::format(" (see lucarium{} --help)", command.get_parent() ? " " + command.get_name() : "");
}

/// Whether a value may stand behind = alone.
bool value_is_optional(const CLI::Option& option) { return option.get_type_name().starts_with("[="); }

/// "=FILE" of "[=FILE]".
std::string without_brackets(const std::string& text) { return text.substr(1, text.size() - 2); }

bool takes_value(const CLI::Option& option) { return option.get_expected_min() > 0; }

/// "--spp", "SCENE".
std::string shown_name(const CLI::Option& option) {
  return option.get_positional() ? option.get_type_name() : "--" + option.get_lnames().front();
}

/// The one name that `word` is a part of, as '--max-bounces' of bounces; empty when there is none, or several.
std::string the_one_with(const std::string& word, const std::vector<std::string>& names) {
  const auto has_word = [&word](const std::string& name) { return name.find(word) != std::string::npos; };
  if (word.size() < 4 || std::count_if(names.begin(), names.end(), has_word) != 1) return "";
  return *std::find_if(names.begin(), names.end(), has_word);
}

/// "; did you mean '--spp'?", or nothing: all names would be a page.
std::string suggest_option(const std::string& name, const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& own : option->get_lnames()) names.push_back("--" + own);
  }
  std::string near = nearest_name(name, names);
  if (near.empty()) near = the_one_with(name.substr(std::min<size_t>(name.size(), 2)), names);
  return near.empty() ? "" : fmt::format("; did you mean '{}'?", near);
}

/// Complaint about an option of a command that stands before the command's name; else empty.
std::string misplaced_option(const CLI::App& program, const Words& line) {
  const CLI::App& chosen = chosen_command(program);
  for (const std::string& word : line) {
    const std::string name = name_of(word);
    if (!is_option(name)) break;
    if (program.get_option_no_throw(name)) continue;
    const auto has_it = [&](const CLI::App* sub) {
      return (&chosen == &program ? !sub->get_group().empty() : sub == &chosen) && sub->get_option_no_throw(name);
    };
    const auto owners = program.get_subcommands(has_it);
    if (owners.empty()) break;
    return fmt::format("{0} stands before the command's name; options of {1} stand behind it: lucarium {1} … {0}", name,
                       owners.front()->get_name());
  }
  return "";
}

/// Complaint about an option that the command does not have; else empty.
std::string unknown_option(const CLI::App& program, const Words& line) {
  const CLI::App& command = chosen_command(program);
  const std::vector<std::string> rest = command.remaining(true);
  for (const std::string& word : line) {
    const std::string name = name_of(word);
    const bool left_over = std::find(rest.begin(), rest.end(), word) != rest.end();
    const bool unknown = name.starts_with("--") ? name != "--" && !command.get_option_no_throw(name) : left_over;
    if (is_option(name) && unknown)
      return fmt::format("unknown option {}{}{}", name, name.starts_with("--") ? suggest_option(name, command) : "",
                         see_help(command));
  }
  return "";
}

/// Complaint about a word behind an option whose value may stand behind = alone; else empty.
std::string value_without_sign(const CLI::App& command, const Words& line) {
  for (size_t i = 1; i < line.size(); ++i) {
    const CLI::Option* option = is_option(line[i - 1]) ? command.get_option_no_throw(line[i - 1]) : nullptr;
    if (option && value_is_optional(*option) && !is_option(line[i]))
      return fmt::format("'{1}' stands behind {0}; its value is written {0}={1}", line[i - 1], line[i]);
  }
  return "";
}

/// The words by their place that a command takes: "TEST REFERENCE".
std::string places(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) names.push_back(option->get_type_name());
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, " "));
}

std::string too_many_words(const CLI::App& program, const Words& line) {
  const CLI::App& command = chosen_command(program);
  if (std::string hint = value_without_sign(command, line); !hint.empty()) return hint;
  const std::vector<std::string> rest = command.remaining(true);
  const auto extra = std::find_first_of(line.begin(), line.end(), rest.begin(), rest.end());
  return fmt::format("'{}' is a word too many: {} takes {}{}", extra == line.end() ? rest.front() : *extra,
                     command.get_name(), places(command), see_help(command));
}

std::string nothing_given(const CLI::App& program) {
  const CLI::App& command = chosen_command(program);
  if (&command == &program) return "no command is given; `lucarium --help` lists them";
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_required() && option->count() == 0) return missing_option(command, *option);
  }
  return "";
}

/// The option that a complaint of CLI11 begins with, or names as what it could not convert; else null.
const CLI::Option* option_of(const CLI::App& command, const std::string& complaint) {
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (complaint.starts_with(name + ":") || complaint.find(": " + name + " = ") != std::string::npos) return option;
  }
  return nullptr;
}

/// Complaint about the value of an option, or a word by its place.
std::string wrong_value(const CLI::App& program, const std::string& complaint, bool is_missing) {
  const CLI::App& command = chosen_command(program);
  const CLI::Option* option = option_of(command, complaint);
  std::string text = complaint;
  if (option && is_missing) {
    text = fmt::format("{} needs a value: {}", shown_name(*option), option->get_type_name());
  } else if (option && !takes_value(*option)) {
    text = shown_name(*option) + " takes no value";
  } else if (option) {
    text = shown_name(*option) + complaint.substr(std::min(complaint.size(), option->get_name().size()));
  }
  return text + see_help(command);
}

}  // namespace

std::string missing_option(const CLI::App& command, const CLI::Option& option) {
  const std::string value = option.get_positional() ? "" : " " + option.get_type_name();
  return fmt::format("{} needs {}{}: {}{}", command.get_name(), shown_name(option), value, option.get_description(),
                     see_help(command));
}

std::string unknown_command(const CLI::App& program, const Words& line) {
  const auto word = std::find_if_not(line.begin(), line.end(), is_option);
  if (&chosen_command(program) != &program || word == line.end()) return "";
  std::vector<std::string> commands;
  const auto is_shown = [](const CLI::App* sub) { return !sub->get_group().empty(); };
  for (const CLI::App* sub : program.get_subcommands(is_shown)) commands.push_back(sub->get_name());
  return fmt::format("unknown command '{}'{}", *word, suggest_name(*word, commands));
}

std::string missing_value(const CLI::App& program, const Words& line) {
  const CLI::App& command = chosen_command(program);
  for (const std::string& word : line) {
    const CLI::Option* option =
        is_option(word) && word.ends_with('=') ? command.get_option_no_throw(name_of(word)) : nullptr;
    if (!option || name_of(word).size() + 1 != word.size()) continue;
    if (value_is_optional(*option))
      return fmt::format("{} has no value; write {} alone, or {}{}", word, shown_name(*option), shown_name(*option),
                         without_brackets(option->get_type_name())) +
             see_help(command);
    if (takes_value(*option)) return wrong_value(program, option->get_name() + ":", true);
  }
  for (size_t i = 1; i < line.size(); ++i) {
    const CLI::Option* option = is_option(line[i - 1]) ? command.get_option_no_throw(line[i - 1]) : nullptr;
    const bool wants_value = option && takes_value(*option);
    if (line[i] == "--" && !wants_value) break;  // behind it words stand as they are: completion has empty ones
    if (line[i].empty() && !wants_value)
      return fmt::format("'' is an empty word: {} takes {}{}", command.get_name(), places(command), see_help(command));
    if (!wants_value || !(line[i].empty() || line[i].starts_with("--"))) continue;
    if (line[i].empty() || line[i] == "--" || command.get_option_no_throw(name_of(line[i])))
      return wrong_value(program, option->get_name() + ":", true);
  }
  return "";
}

std::string describe_mistake(const CLI::App& program, const CLI::ParseError& mistake, const Words& line) {
  for (const auto& complaint : {misplaced_option, unknown_command, unknown_option, missing_value}) {
    if (std::string text = complaint(program, line); !text.empty()) return text;
  }
  if (dynamic_cast<const CLI::ExtrasError*>(&mistake)) return too_many_words(program, line);
  if (dynamic_cast<const CLI::RequiredError*>(&mistake)) {
    if (std::string text = nothing_given(program); !text.empty()) return text;
  }
  return wrong_value(program, mistake.what(), dynamic_cast<const CLI::ArgumentMismatch*>(&mistake) != nullptr);
}

}  // namespace lucarium::app
