// SPDX-License-Identifier: Apache-2.0
// devices, techniques, scene, diff, help and version.
#include <cmath>
#include <fstream>
#include <sstream>

#include "cli_support.h"
#include "lucarium/film/image_io.h"
#include "lucarium/version.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;
using nlohmann::json;

namespace {

std::string write_grey(const TemporaryFolder& folder, const std::string& name, uint32_t width, float value) {
  Film film(width, 12);
  FilmLayer& direct = film.layer("direct", {"R", "G", "B"}, true);
  std::fill(direct.pixels.begin(), direct.pixels.end(), value);
  const std::string file = (folder.path() / name).string();
  write_exr(file, film);
  return file;
}

}  // namespace

TEST_CASE("help and version are on standard output and end with 0") {
  const ProgramResult help = run_lucarium("--help");
  CHECK(help.exit_code == 0);
  for (const char* command : {"render", "reference", "compare", "report", "diff", "scene", "techniques", "devices"})
    CHECK(contains(help.out, command));
  CHECK(run_lucarium("render --help").exit_code == 0);
  CHECK(contains(run_lucarium("--version").out, "lucarium " LUCARIUM_VERSION));
}

TEST_CASE("scene --export writes what render then takes for the same scene") {
  const TemporaryFolder folder;
  const std::string glb = (folder.path() / "a.glb").string();
  const ProgramResult exported = run_lucarium("scene builtin:cornell --environment 0.5 --export " + glb);
  CHECK(exported.exit_code == 0);
  CHECK(contains(exported.out, " " + glb + "\n"));
  CHECK(contains(exported.out, " " + glb + ".lucarium.json\n"));
  CHECK(count_files(folder.path()) == 2);
  const ProgramResult result = run_lucarium("scene " + glb + " --json");
  CHECK(result.exit_code == 0);
  CHECK(json::parse(result.out)["triangles"] ==
        json::parse(run_lucarium("scene builtin:cornell --json").out)["triangles"]);
  check_refused("scene builtin:cornell --export " + glb, 2, "--overwrite");
  CHECK(run_lucarium("scene builtin:cornell --overwrite --export " + glb).exit_code == 0);
  check_refused("scene builtin:cornell --export " + (folder.path() / "a.obj").string(), 2, ".glb");
}

TEST_CASE("devices lists what there is, also as JSON") {
  CHECK(run_lucarium("devices").exit_code == 0);
  const json list = json::parse(run_lucarium("devices --json").out)["devices"];
  REQUIRE(list.size() >= 1);
  CHECK(list[0]["index"] == 0);
  CHECK(list[0]["global_memory_bytes"].get<uint64_t>() > 0);
}

TEST_CASE("techniques prints everything that a technique declares") {
  const std::string folder = "--technique-path " + environment("LUCARIUM_TEST_PLUGINS") + "/constant ";
  const ProgramResult text = run_lucarium("techniques constant " + folder);
  CHECK(text.exit_code == 0);
  CHECK(contains(text.out, "red=0.25  (0 … 100 cd/m²)"));
  const json all = json::parse(run_lucarium("techniques --json " + folder).out)["techniques"];
  bool found = false;
  for (const json& technique : all) {
    if (technique["name"] != "constant") continue;
    found = true;
    CHECK(technique["parameters"][0] == json({{"name", "red"},
                                              {"type", "float"},
                                              {"default", "0.25"},
                                              {"range", "0 … 100"},
                                              {"unit", "cd/m²"},
                                              {"meaning", "radiance of every pixel"},
                                              {"advanced", false}}));
    CHECK(technique["capabilities"]["max_bounces"] == 3);
  }
  CHECK(found);
  check_refused("techniques constnat " + folder, 2, "did you mean 'constant'?");
}

TEST_CASE("docs/techniques.md is what lucarium techniques --markdown prints") {
  std::ifstream page(environment("LUCARIUM_TEST_SOURCE") + "/docs/techniques.md");
  REQUIRE(page);
  std::ostringstream text;
  text << page.rdbuf();
  CHECK(run_lucarium("techniques --markdown").out == text.str());
}

TEST_CASE("scene reports a scene, also as JSON") {
  CHECK(contains(run_lucarium("scene builtin:cornell").out, "triangles"));
  const ProgramResult result = run_lucarium("scene builtin:cornell --json");
  CHECK(result.exit_code == 0);
  CHECK(json::parse(result.out).is_object());
}

TEST_CASE("diff --statistical separates noise from difference") {
  const TemporaryFolder folder;
  const std::string path = folder.path().string();
  const auto render = [&](const std::string& name, const std::string& seed, const std::string& replicates) {
    const ProgramResult result =
        run_lucarium("render builtin:cornell -t path_tracing -p samples_per_iteration=16 -p replicates=" + replicates +
                     " --size 16x16 --max-bounces 1 --iterations 2 --seed " + seed + " -o " + path + "/" + name);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  };
  render("a.exr", "1", "16");
  render("b.exr", "2", "16");
  const ProgramResult same = run_lucarium("diff --statistical " + path + "/a.exr " + path + "/b.exr");
  CHECK(same.exit_code == 0);
  CHECK(contains(same.out, "the same up to noise"));
  const json tested = json::parse(run_lucarium("diff --statistical --json " + path + "/a.exr " + path + "/b.exr").out);
  CHECK(tested["passed"] == true);
  CHECK(tested["levels"][0]["name"] == "pixels");
  CHECK(tested["levels"][0]["failures"] == 0);

  Film brighter = read_image(path + "/b.exr");
  for (float& value : brighter.layer("direct", {"R", "G", "B"}, true).pixels) value *= 1.5f;
  write_exr(path + "/c.exr", brighter);
  const ProgramResult different = run_lucarium("diff --statistical " + path + "/a.exr " + path + "/c.exr");
  CHECK(different.exit_code == 1);
  CHECK(contains(different.out, "DIFFERENT"));
  render("single.exr", "1", "1");
  check_refused("diff --statistical " + path + "/a.exr " + path + "/single.exr", 3, "replicates=16");
}

TEST_CASE("diff gives the metrics of two images per layer, and fails above a limit") {
  const TemporaryFolder folder;
  const std::string a = write_grey(folder, "a.exr", 16, 0.5f), b = write_grey(folder, "b.exr", 16, 0.6f);
  const std::string wide = write_grey(folder, "wide.exr", 17, 0.5f);
  const ProgramResult result = run_lucarium("diff " + b + " " + a + " --json");
  CHECK(result.exit_code == 0);
  const json values = json::parse(result.out);
  // (x - r)² = .01; r² + .01 Ȳ² = .25 · 1.01
  for (const char* layer : {"image", "direct"}) {
    CHECK(values["layers"][layer]["MSE"].get<double>() == test::relative(0.01));
    CHECK(values["layers"][layer]["relMSE"].get<double>() == test::relative(0.01 / (0.25 * 1.01)));
  }
  CHECK(values["layers"]["image"]["SSIM"].get<double>() < 1);
  CHECK(values["metrics"]["relMSE"]["lower_is_better"] == true);
  CHECK(values["metrics"]["PSNR"]["unit"] == "dB");
  CHECK(values["hdr_flip_exposures"]["count"] == 2);
  CHECK(values["reference"].is_null());
  CHECK(contains(run_lucarium("diff " + b + " " + a).out, "relMSE"));
  CHECK(contains(run_lucarium("diff " + b + " " + a + " --formulas").out, "mean((x-r)^2 / (r^2 + 0.01 Y^2))"));
  CHECK(json::parse(run_lucarium("diff " + a + " " + a + " --json").out)["layers"]["image"]["PSNR"] == "infinite");
  CHECK(run_lucarium("diff " + b + " " + a + " --max-relmse 0.04 --json").exit_code == 0);
  const ProgramResult above = run_lucarium("diff " + b + " " + a + " --max-relmse 0.03 --json");
  CHECK(above.exit_code == 1);
  CHECK(contains(above.err, "relMSE 0.0396 is above 0.03"));
  check_refused("diff " + a + " " + wide, 3, "different size");
}

TEST_CASE("diff --formulas alone asked for two images") {
  const ProgramResult formulas = run_lucarium("diff --formulas");
  CHECK(formulas.exit_code == 0);
  CHECK(contains(formulas.out, "relMSE          mean((x-r)^2"));
}

TEST_CASE("diff writes maps of the error, as values and as colours") {
  const TemporaryFolder folder;
  const std::string a = write_grey(folder, "a.exr", 16, 0.5f), b = write_grey(folder, "b.exr", 16, 0.6f);
  const std::string map = (folder.path() / "map.exr").string(), picture = (folder.path() / "map.png").string();
  REQUIRE(run_lucarium("diff " + b + " " + a + " --output " + map).exit_code == 0);
  CHECK(read_image(map).image()[0] == test::relative(0.1 / (0.5 + 0.005)));
  check_refused("diff " + b + " " + a + " --output " + map, 2, "exists");
  check_refused("diff " + b + " " + a + " --output map.jpg", 2, ".exr or .png");
  check_refused("diff " + b + " " + a + " --output " + map + " --map-of flop", 2, "--map-of");

  const ProgramResult result =
      run_lucarium("diff " + b + " " + a + " --json --overwrite --map-of ldr_flip --output " + map);
  REQUIRE(result.exit_code == 0);
  const double flip = json::parse(result.out)["layers"]["image"]["LDR_FLIP"].get<double>();
  CHECK(flip == test::within(0.19621, 1e-4));  // rounding of the edge filter, under a root, adds 5e-5
  CHECK(read_image(map).image()[0] == test::relative(flip, 1e-5));

  REQUIRE(run_lucarium("diff " + b + " " + a + " --map-of hdr_flip --output " + picture).exit_code == 0);
  CHECK(read_image(picture).width() == 16);
}

TEST_CASE("diff subtracts the reference's own error, and says when that is too large") {
  const TemporaryFolder folder;
  const std::string image = write_grey(folder, "image.exr", 16, 0.6f);
  // Halves .5 ± .1: own MSE .04/4
  Film film(16, 12);
  const std::pair<const char*, float> layers[] = {{"direct", .5f}, {"HalfA", .4f}, {"HalfB", .6f}};
  for (const auto& [name, value] : layers) {
    FilmLayer& layer = film.layer(name, {"R", "G", "B"}, std::string(name) == "direct");
    std::fill(layer.pixels.begin(), layer.pixels.end(), value);
  }
  film.metadata = {{"half_a_samples", "4"}, {"half_b_samples", "4"}, {"rounds", "2"}};
  const std::string reference = (folder.path() / "reference.exr").string();
  write_exr(reference, film);
  const ProgramResult result = run_lucarium("diff " + image + " " + reference + " --json");
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  const json own = json::parse(result.out)["reference"];
  CHECK(own["own_mse"].get<double>() == test::relative(0.01, 1e-5));
  CHECK(own["debiased_mse"].get<double>() == test::within(0, 1e-6));
  CHECK(own["mse_resolved"] == false);
  CHECK(contains(run_lucarium("diff " + image + " " + reference).out, "too noisy"));
}

TEST_CASE("scene without a scene lists the built-in ones, with what may be given") {
  const ProgramResult list = run_lucarium("scene");
  CHECK(list.exit_code == 0);
  CHECK(contains(list.out, "builtin:cornell\n"));
  CHECK(contains(list.out, ":pieces=4000"));
  const json answer = json::parse(run_lucarium("scene --json").out);
  CHECK(answer["schema"] == "lucarium-scenes-1");
  for (const json& scene : answer["scenes"]) {
    CAPTURE(scene.dump());
    CHECK(contains(list.out, scene["name"].get<std::string>() + "\n"));
    for (const json& parameter : scene["parameters"])
      CHECK(parameter["min"].get<int>() <= parameter["default"].get<int>());
  }
}
