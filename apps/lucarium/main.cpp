// SPDX-License-Identifier: Apache-2.0
// lucarium: the command-line program. All work is in the library; this only reads arguments and prints.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <new>

#include "commands.h"
#include "lucarium/base/child_process.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/log.h"
#include "lucarium/base/nearest_name.h"
#include "lucarium/version.h"

namespace {

using namespace lucarium;

/// One line, whatever a library put into the message.
void print_error(std::string message, const std::string& details) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  fmt::print(stderr, "lucarium: error: {}\n", message);
  if (!details.empty() && log_level() >= LogLevel::info) fmt::print(stderr, "{}\n", details);
}

/// The subcommand that was named, else the program itself.
const CLI::App& chosen_command(const CLI::App& program) {
  const auto commands = program.get_subcommands();
  return commands.empty() ? program : *commands.front();
}

/// Complaint about a first argument that names no command, which --help behind it would hide; else empty.
std::string unknown_command(const CLI::App& program, const std::vector<std::string>& arguments) {
  if (&chosen_command(program) != &program || arguments.empty() || arguments.front().starts_with("-")) return "";
  std::vector<std::string> commands;
  for (const CLI::App* sub : program.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(sub->get_name());
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

int run(int argc, char** argv) {
  CLI::App program("Compares global-illumination techniques on glTF scenes, on any OpenCL device.", "lucarium");
  program.set_version_flag("--version", std::string("lucarium ") + LUCARIUM_VERSION);
  program.require_subcommand(1);
  program.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);  // the last one wins
  app::Action action;
  app::add_render_command(program, action);
  app::add_reference_command(program, action);
  app::add_compare_command(program, action);
  app::add_reproduce_command(program, action);
  app::add_report_command(program, action);
  app::add_diff_command(program, action);
  app::add_scene_command(program, action);
  app::add_techniques_command(program, action);
  app::add_devices_command(program, action);
  app::add_check_command(program, action);
  app::add_new_technique_command(program, action);
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help) {
    if (const std::string unknown = unknown_command(program, {argv + 1, argv + argc}); !unknown.empty()) {
      print_error(unknown, "");
      return static_cast<int>(ErrorClass::usage);
    }
    return program.exit(help);
  } catch (const CLI::ParseError& mistake) {
    print_error(describe_mistake(program, mistake, {argv + 1, argv + argc}), "");
    return static_cast<int>(ErrorClass::usage);
  }
  install_interrupt_handler();
  end_with_parent();
  return action();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    print_error(error.what(), error.details());
    return error.exit_code();
  } catch (const std::bad_alloc&) {
    print_error("the host's memory does not suffice; use a smaller scene, --size or --texture-size", "");
    return static_cast<int>(ErrorClass::device);
  } catch (const std::exception& error) {
    print_error(fmt::format("internal: {}; please report it", error.what()), "");
  } catch (...) {
    print_error("internal: something that is no exception was thrown; please report it", "");
  }
  return static_cast<int>(ErrorClass::internal);
}
