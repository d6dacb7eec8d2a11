// SPDX-License-Identifier: Apache-2.0
// Commands whose work children do, when children cannot be started: one line, exit code 3, and nothing lost.
#include <fstream>
#include <thread>

#include "cli_support.h"

using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

/// The program under a name of its own, which can be taken away while it runs.
fs::path copy_of_program(const TemporaryFolder& folder) {
  const fs::path copy = folder.path() / "bin" / "lucarium";
  fs::create_directories(copy.parent_path());
  const fs::path program = environment("LUCARIUM_TEST_PROGRAM");
  fs::copy_file(program, copy);
  const fs::path library = fs::path("lib") / "lucarium" / "lucarium_program.so";  // what the executable loads
  fs::create_directories((folder.path() / library).parent_path());
  fs::copy_file(program.parent_path().parent_path() / library, folder.path() / library);
  return copy;
}

fs::path make_reference(const TemporaryFolder& folder) {
  fs::path reference = folder.path() / "reference.exr";
  REQUIRE(run_lucarium("render builtin:cornell " + constant_technique("red=0.3") + "--iterations 1 -o " +
                       reference.string())
              .exit_code == 0);
  return reference;
}

void check_one_line(const ProgramResult& result) {
  CAPTURE(result.err);
  CHECK(result.exit_code == 3);
  const size_t at = result.err.find("lucarium: error: cannot start ");
  REQUIRE(at != std::string::npos);
  CHECK(result.err.find('\n', at) == result.err.size() - 1);
}

}  // namespace

TEST_CASE("a comparison whose pieces cannot be started any more aborted as by a fault of ours, and kept no page") {
  const TemporaryFolder folder;
  const fs::path program = copy_of_program(folder), results = folder.path() / "results";
  const std::string command = program.string() + " compare builtin:cornell " + constant_technique("red=0.25,sleep=30") +
                              "--iterations 5 --seeds 12 --reference " + make_reference(folder).string() + " -o " +
                              results.string();
  ProgramResult ended;
  std::thread comparison([&] { ended = run_program(command); });
  const bool begun = wait_until([&] { return fs::exists(results / "results.json"); });
  fs::remove(program);
  comparison.join();
  REQUIRE(begun);
  check_one_line(ended);
  CHECK(contains(ended.err, " finished piece"));
  CHECK(fs::exists(results / "report.html"));
  const ProgramResult resumed = run_lucarium(command.substr(program.string().size()) + " --resume --json");
  CHECK(resumed.exit_code == 0);
  CHECK(contains(resumed.err, "finished already: "));
  CHECK(nlohmann::json::parse(resumed.out)["pieces"].size() == 12);
}
