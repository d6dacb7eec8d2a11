// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/emission.clh: samples follow their densities, carry the power of their light, and bring to a
// receiver what light samples find there.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>

#include "chi2.h"
#include "closed_forms.h"
#include "light_scenes.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

const Program& emission_program() {
  static const Program instance = kernel_program("emission");
  return instance;
}

struct Emissions {
  std::vector<float4> origins, directions, fluxes, pdfs;  ///< w: density; pdfs: choice, position, direction again
  std::vector<float2> weights;
  std::vector<uint> lights;
};

Emissions emit(const SceneBuffers& buffers, uint count, uint kinds = all_kinds) {
  const auto origins = test_buffer<float4>(count), directions = test_buffer<float4>(count),
             fluxes = test_buffer<float4>(count), pdfs = test_buffer<float4>(count);
  const auto lights = test_buffer<uint>(count);
  const auto weights = test_buffer<float2>(count);
  run_kernel(emission_program(), "sample_emissions", count, 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("kinds", kinds).arg("seed", 3u).arg("count", count).arg("origins", origins);
    pass.arg("directions", directions).arg("fluxes", fluxes).arg("lights", lights);
  });
  run_kernel(emission_program(), "find_emission_pdfs", count, 64, [&](PassBuilder& pass) {
    buffers.bind(pass);
    pass.arg("count", count).arg("origins", origins).arg("directions", directions).arg("lights", lights);
    pass.arg("pdfs", pdfs).arg("weights", weights);
  });
  return {origins.download(), directions.download(), fluxes.download(),
          pdfs.download(),    weights.download(),    lights.download()};
}

/// A small black sphere's worth of bounds: two triangles from -s to s, which give scenes without surfaces a radius.
void add_bounds(Scene& scene, float s) {
  add_triangle(scene, lambert(0), {-s, -s, -s}, {-s + 0.01f, -s, -s}, {-s, -s + 0.01f, -s});
  add_triangle(scene, lambert(0), {s, s, s}, {s - 0.01f, s, s}, {s, s - 0.01f, s});
}

SceneLight light_at(LightType type, const glm::vec3& intensity) {
  SceneLight light;
  light.type = type;
  light.intensity = intensity;
  light.world_from_light = glm::inverse(glm::lookAt(glm::vec3(0.3f, 0.2f, 1.5f), glm::vec3(0.1f, 0, 0), {0, 1, 0}));
  light.inner_angle = static_cast<float>(20 * pi / 180);
  light.outer_angle = static_cast<float>(30 * pi / 180);
  return light;
}

Scene punctual_scene(LightType type, const glm::vec3& intensity) {
  Scene scene = empty_scene();
  add_bounds(scene, 1);
  scene.lights = {light_at(type, intensity)};
  return scene;
}

/// One texel in four of a lamp shines, and its other three quarters do not; covered by `alpha` (BLEND).
SceneMaterial textured_lamp(Scene& scene, float radiance, AlphaMode mode, float alpha) {
  scene.images.push_back({"two texels", 2, 1, {255, 255, 255, 255, 0, 0, 0, 255}});
  scene.textures.push_back({0, Wrap::clamp, Wrap::clamp, true, true});
  SceneMaterial material = emitter(radiance);
  material.emissive_texture.texture = 0;
  material.alpha_mode = mode;
  material.base_color.a = alpha;
  return material;
}

const glm::vec3 lamp_a(-0.5f, -0.2f, 1), lamp_b(0.4f, 1, 1.2f), lamp_c(1, -0.6f, 0.9f);  // faces down
const glm::vec3 lamp_normal = glm::normalize(glm::cross(lamp_b - lamp_a, lamp_c - lamp_a));

struct Case {
  std::string name;
  Scene scene;
  double power;       ///< green [lm]
  double brightness;  ///< green: intensity [cd], illuminance [lx] or radiance [cd/m²] where it is the highest
  double precision;   ///< to which every sample carries the power; 0: they differ
};

double radius_of(const Scene& scene) { return double{SceneBuffers(*test_device(), scene).info().bounds_max.w}; }

/// The integral of a map's green radiance over all directions, by its bilinear lookup.
double environment_power(const Environment& e) {
  double sum = 0;
  constexpr int fine = 8;  // sub-texels along each side
  const auto texel = [&](int i, int j) {
    const int w = static_cast<int>(e.width);
    return double{e.radiance[std::clamp(j, 0, static_cast<int>(e.height) - 1) * w + (i + w) % w].y};
  };
  const double size = 1.0 / fine, cell = 2 * pi / e.width * (pi / e.height) * size * size;
  for (int j = 0; j < static_cast<int>(e.height) * fine; ++j)
    for (int i = 0; i < static_cast<int>(e.width) * fine; ++i) {
      const double x = (i + 0.5) * size - 0.5, y = (j + 0.5) * size - 0.5;
      const int i0 = static_cast<int>(std::floor(x)), j0 = static_cast<int>(std::floor(y));
      const double fx = x - i0, fy = y - j0;
      const double radiance = (1 - fy) * ((1 - fx) * texel(i0, j0) + fx * texel(i0 + 1, j0)) +
                              fy * ((1 - fx) * texel(i0, j0 + 1) + fx * texel(i0 + 1, j0 + 1));
      sum += radiance * std::sin(pi * (j + 0.5) * size / e.height) * cell;
    }
  return sum * double{e.factor.y};
}

/// Expected product of flux and all densities: radiance and cosine, or their equivalent (of cases without textures).
double sent_light(const Case& c, const Light& light, const glm::vec3& direction) {
  const double cosine = glm::dot(glm::dvec3(direction), glm::dvec3(light.direction.xyz()));
  if (light.kind == LUCARIUM_LIGHT_TRIANGLE) return c.brightness * std::abs(double{glm::dot(direction, lamp_normal)});
  if (light.kind != LUCARIUM_LIGHT_SPOT) return c.brightness;
  const double outer = std::cos(double{c.scene.lights[0].outer_angle}),
               width = std::max(0.001, std::cos(double{c.scene.lights[0].inner_angle}) - outer);
  return c.brightness * std::pow(std::clamp((cosine - outer) / width, 0.0, 1.0), 2);
}

/// Every kind of light by itself, with its power in closed form.
std::vector<Case> cases() {
  std::vector<Case> list;
  const glm::vec3 intensity(2, 3, 4);
  list.push_back({"point", punctual_scene(LightType::point, intensity), 4 * pi * 3, 3, 2e-5});
  list.push_back({"spot of 20 and 30 degrees", punctual_scene(LightType::spot, intensity), .533211 * 3, 3, 2e-5});
  // Inner and outer cone closer than glTF's ramp is wide, which then goes on beyond the axis: int (c - c_o)^2 1e6.
  Scene narrow = punctual_scene(LightType::spot, intensity);
  narrow.lights[0].inner_angle = 0;
  narrow.lights[0].outer_angle = 0.03f;
  const double height = 1 - std::cos(0.03);  // of which a float cosine leaves 1.3e-4
  list.push_back({"narrow spot", narrow, 3 * 2 * pi * height * height * height / 3 * 1e6, 3, 4e-4});
  Scene sun = punctual_scene(LightType::directional, intensity);
  const double radius = radius_of(sun);
  list.push_back({"directional", sun, pi * radius * radius * 3, 3, 2e-5});

  const double area = 0.5 * double{glm::length(glm::cross(lamp_b - lamp_a, lamp_c - lamp_a))};
  const auto lamp = [&](const SceneMaterial& material, Scene scene = empty_scene()) {
    add_triangle(scene, material, lamp_a, lamp_b, lamp_c);
    add_bounds(scene, 1);
    return scene;
  };
  list.push_back({"triangle", lamp(emitter(5)), pi * area * 5, 5, 2e-5});
  list.push_back({"two-sided triangle", lamp(two_sided(emitter(5))), 2 * pi * area * 5, 5, 2e-5});
  // u is the second corner's weight: it is below 1/2 in three quarters of the area.
  Scene textures = empty_scene();
  SceneMaterial material = textured_lamp(textures, 5, AlphaMode::opaque, 1);
  list.push_back({"textured triangle", lamp(material, textures), pi * area * 5 * 0.75, 5, 0});
  textures = empty_scene();
  material = textured_lamp(textures, 5, AlphaMode::blend, 0.25f);
  list.push_back({"BLEND triangle", lamp(two_sided(material), textures), 2 * pi * area * 5 * 0.75 * 0.25, 5, 0});
  // MASK by the alpha of a texture: there where u is below 1/2.
  textures = empty_scene();
  textures.images.push_back({"half a hole", 2, 1, {255, 255, 255, 255, 255, 255, 255, 0}});
  textures.textures.push_back({0, Wrap::clamp, Wrap::clamp, true, true});
  material = emitter(5);
  material.alpha_mode = AlphaMode::mask;
  material.base_color_texture.texture = 0;
  list.push_back({"MASK triangle", lamp(material, textures), pi * area * 5 * 0.75, 5, 0});

  Scene sky = empty_scene();
  add_bounds(sky, 1);
  set_environment(sky, 2);
  list.push_back({"constant environment", sky, pi * radius * radius * 4 * pi * 2, 2, 2e-5});
  Scene map = environment_scene();
  add_bounds(map, 1);
  list.push_back({"environment map", map, pi * radius * radius * environment_power(*map.environment), 0, 0});
  return list;
}

}  // namespace

TEST_CASE("emission carries the power of every kind of light, and its densities are found again") {
  const uint n = full_run() ? 1u << 20 : 1u << 15;
  ClosedForms table;
  for (const Case& c : cases()) {
    CAPTURE(c.name);
    const SceneBuffers buffers(*test_device(), c.scene);
    const Emissions e = emit(buffers, n);
    const Estimate flux = interleaved_estimate(n, [&](size_t i) { return e.fluxes[i].y; });
    if (c.precision > 0)
      CHECK(flux.mean == test::relative(c.power, c.precision));
    else
      table.add(c.name, flux, c.power);
    const Light light = buffers.scene_lights.download().front();
    uint64_t different = 0, other_light = 0;
    for (uint i = 0; i < n; ++i) {
      const double sent = double{e.fluxes[i].y} * e.fluxes[i].w * e.origins[i].w * e.directions[i].w;
      const double expected = sent_light(c, light, e.directions[i].xyz());
      // The narrow spot's ramp rises by up to 900 times the brightness per unit of the cosine, of which the device's
      // float leaves 1e-7 or two.
      const double bound = std::max(1e-4, c.precision) * c.brightness;
      if (c.precision > 0) other_light += !(std::abs(sent - expected) <= bound);
      const float found[] = {e.pdfs[i].x, e.pdfs[i].y, e.pdfs[i].z},
                  drawn[] = {e.fluxes[i].w, e.origins[i].w, e.directions[i].w};
      for (int k = 0; k < 3; ++k) different += !(std::abs(found[k] - drawn[k]) <= 2e-3f * drawn[k]);
    }
    CHECK(different <= n / 2000);  // directions on the edge of a texel may fall on its other side
    CHECK(other_light == 0);
  }
  table.check(5e-3);
}

TEST_CASE("all lights at once have the sum of their powers, and kinds can be left out") {
  Scene scene = empty_scene();
  add_bounds(scene, 1);
  add_triangle(scene, two_sided(emitter(5)), lamp_a, lamp_b, lamp_c);
  scene.lights = {light_at(LightType::point, glm::vec3(3)), light_at(LightType::spot, glm::vec3(30)),
                  light_at(LightType::directional, glm::vec3(1))};
  set_environment(scene, 0.5f);
  const SceneBuffers buffers(*test_device(), scene);
  const double disc = pi * std::pow(double{buffers.info().bounds_max.w}, 2);
  const double lamp = 5 * pi * double{glm::length(glm::cross(lamp_b - lamp_a, lamp_c - lamp_a))};
  const double punctual = 4 * pi * 3 + .533211 * 30 + disc;
  const uint n = full_run() ? 1u << 20 : 1u << 16;
  ClosedForms table;
  const Emissions all = emit(buffers, n), some = emit(buffers, n, 7u);
  table.add("all", interleaved_estimate(n, [&](size_t i) { return all.fluxes[i].y; }),
            punctual + lamp + disc * 4 * pi * 0.5);
  table.add("punctual", interleaved_estimate(n, [&](size_t i) { return some.fluxes[i].y; }), punctual);
  table.check(2e-3);
}

namespace {

/// Every texel is chosen as often as its density says (scene_buffers.h), and its light comes out of it.
void check_texels(const Environment& map, const SceneBuffers& buffers, const Emissions& e) {
  const std::vector<float4> texels = buffers.scene_environment.download();
  std::vector<uint64_t> observed(texels.size());
  std::vector<double> expected;
  for (const float4& direction : e.directions) {
    const glm::dvec3 d = glm::dmat3(map.environment_from_world) * -glm::dvec3(direction.xyz());
    const double u = 0.5 + std::atan2(d.z, d.x) / (2 * pi), v = std::acos(std::clamp(d.y, -1.0, 1.0)) / pi;
    ++observed[std::min(static_cast<uint32_t>(v * map.height), map.height - 1) * map.width +
               std::min(static_cast<uint32_t>(u * map.width), map.width - 1)];
  }
  for (const float4& texel : texels)
    expected.push_back(double{texel.w} * static_cast<double>(e.directions.size()) / static_cast<double>(texels.size()));
  const Chi2Result result = chi2_test(observed, expected);
  CHECK(result.stray < e.directions.size() / 5000);  // on the edge of a texel
  CHECK(result.p >= sidak(0.01, 18));
}

}  // namespace

TEST_CASE("emission follows its densities") {
  constexpr int columns = 32, rows = 64;
  const uint n = full_run() ? 1u << 20 : 1u << 17;
  const auto azimuth = [](double x, double y) {
    const double turns = std::atan2(y, x) / (2 * pi);
    return turns < 0 ? turns + 1 : turns;
  };
  /// Observed (a, b) of [0, 1]^2 against P([0, a] x [0, b]) = cumulative(a) b.
  const auto check = [&](const std::function<glm::dvec2(uint)>& place,
                         const std::function<double(double)>& cumulative) {
    std::vector<uint64_t> observed(columns * rows);
    for (uint i = 0; i < n; ++i) {
      const glm::dvec2 p = place(i);
      const int x = std::clamp(static_cast<int>(p.x * columns), 0, columns - 1);
      const int y = std::clamp(static_cast<int>(p.y * rows), 0, rows - 1);
      ++observed[x * rows + y];
    }
    std::vector<double> expected;
    for (int x = 0; x < columns; ++x)
      for (int y = 0; y < rows; ++y)
        expected.push_back((cumulative((x + 1.0) / columns) - cumulative(double(x) / columns)) * n / rows);
    const Chi2Result result = chi2_test(observed, expected);
    CHECK(result.stray == 0);
    CHECK(result.p >= sidak(0.01, 18));
  };
  const auto linear = [](double a) { return a; };
  for (const Case& c : cases()) {
    CAPTURE(c.name);
    const SceneBuffers buffers(*test_device(), c.scene);
    const Emissions e = emit(buffers, n);
    const Light light = buffers.scene_lights.download().front();
    // Directions about the light's axis, its triangle's front, or the z axis.
    glm::dvec3 axis(0, 0, 1);
    if (light.kind == LUCARIUM_LIGHT_SPOT) axis = glm::dvec3(light.direction.xyz());
    if (light.kind == LUCARIUM_LIGHT_TRIANGLE) axis = glm::dvec3(lamp_normal);
    const glm::dvec3 x = glm::normalize(glm::cross(axis, glm::dvec3(0.3, 1, 0.2))), y = glm::cross(axis, x);
    const auto turned = [&](uint i) {
      const glm::dvec3 d(e.directions[i].xyz());
      return glm::dvec3(glm::dot(d, x), glm::dot(d, y), glm::dot(d, axis));
    };
    const auto zonal = [&](uint i) {
      const glm::dvec3 d = turned(i);
      return glm::dvec2(0.5 * (1 - d.z), azimuth(d.x, d.y));
    };
    const double radius = double{buffers.info().bounds_max.w};
    const auto on_disc = [&](uint i) {
      const glm::dvec3 d(e.directions[i].xyz()), t = glm::normalize(glm::cross(d, glm::dvec3(0.9, 0.1, 0.3))),
                                                 p = glm::dvec3(e.origins[i].xyz()) / radius + d;
      return glm::dvec2(glm::dot(p, p), azimuth(glm::dot(p, t), glm::dot(p, glm::cross(d, t))));
    };
    if (light.kind == LUCARIUM_LIGHT_POINT) {
      check(zonal, linear);
    } else if (light.kind == LUCARIUM_LIGHT_SPOT) {
      // Over the cone alone: a of [0, 1] is (1 - c) / (1 - c_o).
      const SceneLight& spot = c.scene.lights[0];
      const double outer = std::cos(double{spot.outer_angle}),
                   width = std::max(0.001, std::cos(double{spot.inner_angle}) - outer);
      const auto missing = [&](double cosine) {  // intensity beyond 1 - c, over 2 pi
        const double top = std::min(outer + width, 1.0), low = std::min(cosine, top);
        return std::max(cosine - top, 0.0) + (std::pow(low - outer, 3)) / (3 * width * width);
      };
      check([&](uint i) { return glm::dvec2((1 - turned(i).z) / (1 - outer), zonal(i).y); },
            [&](double a) { return 1 - missing(1 - a * (1 - outer)) / missing(1); });
    } else if (light.kind == LUCARIUM_LIGHT_TRIANGLE) {
      const bool sides = c.name == "two-sided triangle" || c.name == "BLEND triangle";
      check(zonal, [&](double a) {
        const double z = 1 - 2 * a, front = 1 - z * z;  // both hemispheres weigh the same
        return sides ? (z > 0 ? 0.5 * front : 1 - 0.5 * front) : z > 0 ? front : 1.0;
      });
      check(
          [&](uint i) {
            const double u = double{e.weights[i].x}, v = double{e.weights[i].y}, sum = u + v;
            return glm::dvec2(sum * sum, sum > 0 ? u / sum : 0);
          },
          linear);
    } else {
      check(on_disc, linear);
      if (c.name == "constant environment") check(zonal, linear);
      if (c.name == "environment map") check_texels(*c.scene.environment, buffers, e);
    }
  }
}

TEST_CASE("emission brings to a receiver what light samples find there") {
  // A square of edge 2 at z = -1 that faces up (from below: nothing). Both are estimates, by other code each.
  const uint n = full_run() ? 1u << 20 : 1u << 17;
  ClosedForms table;
  for (const Case& c : cases()) {
    if (c.name == "narrow spot") continue;  // all of it misses the square or meets it
    CAPTURE(c.name);
    const SceneBuffers buffers(*test_device(), c.scene);
    const Emissions e = emit(buffers, n);
    const auto caught = interleaved_estimate(n, [&](size_t i) {
      const glm::dvec3 o(e.origins[i].xyz()), d(e.directions[i].xyz());
      const double t = (-1 - o.z) / d.z;
      const glm::dvec3 p = o + t * d;
      return d.z < 0 && t > 0 && std::abs(p.x) < 1 && std::abs(p.y) < 1 ? double{e.fluxes[i].y} : 0.0;
    });
    constexpr uint cells = 24;
    const auto values = test_buffer<float>(cells * cells);
    run_kernel(emission_program(), "light_receiver", cells * cells, 64, [&](PassBuilder& pass) {
      buffers.bind(pass);
      pass.arg("cells", cells).arg("samples", 512u).arg("values", values);
    });
    double flux = 0;
    for (const float value : values.download()) flux += double{value} * 4 / (cells * cells);
    table.add(c.name, caught, flux, 4e-3 * flux);  // what the cells and the light samples leave
  }
  table.check(1e-2);
}

TEST_CASE("directions of spots can be mapped back") {
  for (const float inner : {0.f, 0.3f, 0.9999f}) {
    Scene scene = punctual_scene(LightType::spot, glm::vec3(1));
    scene.lights[0].outer_angle = 0.8f;
    scene.lights[0].inner_angle = inner * 0.8f;
    const SceneBuffers buffers(*test_device(), scene);
    const uint n = 1 << 14;
    const auto squares = test_buffer<float2>(n), inverses = test_buffer<float2>(n);
    const auto directions = test_buffer<float4>(n);
    run_kernel(emission_program(), "sample_spots", n, 64, [&](PassBuilder& pass) {
      buffers.bind(pass);
      pass.arg("count", n).arg("squares", squares).arg("directions", directions).arg("inverses", inverses);
    });
    const auto s = squares.download(), inverse = inverses.download();
    double worst = 0;
    for (uint i = 0; i < n; ++i) {
      double dy = std::abs(double(inverse[i].y) - s[i].y);
      dy = std::min(dy, 1 - dy) * std::min(1.0, 20 * std::sqrt(double{s[i].x}));  // few digits at the axis
      worst = std::max({worst, std::abs(double(inverse[i].x) - s[i].x), dy});
    }
    CHECK(worst < 2e-5);
  }
}
