// SPDX-License-Identifier: Apache-2.0
// The completion script of fish. Declared in completion.h.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "manual/completion.h"

namespace lucarium::app {
namespace {

constexpr size_t max_place = 1000;  // of a word that may be given several times

constexpr const char* fish_head = R"fish(# fish completion of lucarium; made by `lucarium completion fish`.

# The first word that is no option is $argv, or there is none and neither is $argv.
function __lucarium_command
    set -l words (commandline -opc)
    for word in $words[2..]
        string match -q -- '-*' $word; and continue
        test "$word" = "$argv"
        return
    end
    test -z "$argv"
end

# Whether the word at the cursor is one by its place of the command $argv[1], and not before place $argv[2] (from 0) or
# behind place $argv[3].
function __lucarium_place
    set -l words (commandline -opc)
    set -l command
    set -l place 0
    set -l valued (__lucarium_valued $argv[1])
    set -l value no
    for word in $words[2..]
        if test $value = yes
            set value no
        else if contains -- $word $valued
            set value yes
        else if string match -q -- '-*' $word
            continue
        else if test -z "$command"
            set command $word
        else
            set place (math $place + 1)
        end
    end
    test $value = no -a "$command" = "$argv[1]" -a $place -ge $argv[2] -a $place -le $argv[3]
end

# Names that the program knows, with those of its plug-ins.
function __lucarium_ask
    set -l words (commandline -opc)
    set -l typed (commandline -ct | string replace -r -- '^(--[^=]*=|-[a-zA-Z])' '' | string trim -l -c '\'"')
    $words[1] complete $argv -- $words[2..] "$typed" 2>/dev/null
end

complete -c lucarium -f
)fish";

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') result += '\\';
    result += c;
  }
  return result + "'";
}

/// What says which values there are; -f: no files.
std::string values(const OptionDeclaration& option, const std::string& commands) {
  switch (const ValueKind kind = value_kind(option)) {
    case ValueKind::words: return fmt::format(" -f -a '{}'", fmt::join(option.words, " "));
    case ValueKind::file: return " -F";
    case ValueKind::folder: return " -f -a '(__fish_complete_directories (commandline -ct))'";
    case ValueKind::scene: return " -F -a '(__lucarium_ask scene)'";
    case ValueKind::command: return fmt::format(" -f -a '{}'", commands);
    default: return asked_kind(kind).empty() ? " -f" : fmt::format(" -f -a '(__lucarium_ask {})'", asked_kind(kind));
  }
}

/// The options of each command that a value stands behind, for __lucarium_place.
std::string valued_options(const ProgramDeclaration& program) {
  std::string text = "\nfunction __lucarium_valued\n    switch $argv\n";
  for (const CommandDeclaration& command : program.commands) {
    std::string names;
    for (const OptionDeclaration& option : command.options) {
      if (!option.is_flag() && !option.value_optional) names += fmt::format(" {}", fmt::join(option.names, " "));
    }
    if (!names.empty())
      text += fmt::format("        case {}\n            string split ' ' -- '{}'\n", command.name, names.substr(1));
  }
  return text + "    end\nend\n\n";
}

std::string lines(const CommandDeclaration& command, const std::string& name, const std::string& commands) {
  const std::string when =
      fmt::format("complete -c lucarium -n '__lucarium_command{}'", name.empty() ? "" : " " + name);
  std::string text;
  for (size_t i = 0; i < command.words.size(); ++i) {
    const OptionDeclaration& word = command.words[i];
    text += fmt::format("complete -c lucarium -n '__lucarium_place {} {} {}'{}\n", name, i,
                        word.repeatable ? max_place : i, values(word, commands));
  }
  for (const OptionDeclaration& option : command.options) {
    text += when;
    for (const std::string& own : option.names)
      text += own.starts_with("--") ? " -l " + own.substr(2) : " -s " + own.substr(1);
    if (!option.is_flag() && !option.value_optional) text += " -r";
    if (!option.is_flag()) text += values(option, commands);
    text += " -d " + quoted(option.text) + "\n";
  }
  return text;
}

}  // namespace

std::string fish_completion(const ProgramDeclaration& program) {
  std::string names, text = fish_head + valued_options(program);
  for (const CommandDeclaration& command : program.commands) {
    names += (names.empty() ? "" : " ") + command.name;
    text += fmt::format("complete -c lucarium -n __lucarium_command -a {} -d {}\n", command.name, quoted(command.text));
  }
  text += lines(program.program, "", names);
  for (const CommandDeclaration& command : program.commands) text += lines(command, command.name, names);
  return text;
}

}  // namespace lucarium::app
