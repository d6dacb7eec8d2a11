// SPDX-License-Identifier: Apache-2.0
// Comparisons that walk along the camera path of a scene behind every run.
#include <fstream>
#include <iterator>

#include "cli_support.h"
#include "file_bytes.h"
#include "tolerance.h"

using namespace lucarium::test;
using nlohmann::json;
namespace fs = std::filesystem;

TEST_CASE("a comparison with a walk: seconds per frame, and the error of frames that have a reference") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "walk.json", results = folder.path() / "results";
  std::ofstream(file) << R"({"schema": "lucarium-comparison-1",
    "scenes": [{"scene": "builtin:cornell", "camera_path": "walk"}],
    "techniques": ["path_tracing",
                   {"technique": "bundle_exchange", "parameters": {"texels": 1024, "directions": 16, "stop_error": 0}}],
    "budgets": [{"iterations": 4}], "seeds": 1, "size": [16, 12], "reference": {"samples": 32},
    "walk": {"frames": 5, "samples": 3, "references": 2}})";
  const ProgramResult run = run_lucarium("compare --comparison " + file.string() + " -o " + results.string());
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  const json result = json::parse(bytes_of(results / "results.json"));
  CHECK(result["comparison"]["walk"] == json({{"frames", 5}, {"samples", 3}, {"references", 2}}));
  for (const char* list : {"pieces", "summaries"}) {
    for (const json& entry : result[list]) {
      const json& walk = entry["walk"];
      CHECK(walk["frame_seconds"]["min"] > 0);
      CHECK(walk["frame_seconds"]["min"] <= walk["frame_seconds"]["median"]);
      CHECK(walk["frame_seconds"]["median"] <= walk["frame_seconds"]["max"]);
      CHECK(walk["relmse"] > 0);
    }
  }
  CHECK(contains(bytes_of(results / "results.csv"), "walk_median_seconds"));
  CHECK(contains(bytes_of(results / "report.html"), "Walk along the camera path"));

  // The reference of path_tracing's light paths; its first frame is the scene's own view.
  const json& piece = result["pieces"][0];
  const size_t set = result["scenes"][0]["variants"][0]["reference"];
  const json& reference = result["scenes"][0]["references"][set];
  REQUIRE(reference["walk"].size() == 2);
  CHECK(reference["walk"][0]["frame"] == 0);
  CHECK(reference["walk"][1]["frame"] == 4);
  const auto image = [&](const json& name) { return (results / name.get<std::string>()).string(); };
  const auto error = [&](const std::string& test, const std::string& truth, const char* metric) {
    const ProgramResult diff = run_lucarium("diff " + test + " " + truth + " --json");
    CAPTURE(diff.err);
    return json::parse(diff.out).at("layers").at("image").at(metric).get<double>();
  };
  CHECK(error(image(reference["walk"][0]["image"]), image(reference["image"]), "MSE") == 0);
  CHECK(error(image(reference["walk"][1]["image"]), image(reference["image"]), "MSE") > 0);
  // What was measured on the way is what a picture from there has.
  double expected = 0;
  for (const json& frame : reference["walk"]) {
    const std::string picture = (folder.path() / "frame.exr").string();
    REQUIRE(run_lucarium("render builtin:cornell -t path_tracing --size 16x12 --spp 3 --quiet --overwrite --camera=" +
                         frame["camera"].get<std::string>() + " -o " + picture)
                .exit_code == 0);
    expected += 0.5 * error(picture, image(frame["image"]), "relMSE");
  }
  CHECK(piece["walk"]["relmse"].get<double>() == relative(expected, 1e-4));
}

TEST_CASE("walks that are stated wrong, or on a scene without a path, end before anything is rendered") {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& scene, const std::string& walk, int exit_code, const std::string& part) {
    const fs::path file = folder.path() / "walk.json";
    std::ofstream(file) << R"({"schema": "lucarium-comparison-1", "scenes": [)" + scene +
                               R"(], "techniques": ["path_tracing"], "budgets": [{"iterations": 1}], "walk": )" + walk +
                               "}";
    check_refused("compare --comparison " + file.string() + " -q -o " + (folder.path() / "results").string(), exit_code,
                  part);
  };
  const std::string scene = R"({"scene": "builtin:cornell", "camera_path": "walk"})";
  refuse(scene, R"({"samples": 2})", 3, "walk: \"frames\" is missing");
  refuse(scene, R"({"frames": 1})", 3, "walk/frames: must be a whole number from 2 to 100000");
  refuse(scene, R"({"frames": 9, "samples": 0})", 3, "walk/samples: must be a whole number from 1 to");
  refuse(scene, R"({"frames": 9, "references": 10})", 3, "walk/references: must be a whole number from 0 to 9");
  refuse(scene, R"({"frames": 9, "smaples": 1})", 3, "walk/smaples: unknown key; did you mean 'samples'?");
  refuse("\"builtin:cornell\"", R"({"frames": 9})", 3, "there is no camera path to walk along");
  CHECK(count_files(folder.path()) == 1);
}

TEST_CASE("a walk says where it waits for light that may never be finished") {
  const TemporaryFolder folder;
  const auto walk = [&](const std::string& parameters) {
    return run_lucarium("render builtin:cornell -t bundle_exchange:texels=1024," + parameters +
                        " --camera-path walk --frames 0:0 --size 16x12 --spp 1 --overwrite -o " +
                        (folder.path() / "frame_#.png").string());
  };
  const ProgramResult endless = walk("directions=0,stop_error=0.05"), limited = walk("directions=16");
  CAPTURE(endless.err);
  CHECK(endless.exit_code == 0);
  CHECK(limited.exit_code == 0);
  CHECK(contains(endless.err, "when its light will be finished is unknown"));
  CHECK_FALSE(contains(limited.err, "is unknown"));
}
