// SPDX-License-Identifier: Apache-2.0
// Comparison files, and what is made of results that are already there.
#include <doctest/doctest.h>

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/file_lock.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/request/device_arguments.h"
#include "lucarium/compare/run/comparison.h"
#include "lucarium/metrics/error_map.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

ComparisonSpec example_spec() {
  ComparisonSpec spec;
  spec.scenes.resize(2);
  spec.scenes[0].source = "builtin:cornell";
  spec.scenes[1].source = "/scenes/a \"b\".glb";
  spec.scenes[1].name = "mine";
  spec.scenes[1].overrides.camera = "0,1,2:0,0,0:45";
  spec.scenes[1].overrides.environment = "1,1,1*2";
  spec.scenes[1].overrides.lights = {"none", "point:0,1,0:5,5,5"};
  spec.scenes[1].overrides.exposure = -1.5f;
  spec.scenes[1].overrides.materials = {"wall*:roughness=0.5"};
  spec.scenes[1].overrides.use_sidecar = false;
  spec.scenes[1].import.max_texture_size = 512;
  spec.scenes[1].size = {32, 18};
  spec.scenes[1].max_bounces = 0;
  spec.scenes[1].threads = 2;
  spec.variants = {{"path_tracing", {{"estimator", "mis"}, {"replicates", "4"}}, ""}, {"path_tracing", {}, "plain"}};
  spec.budgets = {{2.5, 0, 0, 0}, {0, 64, 0, 0}, {0, 0, 0.001, 60}, {0, 0, 0, 0, 16}};
  spec.width = 8;
  spec.height = 4;
  spec.max_bounces = 3;
  spec.reference = {std::nullopt, 512, 1e-4};
  spec.scenes[0].overrides.camera_path = "linear:0@0,1,2:0,0,0:40;1@0,1,3:0,0,0:45";
  spec.walk = WalkRequest{48, 4, 3};
  return spec;
}

/// What reading the text as a comparison file complains about.
std::string complaint(const std::string& text) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "my.json";
  write_file_atomically(file, text);
  try {
    check_comparison(read_comparison(file));
  } catch (const Error& error) {
    const std::string what = error.what();
    const size_t at = what.find("my.json");
    return at == std::string::npos ? what : what.substr(at);
  }
  return "accepted";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string with(const std::string& members) {
  return "{\"schema\": \"lucarium-comparison-1\",\n\"scenes\": [\"builtin:cornell\"],\n\"techniques\": "
         "[\"path_tracing\"],\n" +
         members + "}";
}

}  // namespace

TEST_CASE("a comparison survives its file") {
  const test::TemporaryFolder folder;
  const ComparisonSpec spec = example_spec();
  write_file_atomically(folder.path() / "comparison.json", spec.to_json());
  const ComparisonSpec again = read_comparison(folder.path() / "comparison.json");
  CHECK(again.to_json() == spec.to_json());
  CHECK(again.variants[0].label() == "path_tracing:estimator=mis,replicates=4");
  CHECK(again.variants[1].label() == "plain");
  CHECK(again.scenes[1].overrides.lights == spec.scenes[1].overrides.lights);
  CHECK(again.scenes[1].overrides.materials == spec.scenes[1].overrides.materials);
  CHECK(again.budgets[2].limit_seconds == 60);
  CHECK(again.budgets[3].samples == 16);
  CHECK(again.scenes[0].overrides.camera_path == spec.scenes[0].overrides.camera_path);
  CHECK(again.walk->references == 3);
  CHECK(again.scenes[1].size == spec.scenes[1].size);
}

TEST_CASE("a scene's own size, bounces and threads take the place of the comparison's") {
  ComparisonSpec spec = example_spec();
  spec.device_arguments = {"--threads", "1", "--memory-limit", "1G"};
  const SceneSettings common = spec.settings_of(spec.scenes[0]), own = spec.settings_of(spec.scenes[1]);
  CHECK(common.width == 8);
  CHECK(common.height == 4);
  CHECK(common.max_bounces == 3);
  CHECK(own.width == 32);
  CHECK(own.height == 18);
  CHECK(own.max_bounces == 0);
  DeviceOptions device;
  REQUIRE_FALSE(read_device_arguments(common.device_arguments, device));
  CHECK(device.threads == 1);
  REQUIRE_FALSE(read_device_arguments(own.device_arguments, device));
  CHECK(device.threads == 2);
  CHECK(device.memory_limit_bytes == size_t{1} << 30);
}

TEST_CASE("file names in a comparison file are meant from its folder") {
  const test::TemporaryFolder folder;
  write_file_atomically(
      folder.path() / "c.json",
      R"({"schema": "lucarium-comparison-1", "scenes": [{"scene": "a/b.glb", "environment": "sky.hdr*2"}],
                            "techniques": ["path_tracing"], "budgets": [{"seconds": 1}],
                             "reference": {"file": "r.exr"}})");
  const ComparisonSpec spec = read_comparison(folder.path() / "c.json");
  CHECK(spec.scenes[0].source == (folder.path() / "a/b.glb").string());
  CHECK(*spec.scenes[0].overrides.environment == (folder.path() / "sky.hdr*2").string());
  CHECK(*spec.reference.file == folder.path() / "r.exr");
}

TEST_CASE("mistakes in a comparison file are named with line and key") {
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1}]")) == "accepted");
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1}],\n\"sedes\": 3")) ==
        "my.json:5: sedes: unknown key; did you mean 'seeds'?");
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1,\n\"iterations\": 2}]")) ==
        "my.json:4: budgets/0: must have exactly one of \"seconds\", \"iterations\", \"samples\" and \"relmse\"");
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 0}]")) == "my.json:4: budgets/0/seconds: must be above 0");
  CHECK(complaint(with("\"budgets\": [{\"relmse\": 0.1}]")) ==
        "my.json:4: budgets/0: \"relmse\" and \"limit_seconds\" must be given together");
  CHECK(complaint(with("\"budgets\": []")) == "my.json:4: budgets: must be an array with at least one element");
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1}],\n\n\"size\": [640]")) ==
        "my.json:6: size: must be [width, height]");
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1}], \"seeds\": 0")) ==
        "my.json:4: seeds: must be a whole number from 1 to 1000");
  const auto scene = [](const std::string& members) {
    return complaint(
        "{\"schema\": \"lucarium-comparison-1\", \"techniques\": [\"path_tracing\"],\n\"budgets\": "
        "[{\"seconds\": 1}], \"scenes\": [{\"scene\": \"builtin:cornell\", " +
        members + "}]}");
  };
  CHECK(scene("\"size\": [16, 9], \"max_bounces\": 2, \"threads\": 1") == "accepted");
  CHECK(scene("\"size\": [16]") == "my.json:2: scenes/0/size: must be [width, height]");
  CHECK(contains(scene("\"size\": [16, 0]"), "my.json:2: scenes/0/size: must be from 1 to"));
  CHECK(contains(scene("\"max_bounces\": -2"), "my.json:2: scenes/0/max_bounces: must be a whole number from -1"));
  CHECK(contains(scene("\"threads\": 0"), "my.json:2: scenes/0/threads: must be a whole number from 1"));
  CHECK(complaint("{\"scenes\": []}") == "my.json:1: schema: must be \"lucarium-comparison-1\"");
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1}, {\"seconds\": 1.0}]")) == "the budget 1 s is given twice");
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1}], \"reference\": {\"file\": \"a.exr\", \"samples\": 64}")) ==
        "my.json:4: reference: a file is used as it is; leave out the other keys");
  CHECK(complaint("{").starts_with("my.json:1: this is not valid JSON"));
}

TEST_CASE("a comparison file ran code: device_arguments passed any word on") {
  const auto with_words = [](const std::string& words) {
    return complaint(with("\"budgets\": [{\"seconds\": 1}],\n\"device_arguments\": [" + words + "]"));
  };
  CHECK(
      with_words("\"--technique-path\", \"E\"") ==
      "my.json:5: device_arguments/0: '--technique-path' is not allowed here; --device, --threads, --memory-limit and "
      "--allocation-limit are, each with a value");
  CHECK(contains(with_words("\"--threads\", \"2\", \"-o\", \"a.exr\""),
                 "my.json:5: device_arguments/2: '-o' is not allowed here"));
  CHECK(contains(with_words("\"--technique-path=E\""), "device_arguments/0: '--technique-path=E' is not allowed"));
  CHECK(contains(with_words("\"--cache-dir\", \"E\""), "'--cache-dir' is not allowed here"));
  CHECK(contains(with_words("\"--device\", \"--technique-path=E\""),
                 "device_arguments/1: '--technique-path=E' names no device"));
  CHECK(contains(with_words("\"--threads\", \"-1\""), "device_arguments/1: '-1' is not a number of threads"));
  CHECK(contains(with_words("\"--memory-limit\", \"lots\""), "'lots' is not a number of bytes"));
  CHECK(contains(with_words("\"--threads\""), "device_arguments/0: --threads needs a value"));
  CHECK(with_words("\"--device\", \"cpu\", \"--threads=2\", \"--memory-limit\", \"1G\", \"--allocation-limit=500M\"") ==
        "accepted");
}

TEST_CASE("device_arguments say what was written, in either form") {
  DeviceOptions device;
  REQUIRE(!read_device_arguments(write_device_arguments("cpu", 2, "1.5G", "500M"), device));
  CHECK(device.selector == "cpu");
  CHECK(device.threads == 2);
  CHECK(device.memory_limit_bytes == size_t{3} << 29);
  CHECK(device.allocation_limit_bytes == size_t{500} << 20);
  REQUIRE(!read_device_arguments({"--threads=3"}, device));
  CHECK(device.threads == 3);  // the last one counts, and the others stay
  CHECK(device.selector == "cpu");
  CHECK(write_device_arguments("", 0, "", "").empty());
}

TEST_CASE("a fallback environment that is no colour was taken for a file and found out when a scene needed it") {
  for (const char* text : {"x", "none", "1,2", "-1", "sky.hdr*2"}) {
    CHECK(
        complaint(with("\"budgets\": [{\"seconds\": 1}],\n\"fallback_environment\": \"" + std::string(text) + "\"")) ==
        "my.json:5: fallback_environment: '" + std::string(text) + "' is not a sky: R,G,B or one grey value [cd/m2]");
  }
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1}], \"fallback_environment\": \"1,1,1*2\"")) == "accepted");
}

TEST_CASE("of a key that is given twice the second won silently") {
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1}],\n\"seeds\": 1,\n\"seeds\": 2")) ==
        "my.json:6: the key \"seeds\" is given twice in one object");
  CHECK(complaint(with("\"budgets\": [{\"seconds\": 1,\n\"seconds\": 2}]")) ==
        "my.json:5: the key \"seconds\" is given twice in one object");
  // The same key in two objects, and one that reads like a path, are no doubles.
  CHECK(contains(complaint(with("\"budgets\": [{\"seconds\": 1}, {\"seconds\": 2}], \"a/b\": 1, \"a\": {\"b\": 1}")),
                 "my.json:4: a: unknown key"));
}

TEST_CASE("a gate whose bar is no finite number always passed, or never") {
  for (const char* text : {"relmse<nan", "relmse>nan", "relmse<inf", "relmse>-inf", "psnr>-infinity"}) {
    CHECK_THROWS_WITH_AS(parse_gate(text), doctest::Contains("is not METRIC<VALUE"), Error);
  }
  CHECK(parse_gate("relmse<1e-3").bar == 1e-3);
}

TEST_CASE("two comparisons cannot use one folder") {
  const test::TemporaryFolder folder;
  const FolderLock first(folder.path());
  CHECK_THROWS_AS(FolderLock second(folder.path()), Error);
}

TEST_CASE("the error map is blue where too dark, red where too bright, white where right") {
  const std::vector<float> reference = {1, 1, 1, 1, 1, 1, 1, 1, 1}, test = {0, 0, 0, 1, 1, 1, 3, 3, 3};
  const std::vector<float> map = color_signed_error(signed_relative_error(test, reference));
  CHECK(map[2] > map[0]);  // dark: blue above red
  CHECK(map[3] == test::relative(map[5]));
  CHECK(map[6] > map[8]);  // bright: red above blue
}
