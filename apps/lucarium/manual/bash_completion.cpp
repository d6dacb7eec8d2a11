// SPDX-License-Identifier: Apache-2.0
// The completion script of bash. Declared in completion.h.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

#include "manual/completion.h"

namespace lucarium::app {
namespace {

constexpr const char* bash_head = R"bash(# bash completion of lucarium; made by `lucarium completion bash`.

# Names that the program knows, with those of its plug-ins.
_lucarium_ask() {
  local name
  while IFS=$'\t' read -r name _; do
    COMPREPLY+=("$name")
  done < <("${words[0]}" complete "$1" -- "${words[@]:1:${#words[@]}-2}" "$cur" 2>/dev/null)
}

_lucarium() {
  # The words without their quotes, up to the cursor: COMP_WORDS parts them at : and =.
  local line=${COMP_LINE:0:COMP_POINT} words=() cur= command= option= prefix= place=0 i char quote= begun=
  for ((i = 0; i < ${#line}; ++i)); do
    char=${line:i:1}
    if [[ -n $quote && $char == "$quote" ]]; then
      quote=
    elif [[ -z $quote && $char == [\'\"] ]]; then
      quote=$char begun=1
    elif [[ $char == \\ && $quote != \' ]]; then
      cur+=${line:++i:1} begun=1
    elif [[ -z $quote && $char == [[:space:]] ]]; then
      [[ -n $begun ]] && words+=("$cur")
      cur= begun=
    else
      cur+=$char begun=1
    fi
  done
  words+=("$cur")
  COMPREPLY=()

  local plain= valued= word
)bash";

constexpr const char* scan = R"bash(
  # Which command it is, whose option's value is at the cursor, and how many words by their place there are.
  _lucarium_options
  for ((i = 1; i < ${#words[@]} - 1; ++i)); do
    word=${words[i]}
    if [[ " $valued " == *" $word "* ]]; then
      option=$word
      ((++i))
    elif [[ $word != -* && -z $command ]]; then
      command=$word
      _lucarium_options
    elif [[ $word != -* ]]; then
      ((++place))
    fi
  done
  if ((i < ${#words[@]})); then
    option=
    if [[ $cur == --*=* ]]; then
      option=${cur%%=*}
      cur=${cur#*=}
    elif [[ $cur == -[!-]?* && " $valued " == *" ${cur:0:2} "* ]]; then
      option=${cur:0:2}
      prefix=$option
      cur=${cur:2}
    fi
  fi

  local kind=free values=
  if [[ -n $option ]]; then
    case "$command $option" in
)bash";

constexpr const char* tail = R"bash(    esac
  fi

  case $kind in
    words) mapfile -t COMPREPLY < <(compgen -W "$values" -- "$cur") ;;
    file) [[ -n $prefix ]] && mapfile -t COMPREPLY < <(compgen -f -- "$cur") || compopt -o default 2>/dev/null ;;
    folder) [[ -n $prefix ]] && mapfile -t COMPREPLY < <(compgen -d -- "$cur") || compopt -o dirnames 2>/dev/null ;;
    free) ;;
    *) _lucarium_ask "$kind" ;;
  esac
  # A scene is a file as well.
  if [[ $kind == scene ]]; then
    [[ -z $cur ]] && mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f)
    ((${#COMPREPLY[@]})) || compopt -o default 2>/dev/null
  fi
  [[ ${#COMPREPLY[@]} -gt 0 && ${COMPREPLY[0]} == *[:=] ]] && compopt -o nospace 2>/dev/null
  # Within open quotes the shell replaces what stands behind them.
  [[ -n $quote ]] && return 0
  if [[ -n $prefix ]]; then
    COMPREPLY=("${COMPREPLY[@]/#/$prefix}")
    cur=$prefix$cur
  fi
  # Of a word that is parted at : or =, the last part is replaced.
  local breaks=${COMP_WORDBREAKS//[!:=]/}
  [[ -n $breaks ]] && COMPREPLY=("${COMPREPLY[@]#"${cur%"${cur##*[$breaks]}"}"}")
  return 0
}

complete -F _lucarium lucarium
)bash";

/// "kind=words values='a b'", what a case of the script sets.
std::string setting(const OptionDeclaration& option) {
  switch (value_kind(option)) {
    case ValueKind::words: return fmt::format("kind=words values='{}'", fmt::join(option.words, " "));
    case ValueKind::file: return "kind=file";
    case ValueKind::folder: return "kind=folder";
    case ValueKind::command: return "kind=words values=$commands";
    default: return asked_kind(value_kind(option)).empty() ? "" : "kind=" + asked_kind(value_kind(option));
  }
}

/// One case for all patterns that set the same.
std::string cases(const std::map<std::string, std::vector<std::string>>& patterns) {
  std::string text;
  for (const auto& [set, names] : patterns) text += fmt::format("      {}) {} ;;\n", fmt::join(names, " | "), set);
  return text;
}

/// The names of the command's options, with a value or without one.
std::string option_names(const CommandDeclaration& command, bool valued) {
  std::string text;
  for (const OptionDeclaration& option : command.options) {
    if (valued == (!option.is_flag() && !option.value_optional))
      text += fmt::format("{}{}", text.empty() ? "" : " ", fmt::join(option.names, " "));
  }
  return text;
}

}  // namespace

std::string bash_completion(const ProgramDeclaration& program) {
  std::string names, text = bash_head;
  for (const CommandDeclaration& command : program.commands) names += (names.empty() ? "" : " ") + command.name;
  text += fmt::format("  local commands='{}'\n  _lucarium_options() {{\n    case $command in\n", names);
  std::map<std::string, std::vector<std::string>> values, places;
  const auto add = [&](const CommandDeclaration& command, const std::string& name) {
    text += fmt::format("      '{}')\n        plain='{}'\n        valued='{}'\n        ;;\n", name,
                        option_names(command, false), option_names(command, true));
    for (const OptionDeclaration& option : command.options) {
      if (setting(option).empty()) continue;
      for (const std::string& own : option.names) values[setting(option)].push_back(fmt::format("'{} {}'", name, own));
    }
    for (size_t i = 0; i < command.words.size(); ++i) {
      const OptionDeclaration& word = command.words[i];
      if (setting(word).empty()) continue;
      places[setting(word)].push_back(word.repeatable ? fmt::format("'{} '*", name) : fmt::format("'{} {}'", name, i));
    }
  };
  add(program.program, "");
  for (const CommandDeclaration& command : program.commands) add(command, command.name);
  text += "    esac\n  }\n";
  text += scan + cases(values);
  text += R"bash(    esac
  elif [[ $cur == -* ]]; then
    kind=words values="$plain $valued"
  elif [[ -z $command ]]; then
    kind=words values=$commands
  else
    case "$command $place" in
)bash";
  return text + cases(places) + tail;
}

}  // namespace lucarium::app
