// SPDX-License-Identifier: Apache-2.0
// What lucarium render writes and prints when all goes well, and what it keeps when it is interrupted.
#include <cmath>

#include "cli_support.h"
#include "lucarium/film/image_io.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;
using nlohmann::json;

TEST_CASE("an EXR with layers and metadata, a picture, and a summary that parses") {
  const TemporaryFolder folder;
  const std::string exr = (folder.path() / "a.exr").string(), png = (folder.path() / "a.png").string();
  const ProgramResult result = run_lucarium("render builtin:cornell " + constant_technique("red=0.75") +
                                            "-p blue=2 --spp 3 --seed 9 --json --quiet -o " + exr + " -o " + png);
  CHECK(result.exit_code == 0);
  CHECK(result.err.empty());
  CHECK(json::parse(result.out)["schema"] == "lucarium-render-2");
  const json summary = only_frame(result);
  for (const char* key : {"max_bounces", "pixel_sampling", "scene_time_seconds"}) CHECK(summary[key].is_number());
  CHECK(summary["technique"] == "constant");
  CHECK(summary["samples"] == 3);
  CHECK(summary["seed"] == 9);
  CHECK(summary["partial"] == false);
  CHECK(summary["width"] == 16);
  CHECK(summary["clocks"]["iterate_seconds"].get<double>() > 0);
  CHECK(summary["seconds"].get<double>() > summary["clocks"]["iterate_seconds"].get<double>());
  CHECK(summary["peak_device_memory_bytes"].get<uint64_t>() >= 16 * 8 * 16);
  CHECK(summary["limitations"][0] == "the scene is ignored");
  CHECK(summary["counters"]["samples"] == 3);
  CHECK(summary["files"] == json({exr, png}));
  const Film film = read_image(exr);
  CHECK(film.width() == 16);
  CHECK(film.image()[0] == 0.75f);
  CHECK(film.image()[2] == 2);
  CHECK(film.find("direct"));
  CHECK(film.find("count")->pixels[5] == 3);
  CHECK(film.metadata.at("technique") == "constant");
  CHECK(contains(film.metadata.at("parameters"), "red=0.75,green=0.5,blue=2"));
  CHECK(film.metadata.count("partial") == 0);
  CHECK(count_files(folder.path()) == 2);
}

TEST_CASE("the result names all files that were written") {
  const TemporaryFolder folder;
  const std::string exr = (folder.path() / "a.exr").string(), png = (folder.path() / "b.png").string();
  const ProgramResult result =
      run_lucarium("render builtin:cornell " + constant_technique() + "--iterations 1 -o " + exr + " -o " + png);
  CHECK(contains(result.out, exr + ", " + png + ": 1 sample per pixel"));
}

TEST_CASE("the reason why a rendering ended is printed: the technique's own words, or an option") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "a.png").string();
  const std::string common = "render builtin:cornell " + constant_technique("converge_at=3") + "--overwrite -o " + file;
  const ProgramResult ended = run_lucarium(common + " --spp 8");
  CHECK(contains(ended.out, "3 samples per pixel"));
  CHECK(contains(ended.out, "ended by constant: converge_at is reached"));
  CHECK(only_frame(run_lucarium(common + " --spp 8 --json --quiet"))["ended_by"] == "converge_at is reached");
  const json half = only_frame(run_lucarium(common + " --spp 2 --json --quiet"));
  CHECK(half["ended_by"] == "--spp");
  CHECK(half["progress"].get<double>() == test::relative(2. / 3));
  CHECK(half["seconds_left"].get<double>() > 0);
  const json field = only_frame(run_lucarium(
      "render builtin:cornell -t virtual_light_field:dir_n=3,cells=16,texels=512 --size 8x8 --json --quiet "
      "--iterations 1"));
  CHECK(field["phase"] != "walk");
  CHECK_FALSE(field["phase"].get<std::string>().empty());
  CHECK(field["progress"].get<double>() < 1);
}

TEST_CASE("of two budgets of time the result named both") {
  const std::string render = "render builtin:cornell " + constant_technique("sleep=20") + "--json -q ";
  CHECK(only_frame(run_lucarium(render + "--time 0.3 --wall-time 600"))["ended_by"] == "--time");
  CHECK(only_frame(run_lucarium(render + "--time 600 --wall-time 1.5"))["ended_by"] == "--wall-time");
}

TEST_CASE("a time that is over before the first iteration gives a picture and a line that says so") {
  const TemporaryFolder folder;
  const ProgramResult late = run_lucarium("render builtin:cornell " + constant_technique("red=1") +
                                          "--wall-time 0.001 -o " + (folder.path() / "a.png").string());
  CHECK(late.exit_code == 0);
  CHECK(contains(late.err, "--wall-time 0.001 was over before the first iteration"));
  CHECK(contains(late.err, "the first picture came later than the budget: --wall-time "));
  const ProgramResult unlit = run_lucarium(
      "render builtin:cornell -t bundle_exchange:texels=2048 --size 16x16 --max-bounces 1 --iterations 1 --json "
      "--overwrite -o " +
      (folder.path() / "a.png").string());
  CHECK(contains(unlit.err, "ended in the stage 'light'"));
  CHECK(only_frame(unlit)["partial"] == true);
  CHECK(count_files(folder.path()) == 1);
}

TEST_CASE("a budget of time lowers what nobody set, says so, and the picture can be had again with what it says") {
  const TemporaryFolder folder;
  const auto file = [&](const char* name) { return (folder.path() / name).string(); };
  const std::string common = "render builtin:cornell --size 16x16 --max-bounces 1 --iterations 1 --json ";
  const ProgramResult timed =
      run_lucarium(common + "-t micro_rendering:light_samples=2 --time 0.01 -o " + file("a.exr"));
  REQUIRE(timed.exit_code == 0);
  CHECK(contains(timed.err, "micro_rendering: for --time 0.01: points_log2 18 -> "));
  CHECK(contains(timed.err, "; half of it is for the first whole picture, which would take about "));
  CHECK(contains(timed.err, "is too short for a whole picture; about "));
  const json summary = only_frame(timed);
  CHECK(summary["plan"]["budget_seconds"] == 0.01);
  CHECK(summary["plan"]["sufficient_seconds"] > 0.01);
  CHECK(summary["plan"]["changes"][0]["parameter"] == "points_log2");
  const Film planned = read_image(file("a.exr"));
  const std::string parameters = planned.metadata.at("parameters");
  CHECK(contains(planned.metadata.at("planned"), "points_log2 18 -> "));
  CHECK_FALSE(contains(parameters, "points_log2=18"));
  CHECK(contains(parameters, "light_samples=2"));
  run_lucarium(common + "-t micro_rendering:" + parameters + " -o " + file("b.exr"));
  CHECK(read_image(file("b.exr")).image() == planned.image());
  const ProgramResult given =
      run_lucarium(common + "-t micro_rendering:" + parameters + " --time 0.01 -o " + file("c.exr"));
  CHECK(only_frame(given)["plan"]["changes"].empty());
}

TEST_CASE("a budget of time is used to its end, unless a parameter says when to end") {
  const std::string box = "render builtin:cornell --size 8x8 --max-bounces 1 --json -q --time 2 -t ";
  for (const std::string technique :
       {"bundle_exchange:texels=512", "virtual_light_field:dir_n=3,cells=16,texels=512"}) {
    CAPTURE(technique);
    const json all = only_frame(run_lucarium(box + technique));
    CHECK(all["ended_by"] == "--time");
    CHECK(contains(all["parameters"], "camera_samples=0"));
    CHECK(all["plan"]["lifted"].back()["parameter"] == "camera_samples");
    CHECK(all["plan"]["lifted"].back()["from"] == "64");
    const json ended = only_frame(run_lucarium(box + technique + ",camera_samples=1"));
    CHECK(ended["plan"]["lifted"].empty());
  }
}

TEST_CASE("light that several frames share ends by itself, whatever time each of them has") {
  const ProgramResult walk = run_lucarium(
      "render builtin:cornell --camera-path walk --frames 0:1 --size 8x8 --max-bounces 1 --json -q --time 0.1 "
      "-t bundle_exchange:texels=512");
  CAPTURE(walk.err);
  REQUIRE(walk.exit_code == 0);
  const json frames = json::parse(walk.out).at("frames");
  REQUIRE(frames.size() == 2);
  CHECK(contains(frames[0]["parameters"], "directions=2000"));
}

TEST_CASE("exposure brightens the picture and leaves the EXR alone") {
  const TemporaryFolder folder;
  const std::string exr = (folder.path() / "a.exr").string(), png = (folder.path() / "a.png").string();
  CHECK(run_lucarium("render builtin:cornell " + constant_technique("red=0.107,green=0.107,blue=0.107") +
                     "--iterations 1 --exposure 1 -o " + exr + " -o " + png)
            .exit_code == 0);
  CHECK(read_image(exr).image()[0] == 0.107f);
  CHECK(read_image(png).image()[0] == test::relative(2 * 0.107, .01));  // an 8-bit step is 0.8 % there
}

TEST_CASE("a picture without a stated exposure gets one from the image, which the summary states") {
  const TemporaryFolder folder;
  const auto picture = [&](const std::string& name) { return (folder.path() / name).string(); };
  const std::string lux =
      "render builtin:cornell " + constant_technique("red=100,green=50,blue=25") + "--iterations 1 ";
  const ProgramResult result = run_lucarium(lux + "-o " + picture("auto.png"));
  CHECK(contains(result.out, "exposure -6.6 stops (auto)"));  // log2 100 = 6.64
  CHECK(read_image(picture("auto.png")).image()[1] == test::relative(50 * std::exp2(-6.6), .01));
  // Stated, it is the same picture; at 0 it is white; the EXR is unaffected.
  REQUIRE(run_lucarium(lux + "--exposure=-6.6 -o " + picture("same.png")).exit_code == 0);
  CHECK(read_image(picture("same.png")).image() == read_image(picture("auto.png")).image());
  const json stated = only_frame(run_lucarium(lux + "--exposure 0 --json -o " + picture("white.png")));
  CHECK(stated["exposure_stops"] == 0);
  CHECK(stated["exposure_automatic"] == false);
  CHECK(read_image(picture("white.png")).image()[1] == 1);
  const json chosen = only_frame(run_lucarium(lux + "--json --exposure auto -o " + picture("a.exr")));
  CHECK(chosen["exposure_stops"].get<double>() == test::relative(-6.6, 1e-6));
  CHECK(chosen["exposure_automatic"] == true);
  CHECK(read_image(picture("a.exr")).image()[0] == 100);
}

TEST_CASE("what a display shows well is left as it is, and frames share the exposure of the first") {
  const TemporaryFolder folder;
  const auto picture = [&](const std::string& name) { return (folder.path() / name).string(); };
  const std::string plain = "render builtin:cornell " + constant_technique("red=0.9") + "--iterations 1 ";
  CHECK(contains(run_lucarium(plain + "-o " + picture("a.png")).out, "exposure 0 stops (auto)"));
  REQUIRE(run_lucarium(plain + "--exposure 0 -o " + picture("b.png")).exit_code == 0);
  CHECK(read_image(picture("a.png")).image() == read_image(picture("b.png")).image());
  const json frames = json::parse(run_lucarium("render builtin:cornell " + constant_technique("red=8") +
                                               "--iterations 1 --frames 0:1 --json -o " + picture("f.png"))
                                      .out)["frames"];
  REQUIRE(frames.size() == 2);
  for (const json& frame : frames) CHECK(frame["exposure_stops"] == -3);
}

TEST_CASE("--half stores 16-bit floats and reports values that do not fit") {
  const TemporaryFolder folder;
  const std::string exr = (folder.path() / "a.exr").string();
  const ProgramResult result =
      run_lucarium("render builtin:cornell " + constant_technique("red=0.1") + "--iterations 1 --half -o " + exr);
  CHECK(result.exit_code == 0);
  CHECK(read_image(exr).image()[0] == test::relative(0.1, 1e-3));
  CHECK(read_image(exr).image()[0] != 0.1f);
}

TEST_CASE("an option given twice counts as given last") {
  const json summary = only_frame(run_lucarium("render builtin:cornell " + constant_technique() +
                                               "--size 5x4 --iterations 3 --iterations 2 --json"));
  CHECK(summary["width"] == 5);
  CHECK(summary["iterations"] == 2);
}

TEST_CASE("a sequence writes one file per frame, each standing for itself") {
  const TemporaryFolder folder;
  const ProgramResult result =
      run_lucarium("render builtin:cornell " + constant_technique() +
                   "--iterations 2 --frames 3:5 --fps 10 --json -o " + (folder.path() / "out.exr").string());
  CHECK(result.exit_code == 0);
  CHECK(json::parse(result.out)["frames"].size() == 3);
  CHECK(count_files(folder.path()) == 3);
  const Film last = read_image(folder.path() / "out.0005.exr");
  CHECK(last.metadata.at("scene_time_seconds") == "0.5");
  CHECK(last.metadata.at("samples") == "2");
}

TEST_CASE("--profile prints a table, or writes JSON or a trace") {
  const TemporaryFolder folder;
  const std::string render = "render builtin:cornell " + constant_technique() + "--iterations 3 --json ";
  const ProgramResult table = run_lucarium(render + "--profile");
  CHECK(table.exit_code == 0);
  CHECK(contains(table.err, "fill"));
  const std::string profile = (folder.path() / "p.json").string(), trace = (folder.path() / "p.trace.json").string();
  CHECK(run_lucarium(render + "--profile=" + profile).exit_code == 0);
  CHECK(run_lucarium(render + "--profile=" + trace).exit_code == 0);
  CHECK(json::accept(run_program("cat " + profile).out));
  CHECK(json::accept(run_program("cat " + trace).out));
  check_refused(render + "--profile=" + profile, 2, "exists");
}

TEST_CASE("Ctrl-C keeps the partial result, marked as such, and ends with 6") {
  const TemporaryFolder folder;
  const std::string exr = (folder.path() / "a.exr").string(), log = (folder.path() / "log").string();
  // A first progress line shows that iterating has begun.
  const ProgramResult result =
      run_program(lucarium_program() + " render builtin:cornell " + constant_technique("sleep=50") +
                  "--iterations 100000 --json -o " + exr + " 2>" + log + " & pid=$!; until grep -q rendering " + log +
                  "; do kill -0 $pid || exit 99; sleep 0.1; done; " + "kill -INT $pid; wait $pid");
  CHECK(result.exit_code == 6);
  const json summary = only_frame(result);
  CHECK(summary["partial"] == true);
  const Film film = read_image(exr);
  CHECK(film.metadata.at("partial") == "yes");
  CHECK(film.image()[0] == 0.25f);
  CHECK(film.metadata.at("samples") == std::to_string(summary["samples"].get<uint64_t>()));
  CHECK(summary["samples"].get<uint64_t>() >= 1);
  CHECK(contains(run_program("cat " + log).out, "the partial result is kept"));
  CHECK(count_files(folder.path()) == 2);
}

TEST_CASE("the error against a reference is printed, and a reference of eight bits draws a warning") {
  const TemporaryFolder folder;
  const auto file = [&folder](const char* name) { return (folder.path() / name).string(); };
  const std::string common = "render builtin:cornell --iterations 1 -o ";
  REQUIRE(run_lucarium(common + file("a.exr") + " -o " + file("a.png") + " " + constant_technique()).exit_code == 0);
  const std::string again = common + file("b.exr") + " --overwrite " + constant_technique() + " --reference ";
  const ProgramResult same = run_lucarium(again + file("a.exr"));
  CHECK(contains(same.out, "; relMSE 0 against " + file("a.exr")));
  CHECK(same.err.find("values above 1 are lost") == std::string::npos);
  CHECK(contains(run_lucarium(again + file("a.png")).err, "8-bit picture as a reference: values above 1 are lost"));
}
