// SPDX-License-Identifier: Apache-2.0
// What the command line declares, as data: completions, manual pages and docs/command_line.md are made from it.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace lucarium::app {

struct OptionDeclaration {
  std::string name;                ///< "--output", or "scene" of a word by its place
  std::vector<std::string> names;  ///< "-o", "--output"; none of a word by its place
  std::string value;               ///< what its value is called; empty of a flag
  std::string text, group;
  std::string fallback;            ///< what holds without it; empty: nothing, or the text says it
  std::vector<std::string> words;  ///< values to choose from; empty: any
  bool required = false, repeatable = false;
  bool value_optional = false;  ///< --profile or --profile=FILE

  bool is_flag() const { return value.empty(); }
  bool has(std::string_view wanted) const;
  /// "-o, --output FILE", "--profile[=FILE]", "SCENE".
  std::string usage() const;
};

struct CommandDeclaration {
  std::string name, text;
  std::vector<OptionDeclaration> words;    ///< by their place
  std::vector<OptionDeclaration> options;  ///< in order of their groups
  std::vector<std::string> examples;       ///< command lines
  std::string page;                        ///< what to read, below the repository

  std::vector<std::string> groups() const;
  /// "lucarium render SCENE [OPTIONS]".
  std::string usage(const std::string& program) const;
};

struct ProgramDeclaration {
  CommandDeclaration program;                                      ///< what holds without a command
  std::vector<CommandDeclaration> commands;                        ///< those that --help shows
  std::vector<CommandDeclaration> hidden;                          ///< those that the program itself calls
  const CommandDeclaration& command(std::string_view name) const;  ///< throws Error{usage}
};

/// Reads the tree of build_app().
ProgramDeclaration read_declarations(const CLI::App& app);

/// What a value is, for a completion.
enum class ValueKind { nothing, free, words, file, folder, scene, technique, parameter, experiment, command };
ValueKind value_kind(const OptionDeclaration& option);

/// "technique" and so on, as `lucarium complete` takes it; empty where the shell finds the values itself.
std::string asked_kind(ValueKind kind);

}  // namespace lucarium::app
