// SPDX-License-Identifier: Apache-2.0
// lucarium check: table, JSON and exit codes. What the checks find is the subject of technique/conformance_test.
#include "cli_support.h"

using namespace lucarium::test;

namespace {

std::string faulty(const std::string& parameters) {
  return "check faulty" + parameters + " --technique-path " + environment("LUCARIUM_TEST_PLUGINS") + "/faulty ";
}

}  // namespace

TEST_CASE("exit code 0 when nothing fails, 1 and what was required when something does") {
  const ProgramResult good = run_lucarium(faulty("") + "--only parameters --only repeat/seed");
  CAPTURE(good.out);
  CHECK(good.exit_code == 0);
  CHECK(contains(good.out, "passed       repeat/seed"));
  CHECK(contains(good.out, "faulty: 2 passed, 0 failed, 0 skipped, 0 not claimed"));

  const ProgramResult bad = run_lucarium(faulty(":fault=undocumented") + "--only parameters");
  CHECK(bad.exit_code == 1);
  CHECK(contains(bad.out, "failed       parameters"));
  CHECK(contains(bad.out, "unnamed has no description"));
  CHECK(contains(bad.out, "required: documented"));
}

TEST_CASE("JSON says the same for programs") {
  const ProgramResult result = run_lucarium(faulty("") + "-p fault=understated --only memory --json");
  CHECK(result.exit_code == 1);
  const nlohmann::json json = nlohmann::json::parse(result.out);
  CHECK(json["schema"] == "lucarium-check-1");
  CHECK(json["parameters"]["fault"] == "understated");
  CHECK(json["passed"] == 1);
  CHECK(json["failed"] == 1);
  CHECK(json["full"] == false);
  CHECK(json["not_claimed"] == 0);
  REQUIRE(json["checks"].size() == 2);
  CHECK(json["checks"][1]["name"] == "memory/stated");
  CHECK(json["checks"][1]["verdict"] == "failed");
  CHECK(json["checks"][1]["seconds"].get<double>() > 0);
}

TEST_CASE("mistakes") {
  check_refused("check", 2, "check needs NAME");
  check_refused("check no_such_technique", 2, "no technique is called");
  check_refused(faulty("") + "--only nonsense", 2, "no check has a name that begins with nonsense");
  check_refused(faulty("") + "-p fualt=none", 2, "did you mean 'fault'?");
  check_refused(faulty(":fault=nonsense"), 2, "no value is called 'nonsense'");
}
