// SPDX-License-Identifier: Apache-2.0
// lucarium reference: to a goal, extended, interrupted, refused.
#include "cli_support.h"
#include "lucarium/film/image_io.h"
#include "two_devices.h"

using namespace lucarium;
using namespace lucarium::test;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// A small Cornell box with few bounces.
std::string reference(const fs::path& file, const std::string& more) {
  return "reference builtin:cornell --size 24x24 --max-bounces 1 --quiet -o " + file.string() + " " + more;
}

}  // namespace

TEST_CASE("reference: one that is extended, even after a sudden end, is the one that is rendered at once") {
  const TemporaryFolder folder;
  const fs::path whole = folder.path() / "whole.exr", grown = folder.path() / "grown.exr";
  REQUIRE(run_lucarium(reference(whole, "--spp 256")).exit_code == 0);
  REQUIRE(run_lucarium(reference(grown, "--spp 64")).exit_code == 0);
  const ProgramResult extended = run_lucarium(reference(grown, "--spp 256 --extend --json"));
  REQUIRE(extended.exit_code == 0);
  const json summary = json::parse(extended.out);
  CHECK(summary["samples"] == 256);
  CHECK(summary["rounds_rendered"] == 4);
  CHECK(summary["goal_reached"] == true);
  CHECK(read_image(grown).image() == read_image(whole).image());

  // What suffices already is left as it is.
  const auto written = fs::last_write_time(grown);
  CHECK(json::parse(run_lucarium(reference(grown, "--spp 128 --extend --json")).out)["rounds_rendered"] == 0);
  CHECK(fs::last_write_time(grown) == written);

  // Killed after a few rounds, whenever that is.
  const fs::path killed = folder.path() / "killed.exr";
  const ProgramResult shell = run_program(
      lucarium_program() + " " + reference(killed, "--spp 100000") + " & pid=$!; until [ -e " + killed.string() +
      " ]; do kill -0 $pid || exit 99; sleep 0.05; done; kill -KILL $pid; wait $pid; true");
  REQUIRE(shell.exit_code == 0);
  REQUIRE(run_lucarium(reference(killed, "--spp 4096 --extend")).exit_code == 0);
  REQUIRE(run_lucarium(reference(whole, "--spp 4096 --extend")).exit_code == 0);
  CHECK(read_image(killed).metadata.at("samples") == "4096");
  CHECK(read_image(killed).image() == read_image(whole).image());
}

TEST_CASE("reference: it renders to a wanted error and keeps where it comes from") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "r.exr";
  const ProgramResult result = run_lucarium(reference(file, "--relmse 0.02 --json -t path_tracing:direct=off"));
  REQUIRE(result.exit_code == 0);
  const json summary = json::parse(result.out);
  CHECK(summary["own_relmse"].get<double>() <= 0.02);
  CHECK(summary["own_relmse"].get<double>() > 0.001);  // not far beyond what was asked for
  const Film film = read_image(file);
  CHECK(film.metadata.at("half_a_samples") == film.metadata.at("half_b_samples"));
  CHECK(contains(film.metadata.at("path_set"), "max_bounces=1"));
  CHECK(contains(film.metadata.at("path_set"), "direct=off"));
  CHECK(film.metadata.at("scene_hash").size() == 32);
  CHECK(film.find("HalfA"));
  CHECK(film.find("Variance"));
}

TEST_CASE("reference: a time that preparing uses up still gives an image") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "r.exr";
  const ProgramResult result = run_lucarium(reference(file, "--time 1e-6 --json"));
  REQUIRE(result.exit_code == 0);
  CHECK(json::parse(result.out)["samples"] == 16);  // one iteration
  CHECK(json::parse(result.out)["goal_reached"] == true);
}

TEST_CASE("reference: Ctrl-C keeps what is done, and it goes on from there") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "r.exr";
  const ProgramResult interrupted =
      run_program(lucarium_program() + " " + reference(file, "--spp 1000000") + " & pid=$!; until [ -e " +
                  file.string() + " ]; do kill -0 $pid || exit 99; sleep 0.05; done; kill -INT $pid; wait $pid");
  CHECK(interrupted.exit_code == 6);
  const uint64_t samples = std::stoull(read_image(file).metadata.at("samples"));
  CHECK(samples >= 16);
  REQUIRE(run_lucarium(reference(file, "--extend --spp " + std::to_string(samples + 64))).exit_code == 0);
  CHECK(std::stoull(read_image(file).metadata.at("samples")) >= samples + 64);
}

TEST_CASE(
    "reference: rounds that two devices share give the file of one device, to a number of samples and to an error") {
  if (!lends_two_devices()) return skip("PoCL, which lends two devices");
  const TemporaryFolder folder;
  const std::string two = std::string("env POCL_DEVICES='") + two_devices_of_pocl + "' " + lucarium_program() + " ";
  for (const std::string goal : {"--spp 200", "--relmse 0.02"}) {
    CAPTURE(goal);
    const fs::path alone = folder.path() / "alone.exr", shared = folder.path() / "shared.exr";
    REQUIRE(run_lucarium(reference(alone, goal + " --overwrite")).exit_code == 0);
    const ProgramResult run = run_program(two + reference(shared, goal + " --overwrite --devices 0,1 --json"));
    CAPTURE(run.err);
    REQUIRE(run.exit_code == 0);
    CHECK(json::parse(run.out)["goal_reached"] == true);
    Film a = read_image(alone), b = read_image(shared);
    REQUIRE(a.layers().size() == b.layers().size());
    for (const FilmLayer& layer : a.layers()) CHECK_MESSAGE(layer.pixels == b.find(layer.name)->pixels, layer.name);
    for (Film* film : {&a, &b}) film->metadata.erase("seconds");
    CHECK(a.metadata == b.metadata);
    CHECK(!fs::exists(shared.string() + ".rounds"));
  }
  const ProgramResult timed = run_program(two + reference(folder.path() / "timed.exr", "--time 1 --devices all"));
  CHECK(timed.exit_code == 2);
  CHECK(contains(timed.err, "not --time"));
}

TEST_CASE("reference: mistakes") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "r.exr";
  REQUIRE(run_lucarium(reference(file, "--spp 32")).exit_code == 0);
  check_refused(reference(file, "--spp 32"), 2, "exists");
  check_refused(reference(file, "--spp 32 --extend --overwrite"), 2, "not both");
  check_refused(reference(file, "--spp 64 --extend --max-bounces 3"), 2, "max_bounces: 1 against 3");
  check_refused(reference(file, "--spp 64 --extend --size 8x8"), 2, "size: 24x24 against 8x8");
  check_refused(reference(folder.path() / "r.png", ""), 2, ".exr");
  const std::string by_set = "reference builtin:cornell --size 24x24 -o " + (folder.path() / "s.exr").string();
  check_refused(by_set + " --path-set max_bounce=1", 2, "max_bounces");
  for (const char* wrong :
       {"max_bounces=-7", "max_bounces=5000", "max_bounces=1.5", "indirect_clamp=-1", "indirect_clamp=nan"})
    check_refused(by_set + " --path-set " + wrong, 2, "path set: ");
  const fs::path other = folder.path() / "render.exr";
  REQUIRE(run_lucarium("render builtin:cornell " + constant_technique() + "--iterations 1 --quiet -o " + other.string())
              .exit_code == 0);
  check_refused(reference(other, "--extend"), 3, "not an image of lucarium reference");
}
