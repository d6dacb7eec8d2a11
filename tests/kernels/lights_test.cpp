// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/lights.clh, environment.clh: the environment's look-up, closed forms of illuminance, what surfaces
// emit.
#include <doctest/doctest.h>

#include <cmath>

#include "closed_forms.h"
#include "light_scenes.h"
#include "lucarium/shared/ray.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::vector<float4> illuminate(const SceneBuffers& buffers, const std::vector<float4>& positions) {
  const auto points = test_buffer(positions), values = test_buffer<float4>(positions.size());
  run_kernel(light_program(), "illuminate_points", positions.size(), 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("positions", points).arg("count", static_cast<uint>(positions.size())).arg("values", values);
  });
  return values.download();
}

/// The mean of radiance cos / pdf (green; normal +z) over 16 replicates.
Estimate illuminance(const LightSamples& samples) {
  return interleaved_estimate(samples.directions.size(), [&](size_t i) {
    const float4 d = samples.directions[i];
    return d.w > 0 && d.z > 0 ? double(samples.radiances[i].y) * d.z / d.w : 0;
  });
}

/// The host's own bilinear lookup, in double precision.
glm::dvec3 environment_reference(const Environment& e, const glm::vec3& world) {
  const glm::dvec3 d = glm::dmat3(e.environment_from_world) * glm::dvec3(world);
  const double x = (0.5 + std::atan2(d.z, d.x) / (2 * pi)) * e.width - 0.5;
  const double y = std::acos(std::clamp(d.y / glm::length(d), -1.0, 1.0)) / pi * e.height - 0.5;
  const auto texel = [&](double i, double j) {
    const int w = static_cast<int>(e.width), column = ((static_cast<int>(i) % w) + w) % w;
    const int row = std::clamp(static_cast<int>(j), 0, static_cast<int>(e.height) - 1);
    return glm::dvec3(e.radiance[row * w + column]);
  };
  const double i = std::floor(x), j = std::floor(y), fx = x - i, fy = y - j;
  return glm::dvec3(e.factor) * ((1 - fy) * ((1 - fx) * texel(i, j) + fx * texel(i + 1, j)) +
                                 fy * ((1 - fx) * texel(i, j + 1) + fx * texel(i + 1, j + 1)));
}

}  // namespace

TEST_CASE("the environment is looked up as its definition says") {
  // No peak, whose slope would need more digits than a direction has, and one colour at the pole, which has no azimuth.
  Scene scene = environment_scene();
  for (uint32_t i = 0; i < 32; ++i) scene.environment->radiance[15 * 32 + i] = glm::vec3(0.3f);
  scene.environment->radiance[5 * 32 + 27] = glm::vec3(3, 2, 1);
  const SceneBuffers buffers(*test_device(), scene);
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::vector<float4> directions;
  for (int i = 0; i < 4096; ++i) {
    directions.emplace_back(glm::normalize(glm::vec3(normal(random), normal(random), normal(random))), 0.f);
  }
  // The environment's own poles and seam.
  const glm::mat3 world = glm::transpose(scene.environment->environment_from_world);
  for (const glm::vec3& d :
       {glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), glm::vec3(-1, 0, 1e-7f), glm::vec3(-1, 0, -1e-7f)}) {
    directions.emplace_back(world * d, 0.f);
  }
  directions.resize(4160, directions[0]);
  const auto rays = test_buffer(directions), values = test_buffer<float4>(directions.size());
  run_kernel(light_program(), "lookup_environment", directions.size(), 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("directions", rays).arg("count", static_cast<uint>(directions.size())).arg("values", values);
  });
  const auto got = values.download();
  double worst = 0;
  for (size_t i = 0; i < directions.size(); ++i) {
    const glm::dvec3 expected = environment_reference(*scene.environment, directions[i].xyz());
    worst = std::max(worst, glm::length(glm::dvec3(got[i].xyz()) - expected) / (1 + glm::length(expected)));
  }
  CHECK(worst < 1e-4);
}

TEST_CASE("punctual lights: point, directional, spot") {
  Scene scene = empty_scene();
  SceneLight light;
  light.intensity = glm::vec3(100);
  light.world_from_light[3] = glm::vec4(0, 0, 2, 1);  // shines along -z
  scene.lights = {light};
  const double radii[] = {0, 1, 2, 4}, expected[] = {3.978874, 2.847050, 1.406744, .355881};
  std::vector<float4> points;
  for (const double r : radii) points.emplace_back(static_cast<float>(r), 0.f, 0.f, 0.f);
  points.resize(64, points[0]);
  {
    const SceneBuffers buffers(*test_device(), scene);
    const auto values = illuminate(buffers, points);
    for (int i = 0; i < 4; ++i) CHECK(values[i].y * values[i].w * 0.5 / pi == test::relative(expected[i], 1e-5));
  }
  scene.lights[0].type = LightType::directional;
  {
    const SceneBuffers buffers(*test_device(), scene);
    const auto values = illuminate(buffers, points);
    CHECK(values[2].y * values[2].w * 0.5 / pi == test::relative(15.915494, 1e-5));
    CHECK(values[2].w == test::relative(1));
  }
  // Flux of a spot by summing over a unit sphere about it.
  scene.lights[0].type = LightType::spot;
  scene.lights[0].intensity = glm::vec3(1);
  scene.lights[0].inner_angle = static_cast<float>(20 * pi / 180);
  scene.lights[0].outer_angle = static_cast<float>(30 * pi / 180);
  const int n = 1 << 14;
  points.clear();
  for (int i = 0; i < n; ++i) {
    const double theta = pi * (i + 0.5) / n;
    points.emplace_back(static_cast<float>(std::sin(theta)), 0.f, static_cast<float>(2 - std::cos(theta)), 0.f);
  }
  const SceneBuffers buffers(*test_device(), scene);
  const auto values = illuminate(buffers, points);
  double flux = 0;
  for (int i = 0; i < n; ++i) flux += double(values[i].y) * 2 * pi * std::sin(pi * (i + 0.5) / n) * pi / n;
  CHECK(flux == test::relative(.533211, 1e-4));
}

TEST_CASE("illuminance of a square light, from one and from two sides, and of environments") {
  const uint n = full_run() ? 1u << 18 : 1u << 15;
  ClosedForms table;
  for (const bool double_sided : {false, true}) {
    Scene scene = empty_scene();
    const float h = 0.5f;
    const SceneMaterial material = double_sided ? two_sided(emitter(1)) : emitter(1);
    add_triangle(scene, material, {-h, -h, 1}, {-h, h, 1}, {h, h, 1});
    add_triangle(scene, material, {-h, -h, 1}, {h, h, 1}, {h, -h, 1});
    const SceneBuffers buffers(*test_device(), scene);
    table.add("below the centre", illuminance(sample(buffers, {0, 0, 0}, n)), .752275);
    table.add("below a corner", illuminance(sample(buffers, {.5f, .5f, 0}, n)), .435210);
    table.add("beside", illuminance(sample(buffers, {2, 0, 0}, n)), .0437426);
    // From behind: turn the normal over, since the receiver faces +z.
    LightSamples behind = sample(buffers, {0, 0, 2}, n);
    for (float4& d : behind.directions) d.z = -d.z;
    table.add("behind", illuminance(behind), double_sided ? .752275 : 0);
  }
  Scene scene = empty_scene();
  scene.environment = Environment{};
  scene.environment->factor = glm::vec3(2);
  const SceneBuffers constant(*test_device(), scene);
  table.add("constant environment", illuminance(sample(constant, glm::vec3(0), n)), 2 * pi);
  // The map against a plain sum over directions.
  scene = environment_scene();
  double exact = 0;
  const int steps = 600;
  for (int i = 0; i < steps; ++i) {
    for (int k = 0; k < 4 * steps; ++k) {
      const double z = (i + 0.5) / steps, phi = 2 * pi * (k + 0.5) / (4 * steps), s = std::sqrt(1 - z * z);
      exact += z * environment_reference(*scene.environment, glm::vec3(s * std::cos(phi), s * std::sin(phi), z)).y;
    }
  }
  exact *= 2 * pi / (4.0 * steps * steps);
  const SceneBuffers map(*test_device(), scene);
  table.add("environment", illuminance(sample(map, glm::vec3(0), 8 * n)), exact);
  table.check();
}

TEST_CASE("what surfaces emit: sides, unlit, textures, coverage") {
  Scene scene = empty_scene();
  scene.images.push_back({"two texels", 2, 1, {255, 255, 255, 255, 0, 0, 0, 255}});
  scene.textures.push_back({0, Wrap::clamp, Wrap::clamp, true, true});
  SceneMaterial unlit = emitter(0), textured = emitter(4), blended = emitter(4);
  unlit.unlit = true, unlit.emissive_factor = glm::vec3(0), unlit.base_color = glm::vec4(0.25f, 0.5f, 1, 1);
  textured.emissive_texture.texture = 0;
  blended.alpha_mode = AlphaMode::blend, blended.base_color.a = 0.25f;
  const SceneMaterial materials[] = {emitter(2), two_sided(emitter(2)), unlit, textured, blended};
  // Five triangles side by side at z = 1 that face the points below them.
  const auto place = [](int i) { return 3 * static_cast<float>(i); };
  for (int i = 0; i < 5; ++i) {
    add_triangle(scene, materials[i], {place(i), 0, 1}, {place(i), 1, 1}, {place(i) + 1, 0, 1});
  }
  const SceneBuffers buffers(*test_device(), scene);
  const auto below = [&](int i, float x, float y) {
    return meet(buffers, {place(i) + x, y, 0}, std::vector<float4>(64, float4(0, 0, 1, 0)))[0];
  };
  const auto above = [&](int i) {
    return meet(buffers, {place(i) + 0.2f, 0.2f, 2}, std::vector<float4>(64, float4(0, 0, -1, 0)))[0];
  };
  CHECK(below(0, .2f, .2f).y == test::relative(2));
  CHECK(above(0).y == 0);
  CHECK(below(1, .2f, .2f).y == test::relative(2));
  CHECK(above(1).y == test::relative(2));
  CHECK(below(2, .2f, .2f).x == test::relative(0.25));
  CHECK(below(2, .2f, .2f).z == test::relative(1));
  CHECK(below(3, .2f, .2f).y == test::relative(4));  // u follows +y here
  CHECK(below(3, .1f, .7f).y == 0);
  CHECK(below(3, .1f, .7f).w > 0);
  // A met surface stands for itself; a light sample accounts for how often it is there.
  CHECK(below(4, .2f, .2f).y == test::relative(4));
  Scene alone = empty_scene();
  add_triangle(alone, blended, {0, 0, 1}, {0, 1, 1}, {1, 0, 1});
  const LightSamples samples = sample(SceneBuffers(*test_device(), alone), {0.2f, 0.2f, 0}, 64);
  CHECK(samples.radiances[0].y == test::relative(1));
}

TEST_CASE("lamps with holes, vertex colours and second texture coordinates: light samples bring what is met") {
  // The texture is white and there where u < 1/2, black and a hole elsewhere; v is of no importance. The second
  // coordinates run along x (u follows +y in the first), so that the triangle's right part is dark.
  const glm::vec3 a(0, 0, 1), b(0, 1, 1), c(1, 0, 1), below(0.3f, 0.3f, 0);
  const auto lamp_scene = [&](const SceneMaterial& material, const std::vector<glm::vec4>& colors = {}) {
    Scene scene = empty_scene();
    scene.images.push_back({"half", 2, 1, {255, 255, 255, 255, 0, 0, 0, 0}});
    scene.textures.push_back({0, Wrap::clamp, Wrap::clamp, true, false});
    add_triangle(scene, material, a, b, c);
    scene.meshes[0].uv[1] = {{0, 0}, {0, 0}, {1, 0}};
    scene.meshes[0].colors = colors;
    return scene;
  };
  // Light samples: 4 where the point of the lamp is in its left part, 0 elsewhere, whatever is met there.
  const auto check_left = [&](const SceneMaterial& material, uint ray_seed, bool right_too) {
    const SceneBuffers buffers(*test_device(), lamp_scene(material));
    const LightSamples samples = sample(buffers, below, 256, all_kinds, 1, ray_seed);
    uint left = 0, wrong = 0;
    for (size_t i = 0; i < samples.ends.size(); ++i) {
      const bool is_left = samples.ends[i].x < 0.5f;
      left += is_left;
      wrong += std::abs(samples.radiances[i].y - (is_left || right_too ? 4 : 0)) > 1e-4f;
    }
    CHECK(wrong == 0);
    CHECK(left > 100);
    CHECK(left < 250);
  };
  SceneMaterial textured = emitter(4);
  textured.emissive_texture.texture = 0, textured.emissive_texture.uv_set = 1;
  check_left(textured, 1, false);
  const auto met = [&](float x) {
    return meet(SceneBuffers(*test_device(), lamp_scene(textured)), {x, 0.2f, 0},
                std::vector<float4>(64, float4(0, 0, 1, 0)))[0]
        .y;
  };
  CHECK(met(0.2f) == test::relative(4));
  CHECK(met(0.7f) == 0);

  SceneMaterial holed = emitter(4);
  holed.base_color_texture.texture = 0, holed.base_color_texture.uv_set = 1;
  holed.alpha_mode = AlphaMode::mask;
  check_left(holed, 1, false);
  check_left(holed, LUCARIUM_SEED_OPAQUE, false);
  holed.alpha_mode = AlphaMode::blend;
  check_left(holed, 1, false);
  check_left(holed, LUCARIUM_SEED_OPAQUE, true);  // for such rays all of a veil is there

  SceneMaterial unlit = emitter(0);
  unlit.unlit = true, unlit.emissive_factor = glm::vec3(0), unlit.base_color = glm::vec4(1, 1, 0.5f, 1);
  const std::vector<glm::vec4> colors(3, glm::vec4(0.25f, 0.5f, 1, 1));
  const SceneBuffers buffers(*test_device(), lamp_scene(unlit, colors));
  const float4 sampled = sample(buffers, below, 64).radiances[0];
  const float4 seen = meet(buffers, below, std::vector<float4>(64, float4(0, 0, 1, 0)))[0];
  for (const float4& light : {sampled, seen}) {
    CHECK(light.x == test::relative(0.25, 1e-3));
    CHECK(light.y == test::relative(0.5, 1e-3));
    CHECK(light.z == test::relative(0.5, 1e-3));
  }
}
