// SPDX-License-Identifier: Apache-2.0
// lucarium new-technique: what it writes and what it refuses. That the result builds, runs and passes its tests is the
// subject of sdk/new_technique.
#include <fstream>
#include <sstream>

#include "cli_support.h"
#include "file_bytes.h"

using namespace lucarium::test;
namespace fs = std::filesystem;

TEST_CASE("a new technique is a folder that names itself everywhere and says what to do next") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "fresh";
  const ProgramResult result = run_lucarium("new-technique light_soup --output " + target.string());
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "cmake -G Ninja -S " + target.string()));
  CHECK(contains(result.out, "-t light_soup"));
  for (const char* name : {"CMakeLists.txt", "README.md", "light_soup.cpp", "test_light_soup.cpp", "add_emission.cl"}) {
    CAPTURE(name);
    REQUIRE(fs::exists(target / name));
    CHECK_FALSE(contains(bytes_of(target / name), "my_technique"));
  }
  CHECK(contains(bytes_of(target / "light_soup.cpp"), "info.name = \"light_soup\""));
  CHECK(count_files(target) == 5);
}

TEST_CASE("--overwrite writes the template's files again and leaves all others") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "fresh";
  const std::string command = "new-technique light_soup --output " + target.string();
  REQUIRE(run_lucarium(command).exit_code == 0);
  const std::string before = bytes_of(target / "light_soup.cpp");
  std::ofstream(target / "light_soup.cpp") << "mine";
  std::ofstream(target / "notes.txt") << "mine";
  check_refused(command, 2, "exists; choose another folder with --output or give --overwrite");
  CHECK(bytes_of(target / "light_soup.cpp") == "mine");
  CHECK(run_lucarium(command + " --overwrite").exit_code == 0);
  CHECK(bytes_of(target / "light_soup.cpp") == before);
  CHECK(bytes_of(target / "notes.txt") == "mine");
  check_refused("new-technique light_soup --overwrite --output " + (target / "notes.txt").string(), 2, "is no folder");
}

TEST_CASE("bad names, names that are taken and folders that exist are refused, and nothing is written") {
  const TemporaryFolder folder;
  const std::string there = " --output " + (folder.path() / "fresh").string();
  check_refused("new-technique", 2, "new-technique needs NAME");
  check_refused("new-technique LightSoup" + there, 2, "a-z, 0-9 and _");
  check_refused("new-technique 2fast" + there, 2, "a letter first");
  check_refused("new-technique ../escape" + there, 2, "no name for a technique");
  check_refused("new-technique " + std::string(65, 'a') + there, 2, "at most 64");
  check_refused("new-technique lucarium" + there, 2, "framework's own");
  check_refused("new-technique path_tracing" + there, 2, "is there already");
  check_refused("new-technique fine --output " + folder.path().string(), 2, "exists");
  check_refused("new-technique fine --output /proc/fine", 3, "/proc/fine");
  CHECK(count_files(folder.path()) == 0);
}
