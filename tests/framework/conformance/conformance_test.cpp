// SPDX-License-Identifier: Apache-2.0
// The conformance kit passes a technique that is right, and each of its checks fails one that breaks what it looks at.
#include "lucarium/conformance/conformance.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <set>

#include "device_fixture.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "test_support.h"

using namespace lucarium;
namespace fs = std::filesystem;

namespace {

using Parameters = std::vector<std::pair<std::string, std::string>>;

fs::path plugin_folder(const std::string& name) { return fs::path(std::getenv("LUCARIUM_TEST_PLUGINS")) / name; }

std::vector<CheckResult> check_plugin(const std::string& name, const Parameters& parameters,
                                      const std::vector<std::string>& only, bool full = false) {
  const TechniqueRegistry registry({plugin_folder(name)});
  ConformanceOptions options;
  options.parameters = parameters;
  options.only = only;
  options.full = full;
  options.program = std::getenv("LUCARIUM_TEST_PROGRAM");
  options.technique_folders = {plugin_folder(name)};
  return check_technique(test::test_device(), registry, registry.find(name), options);
}

/// The verdict of the checks whose names begin with `only`; all must agree.
Verdict verdict(const std::string& name, const Parameters& parameters, const std::string& only,
                std::string* measured = nullptr) {
  const std::vector<CheckResult> results = check_plugin(name, parameters, {only});
  for (const CheckResult& result : results) {
    CAPTURE(result.name);
    CAPTURE(result.measured);
    CHECK(result.verdict == results.front().verdict);
    CHECK_FALSE(result.required.empty());
  }
  if (measured) *measured = results.front().measured;
  return results.front().verdict;
}

const std::vector<std::string> quick_groups = {
    "declaration",  "parameters",  "layers",      "finite", "repeat",
    "view",         "camera_move", "change",      "memory", "budget",
    "cancellation", "furnace",     "shining_box", "light",  "reference/light/emissive",
    "oclgrind"};

}  // namespace

TEST_CASE("a technique that is right passes every check") {
  std::set<std::string> names;
  for (const CheckResult& result :
       check_plugin("faulty", {}, test::full_run() ? std::vector<std::string>{} : quick_groups)) {
    CAPTURE(result.name);
    CAPTURE(result.measured);
    CHECK(names.insert(result.name).second);
    if (result.name.starts_with("view/"))  // it begins every view with nothing, and says so
      CHECK(result.verdict == Verdict::not_claimed);
    else
      CHECK((result.verdict == Verdict::passed || result.verdict == Verdict::skipped));
    // The only checks that may have to be left out, and say why; the number of threads is PoCL's.
    if (result.verdict == Verdict::skipped)
      CHECK((result.name == "oclgrind" || (result.name == "repeat/threads" && !test::test_device()->info().is_pocl)));
  }
  CHECK(names.size() >= 28);
}

TEST_CASE("every check of behaviour fails where its promise is broken") {
  const std::pair<const char*, const char*> broken[] = {
      {"undocumented", "parameters"},     {"extra_layer", "layers"},        {"nan", "finite"},
      {"unseeded", "repeat/seed"},        {"sticky_seed", "repeat/reset"},  {"resolve_counts", "repeat/observing"},
      {"thread_count", "repeat/threads"}, {"rebuild", "camera_move"},       {"deaf", "change/camera"},
      {"deaf", "change/transforms"},      {"deaf", "change/deformation"},   {"deaf", "change/materials"},
      {"deaf", "change/alpha"},           {"deaf", "change/lights"},        {"deaf", "change/topology"},
      {"leak", "memory/returned"},        {"understated", "memory/stated"}, {"uncounted", "budget/iterations"},
      {"slow", "budget/seconds"},         {"traces", "cancellation"},       {"deaf_to_cancel", "cancellation"}};
  for (const auto& [fault, check] : broken) {
    CAPTURE(fault);
    CAPTURE(check);
    if (std::string_view(check) == "repeat/threads" && !test::test_device()->info().is_pocl) continue;
    std::string measured;
    CHECK(verdict("faulty", {{"fault", fault}}, check, &measured) == Verdict::failed);
    CAPTURE(measured);
    CHECK_FALSE(measured.empty());
  }
  CHECK(verdict("faulty_declaration", {}, "declaration") == Verdict::failed);
}

TEST_CASE(
    "two percent too much light fails every radiometric check; who admits to five percent passes, and fails with ten") {
  const std::vector<std::string> groups =
      test::full_run() ? std::vector<std::string>{"furnace", "shining_box", "light", "reference"}
                       : std::vector<std::string>{"furnace", "shining_box", "light", "reference/light/emissive"};
  for (const std::string& group : groups) {
    CAPTURE(group);
    CHECK(verdict("faulty", {{"gain", "1.02"}}, group) == Verdict::failed);
  }
  for (const char* group : {"furnace", "light/point", "reference/light/directional"}) {
    CAPTURE(group);
    CHECK(verdict("biased", {{"gain", "1.02"}}, group) == Verdict::passed);
    CHECK(verdict("biased", {{"gain", "1.1"}}, group) == Verdict::failed);
  }
}

TEST_CASE("a technique that has no light before its seventieth iteration is compared with all its light") {
  CHECK(verdict("faulty", {{"fault", "late"}}, "reference/light/emissive") == Verdict::passed);
}

TEST_CASE("the bias that counts is the one that the parameters admit") {
  const char* group = "light/point";
  CHECK(verdict("biased", {{"gain", "1.1"}, {"admits", "0.15"}}, group) == Verdict::passed);
  CHECK(verdict("biased", {{"gain", "1.02"}, {"admits", "0"}}, group) == Verdict::failed);
  CHECK(verdict("biased", {{"admits", "1.5"}}, "declaration") == Verdict::failed);
}

TEST_CASE("the sky of the wrong direction, sheets with one side, and a coat that reflects nothing fail their check") {
  const std::pair<const char*, std::vector<const char*>> wrong[] = {
      {"turned_sky", {"reference/light/environment", "reference/sky"}},
      {"one_sided", {"reference/sides"}},
      {"no_coat", {"reference/lobes"}}};
  for (const auto& [fault, checks] : wrong) {
    for (const char* check : checks) {
      CAPTURE(fault);
      CAPTURE(check);
      CHECK(verdict("faulty", {{"fault", fault}}, check) == Verdict::failed);
      CHECK(verdict("faulty", {}, check) == Verdict::passed);
    }
  }
}

TEST_CASE("checks run at the settings that a technique names for them, unless the user has others or asks for all") {
  const auto finite = [](const Parameters& parameters, bool full) {
    return check_plugin("faulty_declaration", parameters, {"finite"}, full).front().verdict;
  };
  CHECK(finite({}, false) == Verdict::failed);  // it names fault=nan
  CHECK(finite({{"fault", "none"}}, false) == Verdict::passed);
  CHECK(finite({}, true) == Verdict::passed);
}

TEST_CASE("every check is announced before it runs, with how many there are") {
  const TechniqueRegistry registry({plugin_folder("constant")});
  ConformanceOptions options;
  options.only = {"declaration", "parameters", "light/spot"};
  std::vector<std::string> heard;
  options.on_check = [&](size_t index, size_t count, const std::string& name) {
    heard.push_back(fmt::format("{}/{} {}", index + 1, count, name));
  };
  options.on_result = [&](const CheckResult& result) { heard.push_back(result.name); };
  check_technique(test::test_device(), registry, registry.find("constant"), options);
  CHECK(heard == std::vector<std::string>{"1/3 declaration", "declaration", "2/3 parameters", "parameters",
                                          "3/3 light/spot", "light/spot"});
}

TEST_CASE("a check that an interrupt cut short counted as failed, and the rest as if there were none") {
  const TechniqueRegistry registry({plugin_folder("constant")});
  ConformanceOptions options;
  options.only = {"declaration", "parameters", "repeat/seed", "repeat/observing"};
  for (const size_t cut : {0, 1, 2, 3}) {
    options.on_check = [&](size_t index, size_t, const std::string&) { set_interrupt_requested(index == cut); };
    const std::vector<CheckResult> results =
        check_technique(test::test_device(), registry, registry.find("constant"), options);
    set_interrupt_requested(false);
    CHECK(results.size() == cut);
    for (const CheckResult& result : results) CHECK(result.verdict == Verdict::passed);
  }
}

TEST_CASE("sizes for Oclgrind come behind those of the check, and the command line wins") {
  TechniqueInfo info;
  info.check_parameters = {{"size", "256"}, {"steps", "8"}};
  info.oclgrind_parameters = {{"size", "16"}};
  ConformanceOptions options;
  options.parameters = {{"steps", "2"}};
  CHECK(effective_parameters(info, options) == Parameters{{"size", "256"}, {"steps", "8"}, {"steps", "2"}});
  CHECK(oclgrind_parameters(info, options) ==
        Parameters{{"size", "256"}, {"steps", "8"}, {"size", "16"}, {"steps", "2"}});
  options.full = true;
  CHECK(oclgrind_parameters(info, options) == options.parameters);
}

TEST_CASE("Oclgrind finds a kernel that writes outside its buffer") {
  if (verdict("faulty", {}, "oclgrind") == Verdict::skipped) return test::skip("oclgrind");
  std::string measured;
  CHECK(verdict("faulty", {{"fault", "outside"}}, "oclgrind", &measured) == Verdict::failed);
  CHECK(measured.find("Invalid write") != std::string::npos);

  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "oclgrind");
  const std::string before = std::getenv("PATH");
  setenv("PATH", (folder.path().string() + ":" + before).c_str(), 1);
  CHECK(verdict("faulty", {}, "oclgrind", &measured) == Verdict::passed);
  CHECK(measured.find("no data race") != std::string::npos);
  setenv("PATH", before.c_str(), 1);
}

TEST_CASE("a technique that computes no light claims nothing about light, and unknown checks are refused") {
  for (const CheckResult& result :
       check_plugin("constant", {}, {"light/spot", "reference/light/spot", "reference/material/glossy"})) {
    CHECK(result.verdict == Verdict::not_claimed);
  }
  CHECK_THROWS_AS(check_plugin("constant", {}, {"nonsense"}), Error);
}
