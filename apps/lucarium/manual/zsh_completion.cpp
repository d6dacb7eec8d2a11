// SPDX-License-Identifier: Apache-2.0
// The completion script of zsh. Declared in completion.h.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "manual/completion.h"

namespace lucarium::app {
namespace {

constexpr const char* zsh_head = R"zsh(#compdef lucarium
# zsh completion of lucarium; made by `lucarium completion zsh`.

# Names that the program knows, with those of its plug-ins.
_lucarium_ask() {
  local line name
  local -a names texts open open_texts
  for line in ${(f)"$($program complete $1 -- "${(@Q)words[1,CURRENT-1]}" "$PREFIX" 2>/dev/null)"}; do
    name=${line%%$'\t'*}
    if [[ $name == *[:=] ]]; then
      open+=("$name")
      open_texts+=("${line/$'\t'/  -- }")
    else
      names+=("$name")
      texts+=("${line/$'\t'/  -- }")
    fi
  done
  (( $#open )) && compadd -S '' -l -d open_texts -a open
  (( $#names )) && compadd -l -d texts -a names
  (( $#open + $#names ))
}

_lucarium_scene() {
  local found=1
  _lucarium_ask scene && found=0
  _files && found=0
  return found
}

_lucarium_commands() {
  local -a commands=(
)zsh";

constexpr const char* begin = R"zsh(  )
  _describe command commands
}

_lucarium() {
  local program=$words[1] curcontext=$curcontext state line found=1
  local -A opt_args
)zsh";

/// Text within single quotes, and within [] or before a colon.
std::string escape(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
      result += c;
    }
  }
  return result;
}

/// A leading space keeps _arguments from adding arguments of its own.
std::string action(const OptionDeclaration& option) {
  switch (const ValueKind kind = value_kind(option)) {
    case ValueKind::words: return fmt::format("({})", fmt::join(option.words, " "));
    case ValueKind::file: return "_files";
    case ValueKind::folder: return "_files -/";
    case ValueKind::scene: return "_lucarium_scene";
    case ValueKind::command: return "_lucarium_commands";
    default: return asked_kind(kind).empty() ? "( )" : " _lucarium_ask " + asked_kind(kind);
  }
}

/// "'--spp=[samples per pixel]:N:( )'", and one more for a second name.
std::string specifications(const OptionDeclaration& option, const std::string& indent) {
  std::string text;
  for (const std::string& name : option.names) {
    const std::string others = option.repeatable ? "*" : fmt::format("({})", fmt::join(option.names, " "));
    // A value stands behind a space or, of a long name, behind =; an optional one behind = alone.
    const std::string sign = option.is_flag() ? "" : option.value_optional ? "=-" : name.starts_with("--") ? "=" : "+";
    text += fmt::format("{}'{}{}{}[{}]", indent, others, name, sign, escape(option.text));
    if (!option.is_flag())
      text += fmt::format("{}{}:{}", option.value_optional ? "::" : ":", escape(option.value), action(option));
    text += "' \\\n";
  }
  return text;
}

std::string arguments(const CommandDeclaration& command, const std::string& indent) {
  std::string text;
  for (const OptionDeclaration& option : command.options) text += specifications(option, indent);
  for (const OptionDeclaration& word : command.words)
    text += fmt::format("{}'{}:{}:{}' \\\n", indent, word.repeatable ? "*" : "", escape(word.value), action(word));
  return text;
}

}  // namespace

std::string zsh_completion(const ProgramDeclaration& program) {
  std::string text = zsh_head;
  for (const CommandDeclaration& command : program.commands)
    text += fmt::format("    '{}:{}'\n", command.name, escape(command.text));
  text += begin;
  text += "  _arguments -C -A '-*' \\\n" + arguments(program.program, "    ") +
          "    '1:command:_lucarium_commands' \\\n    '*::word:->word' && found=0\n"
          "  [[ $state == word ]] || return found\n  case $words[1] in\n";
  for (const CommandDeclaration& command : program.commands) {
    text += fmt::format("    {})\n      _arguments \\\n{}        && found=0\n      ;;\n", command.name,
                        arguments(command, "        "));
  }
  return text + "  esac\n  return found\n}\n\n_lucarium \"$@\"\n";
}

}  // namespace lucarium::app
