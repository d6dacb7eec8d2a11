// SPDX-License-Identifier: Apache-2.0
// What the command line promises about itself: texts, help, manual pages, docs/command_line.md. Completion is tried in
// the shells themselves (shells.py).
#include <algorithm>
#include <map>
#include <regex>
#include <set>

#include "cli_support.h"
#include "lucarium/base/files/atomic_file.h"

using namespace lucarium::test;
using nlohmann::json;

namespace {

const std::vector<json>& commands() {
  static const std::vector<json> declared = [] {
    const ProgramResult result = run_lucarium("commands --json");
    REQUIRE(result.exit_code == 0);
    return json::parse(result.out).at("commands").get<std::vector<json>>();
  }();
  return declared;
}

/// All that is declared of a command: words by their place and options.
std::vector<json> declared(const json& command) {
  std::vector<json> all(command.at("words").begin(), command.at("words").end());
  all.insert(all.end(), command.at("options").begin(), command.at("options").end());
  return all;
}

bool is_installed(const std::string& program) { return run_program("command -v " + program).exit_code == 0; }

}  // namespace

TEST_CASE("docs/command_line.md is what the program prints") {
  const std::string page = environment("LUCARIUM_TEST_SOURCE") + "/docs/command_line.md";
  CHECK_MESSAGE(lucarium::read_file(page) == run_lucarium("commands --markdown").out,
                "lucarium commands --markdown > docs/command_line.md");
}

TEST_CASE("an option has one text, group and set of names over all commands") {
  std::map<std::string, json> known;
  for (const json& command : commands()) {
    for (const json& option : declared(command)) {
      const std::string name = option.at("name");
      const json said = {option.at("names"), option.at("text"), option.at("group"), option.at("words")};
      CAPTURE(name);
      CHECK(known.emplace(name, said).first->second == said);
    }
  }
  CHECK(known.size() > 50);
}

TEST_CASE("options have a text and a group, values a name and what holds without them") {
  for (const json& command : commands()) {
    CAPTURE(command.at("name"));
    for (const json& option : declared(command)) {
      CAPTURE(option.at("name"));
      CHECK_FALSE(option.at("text").get<std::string>().empty());
      const std::string value = option.at("value"), fallback = option.at("default");
      if (option.at("names").empty()) {
        CHECK_FALSE(value.empty());
        continue;
      }
      CHECK_FALSE(option.at("group").get<std::string>().empty());
      const bool is_flag = value.empty() || value.starts_with("[=");  // --profile, --profile=FILE
      CHECK((is_flag || option.at("required").get<bool>() || !fallback.empty()));
    }
  }
}

TEST_CASE("--parameter may be repeated everywhere, --technique where a command takes several") {
  for (const json& command : commands()) {
    const bool several = command.at("name") == "compare" || command.at("name") == "view";
    for (const json& option : declared(command)) {
      const std::string name = option.at("name");
      CAPTURE(command.at("name"));
      if (name == "--parameter") CHECK(option.at("repeatable") == true);
      if (name == "--technique") CHECK(option.at("repeatable") == several);
    }
  }
}

TEST_CASE("every command has two examples that name it, and a page that exists") {
  const std::string source = environment("LUCARIUM_TEST_SOURCE");
  for (const json& command : commands()) {
    const std::string name = command.at("name"), page = command.at("page");
    CAPTURE(name);
    CHECK(command.at("examples").size() >= 2);
    for (const std::string example : command.at("examples")) CHECK(contains(example + " ", "lucarium " + name + " "));
    CHECK(std::filesystem::is_regular_file(std::filesystem::path(source) / page));
  }
}

TEST_CASE("help COMMAND is COMMAND --help, and names the nearest command") {
  CHECK(run_lucarium("help").out == run_lucarium("--help").out);
  for (const json& command : commands()) {
    const std::string name = command.at("name");
    const ProgramResult help = run_lucarium("help " + name);
    CAPTURE(name);
    CHECK(help.exit_code == 0);
    CHECK(help.out == run_lucarium(name + " --help").out);
    for (const json& option : command.at("options")) CHECK(contains(help.out, option.at("name")));
  }
  for (const char* command : {"help", "man"}) {
    check_refused(command + std::string(" rendr"), 2, "unknown command 'rendr'; did you mean 'render'?");
  }
  check_refused("completion tcsh", 2, "tcsh");
}

TEST_CASE("a command that --help does not list had a help as text, none as JSON or page") {
  CHECK(contains(run_lucarium("help job").out, "Usage: lucarium job FILE"));
  CHECK(json::parse(run_lucarium("help job --json").out)["commands"][0]["name"] == "job");
  CHECK(contains(run_lucarium("man job").out, "lucarium job"));
  CHECK_FALSE(contains(run_lucarium("commands").out, "job"));
}

TEST_CASE("a manual page for the program and for every command, with all options") {
  const TemporaryFolder folder;
  REQUIRE(run_lucarium("man --output " + folder.path().string()).exit_code == 0);
  CHECK(count_files(folder.path()) == commands().size() + 1);
  const auto page_of = [&](const std::string& page) { return lucarium::read_file(folder.path() / (page + ".1")); };
  CHECK(page_of("lucarium") == run_lucarium("man").out);
  for (const json& command : commands()) {
    const std::string name = command.at("name"), page = page_of("lucarium-" + name);
    CAPTURE(name);
    CHECK(page == run_lucarium("man " + name).out);
    CHECK(contains(page_of("lucarium"), "\\fB" + std::regex_replace(name, std::regex("-"), "\\-") + "\\fR"));
    for (const char* section :
         {"NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXAMPLES", "EXIT STATUS", "FILES", "SEE ALSO"})
      CHECK(contains(page, std::string("\n.SH ") + section + "\n"));
    for (const json& option : command.at("options")) {
      for (const std::string own : option.at("names"))
        CHECK(contains(page, "\\fB" + std::regex_replace(own, std::regex("-"), "\\-") + "\\fR"));
    }
  }
}

TEST_CASE("manual pages are what man and mandoc understand") {
  const TemporaryFolder folder;
  REQUIRE(run_lucarium("man --output " + folder.path().string()).exit_code == 0);
  const std::string pages = folder.path().string() + "/*.1";
  if (!is_installed("mandoc") && !is_installed("man")) return skip("mandoc or man");
  if (is_installed("mandoc")) {
    // The pages have no date: the same program makes the same pages.
    const ProgramResult lint = run_program("mandoc -Tlint -Wwarning " + pages + " | grep -v 'missing date'");
    CHECK_MESSAGE(lint.out.empty(), lint.out);
  }
  if (is_installed("man")) {
    const ProgramResult shown =
        run_program("for page in " + pages + "; do LC_ALL=C.UTF-8 man --warnings -l $page >/dev/null; done");
    CHECK_MESSAGE(shown.err.empty(), shown.err);
  }
}
