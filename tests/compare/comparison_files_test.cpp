// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "lucarium/base/atomic_file.h"
#include "lucarium/base/error.h"
#include "lucarium/compare/comparison.h"
#include "lucarium/compare/error_map.h"
#include "lucarium/compare/file_lock.h"
#include "lucarium/film/image_io.h"
#include "test_support.h"

using namespace lucarium;

namespace {

ComparisonSpec example_spec() {
  ComparisonSpec spec;
  spec.scenes = {"builtin:cornell", "a scene with \"quotes\".glb"};
  spec.variants = {{"path_tracing", {{"estimator", "mis"}, {"replicates", "4"}}}, {"path_tracing", {}}};
  spec.budget.seconds = 2.5;
  spec.width = 8;
  spec.height = 4;
  spec.max_bounces = 3;
  spec.exposure = -1.5f;
  spec.scene_arguments = {"--camera", "0"};
  return spec;
}

Film constant_film(float value) {
  Film film(8, 4);
  FilmLayer& layer = film.layer("direct", {"R", "G", "B"}, true);
  layer.pixels.assign(8 * 4 * 3, value);
  return film;
}

ComparisonResult example_result() {
  ComparisonResult result;
  result.spec = example_spec();
  result.device = "test device";
  result.driver = "1.0";
  result.version = "0";
  result.scenes.resize(2);
  result.scenes[0].name = result.spec.scenes[0];
  result.scenes[0].limitations = {{}, {"cannot do </script> lights"}};
  result.scenes[0].reference = {"references/scene1.exr", "path_tracing", "max_bounces=3", false, 1.5, true, 1e-6, 1e-5};
  result.scenes[1].name = result.spec.scenes[1];
  result.scenes[1].failure = "no such file";
  PieceResult good;
  good.image = "pieces/scene1-variant1-seed1.exr";
  good.render_summary = R"({"samples":16})";
  good.samples = 16;
  good.seconds = 2.25;
  good.relmse = 0.25;
  PieceResult dead;
  dead.variant = 1;
  dead.failure = "killed by signal 9 (Killed): last words";
  result.pieces = {good, dead};
  return result;
}

}  // namespace

TEST_CASE("a comparison survives its JSON") {
  const ComparisonSpec spec = example_spec();
  const ComparisonSpec again = ComparisonSpec::parse(spec.to_json(), "test");
  CHECK(again.to_json() == spec.to_json());
  CHECK(again.variants[0].label() == "path_tracing:estimator=mis,replicates=4");
  CHECK(again.scenes == spec.scenes);
  CHECK(*again.exposure == -1.5f);
}

TEST_CASE("an unknown key of a comparison is named with the nearest known one") {
  try {
    ComparisonSpec::parse(R"({"scenes": [], "variants": [], "sedes": 3})", "my.json");
    FAIL("accepted");
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::usage);
    CHECK(std::string(error.what()) == "my.json: unknown key 'sedes'; did you mean 'seeds'?");
  }
  CHECK_THROWS_AS(ComparisonSpec::parse("{\"scenes\": 3}", "my.json"), Error);
}

TEST_CASE("results survive their JSON, and the CSV has a line per piece") {
  const ComparisonResult result = example_result();
  const ComparisonResult again = ComparisonResult::parse(result.to_json(), "test");
  CHECK(again.to_json() == result.to_json());
  CHECK(again.pieces[1].failure == result.pieces[1].failure);
  const std::string csv = result.to_csv();
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 3);
  CHECK(csv.find("\"builtin:cornell\",\"path_tracing:estimator=mis,replicates=4\",1,16,2.25") != std::string::npos);
  CHECK_THROWS_AS(ComparisonResult::parse("{}", "test"), Error);
}

TEST_CASE("a report holds pictures and data, and nothing breaks out of its script") {
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "pieces");
  std::filesystem::create_directories(folder.path() / "references");
  write_exr(folder.path() / "references/scene1.exr", constant_film(1.0f));
  write_exr(folder.path() / "pieces/scene1-variant1-seed1.exr", constant_film(1.5f));
  write_report(example_result(), folder.path());
  const std::string page = read_file(folder.path() / "report.html");
  CHECK(page.find("@DATA@") == std::string::npos);
  CHECK(page.find("src=\"http") == std::string::npos);

  const std::string open = "<script id=\"data\" type=\"application/json\">";
  const size_t begin = page.find(open) + open.size();
  const auto data = nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  REQUIRE(data["scenes"].size() == 2);
  CHECK(data["scenes"][0]["pictures"].size() == 3);  // reference, picture, error map
  CHECK(data["scenes"][0]["rows"][0]["relmse"] == doctest::Approx(0.25));
  CHECK(data["scenes"][0]["rows"][1]["failure"] == "killed by signal 9 (Killed): last words");
  CHECK(data["scenes"][1]["text"] == "no such file");
}

TEST_CASE("two comparisons cannot use one folder") {
  const test::TemporaryFolder folder;
  const FolderLock first(folder.path());
  CHECK_THROWS_AS(FolderLock second(folder.path()), Error);
}

TEST_CASE("the error map is blue where too dark, red where too bright, white where right") {
  const std::vector<float> reference = {1, 1, 1, 1, 1, 1, 1, 1, 1}, test = {0, 0, 0, 1, 1, 1, 3, 3, 3};
  const std::vector<float> map = signed_error_map(test, reference);
  CHECK(map[2] > map[0]);  // dark: blue above red
  CHECK(map[3] == doctest::Approx(map[5]));
  CHECK(map[6] > map[8]);  // bright: red above blue
}
