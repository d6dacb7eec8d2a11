// SPDX-License-Identifier: Apache-2.0
// Starts of eight light paths at once are to the last bit those of one at a time.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include "device_fixture.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/shared/light_path.h"
#include "lucarium/shared/ray.h"
#include "made_scene.h"
#include "test_support.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kPaths = 4096 + 5;  // the last are not eight

Program program(const std::map<std::string, std::string>& defines) {
  SourceLibrary library;
  library.add(test_services_kernels());
  return Program(*test_device(), library, {"test/emitted paths", {"test_services/emitted_paths.cl"}, defines});
}

/// Lights of all kinds, more than half of which eight paths start from at once.
Scene lit_scene() {
  Scene scene;
  scene.source = "test:emitted paths";
  scene.images.push_back({"grey", 1, 1, {90, 120, 200, 128}});
  scene.textures.push_back({0, Wrap::clamp, Wrap::clamp, true, false});
  add_box(scene, glm::vec3(-1), {1, 1, 1.5f}, true, add_material(scene, lambert(0.7f)));
  const auto lamp = [&](const SceneMaterial& material, const glm::vec3& at) {
    const int index = add_material(scene, material);
    for (const float turn : {-1.f, 1.f})
      add_triangles(scene, {at, at + glm::vec3(0.2f, 0.03f, 0), at + turn * glm::vec3(0.02f, 0.05f, 0.2f)}, index);
  };
  lamp(emitter(40), {-0.5f, 0.8f, 0});
  lamp(emitter(30, 0.5f), {0.1f, 0.5f, -0.6f});
  SceneMaterial other = emitter(20);
  other.double_sided = true;
  lamp(other, {0.5f, 0.8f, 0});
  other = emitter(20);
  other.emissive_texture.texture = 0;
  lamp(other, {0.5f, 0.2f, 0});
  other = emitter(20);
  other.alpha_mode = AlphaMode::blend;
  other.base_color.a = 0.5f;
  lamp(other, {-0.5f, 0.2f, 0});
  add_light(scene, LightType::point, 1, {-0.6f, 0.5f, 0.6f}, {0, -1, 0});
  add_light(scene, LightType::point, 2, {0.3f, -30, 0.6f}, {0, -1, 0});
  add_light(scene, LightType::spot, 3, {0.6f, 0.7f, 0.6f}, {0, -1, 0});
  scene.lights.back().inner_angle = 0.3f;
  scene.lights.back().outer_angle = 0.6f;
  add_light(scene, LightType::directional, 1, {}, {0, -1, 0});
  return scene;
}

struct Started {
  std::vector<Ray> rays;
  std::vector<LightPathState> states;
  std::vector<uint32_t> keys, order;
};

Started start(const SceneBuffers& buffers, const Program& program, uint32_t kinds) {
  const auto rays = test_buffer<Ray>(kPaths);
  const auto states = test_buffer<LightPathState>(kPaths);
  const auto keys = test_buffer<uint32_t>(kPaths), order = test_buffer<uint32_t>(kPaths);
  LightPathRules rules{};
  rules.count = kPaths;
  rules.kinds = kinds;
  rules.hit_samples = 1;
  rules.light_samples = 2;
  rules.connection_samples = 3;
  rules.vertices = 1;
  run_kernel(program, "emit_light_paths", (kPaths + 7) / 8, 1, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("rules", rules).arg("base", 8u * 1000u).arg("count", kPaths).arg("frame", 2u).arg("seed", 7u);
    pass.arg("rays", rays).arg("states", states).arg("slice_base", 0u);
    pass.arg("ordered", 1u).arg("keys", keys).arg("order", order);
  });
  return {rays.download(), states.download(), keys.download(), order.download()};
}

template <typename T>
int differing(const std::vector<T>& a, const std::vector<T>& b) {
  int count = 0;
  for (size_t i = 0; i < a.size(); ++i) count += std::memcmp(&a[i], &b[i], sizeof(T)) != 0;
  return count;
}

}  // namespace

TEST_CASE("light paths start eight at once with the bits of one at a time") {
  const Scene scene = lit_scene();
  const SceneBuffers buffers(*test_device(), scene);
  constexpr uint32_t all = 31, no_points = 30;
  for (const char* const chosen : {"", "CHOSEN"}) {
    std::map<std::string, std::string> defines;
    if (*chosen) defines[chosen] = "";
    const Program one = program(defines);
    defines["EIGHT"] = "";
    const Program eight = program(defines);
    for (const uint32_t kinds : {all, no_points}) {
      CAPTURE(chosen);
      CAPTURE(kinds);
      const Started expected = start(buffers, one, kinds), found = start(buffers, eight, kinds);
      CHECK(differing(found.rays, expected.rays) == 0);
      CHECK(differing(found.states, expected.states) == 0);
      int black = 0;
      for (const Ray& ray : found.rays) black += ray.direction.w < 0;
      CHECK((black > 0) == (kinds != all));
    }
  }
}

TEST_CASE("keys of first rays bring those of one place and nearby directions together, others behind them") {
  const Scene scene = lit_scene();
  const SceneBuffers buffers(*test_device(), scene);
  const std::vector<Light> lights = buffers.scene_lights.download();
  const Started all = start(buffers, program({{"EIGHT", ""}}), 31);
  const auto at_place = [&](uint32_t i) {
    const uint32_t kind = lights[all.states[i].light].kind;
    return i < kPaths / 8 * 8 && (kind == LUCARIUM_LIGHT_POINT || kind == LUCARIUM_LIGHT_SPOT);
  };
  int otherwise = 0, places = 0;
  for (uint32_t i = 0; i < kPaths; ++i) {
    otherwise += all.order[i] != i;
    if (!at_place(i)) otherwise += all.keys[i] != LIGHT_FIRST_KEY_LAST;
    places += at_place(i);
  }
  CHECK(otherwise == 0);
  CHECK(places > 1000);
  std::vector<uint32_t> order = all.order;
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return all.keys[a] < all.keys[b]; });
  int pairs = 0, of_lights = 0;
  double cosines = 0;
  for (uint32_t k = 1; k < kPaths; ++k) {
    const uint32_t a = order[k - 1], b = order[k];
    if (!at_place(a) || !at_place(b)) continue;
    const float4 u = all.rays[a].direction, v = all.rays[b].direction;
    if (all.states[a].light != all.states[b].light) {
      ++of_lights;
      continue;
    }
    cosines += double{u.x * v.x + u.y * v.y + u.z * v.z};
    ++pairs;
  }
  CHECK(of_lights <= 3);
  CHECK(cosines / pairs > 0.96);
}
