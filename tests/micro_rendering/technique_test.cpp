// SPDX-License-Identifier: Apache-2.0
// The whole technique: agreement with the path tracer restricted to the same paths, and with closed forms.
#include <doctest/doctest.h>

#include <cmath>

#include "lucarium/scene/load_scene.h"
#include "lucarium/technique/session.h"
#include "test_support.h"

using namespace lucarium;

namespace {

using Parameters = std::vector<std::pair<std::string, std::string>>;

const TechniqueRegistry& registry() {
  static const TechniqueRegistry all;
  return all;
}

RenderSettings settings_for(const Scene& scene, uint32_t size, int max_bounces) {
  RenderSettings settings;
  settings.width = settings.height = size;
  settings.max_bounces = max_bounces;
  settings.camera = scene.cameras.front();
  return settings;
}

/// The layer `indirect` of a scene after some iterations.
std::vector<float> indirect_light(const char* name, const std::string& technique, uint32_t size, int max_bounces,
                                  uint64_t iterations, const Parameters& parameters) {
  Scene scene = load_scene(name);
  const RenderSettings settings = settings_for(scene, size, max_bounces);
  RenderSession session(Device::open(), std::move(scene), registry().find(technique), settings, parameters);
  session.run({.iterations = iterations});
  return session.resolve().find("indirect")->pixels;
}

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

const Parameters reference = {{"secondary_lambert_only", "on"}, {"light_delta", "off"}, {"samples_per_iteration", "64"}};
const Parameters small = {{"points_log2", "13"}, {"micro_size", "16"}, {"jacobi_level", "8"}};

}  // namespace

TEST_CASE("indirect light is the path tracer's, over one and several bounces") {
  for (const char* scene : {"builtin:cornell", "builtin:room"}) {
    for (const int bounces : {1, 3}) {
      CAPTURE(scene);
      CAPTURE(bounces);
      const double mine = mean(indirect_light(scene, "micro_rendering", 24, bounces, 8, small));
      const double expected = mean(indirect_light(scene, "path_tracing", 24, bounces, 16, reference));
      CHECK(mine == doctest::Approx(expected).epsilon(0.03));
    }
  }
}

TEST_CASE("virtual lights and photons bring the light of several bounces") {
  const double expected = mean(indirect_light("builtin:room", "path_tracing", 24, 3, 16, reference));
  Parameters lights = small;
  lights.emplace_back("multibounce", "instant_radiosity");
  lights.emplace_back("vpls", "64");
  lights.emplace_back("vpl_clamp", "1e5");
  lights.emplace_back("points_log2", "11");
  CHECK(mean(indirect_light("builtin:room", "micro_rendering", 24, 3, 8, lights)) == doctest::Approx(expected).epsilon(0.03));
  Parameters photons = small;
  photons.emplace_back("multibounce", "photon_map");
  photons.emplace_back("photons", "50000");
  CHECK(mean(indirect_light("builtin:room", "micro_rendering", 24, 3, 8, photons)) == doctest::Approx(expected).epsilon(0.03));
  photons.emplace_back("photon_direct", "on");
  CHECK(mean(indirect_light("builtin:room", "micro_rendering", 24, 3, 8, photons)) == doctest::Approx(expected).epsilon(0.04));
}
