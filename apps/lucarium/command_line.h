// SPDX-License-Identifier: Apache-2.0
// The grammar of the command line: commands and options that write into variables. command_line.cpp alone includes
// CLI11, which takes seconds to compile in every source that does.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace lucarium::app {

/// What an option's text must be; says what is wrong in one line, and shows in --help.
using Check = std::shared_ptr<const CLI::Validator>;
Check positive_number();                ///< finite and above 0
Check not_negative_number();            ///< finite and not below 0
Check finite_number();                  ///< neither infinite nor NaN
Check whole_number(uint64_t smallest);  ///< decimal digits alone, up to 2⁶⁴ − 1
Check existing_folder();
Check in_range(int low, int high);
Check in_range(unsigned low, unsigned high);
Check one_of(std::vector<std::string> words);

/// An option that was added; each function says one thing more about it: add_option(…)->required()->check(…).
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option* operator->() { return this; }
  Option required();
  Option check(const Check& check);
  Option take_all();  ///< may be given several times; without it the last one counts
  Option take_last();
  Option expected(int values);          ///< words after each use of it
  Option allow_extra_args(bool allow);  ///< false: no further words than expected() belong to it
  Option trigger_on_parse();            ///< calls its function at its place on the line, not at the end
  Option capture_default_str();         ///< --help shows the variable's value as the default
  Option excludes(const std::string& other);

 private:
  CLI::Option* option_;
};

/// A command of the program, or the program itself.
class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}
  Command add_subcommand(const std::string& name, const std::string& text);
  /// names: "-o,--output", or "scene" for a word by its place. The types that there are stand in command_line.cpp.
  template <class Value>
  Option add_option(const std::string& names, Value& value, const std::string& text);
  Option add_option_function(const std::string& names, const std::function<void(const std::string&)>& take,
                             const std::string& text);
  /// "--profile{-}" gives a text that --profile=TEXT replaces.
  template <class Value>
  Option add_flag(const std::string& names, Value& value, const std::string& text);
  void hide();                                         ///< from --help
  void callback(const std::function<void()>& chosen);  ///< called when the command was chosen and all is well

 private:
  CLI::App* app_;
};

/// Reads a whole command line.
class CommandLine {
 public:
  CommandLine(const std::string& name, const std::string& text, const std::string& version);
  CommandLine(CommandLine&&) noexcept;
  ~CommandLine();
  Command program();
  /// The tree of commands and options, for what reads it: completions, pages.
  const CLI::App& app() const { return *app_; }
  /// Fills the variables and calls the chosen command's callback. The exit code when all there was to do is done
  /// (--help, --version). Throws Error{usage}, which names the nearest command or option where one does not exist.
  std::optional<int> parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace lucarium::app
