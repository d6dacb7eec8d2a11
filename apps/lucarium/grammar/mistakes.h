// SPDX-License-Identifier: Apache-2.0
// What is wrong with a command line, in one line that says what to do: the only place where CLI11's errors become ours.
#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class ParseError;
}  // namespace CLI

namespace lucarium::app {

using Words = std::vector<std::string>;  ///< of the line, behind the program's name

/// Complaint about a first word that names no command, which --help behind it would hide; else empty.
std::string unknown_command(const CLI::App& program, const Words& line);

/// Complaint about an option whose value was left out, so that the next option would be taken for it, or is empty, and
/// about an empty word by its place; else empty.
std::string missing_value(const CLI::App& program, const Words& line);

/// "render needs SCENE: a .gltf or .glb file, or builtin:NAME (see lucarium render --help)".
std::string missing_option(const CLI::App& command, const CLI::Option& option);

/// What is wrong with a line that CLI11 refused: commands and options that do not exist, with the nearest that do,
/// before anything that is missing.
std::string describe_mistake(const CLI::App& program, const CLI::ParseError& mistake, const Words& line);

}  // namespace lucarium::app
