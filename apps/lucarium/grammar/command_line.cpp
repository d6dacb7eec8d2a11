// SPDX-License-Identifier: Apache-2.0
#include "grammar/command_line.h"

#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>

#include "grammar/help_format.h"
#include "grammar/mistakes.h"
#include "grammar/option_texts.h"
#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/base/utf8.h"

namespace lucarium::app {
namespace {

CLI::Option* describe(CLI::Option* option, const OptionText& entry) {
  if (*entry.group) option->group(entry.group);
  if (*entry.value) option->type_name(entry.value);
  return option;
}

/// Before the command's name and behind it.
void add_message_options(CLI::App& app, Messages& messages, const std::string& version) {
  const auto add_flag = [&app](const char* name, bool& value) {
    const OptionText& entry = option_text(name);
    describe(app.add_flag(entry.names, value, entry.text), entry);
  };
  add_flag("--json", messages.json);
  add_flag("--quiet", messages.quiet);
  add_flag("--verbose", messages.verbose);
  const OptionText &help = option_text("--help"), &number = option_text("--version");
  describe(app.set_help_flag(help.names, help.text), help);
  describe(app.set_version_flag(number.names, version, number.text), number);
}

/// Behind the command's name or, of the options that every command takes, before it.
bool is_given(const CLI::App& command, const std::string& name) {
  if (command.get_option(name)->count() > 0) return true;
  const CLI::App* program = command.get_parent();
  const CLI::Option* before = program ? program->get_option_no_throw(name) : nullptr;
  return before && before->count() > 0;
}

/// Asked before the options have set anything: --version ends the reading of the command line.
bool wants_json(const CLI::App& program) {
  const auto commands = program.get_subcommands();
  return is_given(commands.empty() ? program : *commands.front(), "--json");
}

/// `text`: "lucarium 1.2.3".
std::string version_json(const std::string& text) {
  const size_t blank = text.find(' ');
  const nlohmann::ordered_json json = {
      {"schema", "lucarium-version-1"}, {"program", text.substr(0, blank)}, {"version", text.substr(blank + 1)}};
  return json.dump(2);
}

/// As the help names it: "--spp", "SCENE".
std::string shown(const CLI::App& command, const std::string& name) {
  const CLI::Option* option = command.get_option(name);
  return option->get_positional() ? option->get_type_name() : name;
}

template <class Validator>
Check make_check(Validator validator) {
  return std::make_shared<const CLI::Validator>(std::move(validator));
}

}  // namespace

Check positive_number() {
  return make_check(CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0;
        return good ? std::string() : fmt::format("'{}' is not a number above 0", text);
      },
      ""));
}

Check not_negative_number() {
  return make_check(CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0;
        return good ? std::string() : fmt::format("'{}' is not a number from 0", text);
      },
      ""));
}

Check finite_number() {
  return make_check(CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
        return good ? std::string() : fmt::format("'{}' is not a finite number", text);
      },
      ""));
}

Check whole_number(uint64_t smallest) {
  return make_check(CLI::Validator(
      [smallest](std::string& text) {
        uint64_t value = 0;
        const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (failure != std::errc() || end != text.data() + text.size() || value < smallest) {
          return fmt::format("'{}' is not a whole number from {} to {}", text, smallest,
                             std::numeric_limits<uint64_t>::max());
        }
        text = std::to_string(value);  // CLI11 takes leading zeros for an octal number
        return std::string();
      },
      ""));
}

Check existing_folder() {
  return make_check(CLI::Validator(
      [](std::string& text) {
        std::error_code ignored;
        const bool there = std::filesystem::is_directory(text, ignored);
        return there ? std::string() : fmt::format("there is no folder '{}'", text);
      },
      ""));
}

Check in_range(int low, int high) {
  return make_check(CLI::Validator(
      [low, high](std::string& text) {
        int value = 0;
        const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
        const bool good = failure == std::errc() && end == text.data() + text.size() && value >= low && value <= high;
        if (!good) return fmt::format("'{}' is not a whole number from {} to {}", text, low, high);
        text = std::to_string(value);  // CLI11 takes leading zeros for an octal number
        return std::string();
      },
      ""));
}

Check one_of(std::vector<std::string> words) {
  return make_check(CLI::Validator(
      [words = std::move(words)](std::string& text) {
        if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
        const std::string near = nearest_name(text, words);
        return fmt::format("'{}' is none of {}{}", text, fmt::join(words, ", "),
                           near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
      },
      ""));
}

void Messages::apply() const { set_log_level(quiet ? LogLevel::error : verbose ? LogLevel::info : LogLevel::warning); }

Option Option::required() { return Option(option_->required()); }
// CLI11's check() drops what a check makes of the text (whole_number: no leading zeros); its transform() keeps it.
Option Option::check(const Check& check) {
  return Option(option_->transform(CLI::Validator(*check).description("")));  // its value_name() says it
}
Option Option::repeatable() { return Option(option_->take_all()->expected(1)->allow_extra_args(false)); }
Option Option::trigger_on_parse() { return Option(option_->trigger_on_parse()->take_last()); }
Option Option::default_text(const std::string& text) { return Option(option_->default_str(text)); }
Option Option::capture_default_str() { return Option(option_->capture_default_str()); }
Option Option::value_name(const std::string& name) { return Option(option_->type_name(name)); }

Command::Command(CLI::App& app, std::shared_ptr<Messages> messages)
    : app_(&app), messages_(std::move(messages)), rules_(std::make_shared<std::vector<std::function<void()>>>()) {}

Command Command::add_subcommand(const std::string& name, const std::string& text) {
  Command command(*app_->add_subcommand(name, text), messages_);
  add_message_options(*command.app_, *messages_, app_->version());
  return command;
}

void Command::examples(const std::vector<std::string>& lines, const std::string& page) {
  std::string text = "Examples\n";
  for (const std::string& line : lines) text += "  " + line + "\n";
  app_->footer(text + "More: " + page);
}

template <class Value>
Option Command::option(const std::string& name, Value& value) {
  const OptionText& entry = option_text(name);
  return Option(describe(app_->add_option(entry.names, value, entry.text), entry));
}
template Option Command::option(const std::string&, int&);
template Option Command::option(const std::string&, uint32_t&);
template Option Command::option(const std::string&, uint64_t&);
template Option Command::option(const std::string&, float&);
template Option Command::option(const std::string&, double&);
template Option Command::option(const std::string&, std::string&);
template Option Command::option(const std::string&, std::filesystem::path&);
template Option Command::option(const std::string&, std::vector<uint64_t>&);
template Option Command::option(const std::string&, std::vector<double>&);
template Option Command::option(const std::string&, std::vector<std::string>&);
template Option Command::option(const std::string&, std::vector<std::filesystem::path>&);
template Option Command::option(const std::string&, std::optional<float>&);
template Option Command::option(const std::string&, std::optional<double>&);
template Option Command::option(const std::string&, std::optional<std::string>&);

Option Command::option_function(const std::string& name, const std::function<void(const std::string&)>& take) {
  const OptionText& entry = option_text(name);
  return Option(describe(app_->add_option_function<std::string>(entry.names, take, entry.text), entry));
}

template <class Value>
Option Command::flag(const std::string& name, Value& value) {
  const OptionText& entry = option_text(name);
  const std::string alone = std::is_same_v<Value, std::string> ? "{-}" : "";
  return Option(describe(app_->add_flag(entry.names + alone, value, entry.text), entry));
}
template Option Command::flag(const std::string&, bool&);
template Option Command::flag(const std::string&, std::string&);

bool Command::given(const std::string& name) const { return is_given(*app_, name); }

void Command::needs(const std::vector<std::string>& names, const std::vector<std::string>& others) {
  rules_->push_back([app = app_, names, others] {
    const auto given = [app](const std::string& name) { return is_given(*app, name); };
    if (std::any_of(others.begin(), others.end(), given)) return;
    std::vector<std::string> wanted;
    for (const std::string& other : others) wanted.push_back(shown(*app, other));
    for (const std::string& name : names) {
      if (given(name))
        throw_error(ErrorClass::usage, "{} does nothing without {}", shown(*app, name), fmt::join(wanted, " or "));
    }
  });
}

void Command::excludes(const std::vector<std::string>& names, const std::vector<std::string>& others) {
  rules_->push_back([app = app_, names, others] {
    for (const std::string& name : names) {
      for (const std::string& other : others) {
        if (is_given(*app, name) && is_given(*app, other))
          throw_error(ErrorClass::usage, "give {} or {}, not both", shown(*app, name), shown(*app, other));
      }
    }
  });
}

void Command::required_without(const std::string& option, const std::vector<std::string>& words) {
  rules_->push_back([app = app_, option, words] {
    const auto given = [app](const std::string& word) { return is_given(*app, word); };
    if (is_given(*app, option) && std::none_of(words.begin(), words.end(), given)) return;
    for (const std::string& word : words) {
      if (!given(word)) throw Error(ErrorClass::usage, missing_option(*app, *app->get_option(word)));
    }
  });
}

void Command::hide() { app_->group(""); }

void Command::callback(const std::function<void()>& chosen) {
  app_->callback([rules = rules_, chosen] {
    for (const std::function<void()>& rule : *rules) rule();
    chosen();
  });
}

CommandLine::CommandLine(const std::string& name, const std::string& text, const std::string& version)
    : app_(std::make_unique<CLI::App>(text, name)), messages_(std::make_shared<Messages>()) {
  app_->formatter(make_help_format());
  app_->require_subcommand(1);
  app_->option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);  // the last one wins
  add_message_options(*app_, *messages_, name + " " + version);
}

CommandLine::CommandLine(CommandLine&&) noexcept = default;
CommandLine::~CommandLine() = default;

Command CommandLine::program() { return Command(*app_, messages_); }

std::optional<int> CommandLine::parse(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  for (const std::string& argument : arguments) {
    if (!is_utf8(argument)) throw_error(ErrorClass::usage, "'{}' is not UTF-8; give it another name", argument);
  }
  if (arguments.empty()) {
    print_note("{}", short_help(*app_));
    return static_cast<int>(ErrorClass::usage);
  }
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& help) {
    if (const std::string unknown = unknown_command(*app_, arguments); !unknown.empty())
      throw Error(ErrorClass::usage, unknown);
    if (dynamic_cast<const CLI::CallForVersion*>(&help) && wants_json(*app_)) {
      print_result("{}\n", version_json(app_->version()));
      return 0;
    }
    std::ostringstream text;
    const int code = app_->exit(help, text, text);
    print_text(text.str());
    return code;
  } catch (const CLI::ParseError& mistake) {
    throw Error(ErrorClass::usage, describe_mistake(*app_, mistake, arguments));
  } catch (const Error&) {  // of a rule about options, which takes what has no value for something else
    if (const std::string missing = missing_value(*app_, arguments); !missing.empty())
      throw Error(ErrorClass::usage, missing);
    throw;
  }
  if (const std::string missing = missing_value(*app_, arguments); !missing.empty())
    throw Error(ErrorClass::usage, missing);
  if (messages_->quiet && messages_->verbose) throw Error(ErrorClass::usage, "give --quiet or --verbose, not both");
  return std::nullopt;
}

}  // namespace lucarium::app
