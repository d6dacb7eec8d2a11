// SPDX-License-Identifier: Apache-2.0
// Walks and saved states, by the whole program.
#include <algorithm>
#include <fstream>

#include "cli_support.h"
#include "file_bytes.h"

using namespace lucarium::test;
using nlohmann::json;

namespace {

const std::string bundles = "-t bundle_exchange:texels=2048,directions=32,stop_error=0 --size 16x16 --spp 2 --quiet ";

/// The pixels of two images are the same to the bit (headers hold times).
bool same_pixels(const std::filesystem::path& a, const std::filesystem::path& b) {
  const ProgramResult result = run_lucarium("diff " + a.string() + " " + b.string() + " --json");
  CAPTURE(result.err);
  const json metrics = json::parse(result.out);
  return metrics.at("layers").at("image").at("MSE") == 0;
}

}  // namespace

TEST_CASE("a frame of a walk is the same alone, in the walk, and from a saved state with its camera") {
  const TemporaryFolder folder;
  const auto file = [&](const char* name) { return (folder.path() / name).string(); };
  const std::string walk = "render builtin:cornell-mirror --camera-path walk --fps 2 " + bundles;
  const ProgramResult all =
      run_lucarium(walk + "--frames 1:2 --json --save-state " + file("a.state") + " -o " + file("all.exr"));
  CAPTURE(all.err);
  REQUIRE(all.exit_code == 0);
  const json frames = json::parse(all.out)["frames"];
  REQUIRE(frames.size() == 2);
  CHECK(frames[0]["clocks"]["light_seconds"] > 0);
  CHECK(frames[1]["clocks"]["light_seconds"] == 0);
  CHECK(frames[1]["counters"]["directions"] == 32);
  REQUIRE(run_lucarium(walk + "--frames 2:2 -o " + file("alone.exr")).exit_code == 0);
  CHECK(same_pixels(file("all.0002.exr"), file("alone.0002.exr")));
  CHECK_FALSE(same_pixels(file("all.0001.exr"), file("all.0002.exr")));
  const std::string camera = frames[1]["camera"];
  const ProgramResult stated =
      run_lucarium("render builtin:cornell-mirror --load-state " + file("a.state") + " --camera=" + camera +
                   " --size 16x16 --spp 2 --json -o " + file("stated.exr"));
  CAPTURE(stated.err);
  REQUIRE(stated.exit_code == 0);
  CHECK(same_pixels(file("all.0002.exr"), file("stated.exr")));
  CHECK(only_frame(stated)["technique"] == "bundle_exchange");
  CHECK(only_frame(stated)["clocks"]["state_seconds"] > 0);
}

TEST_CASE("a state is saved without a picture, shown by lucarium state, and never replaced unasked") {
  const TemporaryFolder folder;
  const std::string state = (folder.path() / "a.state").string();
  const std::string save = "render builtin:cornell " + bundles + "--seed 5 --save-state " + state;
  const ProgramResult result = run_lucarium(save);
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, state + ": state, "));
  CHECK(count_files(folder.path()) == 1);
  const ProgramResult text = run_lucarium("state " + state);
  CHECK(text.exit_code == 0);
  CHECK(contains(text.out, "technique     bundle_exchange "));
  CHECK(contains(text.out, "shown: "));
  const json shown = json::parse(run_lucarium("state --json " + state).out);
  CHECK(shown["schema"] == "lucarium-state-1");
  CHECK(shown["scene"] == "builtin:cornell");
  CHECK(shown["seed"] == 5);
  CHECK(shown["parameters"]["directions"] == "32");
  CHECK(shown["file_bytes"] == std::filesystem::file_size(state));
  CHECK(std::any_of(shown["chunks"].begin(), shown["chunks"].end(),
                    [](const json& chunk) { return chunk["name"] == "shown" && chunk["element_bytes"] == 16; }));
  const std::string before = bytes_of(state);
  check_refused(save, 2, "a.state exists; choose another name or give --overwrite");
  CHECK(bytes_of(state) == before);
  REQUIRE(run_lucarium(save + " --overwrite --compress-state").exit_code == 0);
  CHECK(std::filesystem::file_size(state) < before.size());
}

TEST_CASE("states that cannot be used: one line, and nothing is written") {
  const TemporaryFolder folder;
  const std::string state = (folder.path() / "a.state").string(),
                    out = " --quiet -o " + (folder.path() / "a.exr").string();
  REQUIRE(run_lucarium("render builtin:cornell " + bundles + "--save-state " + state).exit_code == 0);
  const std::string load = "render builtin:cornell --size 16x16 --spp 1 --load-state " + state + out;
  check_refused(load + " -p texels=4096", 2, "it was saved with texels=2048, here it is 4096");
  check_refused(load + " --seed 2", 2, "it was saved with --seed 1");
  check_refused(load + " --max-bounces 1", 2, "it was saved with --max-bounces -1");
  check_refused(load + " -t path_tracing", 2, "path_tracing has no state to save or load: it keeps nothing");
  check_refused("render builtin:room --size 16x16 --load-state " + state + out, 3, "it belongs to another scene");
  check_refused("render builtin:cornell -t path_tracing --save-state " + (folder.path() / "b.state").string(), 2,
                "path_tracing has no state to save or load");
  const std::string bytes = bytes_of(state);
  const std::string damaged = (folder.path() / "c.state").string();
  std::ofstream(damaged, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  for (const std::string& command : {"state " + damaged, "render builtin:cornell --load-state " + damaged + out})
    check_refused(command, 3, "c.state: it is cut off in chunk 'shown'");
  check_refused("state " + (folder.path() / "d.state").string(), 3, "no such file");
  check_refused("state " + folder.path().string(), 3, "is a folder, not a file");
  check_refused(load + " --save-state " + state, 2, "give --load-state or --save-state, not both");
  check_refused("render builtin:cornell --compress-state" + out, 2,
                "--compress-state does nothing without --save-state");
  CHECK(count_files(folder.path()) == 2);
}

TEST_CASE("camera paths on the command line that are wrong: exit code 2, in a file: 3, one line") {
  const TemporaryFolder folder;
  const std::string scene = "scene builtin:cornell --camera-path ";
  const auto in_file = [&](const std::string& text) {
    const std::filesystem::path file = folder.path() / "path.json";
    std::ofstream(file) << text;
    return scene + file.string();
  };
  check_refused(scene + "wlak", 2, "there is no camera path 'wlak', nor such a file; did you mean 'walk'?");
  check_refused(scene + "'cubic:0@0,1,3:0,1,0;1@0,1,2:0,1,0'", 2, "begins neither with linear: nor with spline:");
  check_refused("scene builtin:room --camera-path walk", 3, "walk: no such file of a camera path");
  check_refused(scene + "walk --camera 0", 2, "give --camera or --camera-path, not both");
  check_refused(scene + "linear:0@0,0,1:0,0,0", 2, "a path has at least two keys, this one has one");
  check_refused(scene + "'linear:0@0,0,1:0,0,0;0@0,0,2:0,0,0'", 2, "times must ascend");
  check_refused(scene + "'spline:1@0,0,1:0,0,0;0@0,0,2:0,0,0'", 2, "times must ascend");
  check_refused(scene + "'linear:0@0,0,1:0,0,0;nan@0,0,2:0,0,0'", 2, "with finite numbers");
  check_refused(scene + "'linear:0@0,0,1:0,0,0;1@0,0,2:0,0,2'", 2, "key 1: eye and target are the same point");
  check_refused(scene + "'linear:0@0,0,1:0,0,-1;1@0,0,-1:0,0,1' --at 0.5", 3, "eye and target meet at 0.5 s");
  // No frame is rendered when a later one has no view.
  check_refused(
      "render builtin:cornell --size 8x8 --spp 1 -q --frames 0:2 --fps 2 --camera-path "
      "'linear:0@0,0,1:0,0,-1;1@0,0,-1:0,0,1' -o " +
          (folder.path() / "a.png").string(),
      3, "eye and target meet at 0.5 s");
  CHECK(count_files(folder.path()) == 0);
  const std::string first = R"({"keys": [{"seconds": 0, "eye": [0, 0, 1], "target": [0, 0, 0]}, )";
  check_refused(in_file(first + R"({"seconds": 1, "eye": [0, 0, 1], "target": [0, 0, 0], "vfov": 40}]})"), 3,
                "path.json:1: keys/1/vfov: unknown key; known are seconds, eye, target, vfov_degrees");
  check_refused(in_file(R"({"keys": [{"seconds": 0, "eye": [0, 0, 1], "target": [0, 0, 0]}]})"), 3,
                "keys: a path has at least two keys, this one has one");
  check_refused(in_file(R"({"keys": []})"), 3, "this one has none");
  check_refused(in_file("{}"), 3, "must be an array of keys");
  check_refused(in_file(first + R"({"seconds": 0, "eye": [0, 0, 1], "target": [0, 0, 0]}]})"), 3, "times must ascend");
  check_refused(in_file(first + R"({"seconds": 1, "eye": [0, 0, 1], "target": [0, 0, 1]}]})"), 3, "the same point");
  check_refused(in_file(first + R"({"seconds": 1, "eye": [0, 0], "target": [0, 0, 1]}]})"), 3, "must be three numbers");
  check_refused(in_file(first + R"({"seconds": 1, "eye": [0, 0, 1e39], "target": [0, 0, 1]}]})"), 3,
                "key 1 has a number that is not finite");
  check_refused(in_file(first + R"({"eye": [0, 0, 1], "target": [0, 0, 0]}]})"), 3, "\"seconds\" is missing");
  check_refused(in_file(R"({"interpolation": "cubic", "keys": []})"), 3, "must be \"linear\" or \"spline\"");
  check_refused(in_file("{"), 3, "path.json");
}

TEST_CASE("a camera path beside a scene holds until the command line says otherwise") {
  const TemporaryFolder folder;
  const std::string glb = (folder.path() / "a.glb").string();
  REQUIRE(run_lucarium("scene builtin:cornell --export " + glb).exit_code == 0);
  std::ofstream(folder.path() / "walk.json")
      << R"({"interpolation": "linear", "keys": [{"seconds": 0, "eye": [0, 0.3, 1], "target": [0, 0.3, 0]},
             {"seconds": 2, "eye": [0.2, 0.3, 1], "target": [0, 0.3, 0]}]})";
  std::ofstream(glb + ".lucarium.json") << R"({"camera_path": "walk.json"})";
  const auto position = [&](const std::string& more) {
    const ProgramResult result = run_lucarium("scene --json " + glb + more);
    CAPTURE(result.err);
    return json::parse(result.out)["cameras"][0]["position_m"];
  };
  CHECK(position(" --at 1")[0].get<float>() == 0.1f);
  CHECK(position(" --at 5")[0].get<float>() == 0.2f);
  CHECK(position(" --at 1 --camera 0,1,2:0,0,0")[2] == 2);
  CHECK(position(" --camera-path none")[2] != 1);
  CHECK(position(" --camera-path 'linear:0@0,0,3:0,0,0;1@0,0,4:0,0,0'")[2] == 3);
}
