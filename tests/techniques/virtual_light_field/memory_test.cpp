// SPDX-License-Identifier: Apache-2.0
// Bytes that the experiment `propagation` reports, and those that a run states.
#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli_support.h"
#include "lucarium/compare/request/expression.h"
#include "lucarium/session/memory_needs.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("the experiment's formula gives the bytes of Table 1 for the paper's elements") {
  // Mortensen et al. 2007, Table 1: diffuse and non-diffuse elements.
  constexpr double elements[4][2] = {{34816, 931136}, {816640, 0}, {905984, 0}, {2434560, 7629824}};
  std::ifstream file(environment("LUCARIUM_TEST_SOURCE") +
                     "/techniques/virtual_light_field/experiments/mortensen2007/propagation.json");
  const nlohmann::json experiment = nlohmann::json::parse(file);
  int found = 0;
  for (const auto& value : experiment.at("values")) {
    const std::string expression = value.at("value");
    if (expression.find("counter_sides") == std::string::npos) continue;
    const auto& counts = elements[value.at("scene").get<size_t>()];
    const ExpressionScope scope{{{"counter_sides", counts[0]}, {"counter_cells", counts[1]}}, {}};
    CAPTURE(expression);
    CHECK(evaluate_expression(expression, scope) == relative(value.at("paper").get<double>(), 0.025));
    ++found;
  }
  CHECK(found == 8);
}

namespace {

/// Of all buffers but the scene's [bytes].
double held() {
  double bytes = 0;
  for (const auto& [owner, of_owner] : test_device()->memory().by_owner())
    if (owner != "scene" && owner != "bvh") bytes += static_cast<double>(of_owner);
  return bytes;
}

struct Memory {
  double taken = 0, stated = 0;  ///< [bytes]
};

/// The most that is held while texels are prepared and light is propagated.
Memory memory_of(const std::string& name, const std::vector<std::string>& materials, const Options& parameters) {
  SceneOverrides overrides;
  overrides.materials = materials;
  Scene scene = load_scene(name, overrides);
  RenderSettings settings;
  settings.width = settings.height = 24;
  settings.camera = scene.cameras.front();
  const double others = held();
  Memory result;
  const auto watch = [&] { result.taken = std::max(result.taken, held() - others); };
  RenderSession run(test_device(), std::move(scene), registry().find("virtual_light_field"), settings, parameters,
                    [&](double, const std::string& stage) {
                      if (stage.find("compiling") == std::string::npos) watch();  // copies that a warm-up makes
                    });
  run.run({.iterations = 40}, [&](const IterationResult& now) {
    watch();
    return now.phase == "light" || now.phase == "preview" || now.phase == "fragments";
  });
  watch();
  result.stated = static_cast<double>(run.technique().estimate_bytes(run.scene(), run.settings()));
  return result;
}

}  // namespace

TEST_CASE("stated memory is what is taken, up to a tenth") {
  const Options few = {{"dir_n", "8"}, {"texels", "16384"}, {"access_rays", "128"}};
  const std::pair<const char*, Options> cases[] = {
      {"builtin:cornell", {{"cells", "64"}}},
      {"builtin:cornell", {{"cells", "64"}, {"cache_visibility", "0"}}},
      {"builtin:cornell-mirror", {{"cells", "64"}, {"tile", "4"}}},
      {"builtin:cornell-mirror", {{"cells", "128"}, {"store", "csr"}}},
      {"builtin:spheres", {{"cells", "0"}}},
      {"builtin:spheres", {{"cells", "128"}, {"tile", "0"}, {"split_layers", "off"}, {"cache_visibility", "0"}}},
      {"builtin:spheres", {{"cells", "64"}, {"store", "csr"}, {"perturb", "2"}, {"cache_visibility", "0"}}},
      {"builtin:atrium", {{"cells", "64"}}},
      {"builtin:atrium", {{"cells", "64"}, {"preset", "walkthrough"}}},
  };
  for (const auto& [name, more] : cases) {
    const Memory memory = memory_of(name, {}, with(few, more));
    CAPTURE(name);
    CHECK(memory.taken / memory.stated == relative(1, 0.1));
  }
  for (const char* levels : {"0", "1"}) {
    const Memory memory = memory_of("builtin:cornell-mirror", {"mirror:roughness=0.8"},
                                    with(few, {{"cells", "128"}, {"dir_levels", levels}}));
    CAPTURE(std::string(levels));
    MESSAGE("rough metal, dir_levels ", std::string(levels), ": takes ", memory.taken / memory.stated,
            " of the stated");
    CHECK(memory.taken / memory.stated == relative(1, 0.1));
  }
}

TEST_CASE("where memory does not suffice, the numbers that take most of it are named") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.camera = scene.cameras.front();
  const auto hint = [&](const Options& parameters) {
    const std::unique_ptr<Technique> technique = registry().find("virtual_light_field").create();
    for (const auto& [name, value] : parameters) technique->parameters().set(name, value);
    return memory_hint(*technique, scene, settings);
  };
  const std::string lower = "lower --size or --texture-size, ";
  CHECK(hint({{"dir_n", "6"}, {"cells", "32"}, {"texels", "4096"}}) ==
        lower + "cells (32), texels (4096), dir_n (6), cache_visibility (512)");
  CHECK(hint({{"dir_n", "32"}, {"cells", "0"}, {"texels", "0"}}) ==
        lower + "cells (0: automatic), dir_n (32), texels (0: automatic), cache_visibility (512)");
}
