// SPDX-License-Identifier: Apache-2.0
// lucarium new-technique NAME: a folder with a technique that builds, runs and is tested as it stands. It is the folder
// templates/technique, with every my_technique replaced by the name. Declared in commands.h.
#include <fmt/format.h>

#include <algorithm>

#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/embedded_files.h"
#include "lucarium/base/json.h"
#include "lucarium/base/terminal.h"
#include "lucarium/technique/plugin.h"

const lucarium::EmbeddedSources& lucarium_technique_template();

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view placeholder = "my_technique";
constexpr size_t longest_name = 64;

struct NewTechniqueArguments {
  std::string name;
  fs::path output;
  bool overwrite = false;
};

void check_name(const std::string& name) {
  const bool letters = name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
  if (name.empty() || !letters || name.front() < 'a' || name.front() > 'z' || name.size() > longest_name) {
    throw_error(ErrorClass::usage,
                "'{}' is no name for a technique: a-z, 0-9 and _, a letter first, at most {} of them", name,
                longest_name);
  }
  if (name == "lucarium")
    throw_error(ErrorClass::usage, "lucarium/ is the prefix of the framework's own kernels; choose another name");
  const TechniqueRegistry registry;
  for (const TechniqueType& type : registry.types()) {
    if (type.info().name == name) {
      throw_error(ErrorClass::usage, "a technique called {} is there already ({}); choose another name", name,
                  type.file().string());
    }
  }
}

std::string replace_all(std::string text, std::string_view from, std::string_view to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// Where this program is installed, or empty when it runs from a build folder.
fs::path installation() {
  std::error_code ignored;
  const fs::path prefix = fs::read_symlink("/proc/self/exe", ignored).parent_path().parent_path();
  fs::recursive_directory_iterator entry(prefix / "lib", ignored), end;
  for (; !ignored && entry != end; entry.increment(ignored)) {
    if (entry->path().filename() == "LucariumConfig.cmake") return prefix;
  }
  return {};
}

void print_next_steps(const std::string& name, const fs::path& folder) {
  const fs::path prefix = installation();
  print_result("{} holds the technique {}. To build, test and use it:\n\n", folder.string(), name);
  if (prefix.empty()) print_result("  cmake --install BUILD_FOLDER_OF_LUCARIUM --prefix PREFIX\n");
  print_result(
      "  cmake -G Ninja -S {0} -B {0}/build -DCMAKE_PREFIX_PATH={1}\n  cmake --build {0}/build\n  ctest --test-dir "
      "{0}/build\n",
      folder.string(), prefix.empty() ? "PREFIX" : prefix.string());
  print_result(
      "  {}lucarium render builtin:cornell -t {} --technique-path {}/build/lib/lucarium/techniques -o {}.png\n",
      prefix.empty() ? "PREFIX/bin/" : "", name, folder.string(), name);
}

/// The template's files in the folder; others in it stay.
std::vector<fs::path> write_template(const std::string& name, const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& [file, text] : lucarium_technique_template()) {
    files.push_back(folder / replace_all(file, placeholder, name));
    write_file_atomically(files.back(), replace_all(std::string(text), placeholder, name));
  }
  return files;
}

int new_technique(const NewTechniqueArguments& arguments, const Messages& messages) {
  check_name(arguments.name);
  const fs::path folder = arguments.output.empty() ? fs::path(arguments.name) : arguments.output;
  std::error_code failure;
  const bool there = fs::exists(folder, failure);
  if (there && !fs::is_directory(folder, failure))
    throw_error(ErrorClass::usage, "{} is no folder; choose another one with --output", folder.string());
  if (there && !arguments.overwrite)
    throw_error(ErrorClass::usage, "{} exists; choose another folder with --output or give --overwrite",
                folder.string());
  fs::create_directories(folder, failure);
  if (failure) throw_error(ErrorClass::input, "cannot create the folder {}: {}", folder.string(), failure.message());
  std::vector<fs::path> files;
  try {
    files = write_template(arguments.name, folder);
  } catch (...) {
    if (!there) fs::remove_all(folder, failure);
    throw;
  }
  if (messages.json) {
    nlohmann::ordered_json json = {{"schema", "lucarium-new-technique-1"},
                                   {"name", arguments.name},
                                   {"folder", folder.string()},
                                   {"files", nlohmann::ordered_json::array()}};
    for (const fs::path& file : files) json["files"].push_back(file.string());
    print_result("{}\n", json.dump(2));
  } else {
    print_next_steps(arguments.name, folder);
  }
  return 0;
}

}  // namespace

void add_new_technique_command(Command program, Action& action) {
  auto arguments = std::make_shared<NewTechniqueArguments>();
  Command command =
      program.add_subcommand("new-technique", "write a folder with a new technique, to be changed into your own");
  command.option("name", arguments->name).required();
  command.option("--output", arguments->output).value_name("FOLDER").default_text("NAME");
  command.flag("--overwrite", arguments->overwrite);
  command.examples({"lucarium new-technique my_technique", "lucarium new-technique my_technique -o plugins/mine"},
                   "docs/adding_a_technique.md");
  command.callback([arguments, &action] {
    action = [arguments](const Messages& messages) { return new_technique(*arguments, messages); };
  });
}

}  // namespace lucarium::app
