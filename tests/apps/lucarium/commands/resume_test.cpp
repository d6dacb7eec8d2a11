// SPDX-License-Identifier: Apache-2.0
// A comparison that is killed again and again, at random moments, ends with the pixels of one that was left alone.
#include <chrono>
#include <fstream>
#include <map>
#include <random>
#include <sstream>

#include "cli_support.h"
#include "file_bytes.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/film/image_io.h"

using namespace lucarium;
using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

/// Content of the image and the summary of every finished piece, by file name.
std::map<std::string, std::string> finished(const fs::path& results) {
  std::map<std::string, std::string> files;
  if (!fs::exists(results / "pieces")) return files;
  for (const fs::directory_entry& entry : fs::directory_iterator(results / "pieces")) {
    if (entry.path().extension() != ".json") continue;
    files[entry.path().filename()] = bytes_of(entry.path());
    const fs::path image = fs::path(entry.path()).replace_extension(".exr");
    files[image.filename()] = bytes_of(image);
  }
  return files;
}

/// Two estimators, two seeds, four iterations; without a cache in common, so that the references are rendered too.
std::string comparison(const fs::path& results, const fs::path& cache) {
  return "compare builtin:cornell -t path_tracing -t path_tracing:estimator=nee --size 20x12 --max-bounces 2 "
         "--iterations 4 "
         "--seeds 2 --reference-spp 2048 --quiet --cache-dir " +
         cache.string() + " -o " + results.string();
}

}  // namespace

TEST_CASE("a comparison killed at random moments ends like one left alone; what was finished is never touched again") {
  const TemporaryFolder folder;
  const fs::path alone = folder.path() / "alone", killed = folder.path() / "killed";
  const fs::path cache = folder.path() / "cache";
  const lucarium::Stopwatch watch;
  REQUIRE(run_lucarium(comparison(alone, cache)).exit_code == 0);
  const double undisturbed = watch.seconds();
  fs::remove_all(cache / "references");

  // Some lives are long enough to finish a piece or two, however busy the machine is.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> wait(0.02 * undisturbed, (full_run() ? 0.2 : 0.5) * undisturbed);
  std::map<std::string, std::string> before;
  int kills = 0, exit_code = 137;
  while (exit_code == 137 && kills < 100) {
    const double life = wait(random) * (kills < 3 ? 0.2 : 1);  // the first ones are too short for all of it
    const std::string command = "timeout -s KILL " + std::to_string(life) + " " + lucarium_program() + " " +
                                comparison(killed, cache) + (fs::exists(killed / "comparison.json") ? " --resume" : "");
    const ProgramResult run = run_program(command);
    CAPTURE(run.err);
    exit_code = run.exit_code;
    kills += exit_code == 137;
    const auto now = finished(killed);
    for (const auto& [name, bytes] : before) {
      REQUIRE_MESSAGE(now.count(name), name);
      CHECK_MESSAGE(now.at(name) == bytes, name);
    }
    before = now;
  }
  CHECK(exit_code == 0);
  CHECK(kills >= 2);
  const auto expected = finished(alone), got = finished(killed);
  CHECK(got.size() == 8);
  REQUIRE(got.size() == expected.size());
  for (const auto& [name, unused] : expected) {
    if (fs::path(name).extension() != ".exr") continue;
    CHECK_MESSAGE(read_image(alone / "pieces" / name).image() == read_image(killed / "pieces" / name).image(), name);
  }
  const char* const reference = "references/scene1-set1.exr";
  CHECK(read_image(alone / reference).image() == read_image(killed / reference).image());
}
