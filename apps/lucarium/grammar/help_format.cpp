// SPDX-License-Identifier: Apache-2.0
#include "grammar/help_format.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "grammar/option_texts.h"
#include "lucarium/base/text/text_values.h"

namespace lucarium::app {
namespace {

constexpr size_t page_columns = 120;

using Options = std::vector<const CLI::Option*>;

/// Characters, of which each takes one column.
size_t columns(const std::string& text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

/// "-o, --output FILE", "    --profile[=FILE]", "SCENE".
std::string left_side(const CLI::Option& option) {
  const std::string value = option.get_type_name();
  if (option.get_positional()) return value;
  std::string text = option.get_snames().empty() ? "    " : "-" + option.get_snames().front() + ", ";
  text += "--" + option.get_lnames().back();
  if (value.empty()) return text;
  return text + (value.starts_with("[=") ? "" : " ") + value;
}

bool is_flag(const CLI::Option& option) { return option.get_expected_min() == 0; }

bool is_repeatable(const CLI::Option& option) {
  if (option.get_positional()) return option.get_expected_max() > 1;
  return option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll && !is_flag(option);
}

std::string right_side(const CLI::Option& option) {
  std::string text = option.get_description();
  if (option.get_positional()) return text;
  std::vector<std::string> notes;
  if (is_repeatable(option)) notes.emplace_back("repeatable");
  if (option.get_required()) notes.emplace_back("required");
  if (!is_flag(option) && !option.get_default_str().empty()) notes.push_back("default: " + option.get_default_str());
  return notes.empty() ? text : text + " (" + CLI::detail::join(notes, "; ") + ")";
}

/// Two columns; what does not fit into a line goes on in the next one.
std::string row(const std::string& left, const std::string& right, size_t width) {
  std::string text, line = "  " + left + std::string(width - std::min(width, columns(left)), ' ') + "  ";
  const size_t indent = width + 4;
  for (const std::string& word : split(right, ' ')) {
    if (columns(line) + columns(word) > page_columns) {
      text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
      line = std::string(indent, ' ');
    }
    line += word + " ";
  }
  return text + line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
}

size_t left_width(const Options& options) {
  size_t width = 0;
  for (const CLI::Option* option : options) width = std::max(width, columns(left_side(*option)));
  return width;
}

std::string rows(const Options& options, size_t width) {
  std::string text;
  for (const CLI::Option* option : options) text += row(left_side(*option), right_side(*option), width);
  return text;
}

Options words(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

std::string usage(const CLI::App& app, const std::string& name) {
  std::string text = "Usage: " + name;
  for (const CLI::Option* word : words(app)) {
    const std::string value = word->get_type_name() + (is_repeatable(*word) ? "…" : "");
    text += word->get_required() ? " " + value : " [" + value + "]";
  }
  return text + (app.get_require_subcommand_min() > 0 ? " COMMAND" : "") + " [OPTIONS]\n";
}

/// How it is called, and what it does.
std::string head(const CLI::App& app, const std::string& name) {
  const std::string call = usage(app, name), line = call.substr(0, call.size() - 1) + ": " + app.get_description();
  return columns(line) <= page_columns ? line + "\n" : app.get_description() + "\n" + call;
}

std::string commands(const CLI::App& program) {
  const auto is_shown = [](const CLI::App* command) { return !command->get_group().empty(); };
  const std::vector<const CLI::App*> shown = program.get_subcommands(is_shown);
  size_t width = 0;
  for (const CLI::App* command : shown) width = std::max(width, command->get_name().size());
  std::string text = "Commands\n";
  for (const CLI::App* command : shown) text += row(command->get_name(), command->get_description(), width);
  return text;
}

class HelpFormat : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode) const override {
    const Options all = app->get_options({});
    const size_t width = left_width(all);
    std::string text = head(*app, name) + rows(words(*app), width);
    if (app->get_require_subcommand_min() > 0) text += commands(*app) + "\n";
    for (const std::string group : option_groups()) {
      Options members;
      for (const CLI::Option* option : all)
        if (option->get_group() == group) members.push_back(option);
      if (!members.empty()) text += group + "\n" + rows(members, width);
    }
    return text + app->get_footer() + "\n";
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> make_help_format() { return std::make_shared<HelpFormat>(); }

std::string short_help(const CLI::App& program) {
  return program.get_description() + "\n" + usage(program, program.get_name()) + commands(program) +
         program.get_footer() + "\n";
}

}  // namespace lucarium::app
