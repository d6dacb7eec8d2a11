// SPDX-License-Identifier: Apache-2.0
// lucarium scene --atlas: pictures of the surface atlas and its report.
#include "cli_support.h"
#include "lucarium/film/image_io.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("pictures and report of the atlas") {
  const TemporaryFolder folder;
  const std::string charts = (folder.path() / "charts.exr").string(), view = (folder.path() / "view.png").string();
  const std::string command = "scene builtin:cornell --json --quiet --atlas-texels 2000 --atlas " + charts +
                              " --atlas-view " + view + " --size 64x64";
  const ProgramResult result = run_lucarium(command);
  REQUIRE_MESSAGE(result.exit_code == 0, result.err);
  const nlohmann::json report = nlohmann::json::parse(result.out);
  CHECK(report.at("atlas").at("sides").get<double>() == test::relative(2000, 0.1));
  CHECK(report.at("atlas").at("bytes").get<double>() > 0);
  const Film film = read_image(charts);
  for (const char* layer : {"Albedo", "P", "N", "Area"}) CHECK_MESSAGE(film.find(layer), layer);
  CHECK(read_image(view).width() == 64);

  // Nothing is replaced unasked.
  CHECK(run_lucarium(command).exit_code == 2);
  CHECK(run_lucarium(command + " --overwrite").exit_code == 0);
}

TEST_CASE("mistakes about the atlas") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "charts").string();
  const ProgramResult name = run_lucarium("scene builtin:cornell --atlas " + file + ".jpg");
  CHECK(name.exit_code == 2);
  CHECK(contains(name.err, ".exr or .png"));
  CHECK(run_lucarium("scene builtin:cornell --atlas-texels 0 --atlas " + file + ".exr").exit_code == 2);
  const ProgramResult without = run_lucarium("scene builtin:cornell --atlas-texcoord1 --atlas " + file + ".exr");
  CHECK(without.exit_code == 3);
  CHECK(contains(without.err, "TEXCOORD_1"));
}
