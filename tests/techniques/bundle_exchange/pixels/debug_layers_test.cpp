// SPDX-License-Identifier: Apache-2.0
// What each part of the technique brings: parts sum to the picture, which stays as it is.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "bundle_exchange/declaration.h"
#include "glossy_box.h"
#include "invisible_sheet.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;
using namespace lucarium::test;

namespace {

const char* const kParts[] = {"sampled_direct", "exchanged_direct", "diffuse_exchange", "specular_chains",
                              "bundle_gather"};

Film render(const char* scene, int max_bounces, const Options& options, bool debug) {
  const auto run = session("bundle_exchange", load_scene(scene), max_bounces,
                           with(options, {{"debug_layers", debug ? "on" : "off"}}));
  run->run({.iterations = 12});
  return run->resolve();
}

float largest(const Film& film, const char* layer) {
  const std::vector<float>& pixels = film.find(layer)->pixels;
  return *std::max_element(pixels.begin(), pixels.end());
}

/// By how much the parts' sum is beside the picture, relative to it or to 1e-3.
double worst_of_sums(const Film& film) {
  double worst = 0;
  for (size_t i = 0; i < 3 * film.pixel_count(); ++i) {
    double sum = 0;
    for (const char* part : kParts) sum += static_cast<double>(film.find(part)->pixels[i]);
    const double picture =
        static_cast<double>(film.find("direct")->pixels[i]) + static_cast<double>(film.find("indirect")->pixels[i]);
    worst = std::max(worst, std::abs(sum - picture) / std::max(picture, 1e-3));
  }
  return worst;
}

/// Largest |value|.
double magnitude(const std::vector<float>& values) {
  double result = 0;
  for (const float v : values) result = std::max(result, std::abs(static_cast<double>(v)));
  return result;
}

double distance(const std::vector<float>& a, const std::vector<float>& b) {
  double result = 0;
  for (size_t i = 0; i < a.size(); ++i)
    result = std::max(result, std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
  return result;
}

glm::dvec3 xyz(const float4& v) { return {v.x, v.y, v.z}; }

/// Weight of value i in a mean in which it counts i².
double square_weight(int i) { return 6.0 * i / ((i + 1.0) * (2.0 * i + 1.0)); }

}  // namespace

TEST_CASE("parts of the light sum to direct and indirect light, and change nothing of them") {
  const Options bundles = {{"direct_mode", "exchange"}, {"final_gather", "all"}, {"pixel_rays", "bundle"}};
  struct Setting {
    const char* scene;
    int max_bounces;
    Options options;
    std::vector<std::string> parts;  ///< that bring light
  };
  const Setting settings[] = {
      {"builtin:cornell", -1, {}, {"sampled_direct", "diffuse_exchange"}},
      {"builtin:spheres", 2, {{"preview", "on"}}, {"sampled_direct", "diffuse_exchange", "specular_chains"}},
      {"builtin:spheres",
       -1,
       {{"direct_mode", "exchange"}},
       {"exchanged_direct", "diffuse_exchange", "specular_chains"}},
      {"builtin:spheres", -1, bundles, {"specular_chains", "bundle_gather"}},
  };
  for (const Setting& setting : settings) {
    CAPTURE(setting.scene);
    CAPTURE(setting.options.size());
    const Options options = with(few_texels, setting.options);
    const Film film = render(setting.scene, setting.max_bounces, options, true),
               plain = render(setting.scene, setting.max_bounces, options, false);
    for (const char* layer : {"emission", "direct", "indirect"})
      CHECK(film.find(layer)->pixels == plain.find(layer)->pixels);
    for (const char* part : kParts) {
      CHECK(plain.find(part) == nullptr);
      CHECK(!film.find(part)->additive);
    }
    const TechniqueInfo info = technique_info();
    const std::vector<std::string>& optional = info.optional_layers.front().names;
    CHECK(plain.layers().size() == info.layers.size());
    CHECK(film.layers().size() == info.layers.size() + optional.size());
    for (const std::string& layer : optional) CHECK_MESSAGE(film.find(layer), layer);
    CHECK(largest(film, "direction_history") == 0);  // all chains
    for (const std::string& part : setting.parts) CHECK_MESSAGE(largest(film, part.c_str()) > 0, part);
    CHECK(worst_of_sums(film) < 1e-5);
  }
}

TEST_CASE("layers of texel sides: accessibility, what the balance adds, and direction histories of glossy ones") {
  const Film cornell = render("builtin:cornell", -1, few_texels, true);
  CHECK(largest(cornell, "accessibility") == 1);
  CHECK(largest(cornell, "balance") != 0);
  CHECK(largest(cornell, "direction_history") == 0);
  const Options history = {{"glossy_window", "8"}, {"history_alpha", "0.05"}, {"balance", "off"}};
  const Film spheres = render("builtin:spheres", -1, with(few_texels, history), true);
  CHECK(largest(spheres, "direction_history") > 0);
  CHECK(largest(spheres, "balance") == 0);
}

TEST_CASE("what the balance adds is c (s - 1) e_S, of the scale and the sums that a batch has read") {
  Scene scene;
  std::array<int, 6> walls{};
  for (int i = 0; i < 6; ++i) {
    const float c = 0.3f + 0.1f * static_cast<float>(i);
    walls[static_cast<size_t>(i)] = add_lambert(scene, "wall", glm::vec3(c, 0.9f - c / 2, 0.5f));
  }
  Parameters parameters;
  parameters.batch = 4;
  BundleRig rig(box_scene(walls, std::move(scene)), 384, 0.5f, {}, parameters);
  rig.set_direct([](uint32_t side) { return side % 7 == 0 ? 5.f : 0.5f; });
  const SideState& state = rig.watch();
  const DirectionSequence sequence = make_sequence(parameters, 1);
  const std::vector<float4> albedo = rig.means().albedo().download();
  std::vector<glm::dvec3> expected(rig.sides());
  for (int batch = 1; batch <= 6; ++batch) {
    const std::vector<float4> senders = rig.means().senders().download();
    rig.solve(sequence, static_cast<uint64_t>(4 * batch), static_cast<uint64_t>(4 * (batch - 1)));
    const glm::dvec3 scale = xyz(rig.balance());
    for (uint32_t side = 0; side < rig.sides(); ++side) {
      const float4& sums = senders[side];
      const glm::dvec3 held = sums.w > 0 ? xyz(sums) / static_cast<double>(sums.w) : glm::dvec3(0);
      expected[side] = glm::mix(expected[side], xyz(albedo[side]) * (scale - 1.0) * held, square_weight(batch));
    }
  }
  const std::vector<float4> found = state.balance().download();
  double worst = 0, most = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side)
    for (int c = 0; c < 3; ++c) {
      worst = std::max(worst, std::abs(xyz(found[side])[c] - expected[side][c]));
      most = std::max(most, std::abs(expected[side][c]));
    }
  CHECK(most > 1e-3);
  CHECK(worst < 1e-5 * most);
}

TEST_CASE("a direction history reflects, of light 1 from the direction before, the albedo of its lobe") {
  Parameters parameters;
  parameters.glossy_window = parameters.batch = 1;
  parameters.history_alpha = 0.01f;
  BundleRig rig(shining_box(1, 0.7f), 600, 0.1f, glossy_channels(1), parameters);
  const SideState& state = rig.watch();
  const DirectionSequence sequence = make_sequence(parameters, 3, nullptr, true);
  rig.solve(sequence, 2);
  const std::vector<float4> found = state.history().download();
  const std::vector<SurfacePoint> points = rig.points();
  size_t met = 0;
  double worst = 0;
  for (uint32_t side = 0; side < rig.sides(); ++side) {
    if (found[side].x == 0) continue;  // the first direction had no ray for it
    ++met;
    const double mu = std::abs(glm::dot(xyz(points[side].normal), glm::dvec3(sequence.at(1).direction)));
    // Of two directions, of which the first found nothing to reflect.
    const double light = square_weight(2) * white_lobe_albedo(mu, 0.7);
    worst = std::max(worst, std::abs(static_cast<double>(found[side].x) / light - 1));
  }
  CHECK(met > 0.99 * rig.sides());
  CHECK(worst < 1e-4);
}

TEST_CASE("highlights of a point light are none of the direction history's: it is 0 after the first direction") {
  Parameters parameters;
  parameters.glossy_window = 8;
  parameters.batch = 1;
  parameters.history_alpha = 0.01f;
  for (const bool glass : {false, true}) {
    CAPTURE(glass);
    Scene scene = shining_box(1, 0.7f);
    SceneLight lamp;
    lamp.type = LightType::point;
    lamp.world_from_light = glm::translate(glm::mat4(1), glm::vec3(0.4f, 0.5f, 0.6f));
    lamp.intensity = glm::vec3(3);
    scene.lights.push_back(lamp);
    if (glass)
      add_polygon(scene, {{0, 0.02f, 1}, {0.53f, 0.02f, 1}, {0.53f, 0.02f, 0}, {0, 0.02f, 0}},
                  add_material(scene, invisible_glass()));
    BundleRig rig(std::move(scene), 600, 0.25f, glossy_channels(1), parameters);
    const SideState& state = rig.watch();
    const DirectionSequence sequence = make_sequence(parameters, 3, nullptr, true);
    const auto most = [](const TypedBuffer<float4>& values) {
      double result = 0;
      for (const float4& v : values.download()) result = std::max(result, std::abs(static_cast<double>(v.x)));
      return result;
    };
    rig.solve(sequence, 1);
    REQUIRE(rig.specular().history_light());
    CHECK(most(*rig.specular().history_light()) > 0.1);
    CHECK(most(state.history()) == 0);
    rig.solve(sequence, 2, 1);
    CHECK(most(state.history()) > 0.1);
  }
}

TEST_CASE("debug layers when all directions are done, and after a move of the camera: texel sides keep their state") {
  const Options options = with(few_texels, {{"glossy_window", "8"},
                                            {"history_alpha", "0.05"},
                                            {"preview", "on"},
                                            {"directions", "48"},
                                            {"debug_layers", "on"}});
  const auto run = session("bundle_exchange", load_scene("builtin:spheres"), -1, options);
  do run->run({.iterations = 1});
  while (run->technique().counters().at("directions") < 48);
  run->run({.iterations = 1});
  CHECK(worst_of_sums(run->resolve()) < 1e-5);
  const SceneCamera camera = load_scene("builtin:spheres").cameras.front();
  SceneCamera moved = camera;
  moved.world_from_camera = glm::translate(glm::mat4(1), glm::vec3(0.1f, 0, 0)) * moved.world_from_camera;
  run->set_camera(moved);
  run->run({.iterations = 1});
  const Film elsewhere = run->resolve();
  CHECK(worst_of_sums(elsewhere) < 1e-5);
  run->set_camera(camera);
  run->run({.iterations = 1});
  const Film once = run->resolve();
  run->run({.iterations = 4});
  const Film later = run->resolve();
  CHECK(worst_of_sums(later) < 1e-5);
  for (const char* layer : {"accessibility", "balance", "direction_history"}) {
    CAPTURE(layer);
    const std::vector<float>&first = once.find(layer)->pixels, &last = later.find(layer)->pixels;
    CHECK(magnitude(first) > 0);
    CHECK(distance(first, last) < 1e-5 * magnitude(first));
    CHECK(distance(first, elsewhere.find(layer)->pixels) > 0.1 * magnitude(first));
  }
}

TEST_CASE("debug layers while bundles carry emission only: the balance keeps its state") {
  const Scene cornell = load_scene("builtin:cornell");
  const auto run = session("bundle_exchange", cornell, -1,
                           {{"texels", "2048"},
                            {"batch", "1"},
                            {"stop_error", "0.05"},
                            {"directions", "4096"},
                            {"direct_mode", "exchange"},
                            {"direct_first", "0"},
                            {"debug_layers", "on"}});
  // Iterations of one direction or more, until reflected light is known.
  const auto counter = [&](const char* name) { return run->technique().counters().at(name); };
  do run->run({.iterations = 1});
  while (counter("indirect_directions") == counter("directions") && counter("directions") < 4096);
  run->set_camera(cornell.cameras.front());
  run->run({.iterations = 1});
  const double reflected = counter("indirect_directions"), begun = counter("directions");
  const std::vector<float> first = run->resolve().find("balance")->pixels;
  run->run({.iterations = 3});
  CHECK(counter("indirect_directions") == reflected);
  CHECK(counter("directions") > begun);
  CHECK(magnitude(first) > 0);
  CHECK(distance(first, run->resolve().find("balance")->pixels) < 1e-5 * magnitude(first));
}

TEST_CASE("debug layers without indirect light: of texel sides only where bundles carry light") {
  const Film sampled = render("builtin:cornell", 0, few_texels, true);
  for (const char* layer : {"accessibility", "balance", "direction_history"}) CHECK(sampled.find(layer) == nullptr);
  CHECK(worst_of_sums(sampled) < 1e-5);
  CHECK(largest(sampled, "sampled_direct") > 0);
  const Film exchanged = render("builtin:cornell", 0, with(few_texels, {{"direct_mode", "exchange"}}), true);
  CHECK(worst_of_sums(exchanged) < 1e-5);
  CHECK(largest(exchanged, "exchanged_direct") > 0);
  CHECK(largest(exchanged, "accessibility") == 1);
  CHECK(magnitude(exchanged.find("balance")->pixels) == 0);
}
