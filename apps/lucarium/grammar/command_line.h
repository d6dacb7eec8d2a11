// SPDX-License-Identifier: Apache-2.0
// The grammar of the command line: commands and options that write into variables. Sources that include CLI11 take
// seconds to compile; command_line.cpp and those that read its tree do, nobody else.
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

/// What an option's text must be; says what is wrong in one line.
using Check = std::shared_ptr<const CLI::Validator>;
Check positive_number();                ///< finite and above 0
Check not_negative_number();            ///< finite and not below 0
Check finite_number();                  ///< neither infinite nor NaN
Check whole_number(uint64_t smallest);  ///< decimal digits alone, up to 2⁶⁴ − 1
Check existing_folder();
Check in_range(int low, int high);  ///< a whole number
Check one_of(std::vector<std::string> words);

/// How the program talks: what every command takes.
struct Messages {
  bool json = false, quiet = false, verbose = false;
  void apply() const;  ///< sets the log level
};

/// An option that was added; each function says one thing more about it: option(…).required().check(…).
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option required();
  Option check(const Check& check);
  Option repeatable();                           ///< may be given several times; without it the last one counts
  Option trigger_on_parse();                     ///< calls its function at its place on the line, not at the end
  Option default_text(const std::string& text);  ///< what holds without it, for --help
  Option capture_default_str();                  ///< the variable's value is that
  Option value_name(const std::string& name);    ///< what its value is called here

 private:
  CLI::Option* option_;
};

/// A command of the program, or the program itself. Names, groups and texts of options stand in option_texts.cpp.
class Command {
 public:
  Command(CLI::App& app, std::shared_ptr<Messages> messages);
  /// With the options of Messages, --help and --version.
  Command add_subcommand(const std::string& name, const std::string& text);
  /// Foot of --help: command lines that work as they stand, and the page to read.
  void examples(const std::vector<std::string>& lines, const std::string& page);
  /// "--output", or "scene" for a word by its place. The types that there are stand in command_line.cpp.
  template <class Value>
  Option option(const std::string& name, Value& value);
  Option option_function(const std::string& name, const std::function<void(const std::string&)>& take);
  /// A text as value is "-" for --profile, TEXT for --profile=TEXT.
  template <class Value>
  Option flag(const std::string& name, Value& value);
  /// None of `names` does anything without one of `others`: a mistake then.
  void needs(const std::vector<std::string>& names, const std::vector<std::string>& others);
  /// None of `names` may be given beside one of `others`: a mistake then.
  void excludes(const std::vector<std::string>& names, const std::vector<std::string>& others);
  /// `words`, which stand by their place, must be given without `option`: a mistake then.
  void required_without(const std::string& option, const std::vector<std::string>& words);
  bool given(const std::string& name) const;           ///< on the line that was parsed
  void hide();                                         ///< from --help
  void callback(const std::function<void()>& chosen);  ///< called when the command was chosen and all is well

 private:
  CLI::App* app_;
  std::shared_ptr<Messages> messages_;
  std::shared_ptr<std::vector<std::function<void()>>> rules_;  ///< looked at before the callback
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
  const Messages& messages() const { return *messages_; }
  /// Fills the variables and calls the chosen command's callback. The exit code when all there was to do is done
  /// (--help, --version, no word at all). Throws Error{usage}, which names the nearest command or option where one does
  /// not exist.
  std::optional<int> parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
  std::shared_ptr<Messages> messages_;
};

}  // namespace lucarium::app
