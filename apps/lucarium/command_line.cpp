// SPDX-License-Identifier: Apache-2.0
#include "command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "lucarium/base/error.h"
#include "lucarium/base/nearest_name.h"

namespace lucarium::app {
namespace {

/// The subcommand that was named, else the program itself.
const CLI::App& chosen_command(const CLI::App& program) {
  const auto commands = program.get_subcommands();
  return commands.empty() ? program : *commands.front();
}

/// Complaint about a first argument that names no command, which --help behind it would hide; else empty.
std::string unknown_command(const CLI::App& program, const std::vector<std::string>& arguments) {
  if (&chosen_command(program) != &program || arguments.empty() || arguments.front().starts_with("-")) return "";
  std::vector<std::string> commands;
  const auto is_shown = [](const CLI::App* sub) { return !sub->get_group().empty(); };
  for (const CLI::App* sub : program.get_subcommands(is_shown)) commands.push_back(sub->get_name());
  return fmt::format("unknown command '{}'{}", arguments.front(), suggest_name(arguments.front(), commands));
}

/// What is wrong with the arguments: a command or option that does not exist, with the nearest that does, before
/// anything that CLI11 finds missing.
std::string describe_mistake(const CLI::App& program, const CLI::ParseError& mistake,
                             const std::vector<std::string>& arguments) {
  const CLI::App& command = chosen_command(program);
  std::vector<std::string> options;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  }
  if (const std::string unknown = unknown_command(program, arguments); !unknown.empty()) return unknown;
  for (const std::string& argument : arguments) {
    const std::string name = argument.substr(0, argument.find('='));
    if (name.starts_with("--") && name != "--" && std::find(options.begin(), options.end(), name) == options.end()) {
      return fmt::format("unknown option {}{}", name, suggest_name(name, options));
    }
  }
  return fmt::format("{} (see lucarium{} --help)", mistake.what(),
                     &command == &program ? "" : " " + command.get_name());
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
      "above 0"));
}

Check not_negative_number() {
  return make_check(CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0;
        return good ? std::string() : fmt::format("'{}' is not a number from 0", text);
      },
      "not negative"));
}

Check finite_number() {
  return make_check(CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
        return good ? std::string() : fmt::format("'{}' is not a finite number", text);
      },
      "finite"));
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
      "whole number"));
}

Check existing_folder() {
  return make_check(CLI::Validator(
      [](std::string& text) {
        std::error_code ignored;
        const bool there = std::filesystem::is_directory(text, ignored);
        return there ? std::string() : fmt::format("there is no folder '{}'", text);
      },
      "FOLDER"));
}

Check in_range(int low, int high) { return make_check(CLI::Range(low, high)); }
Check in_range(unsigned low, unsigned high) { return make_check(CLI::Range(low, high)); }
Check one_of(std::vector<std::string> words) { return make_check(CLI::IsMember(std::move(words))); }

Option Option::required() { return Option(option_->required()); }
// CLI11's check() drops what a check makes of the text (whole_number: no leading zeros); its transform() keeps it.
Option Option::check(const Check& check) { return Option(option_->transform(*check)); }
Option Option::take_all() { return Option(option_->take_all()); }
Option Option::take_last() { return Option(option_->take_last()); }
Option Option::expected(int values) { return Option(option_->expected(values)); }
Option Option::allow_extra_args(bool allow) { return Option(option_->allow_extra_args(allow)); }
Option Option::trigger_on_parse() { return Option(option_->trigger_on_parse()); }
Option Option::capture_default_str() { return Option(option_->capture_default_str()); }
Option Option::excludes(const std::string& other) { return Option(option_->excludes(other)); }

Command Command::add_subcommand(const std::string& name, const std::string& text) {
  return Command(*app_->add_subcommand(name, text));
}

template <class Value>
Option Command::add_option(const std::string& names, Value& value, const std::string& text) {
  return Option(app_->add_option(names, value, text));
}
template Option Command::add_option(const std::string&, int&, const std::string&);
template Option Command::add_option(const std::string&, uint32_t&, const std::string&);
template Option Command::add_option(const std::string&, uint64_t&, const std::string&);
template Option Command::add_option(const std::string&, float&, const std::string&);
template Option Command::add_option(const std::string&, double&, const std::string&);
template Option Command::add_option(const std::string&, std::string&, const std::string&);
template Option Command::add_option(const std::string&, std::filesystem::path&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<uint64_t>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::filesystem::path>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<float>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<std::string>&, const std::string&);

Option Command::add_option_function(const std::string& names, const std::function<void(const std::string&)>& take,
                                    const std::string& text) {
  return Option(app_->add_option_function<std::string>(names, take, text));
}

template <class Value>
Option Command::add_flag(const std::string& names, Value& value, const std::string& text) {
  return Option(app_->add_flag(names, value, text));
}
template Option Command::add_flag(const std::string&, bool&, const std::string&);
template Option Command::add_flag(const std::string&, std::string&, const std::string&);

void Command::hide() { app_->group(""); }
void Command::callback(const std::function<void()>& chosen) { app_->callback(chosen); }

CommandLine::CommandLine(const std::string& name, const std::string& text, const std::string& version)
    : app_(std::make_unique<CLI::App>(text, name)) {
  app_->set_version_flag("--version", name + " " + version);
  app_->require_subcommand(1);
  app_->option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);  // the last one wins
}

CommandLine::CommandLine(CommandLine&&) noexcept = default;
CommandLine::~CommandLine() = default;

Command CommandLine::program() { return Command(*app_); }

std::optional<int> CommandLine::parse(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& help) {
    if (const std::string unknown = unknown_command(*app_, arguments); !unknown.empty())
      throw Error(ErrorClass::usage, unknown);
    return app_->exit(help);
  } catch (const CLI::ParseError& mistake) {
    throw Error(ErrorClass::usage, describe_mistake(*app_, mistake, arguments));
  }
  return std::nullopt;
}

}  // namespace lucarium::app
