// SPDX-License-Identifier: Apache-2.0
// Every way of estimating the same light has the same mean: Welch's t on replicate means, Sidak over all pairs.
#include <map>

#include "lucarium/scene/builtin/scenes.h"
#include "test_render.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

struct Variant {
  std::string name;
  PathIntegratorOptions options;
};

std::vector<Variant> variants(int max_bounces) {
  PathIntegratorOptions base;
  base.path_set.max_bounces = max_bounces;
  std::vector<Variant> all = {{"mis", base}};
  const auto add = [&](const std::string& name, auto change) {
    all.push_back({name, base});
    change(all.back().options);
  };
  add("balance heuristic", [](PathIntegratorOptions& o) { o.estimator = PathEstimator::mis_balance; });
  add("nee", [](PathIntegratorOptions& o) { o.estimator = PathEstimator::nee_only; });
  add("bsdf", [](PathIntegratorOptions& o) { o.estimator = PathEstimator::bsdf_only; });
  add("roulette from 1", [](PathIntegratorOptions& o) { o.roulette_start = 1; });
  add("no roulette", [](PathIntegratorOptions& o) { o.roulette = false; });
  add("light choice by power", [](PathIntegratorOptions& o) { o.light_choice = LightChoice::power; });
  add("uniform light choice", [](PathIntegratorOptions& o) { o.light_choice = LightChoice::uniform; });
  add("random sampler", [](PathIntegratorOptions& o) { o.sampler = PathSampler::random; });
  return all;
}

void check_agreement(const Scene& scene, int max_bounces, const Effort& effort) {
  std::vector<std::pair<std::string, Estimate>> results;
  uint64_t seed = 1;
  for (const Variant& variant : variants(max_bounces))
    results.emplace_back(variant.name, estimate(scene, scene.cameras.at(0), variant.options, effort, seed++));
  const size_t pairs = results.size() * (results.size() - 1) / 2;
  for (size_t i = 0; i < results.size(); ++i)
    for (size_t j = i + 1; j < results.size(); ++j) {
      const Estimate &a = results[i].second, &b = results[j].second;
      const double va = a.error * a.error, vb = b.error * b.error;
      const double n = effort.replicates - 1;
      const double dof = (va + vb) * (va + vb) / (va * va / n + vb * vb / n);
      const double t = (a.mean - b.mean) / std::sqrt(va + vb);
      INFO(scene.source, ": ", results[i].first, " ", a.mean, " +- ", a.error, ", ", results[j].first, " ", b.mean,
           " +- ", b.error);
      CHECK(std::abs(t) <= student_t_quantile(sidak_level(0.01, pairs), dof));
      CHECK(a.error <= 0.03 * a.mean);
    }
}

Effort agreement_effort() { return full_run() ? Effort{64, 32, 64} : Effort{32, 16, 8}; }

/// The Cornell box with lights of very different kinds and powers, so that a wrong probability would show.
Scene mixed_lights() {
  Scene scene = make_builtin_scene("cornell");
  set_environment(scene, 0.5f);
  const Bounds bounds = scene.bounds();
  const glm::vec3 center = bounds.center();
  add_light(scene, LightType::point, 0.05f * bounds.radius() * bounds.radius(), center, center - glm::vec3(0, 1, 0));
  return scene;
}

/// So many that a tree chooses among them, under a sun.
Scene many_lights() {
  Scene scene = mixed_lights();
  const glm::vec3 center = scene.bounds().center(), half = scene.bounds().max - center;
  const float power = 0.01f * scene.bounds().radius() * scene.bounds().radius();
  for (int i = 0; i < 6; ++i) {
    const float x = i % 2 ? 0.5f : -0.5f, y = 0.3f * static_cast<float>(i % 3) - 0.3f, z = i < 3 ? 0.4f : -0.3f;
    add_light(scene, i % 3 ? LightType::spot : LightType::point, power * static_cast<float>(1 + i),
              center + half * glm::vec3(x, y, z), center);
  }
  add_light(scene, LightType::directional, 0.3f, center, center + glm::vec3(-0.2f, -0.5f, -1));
  // Panels near the floor that shine on it: both strategies find them.
  const int panel = add_material(scene, emitter(2));
  for (int i = 0; i < 9; ++i)
    add_horizontal(scene, center.x + 0.5f * half.x * static_cast<float>(i % 3 - 1), center.y - 0.8f * half.y,
                   center.z + 0.5f * half.z * static_cast<float>(i / 3 - 1), 0.4f * half.x, 0.4f * half.z, false,
                   panel);
  return scene;
}

}  // namespace

TEST_CASE("estimator agreement: Cornell box, unlimited") {
  check_agreement(make_builtin_scene("cornell"), -1, agreement_effort());
}
TEST_CASE("estimator agreement: Cornell box with mixed lights, unlimited") {
  check_agreement(mixed_lights(), -1, agreement_effort());
}
TEST_CASE("estimator agreement: Cornell box with many lights, two bounces") {
  check_agreement(many_lights(), 2, agreement_effort());
}

// What the kinds of lights bring alone adds up to what they bring together: a kind that is left out is chosen by
// nothing, and the others get its share.
TEST_CASE("kinds of lights add up: Cornell box with many lights") {
  const Scene scene = many_lights();
  const auto light_of = [&](auto choose, uint64_t seed) {
    PathIntegratorOptions options;
    options.path_set.max_bounces = 2;
    options.path_set.point_lights = options.path_set.spot_lights = options.path_set.directional_lights = false;
    options.path_set.emissive_triangles = options.path_set.environment = false;
    choose(options.path_set);
    return estimate(scene, scene.cameras.at(0), options, agreement_effort(), seed);
  };
  const Estimate parts[] = {light_of([](PathSet& s) { s.point_lights = s.environment = true; }, 1),
                            light_of([](PathSet& s) { s.spot_lights = s.emissive_triangles = true; }, 2),
                            light_of([](PathSet& s) { s.directional_lights = true; }, 3)};
  const Estimate all = estimate(
      scene, scene.cameras.at(0),
      [] {
        PathIntegratorOptions options;
        options.path_set.max_bounces = 2;
        return options;
      }(),
      agreement_effort(), 4);
  double sum = 0, variance = all.error * all.error;
  for (const Estimate& part : parts) {
    CHECK(part.mean > 0.02 * all.mean);
    sum += part.mean;
    variance += part.error * part.error;
  }
  INFO("together ", all.mean, ", one by one ", sum);
  CHECK(std::abs(sum - all.mean) <= 4 * std::sqrt(variance));
  CHECK(std::sqrt(variance) <= 0.03 * all.mean);
}

TEST_CASE("estimator agreement: glossy Cornell box, two bounces") {
  check_agreement(make_builtin_scene("cornell-glossy"), 2, agreement_effort());
}
TEST_CASE("estimator agreement: Cornell box with a mirror, two bounces") {
  check_agreement(make_builtin_scene("cornell-mirror"), 2, agreement_effort());
}
