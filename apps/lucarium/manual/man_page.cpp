// SPDX-License-Identifier: Apache-2.0
// Manual pages in the language of man. Declared in pages.h.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/version.h"
#include "manual/pages.h"

namespace lucarium::app {
namespace {

/// The text as roff shows it unchanged: no escapes, no hyphens for minus signs, no line that is a request.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\') {
      result += "\\e";
    } else {
      if (c == '-') result += '\\';
      if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n')) result += "\\&";
      result += c;
    }
  }
  return result;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string heading(const std::string& page) {
  std::string upper = page;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return fmt::format(".TH {} 1 \"\" \"lucarium {}\" \"Lucarium\"\n", roff(upper), LUCARIUM_VERSION);
}

/// A paragraph with a hanging tag.
std::string item(const std::string& tag, const std::string& text) {
  return fmt::format(".TP\n{}\n{}\n", tag, roff(text));
}

/// A text of --help as a sentence. A first word with other signs than letters is a name and keeps its case.
std::string sentence(std::string text) {
  const std::string first = text.substr(0, text.find_first_of(" ,"));
  const auto is_lower = [](char c) { return c >= 'a' && c <= 'z'; };
  if (!first.empty() && std::all_of(first.begin(), first.end(), is_lower))
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text + '.';
}

std::string option_item(const OptionDeclaration& option) {
  std::string tag;
  for (const std::string& name : option.names) tag += (tag.empty() ? "" : ", ") + bold(name);
  if (option.value_optional) {
    tag += "[=" + italic(option.value) + "]";
  } else if (!option.is_flag()) {
    tag += (tag.empty() ? "" : " ") + italic(option.value);
  }
  std::string text = sentence(option.text);
  if (option.repeatable) text += " May be given several times.";
  if (option.required && !option.names.empty()) text += " Required.";
  if (!option.fallback.empty()) text += fmt::format(" Default: {}.", option.fallback);
  return item(tag, text);
}

std::string options(const CommandDeclaration& command) {
  std::string text = ".SH OPTIONS\n";
  for (const std::string& group : command.groups()) {
    text += fmt::format(".SS {}\n", group);
    for (const OptionDeclaration& option : command.options)
      if (option.group == group) text += option_item(option);
  }
  return text;
}

std::string examples(const CommandDeclaration& command) {
  if (command.examples.empty()) return "";
  std::string text = ".SH EXAMPLES\n";
  for (const std::string& example : command.examples) text += fmt::format(".nf\n{}\n.fi\n", roff(example));
  return text;
}

/// docs/errors.md says it at length.
std::string exit_status() {
  const auto code = [](ErrorClass error) { return bold(std::to_string(static_cast<int>(error))); };
  return ".SH EXIT STATUS\n" + item(bold("0"), "Done.") +
         item(code(ErrorClass::check_failed), "A check or comparison failed.") +
         item(code(ErrorClass::usage), "Wrong usage: an unknown option, a value out of range, a result that exists.") +
         item(code(ErrorClass::input), "Input or output: a file that is missing, wrong, or cannot be written.") +
         item(code(ErrorClass::device), "The OpenCL device: none, its driver, too little memory.") +
         item(code(ErrorClass::technique), "A technique: not loaded, or it refuses the scene.") +
         item(code(ErrorClass::interrupted), "Interrupted; what was finished is kept.") +
         item(code(ErrorClass::internal), "A fault of lucarium itself.");
}

std::string files() {
  return ".SH FILES\n" +
         item(italic("SCENE.lucarium.json"), "Lights, camera and materials of a scene, beside its file.") +
         item(italic("~/.cache/lucarium"),
              "Compiled kernels and references, unless XDG_CACHE_HOME or "
              "LUCARIUM_CACHE_DIR names another folder.") +
         item(italic("../lib/lucarium/techniques"), "Techniques, seen from the program's folder.");
}

std::string environment() {
  return ".SH ENVIRONMENT\n" + item(bold("LUCARIUM_TECHNIQUE_PATH"), "Folders of plug-ins, separated by colons.") +
         item(bold("LUCARIUM_KERNEL_PATH"), "Folders of kernels that are taken instead of those in the program.") +
         item(bold("LUCARIUM_CACHE_DIR"), "Folder of compiled kernels and references.") +
         item(bold("LUCARIUM_MEMORY_LIMIT") + ", " + bold("LUCARIUM_ALLOCATION_LIMIT"),
              "Limits of device memory, as --memory-limit and --allocation-limit set them.");
}

/// The pages to read next: of the program those of all commands, of a command that of the program.
std::string see_also(const std::vector<std::string>& pages, const std::string& page) {
  std::string text = ".SH SEE ALSO\n";
  for (size_t i = 0; i < pages.size(); ++i)
    text += fmt::format(".BR {} (1){}\n", roff(pages[i]), i + 1 < pages.size() ? "," : "");
  if (!page.empty()) text += fmt::format(".PP\n{} in the documentation.\n", roff(page));
  return text;
}

}  // namespace

std::string man_page_name(const CommandDeclaration& command) { return "lucarium-" + command.name; }

std::string man_page(const ProgramDeclaration& program) {
  const CommandDeclaration& self = program.program;
  std::string text = heading(self.name) + fmt::format(".SH NAME\n{} \\- {}\n", roff(self.name), roff(self.text));
  text += fmt::format(".SH SYNOPSIS\n{}\n{} [{}]\n", bold(self.name), italic("COMMAND"), italic("OPTIONS"));
  text += ".SH DESCRIPTION\n" + roff(sentence(self.text)) + "\nEach command has a page of its own.\n.SH COMMANDS\n";
  std::vector<std::string> pages;
  for (const CommandDeclaration& command : program.commands) {
    text += item(bold(command.name), sentence(command.text));
    pages.push_back(man_page_name(command));
  }
  return text + options(self) + examples(self) + exit_status() + environment() + files() + see_also(pages, self.page);
}

std::string man_page(const ProgramDeclaration& program, const CommandDeclaration& command) {
  const std::string name = man_page_name(command);
  std::string text = heading(name) + fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n", roff(name), roff(command.text));
  text += bold(program.program.name + " " + command.name);
  for (const OptionDeclaration& word : command.words)
    text += "\n" + (word.required ? italic(word.usage()) : "[" + italic(word.usage()) + "]");
  text += fmt::format("\n[{}]\n.SH DESCRIPTION\n{}\n", italic("OPTIONS"), roff(sentence(command.text)));
  for (const OptionDeclaration& word : command.words) text += option_item(word);
  return text + options(command) + examples(command) + exit_status() + environment() + files() +
         see_also({program.program.name}, command.page);
}

}  // namespace lucarium::app
