// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "lucarium/base/numbers.h"
#include "lucarium/scene/device/alias_table.h"
#include "lucarium/scene/device/environment_tables.h"
#include "lucarium/scene/device/light_list.h"
#include "lucarium/scene/device/texture_sampling.h"
#include "lucarium/scene/load/load_scene.h"
#include "scene_support.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

/// What the table's columns add up to.
std::vector<double> implied_distribution(const std::vector<AliasEntry>& table) {
  std::vector<double> p(table.size(), 0.0);
  const double column = 1.0 / static_cast<double>(table.size());
  for (size_t i = 0; i < table.size(); ++i) {
    p[i] += column * static_cast<double>(table[i].probability);
    p[table[i].alias] += column * (1 - static_cast<double>(table[i].probability));
  }
  return p;
}

Environment random_environment(uint32_t width, uint32_t height, double black_share) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0.f, 1.f);
  Environment e;
  e.width = width, e.height = height;
  for (uint32_t i = 0; i < width * height; ++i) {
    const bool black = uniform(random) < black_share;
    const float peak = uniform(random) < 0.01f ? 10000.f : 1.f;
    e.radiance.push_back(black ? glm::vec3(0) : peak * glm::vec3(uniform(random), uniform(random), uniform(random)));
  }
  return e;
}

/// Luminance of the bilinear lookup, wrapping in u and clamping in v.
double lookup(const Environment& e, double u, double v) {
  const double x = u * e.width - 0.5, y = v * e.height - 0.5, left = std::floor(x), top = std::floor(y);
  const auto at = [&](double column, double row) {
    const int w = static_cast<int>(e.width), h = static_cast<int>(e.height);
    const int i = (static_cast<int>(column) % w + w) % w, j = std::clamp(static_cast<int>(row), 0, h - 1);
    const glm::vec3& c = e.radiance[size_t(j) * e.width + i];
    return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
  };
  const double fx = x - left, fy = y - top;
  return (1 - fy) * ((1 - fx) * at(left, top) + fx * at(left + 1, top)) +
         fy * ((1 - fx) * at(left, top + 1) + fx * at(left + 1, top + 1));
}

}  // namespace

TEST_CASE("alias tables hold the weights' distribution") {
  std::mt19937 random(1);
  for (const size_t n : {1u, 2u, 3u, 17u, 1000u}) {
    std::vector<double> weights(n);
    for (double& w : weights) w = std::pow(10.0, std::uniform_real_distribution<>(-6, 3)(random));
    if (n > 2) weights[1] = 0;
    double sum = 0;
    for (const double w : weights) sum += w;
    const std::vector<AliasEntry> table = make_alias_table(weights);
    const std::vector<double> implied = implied_distribution(table);
    for (size_t i = 0; i < n; ++i) {
      CHECK(table[i].pmf == test::relative(weights[i] / sum, 1e-6));
      CHECK(std::abs(implied[i] - weights[i] / sum) < 1e-6 / static_cast<double>(n));
      if (weights[i] == 0) CHECK(implied[i] == 0);
    }
  }
  const std::vector<AliasEntry> even = make_alias_table({0, 0, 0, 0});
  for (const AliasEntry& entry : even) CHECK(entry.pmf == 0.25f);
}

TEST_CASE("alias tables are sampled at their frequencies") {
  // Chi-squared with 5 degrees of freedom stays below 20.5 with probability 0.999; the seed is fixed.
  const std::vector<double> weights = {1, 5, 0.5, 20, 3, 0.1};
  const std::vector<AliasEntry> table = make_alias_table(weights);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  const int samples = 200000;
  std::vector<int> counts(weights.size(), 0);
  for (int s = 0; s < samples; ++s) {
    const size_t column = static_cast<size_t>(uniform(random) * static_cast<double>(table.size()));
    ++counts[uniform(random) < static_cast<double>(table[column].probability) ? column : table[column].alias];
  }
  double chi2 = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    const double expected = samples * weights[i] / 29.6;
    chi2 += (counts[i] - expected) * (counts[i] - expected) / expected;
  }
  CHECK(chi2 < 20.5);
}

TEST_CASE("environment densities integrate to 1, match the search's frequencies and miss no light") {
  for (const double black : {0.0, 0.7, 0.999}) {
    CAPTURE(black);
    const Environment e = random_environment(64, 33, black);
    const EnvironmentTables tables = make_environment_tables(e);
    REQUIRE(tables.cdf.size() == 34 + 33 * 65);
    double integral = 0;
    size_t missed = 0, wasted = 0;
    for (uint32_t j = 0; j < e.height; ++j) {
      for (uint32_t i = 0; i < e.width; ++i) {
        const double w = static_cast<double>(tables.texels[j * e.width + i].w);
        integral += w / (e.width * e.height);
        double brightest = 0;
        for (int s = 0; s < 25; ++s) {
          brightest =
              std::max(brightest, lookup(e, (i + (s % 5 + 0.5) / 5) / e.width, (j + (s / 5 + 0.5) / 5) / e.height));
        }
        missed += brightest > 0 && !(w > 0);
        wasted += brightest == 0 && w > 0;
      }
    }
    CHECK(integral == test::relative(1, 1e-6));
    CHECK(missed == 0);
    CHECK(wasted == 0);
  }
}

TEST_CASE("environment densities follow luminance times solid angle") {
  // A picture without dark or extreme rows is not touched by the floor of 1 %.
  Environment e = random_environment(16, 8, 0);
  for (glm::vec3& c : e.radiance) c = glm::vec3(1) + 0.5f * glm::min(c, glm::vec3(1));
  const EnvironmentTables tables = make_environment_tables(e);
  // Integrate luminance over cells numerically.
  std::vector<double> mass(16 * 8, 0.0);
  double sum = 0;
  const int n = 64;
  for (size_t cell = 0; cell < mass.size(); ++cell) {
    const double i = static_cast<double>(cell % 16), j = static_cast<double>(cell / 16);
    double mean = 0;
    for (int s = 0; s < n * n; ++s)
      mean += lookup(e, (i + (s % n + 0.5) / n) / 16, (j + (s / n + 0.5) / n) / 8) / (n * n);
    mass[cell] = mean * (std::cos(pi * j / 8) - std::cos(pi * (j + 1) / 8));
    sum += mass[cell];
  }
  for (size_t cell = 0; cell < mass.size(); ++cell) {
    CHECK(static_cast<double>(tables.texels[cell].w) / (16 * 8) == test::relative(mass[cell] / sum, 2e-4));
  }
}

TEST_CASE("a constant picture and a constant environment hold the same light") {
  Environment constant;
  constant.factor = {1, 2, 3};
  Environment picture = constant;
  picture.width = 8, picture.height = 4;
  picture.radiance.assign(32, glm::vec3(1));
  const glm::vec3 a = environment_integral(constant), b = environment_integral(picture);
  CHECK(test::largest_difference(a, glm::vec3(1, 2, 3) * static_cast<float>(4 * pi)) < 1e-5f);
  CHECK(test::largest_difference(a, b) < 1e-4f);
  CHECK(make_environment_tables(constant).texels.empty());
}

TEST_CASE("powers of all kinds of lights, and the mixture") {
  Scene scene = test::one_node_scene(test::triangle_mesh());
  scene.instances[0].world_from_object = glm::scale(glm::mat4(1.f), glm::vec3(2, 3, 1));  // area 3
  scene.materials[0].emissive_factor = {1, 0.5f, 0};
  scene.materials[0].emissive_strength = 4;
  scene.materials[0].double_sided = true;
  SceneLight point, spot, sun, dark;
  point.intensity = glm::vec3(2);
  spot.type = LightType::spot, spot.intensity = glm::vec3(10);
  spot.inner_angle = glm::radians(20.f), spot.outer_angle = glm::radians(30.f);
  sun.type = LightType::directional, sun.intensity = glm::vec3(5);
  dark.intensity = glm::vec3(0);
  scene.lights = {point, dark, spot, sun};
  scene.environment = Environment{};
  scene.environment->factor = glm::vec3(0.25f);
  const float radius = 2;
  LightListBuilder builder;
  const LightList list = builder.build(scene, radius, LightChoice::power);
  REQUIRE(list.lights.size() == 5);
  // 4 pi I; .533211 sr I (reference_and_validation.md); pi R^2 E; 2 pi A L; pi R^2 4 pi L.
  const double powers[] = {8 * pi, 5.33211, 20 * pi, 2 * pi * 3 * 2, 4 * pi * pi};
  const uint kinds[] = {LUCARIUM_LIGHT_POINT, LUCARIUM_LIGHT_SPOT, LUCARIUM_LIGHT_DIRECTIONAL, LUCARIUM_LIGHT_TRIANGLE,
                        LUCARIUM_LIGHT_ENVIRONMENT};
  double sum = 0;
  for (const double p : powers) sum += p;
  for (int i = 0; i < 5; ++i) {
    CAPTURE(i);
    CHECK(list.lights[i].kind == kinds[i]);
    CHECK(static_cast<double>(list.lights[i].intensity.w) == test::relative(powers[i], 1e-5));
    CHECK(static_cast<double>(list.table[i].pmf) == test::relative(0.9 * powers[i] / sum + 0.1 / 5, 1e-5));
  }
  CHECK(list.environment_light == 4);
  CHECK(list.triangle_lights == std::vector<uint>{3});
  CHECK(list.lights[3].position.w == test::relative(3));
  for (const AliasEntry& entry : builder.build(scene, radius, LightChoice::uniform).table) CHECK(entry.pmf == 0.2f);
}

TEST_CASE("spot flux where the ramp is cut off at the axis") {
  // Inner and outer angle nearly equal and tiny: the ramp's top lies beyond cos = 1. Integrate the ramp numerically.
  SceneLight spot;
  spot.type = LightType::spot;
  spot.inner_angle = 0.f, spot.outer_angle = 0.02f;
  const glm::vec2 ramp = spot_ramp(spot);
  double integral = 0;
  const int n = 200000;
  const double low = std::cos(0.02);
  for (int i = 0; i < n; ++i) {
    const double c = low + (1 - low) * (i + 0.5) / n;
    const double f = std::clamp((c - low) * static_cast<double>(ramp.x), 0.0, 1.0);
    integral += 2 * pi * f * f * (1 - low) / n;
  }
  CHECK(spot_solid_angle(spot) == test::relative(integral, 1e-3));
}

TEST_CASE("a textured emitter has an entry if and only if some point of it shines") {
  Scene scene = test::one_node_scene(test::triangle_mesh());
  scene.meshes[0].uv[0] = {{0, 0}, {1, 0}, {0, 1}};
  SceneMaterial& material = scene.materials[0];
  material.emissive_factor = glm::vec3(1);
  material.emissive_texture.texture = 0;
  Image image;
  image.width = image.height = 512;
  image.rgba.assign(4 * 512 * 512, 0);
  scene.textures.push_back({0, Wrap::clamp, Wrap::clamp, false, true});
  const auto lights = [&] { return LightListBuilder().build(scene, 1, LightChoice::power).lights; };

  SUBCASE("black") {
    scene.images = {image};
    CHECK(lights().empty());
  }
  SUBCASE("one texel, which regular samples miss") {
    image.rgba[4 * (512 * 137 + 201)] = 255;
    scene.images = {image};
    REQUIRE(lights().size() == 1);
    CHECK(lights()[0].intensity.x > 0);
  }
  SUBCASE("one texel far from the footprint") {
    image.rgba[4 * (512 * 500 + 500)] = 255;
    scene.images = {image};
    scene.meshes[0].uv[0] = {{0, 0}, {0.5f, 0}, {0, 0.5f}};
    CHECK(lights().empty());
  }
  SUBCASE("half white: the mean over the footprint") {
    for (size_t i = 0; i < image.rgba.size(); ++i) {
      if ((i / 4) % 512 < 256) image.rgba[i] = 255;
    }
    scene.images = {image};
    // The part u < 1/2 of the triangle is 3/4 of it.
    CHECK(lights()[0].intensity.x == test::relative(0.75, 0.01));
  }
}

TEST_CASE("texture transforms scale, turn counter-clockwise in the image, and shift") {
  TextureUse use;
  use.offset = {0.5f, 0.25f}, use.scale = {2, 3}, use.rotation = glm::radians(90.f);
  // (0.1, 0.2) -> scaled (0.2, 0.6) -> turned (0.6, -0.2) -> shifted (1.1, 0.05).
  const glm::vec2 uv = texture_transform(use)({0.1f, 0.2f});
  CHECK(uv.x == test::relative(1.1));
  CHECK(uv.y == test::relative(0.05));
}

TEST_CASE("bilinear lookup wraps, clamps and mirrors") {
  Scene scene;
  Image image;
  image.width = 2, image.height = 1;
  image.rgba = {0, 0, 0, 255, 255, 255, 255, 255};
  scene.images.push_back(image);
  SceneTexture texture{0, Wrap::repeat, Wrap::clamp, false, false};
  CHECK(sample_texture(scene, texture, {0.25f, 0.5f}).r == 0);
  CHECK(sample_texture(scene, texture, {0.5f, 0.5f}).r == test::relative(0.5));
  CHECK(sample_texture(scene, texture, {0.f, 0.5f}).r == test::relative(0.5));
  texture.wrap_u = Wrap::clamp;
  CHECK(sample_texture(scene, texture, {0.f, 0.5f}).r == 0);
  texture.wrap_u = Wrap::mirror;
  CHECK(sample_texture(scene, texture, {1.25f, 0.5f}).r == 1);
  CHECK(sample_texture(scene, texture, {-0.25f, 0.5f}).r == 0);
  texture.nearest = true;
  CHECK(sample_texture(scene, texture, {0.49f, 0.5f}).r == 0);
  texture.srgb = true;
  CHECK(srgb_to_linear_table()[128] == test::relative(0.2158605, 1e-5));
}
