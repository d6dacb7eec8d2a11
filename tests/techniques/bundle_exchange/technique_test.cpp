// SPDX-License-Identifier: Apache-2.0
// The whole technique where the parts alone say little: rays of pixels, preset of the paper, warm starts.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "made_scene.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Half the light of every lamp.
SceneChange dim(Scene& scene) {
  SceneChange change;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    if (scene.materials[i].emissive_factor == glm::vec3(0)) continue;
    scene.materials[i].emissive_factor *= 0.5f;
    change.materials.push_back(static_cast<int>(i));
  }
  return change;
}

}  // namespace

TEST_CASE("pixels that gather by bundles, transfers and the direction history see the path tracer's light") {
  const Options paths = {{"samples_per_iteration", "64"}};
  for (const int bounces : {1, 2}) {
    CAPTURE(bounces);
    const double expected = indirect_mean("path_tracing", "builtin:cornell", bounces, 16, paths);
    for (const Options& more :
         {Options{{"final_gather", "all"}, {"pixel_rays", "bundle"}}, Options{{"transfer", "texel"}}}) {
      CAPTURE(more.back().first);
      CHECK(indirect_mean("bundle_exchange", "builtin:cornell", bounces, 64, with(few_texels, more)) ==
            test::relative(expected, 0.03));
    }
  }
  const double expected = indirect_mean("path_tracing", "builtin:spheres", 2, 64, paths);
  // The spheres cast caustics of about the size of a texel of 2048: with so few, chains and direction history alike are
  // 4 % too dark. What directions reflect comes late: after 16 iterations 2.4 % are missing (mean of five seeds), after
  // 64 iterations 0.5 %.
  const Options history = with(few_texels, {{"texels", "16384"}, {"glossy_window", "32"}, {"history_alpha", "0.1"}});
  CHECK(indirect_mean("bundle_exchange", "builtin:spheres", 2, 32, history) == test::relative(expected, 0.03));
  if (!test::full_run()) return;
  CHECK(indirect_mean("bundle_exchange", "builtin:spheres", 2, 32, with(history, {{"pixel_rays", "bundle"}})) ==
        test::relative(expected, 0.03));
}

TEST_CASE("pixels get the same by looking texels up, by rays that are traced, and by those of bundles") {
  const auto layers = [](const Options& more) {
    const auto run = session("bundle_exchange", load_scene("builtin:cornell"), 1, with(few_texels, more));
    run->run({.iterations = 48});
    return std::pair(mean(run->resolve().find("direct")->pixels), mean(indirect(*run)));
  };
  const auto [direct, looked_up] = layers({});
  for (const Options& more :
       {Options{{"final_gather", "all"}}, Options{{"final_gather", "all"}, {"pixel_rays", "bundle"}},
        Options{{"direct_mode", "exchange"}},
        Options{{"direct_mode", "exchange"}, {"final_gather", "all"}, {"pixel_rays", "bundle"}}}) {
    CAPTURE(more.size());
    CAPTURE(more.front().first);
    const auto found = layers(more);
    MESSAGE("direct ", found.first / direct, ", indirect ", found.second / looked_up);
    CHECK(found.first == relative(direct, 0.04));
    CHECK(found.second == relative(looked_up, 0.04));
  }
}

TEST_CASE("the paper's variants bring diffuse light of all bounces, if slowly") {
  const double expected = indirect_mean("path_tracing", "builtin:cornell", 3, 16, {{"samples_per_iteration", "64"}});
  const double paper =
      indirect_mean("bundle_exchange", "builtin:cornell", 3, 64, {{"preset", "paper"}, {"texels", "2048"}});
  MESSAGE("preset paper: ", paper, ", path tracing: ", expected);
  CHECK(paper == test::relative(expected, 0.05));
}

TEST_CASE("an image forgets that indirect light was missing while bundles carried direct light only") {
  const Options late = {
      {"texels", "2048"}, {"direct_mode", "exchange"}, {"directions", "1000"}, {"stop_error", "0"}, {"batch", "4"}};
  const double expected = indirect_mean("path_tracing", "builtin:cornell", 2, 16, {{"samples_per_iteration", "64"}});
  CHECK(indirect_mean("bundle_exchange", "builtin:cornell", 2, 64, with(late, {{"direct_first", "800"}})) ==
        test::relative(expected, 0.06));
}

TEST_CASE("when indirect light is known well, directions carry emission until direct light is, too") {
  const Options options = {{"texels", "1024"}, {"direct_mode", "exchange"}, {"directions", "20000"},
                           {"batch", "4"},     {"stop_error", "0.15"},      {"camera_samples", "1"}};
  const double expected = indirect_mean("path_tracing", "builtin:cornell", -1, 16, {{"samples_per_iteration", "64"}});
  for (const Options& more : {Options{}, Options{{"final_gather", "all"}, {"pixel_rays", "bundle"}}}) {
    CAPTURE(more.size());
    const auto run = session("bundle_exchange", load_scene("builtin:cornell"), -1, with(options, more));
    run->run({.iterations = 4000});
    REQUIRE(run->last().converged);
    const std::map<std::string, double> done = run->technique().counters();
    MESSAGE(done.at("directions"), " directions, of them with indirect light ", done.at("indirect_directions"));
    CHECK(done.at("relative_error") < 0.15);
    CHECK(done.at("directions") < 20000);
    CHECK(done.at("indirect_directions") < 0.6 * done.at("directions"));
    CHECK(done.at("indirect_directions") >= 64);
    CHECK(mean(indirect(*run)) == relative(expected, 0.03));
  }
}

TEST_CASE("iterations can be cancelled anywhere, batches that several of them share included") {
  const Options by_lights = {
      {"texels", "4096"}, {"batch", "48"}, {"directions", "1000"}, {"stop_error", "0"}, {"eye_share", "0.2"}};
  const Options by_texels = {
      {"texels", "4096"},    {"batch", "16"},         {"directions", "96"},     {"stop_error", "0"},
      {"transfer", "texel"}, {"final_gather", "all"}, {"pixel_rays", "bundle"}, {"direct_mode", "exchange"}};
  const Options by_variances = {{"texels", "1024"}, {"batch", "1"}, {"directions", "1000"}, {"stop_error", "0"}};
  for (const Options& options : {by_lights, by_texels, by_variances}) {
    const uint64_t iterations = 20;
    const auto whole = session("bundle_exchange", load_scene("builtin:spheres"), -1, options);
    whole->run({.iterations = iterations});
    const auto halting = session("bundle_exchange", load_scene("builtin:spheres"), -1, options);
    int requests = 0, cancelled = 0;
    while (halting->iterations() < iterations) {
      // Ever later in the iteration, so that in the end it gets through.
      const uint64_t before = halting->iterations();
      for (int left = 3; halting->iterations() == before; left += 37, ++cancelled) {
        requests = left;
        halting->scheduler().set_cancel([&] { return requests-- <= 0; });
        halting->iterate();
      }
    }
    halting->scheduler().set_cancel([] { return false; });
    CHECK(cancelled > static_cast<int>(iterations));
    CHECK(whole->technique().counters().at("directions") > 90);
    CHECK(halting->technique().counters().at("directions") == whole->technique().counters().at("directions"));
    CHECK(halting->last().samples == whole->last().samples);
    CHECK(indirect(*halting) == indirect(*whole));
  }
}

TEST_CASE("samples of pixels get the more work the more they scatter") {
  // The Cornell box by its lamp, from which direct light is noisy, or by a point light, from which it is not.
  const auto samples = [](bool point_light, const Options& more, const char* name = "builtin:cornell") {
    Scene scene = load_scene(name);
    if (point_light) {
      for (SceneMaterial& material : scene.materials) material.emissive_factor = glm::vec3(0);
      add_light(scene, LightType::point, 10, {0.1f, 1.5f, 0.1f}, {0, 0, 0});
    }
    const auto run = session("bundle_exchange", std::move(scene), -1,
                             with({{"texels", "4096"}, {"batch", "1"}, {"stop_error", "0"}}, more));
    const auto to = [&](double directions) {
      while (run->technique().counters().at("directions") < directions) run->iterate();
      return static_cast<double>(run->last().samples);
    };
    const double before = to(128);  // nothing is known at first
    return to(640) - before;
  };
  const double noisy = samples(false, {}), exact = samples(true, {});
  const double glossy = samples(true, {}, "builtin:cornell-glossy");  // what pixels trace is noisy
  MESSAGE("samples of pixels in 512 directions: ", noisy, ", with a point light ", exact, ", glossy ", glossy);
  CHECK(glossy > 1.3 * exact);
  CHECK(noisy > 3 * exact);
  CHECK(samples(false, {{"eye_share", "0.25"}}) == relative(samples(true, {{"eye_share", "0.25"}}), 0.1));
}

TEST_CASE("dear pixels do not delay light at texels and directions, which had one sample of them in each iteration") {
  const auto run = session("bundle_exchange", load_scene("builtin:spheres"), SessionStart{.width = 2048},
                           {{"texels", "4096"}, {"stop_error", "0"}});
  const auto exchanged = [&] { return run->technique().counters().at("directions") > 0; };
  uint64_t light = 0, exchange = 0;
  for (run->iterate(); !exchanged(); run->iterate(), ++light) CHECK(run->last().samples == 1);
  CHECK(light > 5);
  const uint64_t before = run->last().samples;
  for (; run->last().samples < before + 3; ++exchange) run->iterate();
  CHECK(exchange > 3);
  CHECK(exchange < 100);
  const auto ended = session("bundle_exchange", load_scene("builtin:spheres"), SessionStart{.width = 2048},
                             {{"texels", "1024"}, {"directions", "4"}});
  ended->finish_light();
  ended->run({.iterations = 3});
  CHECK(ended->last().samples == 3);  // nothing else to do
}

TEST_CASE("a reset gives the bits of a new run, however many texels had to be measured first") {
  const Options options = {{"texels", "16384"}, {"direct_mode", "exchange"}};
  const auto used = session("bundle_exchange", load_scene("builtin:cornell"), -1, options);
  const auto fresh = session("bundle_exchange", load_scene("builtin:cornell"), -1, options);
  used->run({.iterations = 2});
  used->restart(1);
  for (const auto& run : {used.get(), fresh.get()}) run->run({.iterations = 3});
  CHECK(fresh->technique().counters().at("directions") > 0);
  CHECK(indirect(*used) == indirect(*fresh));
}

TEST_CASE("a long batch takes several iterations") {
  const auto run = session("bundle_exchange", load_scene("builtin:cornell"), -1,
                           {{"texels", "2048"},
                            {"batch", "64"},
                            {"directions", "4096"},
                            {"stop_error", "0"},
                            {"transfer", "texel"},
                            {"direct_mode", "exchange"},
                            {"direct_first", "4096"}});
  run->run({.iterations = 8});
  const double directions = run->technique().counters().at("directions");
  CHECK(directions >= 64);
  CHECK(directions <= 8 * 64.0 / 3);  // what is stored costs three times as much as what is exchanged at once
}

TEST_CASE("one bounce for each block: directions of emission only are none of its, and a limit of bounces is kept") {
  const auto run = [](const char* direct_first, const char* directions, int max_bounces) {
    auto made = session("bundle_exchange", load_scene("builtin:cornell"), max_bounces,
                        with(few_texels, {{"interleave", "pingpong"},
                                          {"block", "128"},
                                          {"direct_mode", "exchange"},
                                          {"direct_first", direct_first},
                                          {"directions", directions}}));
    made->run({.iterations = 64});
    return made;
  };
  const auto late = run("200", "456", -1), soon = run("8", "264", -1);
  CHECK(late->technique().counters().at("directions") == 456);
  const auto bounces = [](RenderSession& s) { return s.technique().path_set(s.scene(), s.settings()).max_bounces; };
  CHECK(bounces(*late) == 2);
  CHECK(bounces(*soon) == 2);
  CHECK(mean(indirect(*late)) == test::relative(mean(indirect(*soon)), 0.05));
  CHECK(bounces(*run("8", "264", 3)) == 3);
}

TEST_CASE("a change starts over with the bits of a fresh start, or with the senders' mean if requested") {
  const auto after_change = [](bool warm, uint64_t iterations) {
    const auto run = session("bundle_exchange", load_scene("builtin:cornell"), -1,
                             with(few_texels, {{"warm_start", warm ? "on" : "off"}}));
    run->run({.iterations = 24});
    run->change_scene(dim);
    run->run({.iterations = iterations});
    return indirect(*run);
  };
  Scene dimmed = load_scene("builtin:cornell");
  dim(dimmed);
  const auto fresh = session("bundle_exchange", std::move(dimmed), -1, few_texels);
  const uint64_t soon = 12;  // the first iterations light texel sides
  fresh->run({.iterations = soon});
  CHECK(after_change(false, soon) == indirect(*fresh));
  CHECK(after_change(true, soon) != indirect(*fresh));
  // What was known of twice the light fades.
  fresh->run({.iterations = 24 - soon});
  CHECK(mean(after_change(true, 24)) == test::relative(mean(indirect(*fresh)), 0.03));
}

TEST_CASE("a change of lights alone keeps what is known of texels, and has the bits of a fresh start") {
  const auto room = [](float brightness) {
    Scene scene = load_scene("builtin:cornell");
    Environment sky;
    sky.width = 2, sky.height = 1;
    sky.radiance.assign(2, glm::vec3(brightness));
    scene.environment = sky;
    return scene;
  };
  const auto changed = session("bundle_exchange", room(1), -1, few_texels);
  changed->run({.iterations = 8});
  changed->change_scene([](Scene& scene) {
    for (glm::vec3& radiance : scene.environment->radiance) radiance *= 0.5f;
    SceneChange change;
    change.environment = true;
    return change;
  });
  changed->run({.iterations = 12});
  const auto fresh = session("bundle_exchange", room(0.5f), -1, few_texels);
  fresh->run({.iterations = 12});
  CHECK(changed->technique().counters().at("directions") > 0);
  CHECK(indirect(*changed) == indirect(*fresh));
}

TEST_CASE("a warm start follows what moves") {
  // A box of the room is lifted: what its old place knew is wrong, and fades.
  const auto lift = [](Scene& scene) {
    SceneChange change;
    const int last = static_cast<int>(scene.instances.size()) - 1;
    SceneInstance& instance = scene.instances[last];
    change.moved_instances = {last};
    change.previous_world_from_object = {instance.world_from_object};
    instance.world_from_object[3] += glm::vec4(0, 0.1f, 0, 0);
    return change;
  };
  const auto run =
      session("bundle_exchange", load_scene("builtin:cornell"), -1, with(few_texels, {{"warm_start", "on"}}));
  run->run({.iterations = 16});
  run->change_scene(lift);
  run->run({.iterations = 24});
  Scene lifted = load_scene("builtin:cornell");
  lift(lifted);
  const auto fresh = session("bundle_exchange", std::move(lifted), -1, few_texels);
  fresh->run({.iterations = 24});
  CHECK(mean(indirect(*run)) == test::relative(mean(indirect(*fresh)), 0.03));
}

TEST_CASE("triangles that nothing hits change neither bundle image nor light, slivers hardly any") {
  const Scene room = load_scene("builtin:cornell");
  const auto render = [](Scene scene) {
    auto run = session("bundle_exchange", std::move(scene), 2, few_texels);
    run->run({.iterations = 48});
    return run;
  };
  const auto pixels = [](RenderSession& run) { return run.technique().counters().at("bundle_pixels"); };
  const auto plain = render(room);
  Scene with_lines = room, with_slivers = room;
  // As a surface and as a lamp of their own. Where corners are snapped to the bundle image's grid, they would get an
  // area.
  const int lamp = add_material(with_lines, emitter(1000));
  add_threads(with_lines, 50, 0, 0);
  add_threads(with_lines, 50, 0, lamp);
  const auto lines = render(with_lines);
  CHECK(pixels(*lines) == pixels(*plain));
  CHECK(indirect(*lines) == indirect(*plain));
  // Before the others in the file they shift the numbers of triangles, and nothing else.
  std::rotate(with_lines.instances.begin(), with_lines.instances.end() - 2, with_lines.instances.end());
  const auto lines_first = render(with_lines);
  CHECK(pixels(*lines_first) == pixels(*plain));
  CHECK(indirect(*lines_first) == indirect(*plain));
  add_threads(with_slivers, 50, 1e-6f, 0);
  const auto slivers = render(with_slivers);
  // Most of their texels come on top of the others.
  CHECK(pixels(*slivers) == relative(pixels(*plain), 0.1));
  CHECK(mean(indirect(*slivers)) == relative(mean(indirect(*plain)), 0.01));
}
