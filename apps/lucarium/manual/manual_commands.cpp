// SPDX-License-Identifier: Apache-2.0
// lucarium help, man, completion, commands: what the command line declares, for a person, a shell, a page. Declared in
// commands/commands.h.
#include <algorithm>
#include <filesystem>

#include "build_app.h"
#include "grammar/option_texts.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"
#include "manual/completion.h"
#include "manual/pages.h"
#include "outputs/output_files.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

constexpr const char* page = "docs/command_line.md";

ProgramDeclaration declarations() {
  Action unused;
  return read_declarations(build_app(unused).app());
}

/// The program called as "lucarium [COMMAND] --help".
int print_help(std::string command, bool json) {
  if (json) {
    ProgramDeclaration program = declarations();
    if (!command.empty()) program.commands = {program.command(command)};
    print_result("{}\n", declarations_json(program).dump(2));
    return 0;
  }
  std::string program = "lucarium", help = "--help";
  std::vector<char*> words = {program.data()};
  if (!command.empty()) words.push_back(command.data());
  words.push_back(help.data());
  Action unused;
  return build_app(unused).parse(static_cast<int>(words.size()), words.data()).value_or(0);
}

struct ManArguments {
  std::string command;
  fs::path folder;
  bool overwrite = false;
};

using Pages = std::vector<std::pair<std::string, std::string>>;  // names and texts

/// The pages' files. All are refused before one is written.
std::vector<fs::path> write_pages(const ManArguments& arguments, const Pages& pages) {
  std::error_code failure;
  fs::create_directories(arguments.folder, failure);
  if (failure)
    throw_error(ErrorClass::input, "cannot create the folder {}: {}", arguments.folder.string(), failure.message());
  std::vector<fs::path> files;
  for (const auto& [name, text] : pages) {
    files.push_back(arguments.folder / (name + ".1"));
    check_output(files.back(), arguments.overwrite);
  }
  for (size_t i = 0; i < pages.size(); ++i) write_file_atomically(files[i], pages[i].second);
  return files;
}

int man(const ManArguments& arguments, bool json) {
  const ProgramDeclaration program = declarations();
  Pages pages;
  const auto add = [&](const CommandDeclaration& command) {
    pages.emplace_back(man_page_name(command), man_page(program, command));
  };
  if (!arguments.command.empty()) {
    add(program.command(arguments.command));
  } else {
    pages.emplace_back(program.program.name, man_page(program));
    if (!arguments.folder.empty()) std::for_each(program.commands.begin(), program.commands.end(), add);
  }
  std::vector<fs::path> files;
  if (!arguments.folder.empty()) files = write_pages(arguments, pages);
  ordered_json written = {{"schema", "lucarium-man-1"}, {"pages", ordered_json::array()}};
  for (size_t i = 0; i < pages.size(); ++i) {
    const auto& [name, text] = pages[i];
    if (files.empty()) {
      if (!json) print_result("{}", text);
      written["pages"].push_back({{"name", name}, {"text", text}});
    } else {
      if (!json) print_result("{}\n", files[i].string());
      written["pages"].push_back({{"name", name}, {"file", files[i].string()}});
    }
  }
  if (json) print_result("{}\n", written.dump(2));
  return 0;
}

int completion(const std::string& shell, bool json) {
  const ProgramDeclaration program = declarations();
  const std::string script = shell == "bash"  ? bash_completion(program)
                             : shell == "zsh" ? zsh_completion(program)
                                              : fish_completion(program);
  if (json) {
    print_result("{}\n",
                 ordered_json{{"schema", "lucarium-completion-1"}, {"shell", shell}, {"script", script}}.dump(2));
  } else {
    print_result("{}", script);
  }
  return 0;
}

int commands(bool json, bool markdown) {
  const ProgramDeclaration program = declarations();
  if (json) {
    print_result("{}\n", declarations_json(program).dump(2));
  } else if (markdown) {
    print_result("{}", markdown_page(program));
  } else {
    for (const CommandDeclaration& command : program.commands) print_result("{:<14} {}\n", command.name, command.text);
  }
  return 0;
}

void add_help_command(Command program, Action& action) {
  auto wanted = std::make_shared<std::string>();
  Command command = program.add_subcommand("help", "print the help of a command");
  command.option("command", *wanted);
  command.examples({"lucarium help", "lucarium help render"}, page);
  command.callback([wanted, &action] {
    action = [wanted](const Messages& messages) { return print_help(*wanted, messages.json); };
  });
}

void add_man_command(Command program, Action& action) {
  auto arguments = std::make_shared<ManArguments>();
  Command command = program.add_subcommand("man", "write a manual page");
  command.option("command", arguments->command);
  command.option("--output", arguments->folder).value_name("FOLDER").default_text("standard output");
  command.flag("--overwrite", arguments->overwrite);
  command.needs({"--overwrite"}, {"--output"});
  command.examples({"lucarium man render | man -l -", "lucarium man -o ~/.local/share/man/man1"}, page);
  command.callback([arguments, &action] {
    action = [arguments](const Messages& messages) { return man(*arguments, messages.json); };
  });
}

void add_completion_command(Command program, Action& action) {
  auto shell = std::make_shared<std::string>();
  Command command = program.add_subcommand("completion", "write the completion script of a shell");
  command.option("shell", *shell).required().check(one_of(option_words("shell")));
  command.examples(
      {"source <(lucarium completion bash)", "lucarium completion fish > ~/.config/fish/completions/lucarium.fish"},
      page);
  command.callback(
      [shell, &action] { action = [shell](const Messages& messages) { return completion(*shell, messages.json); }; });
}

void add_commands_command(Command program, Action& action) {
  auto markdown = std::make_shared<bool>(false);
  Command command = program.add_subcommand("commands", "list the commands, or print all that they declare");
  command.flag("--markdown", *markdown);
  command.excludes({"--markdown"}, {"--json"});
  command.examples({"lucarium commands", "lucarium commands --json"}, page);
  command.callback([markdown, &action] {
    action = [markdown](const Messages& messages) { return commands(messages.json, *markdown); };
  });
}

/// What the completion scripts ask for.
void add_complete_command(Command program, Action& action) {
  struct Arguments {
    std::string kind;
    std::vector<std::string> words;
  };
  auto arguments = std::make_shared<Arguments>();
  Command command = program.add_subcommand("complete", "print what may stand at the cursor");
  command.hide();
  command.option("kind", arguments->kind).required();
  command.option("words", arguments->words);
  command.callback([arguments, &action] {
    action = [arguments](const Messages&) {
      for (const Candidate& candidate : complete(arguments->kind, arguments->words))
        print_result("{}{}\n", candidate.name, candidate.text.empty() ? "" : "\t" + candidate.text);
      return 0;
    };
  });
}

}  // namespace

void add_manual_commands(const Command& program, Action& action) {
  add_help_command(program, action);
  add_commands_command(program, action);
  add_man_command(program, action);
  add_completion_command(program, action);
  add_complete_command(program, action);
}

}  // namespace lucarium::app
