// SPDX-License-Identifier: Apache-2.0
// What every command promises: the same words for the same things, help that can be read, results apart from talk.
#include <fstream>
#include <regex>
#include <sstream>

#include "cli_support.h"
#include "lucarium/version.h"

using namespace lucarium::test;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

size_t columns(const std::string& text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

/// The commands that --help lists.
std::vector<std::string> command_names() {
  std::vector<std::string> names;
  bool inside = false;
  for (const std::string& line : lines_of(run_lucarium("--help").out)) {
    if (inside && line.empty()) break;
    if (inside) names.push_back(line.substr(2, line.find(' ', 2) - 2));
    if (line == "Commands") inside = true;
  }
  REQUIRE(names.size() >= 11);
  return names;
}

/// Of a command's --help: each option with what stands behind it, continued lines joined.
std::vector<std::string> option_rows(const std::string& help) {
  std::vector<std::string> rows;
  for (const std::string& line : lines_of(help)) {
    if (std::regex_search(line, std::regex("^  (-|    --)"))) {
      rows.push_back(line);
    } else if (!rows.empty() && line.starts_with("          ")) {
      rows.back() += " " + line;
    }
  }
  return rows;
}

/// Commands that are done in a moment, without --json. `folder` has the images a.exr and b.exr.
std::vector<std::string> quick_commands(const fs::path& folder) {
  const std::string a = (folder / "a.exr").string(), b = (folder / "b.exr").string();
  const std::string renders = "--overwrite --iterations 1 -o " + (folder / "r.png").string() + " --exposure 0";
  return {"devices",
          "techniques",
          "commands",
          "help render",
          "man render",
          "completion bash",
          "scene builtin:cornell",
          "diff " + a + " " + b,
          "reproduce --list",
          "check path_tracing --only declaration",
          "new-technique --overwrite light_soup -o " + (folder / "light_soup").string(),
          "render builtin:cornell " + constant_technique() + renders,
          "reference builtin:cornell --overwrite --size 8x8 --spp 32 -o " + (folder / "ref.exr").string(),
          "compare builtin:cornell " + constant_technique() + "--iterations 1 --seeds 1 --overwrite --reference " + a +
              " -o " + (folder / "results").string(),
          "report " + (folder / "results").string()};
}

void make_images(const fs::path& folder) {
  for (const char* name : {"a", "b"}) {
    REQUIRE(run_lucarium("render builtin:cornell " +
                         constant_technique(std::string("red=") + (*name == 'a' ? "1" : "2")) + "--iterations 1 -o " +
                         (folder / (std::string(name) + ".exr")).string())
                .exit_code == 0);
  }
}

}  // namespace

TEST_CASE("without any word it prints the commands and ends with 2") {
  const ProgramResult alone = run_lucarium("");
  CHECK(alone.exit_code == 2);
  CHECK(alone.out.empty());
  for (const std::string& name : command_names()) CHECK(contains(alone.err, "\n  " + name + " "));
  CHECK(contains(alone.err, "Usage: lucarium COMMAND"));
  CHECK(lines_of(alone.err).size() <= 24);
}

TEST_CASE(
    "every command takes -v, -q, --json, -h and -V, and its help has options with defaults, examples and a page") {
  const fs::path source = environment("LUCARIUM_TEST_SOURCE");
  const std::string version = run_lucarium("-V").out;
  for (const std::string& name : command_names()) {
    CAPTURE(name);
    const std::string help = run_lucarium(name + " --help").out;
    for (const char* option : {"-v, --verbose ", "-q, --quiet ", "--json ", "-h, --help ", "-V, --version "})
      CHECK_MESSAGE(contains(help, option), option);
    CHECK(run_lucarium(name + " -V").out == version);
    CHECK(run_lucarium("-h " + name).exit_code == 0);
    for (const std::string& line : lines_of(help)) CHECK_MESSAGE(columns(line) <= 120, line);
    for (const std::string& row : option_rows(help)) {
      const bool takes_value = std::regex_search(row, std::regex("--[a-z0-9-]+ [^ ]"));
      if (takes_value) CHECK_MESSAGE(std::regex_search(row, std::regex("default: .+\\)|required\\)")), row);
    }
    std::smatch page;
    REQUIRE(std::regex_search(help, page, std::regex("\nMore: (.+)\n")));
    CHECK(fs::exists(source / page[1].str()));
  }
}

TEST_CASE("every help fits a page of 60 lines") {
  for (const std::string& name : command_names()) {
    CAPTURE(name);
    CHECK(lines_of(run_lucarium(name + " --help").out).size() <= 60);
  }
}

TEST_CASE("render --help has eight groups") {
  const std::string help = run_lucarium("render --help").out;
  std::vector<std::string> groups;
  for (const std::string& line : lines_of(help)) {
    if (std::regex_match(line, std::regex("[A-Z][a-z]+")) && line != "Examples") groups.push_back(line);
  }
  CHECK(groups ==
        std::vector<std::string>{"Output", "Budget", "Image", "Scene", "Technique", "Animation", "Device", "Messages"});
}

TEST_CASE("--json gives one object with a schema that docs/results.md lists, wherever it stands") {
  const TemporaryFolder folder;
  make_images(folder.path());
  std::ostringstream page;
  page << std::ifstream(environment("LUCARIUM_TEST_SOURCE") + "/docs/results.md").rdbuf();
  std::vector<std::string> commands = quick_commands(folder.path());
  commands.push_back("compare builtin:cornell " + constant_technique() + "--iterations 1 --dry-run");
  for (size_t i = 0; i < commands.size(); ++i) {
    const std::string line = i % 2 ? "--json " + commands[i] : commands[i] + " --json -q";
    CAPTURE(line);
    const ProgramResult result = run_lucarium(line);
    CAPTURE(result.err);
    CHECK(result.exit_code == 0);
    REQUIRE(json::accept(result.out));
    const json answer = json::parse(result.out);
    REQUIRE(answer.is_object());
    CHECK_MESSAGE(contains(page.str(), "`" + answer.at("schema").get<std::string>() + "`"), answer.at("schema"));
  }
}

TEST_CASE("--version --json printed text") {
  const std::string version = run_lucarium("-V").out;
  REQUIRE(contains(version, "lucarium " LUCARIUM_VERSION));  // and the commit, where that is known
  REQUIRE(lines_of(version).size() == 1);
  for (const char* line : {"--version --json", "--json -V", "render --json -V", "--json render -V"}) {
    const ProgramResult result = run_lucarium(line);
    CHECK(result.exit_code == 0);
    CHECK(json::parse(result.out) == json{{"schema", "lucarium-version-1"},
                                          {"program", "lucarium"},
                                          {"version", version.substr(9, version.size() - 10)}});
  }
}

TEST_CASE("-q leaves standard output as it is, as -v does, and standard error empty; -q and -v contradict each other") {
  const TemporaryFolder folder;
  make_images(folder.path());
  // Times differ from run to run.
  const auto without_times = [](const std::string& text) {
    return std::regex_replace(text, std::regex("[0-9.]+ m?s\\b"), "…");
  };
  for (const std::string& command : quick_commands(folder.path())) {
    CAPTURE(command);
    const ProgramResult plain = run_lucarium(command + " -v"), quiet = run_lucarium("-q " + command);
    CHECK(plain.exit_code == 0);
    CHECK(quiet.exit_code == 0);
    CHECK(quiet.err.empty());
    CHECK_FALSE(quiet.out.empty());
    CHECK(without_times(quiet.out) == without_times(plain.out));
  }
  check_refused("-q devices -v", 2, "give --quiet or --verbose, not both");
}

TEST_CASE("-v promised to say what is being done, and said nothing where kernels were compiled before") {
  const TemporaryFolder folder;
  const std::string image = (folder.path() / "a.exr").string(), copy = (folder.path() / "b.glb").string();
  const std::string render = "render builtin:cornell " + constant_technique("red=2") + "--iterations 2 --overwrite -o ";
  REQUIRE(run_lucarium(render + image).exit_code == 0);  // kernels are in the cache now
  const ProgramResult told = run_lucarium(render + image + " -v"), silent = run_lucarium(render + image + " -q");
  CHECK(silent.err.empty());
  for (const char* part :
       {"\nscene builtin:cornell: 42 triangles", "\ndevice 0: ", "of memory\n", "\ntechnique constant", "red=2",
        "16×8 pixels", "\nmemory: ", "\nprepared: upload ", "\nended by --iterations after 2 iterations", "\nwrote "})
    CHECK_MESSAGE(contains("\n" + told.err, part), part << told.err);
  CHECK(contains(run_lucarium(render + image + " --time 5 -v").err, "\nplan for 5 s: "));
  CHECK(contains(run_lucarium("-v diff " + image + " " + image).err, "read " + image + ": 16×8 pixels"));
  CHECK(contains(run_lucarium("scene builtin:cornell -v --export " + copy).err, "wrote " + copy));
  CHECK(contains(run_lucarium("techniques -v").err, "technique path_tracing of "));
}

TEST_CASE("-p takes a list everywhere, and belongs to the default technique where none is named") {
  const std::string render = "render builtin:cornell --size 8x8 --max-bounces 1 --iterations 1 --json ";
  const json frame = only_frame(run_lucarium(render + "-p estimator=bsdf,replicates=2 -p samples_per_iteration=3"));
  CHECK(frame["technique"] == "path_tracing");
  for (const char* part : {"estimator=bsdf", "replicates=2", "samples_per_iteration=3"})
    CHECK_MESSAGE(contains(frame["parameters"].get<std::string>(), part), part);
  const json again =
      only_frame(run_lucarium(render + "-t path_tracing:estimator=bsdf -p replicates=2,samples_per_iteration=3"));
  CHECK(again["parameters"] == frame["parameters"]);
  const json blanks = only_frame(
      run_lucarium(render + "-t 'path_tracing: estimator = bsdf' -p 'replicates=2, samples_per_iteration = 3 '"));
  for (const char* part : {"estimator=bsdf", "replicates=2", "samples_per_iteration=3"})
    CHECK_MESSAGE(contains(blanks["parameters"].get<std::string>(), part), part);
  const json checked =
      json::parse(run_lucarium("check path_tracing -p estimator=bsdf,replicates=2 --only declaration --json").out);
  CHECK(checked["parameters"]["estimator"] == "bsdf");
  CHECK(checked["parameters"]["replicates"] == "2");
}

TEST_CASE("names are taken in both spellings and printed in one") {
  const std::string render =
      "render builtin:cornell " + constant_technique() + "--iterations 1 --json --pixel-sampling ";
  for (const char* mode : {"center", "centre"}) {
    CAPTURE(mode);
    CHECK(only_frame(run_lucarium(render + mode))["pixel_sampling"] == 1);
  }
  const auto materials = [](const std::string& key) {
    return json::parse(run_lucarium("scene builtin:cornell --json --material '*:" + key + "=0.25'").out)["materials"];
  };
  CHECK(materials("base_colour") == materials("base_color"));
}

TEST_CASE("a folder whose name is not UTF-8 is refused before anything is done") {
  const TemporaryFolder folder;
  const std::string odd = "$(printf '" + folder.path().string() + "/\\377')";
  const std::string rest = "builtin:cornell " + constant_technique() + "--iterations 1 ";
  check_refused("compare " + rest + "-o " + odd, 2, "is not UTF-8");
  check_refused("render " + rest + "-o " + odd + ".exr", 2, "is not UTF-8");
  CHECK(count_files(folder.path()) == 0);
  // Nor can a comparison be run from within such a folder.
  const ProgramResult inside =
      run_program("mkdir " + odd + " && cd " + odd + " && " + lucarium_program() + " compare " + rest + "-o results");
  CHECK(inside.exit_code == 2);
  CHECK(contains(inside.err, "is not UTF-8; give the folder another name"));
}

TEST_CASE("--relmse is a budget: without another one 64 samples do not end it") {
  const TemporaryFolder folder;
  const std::string exr = (folder.path() / "a.exr").string();
  const std::string render = "render builtin:cornell --size 8x8 --max-bounces 2 --json ";
  REQUIRE(run_lucarium(render + "--spp 4096 -o " + exr).exit_code == 0);
  // Of the same samples: the more of them, the nearer.
  const json few = only_frame(run_lucarium(render + "--reference " + exr));
  CHECK(few["ended_by"] == "--spp");
  CHECK(few["samples"] == 64);
  const std::string error = std::to_string(few["metrics"]["relMSE"].get<double>() / 4);
  const json frame = only_frame(run_lucarium(render + "--reference " + exr + " --relmse " + error));
  CHECK(frame["ended_by"] == "--relmse");
  CHECK(frame["samples"] > 64);
  CHECK(frame["metrics"]["relMSE"] <= std::stod(error));
}

TEST_CASE("numbers of reference --json are numbers") {
  const TemporaryFolder folder;
  const json answer = json::parse(
      run_lucarium("reference builtin:cornell --size 8x8 --spp 32 --json -o " + (folder.path() / "a.exr").string())
          .out);
  CHECK(answer["max_bounces"] == -1);
  CHECK(answer["scene_time_seconds"] == 0);
}
