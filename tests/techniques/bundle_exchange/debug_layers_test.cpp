// SPDX-License-Identifier: Apache-2.0
// What each part of the technique brings: parts sum to the picture, which stays as it is.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
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
    CHECK(largest(film, "direction_history") == 0);  // all chains
    for (const std::string& part : setting.parts) CHECK_MESSAGE(largest(film, part.c_str()) > 0, part);
    double worst = 0;
    for (size_t i = 0; i < 3 * film.pixel_count(); ++i) {
      double sum = 0;
      for (const char* part : kParts) sum += static_cast<double>(film.find(part)->pixels[i]);
      const double picture =
          static_cast<double>(film.find("direct")->pixels[i]) + static_cast<double>(film.find("indirect")->pixels[i]);
      worst = std::max(worst, std::abs(sum - picture) / std::max(picture, 1e-3));
    }
    CHECK(worst < 1e-5);
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
