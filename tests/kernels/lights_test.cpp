// SPDX-License-Identifier: Apache-2.0
// kernels/lights.clh, environment.clh: samples follow their densities, densities agree with those of met light, closed
// forms of illuminance, sides and kinds.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "chi2.h"
#include "kernel_fixture.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr double pi = std::numbers::pi;
constexpr uint replicates = 16;
constexpr uint all_kinds = 31;

const Program& program() {
  static const Program instance = kernel_program("lights");
  return instance;
}

SceneMaterial emitter(float radiance, bool double_sided = false) {
  SceneMaterial m;
  m.base_color = glm::vec4(0, 0, 0, 1);
  m.metallic = 0;
  m.emissive_factor = glm::vec3(1);
  m.emissive_strength = radiance;
  m.double_sided = double_sided;
  return m;
}

void add_triangle(Scene& scene, const SceneMaterial& material, const glm::vec3& a, const glm::vec3& b,
                  const glm::vec3& c) {
  Mesh mesh;
  mesh.positions = {a, b, c};
  mesh.normals.assign(3, glm::normalize(glm::cross(b - a, c - a)));
  mesh.uv[0] = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  SceneInstance instance;
  instance.mesh = static_cast<int>(scene.meshes.size());
  instance.material = static_cast<int>(scene.materials.size());
  scene.meshes.push_back(mesh);
  scene.materials.push_back(material);
  scene.instances.push_back(instance);
}

Scene empty_scene() {
  Scene scene;
  scene.source = "test";
  return scene;
}

/// 32 x 16 texels, many black, one 3000 times the others, turned in all axes.
Scene environment_scene() {
  Scene scene = empty_scene();
  Environment e;
  e.width = 32, e.height = 16;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (uint32_t i = 0; i < e.width * e.height; ++i) {
    const uint32_t column = i % e.width, row = i / e.width;
    const bool black = (column > 8 && column < 17) || (row > 10 && column < 22) || row < 2;
    e.radiance.push_back(black ? glm::vec3(0) : glm::vec3(uniform(random), uniform(random), uniform(random)));
  }
  e.radiance[5 * e.width + 27] = glm::vec3(3000, 2000, 1000);
  e.factor = glm::vec3(1, 2, 0.5f);
  e.environment_from_world = glm::mat3(glm::mat4_cast(glm::normalize(glm::quat(0.8f, 0.3f, -0.4f, 0.2f))));
  scene.environment = e;
  return scene;
}

/// A single-sided triangle above the origin, its black back on another side of it, and a double-sided one seen from
/// its back.
Scene triangle_scene() {
  Scene scene = empty_scene();
  add_triangle(scene, emitter(2), {-1, -1, 2}, {0.5f, 1.5f, 2}, {1.5f, -1, 2.5f});
  add_triangle(scene, emitter(1, true), {3, -1, -0.5f}, {3, 1.5f, -0.8f}, {2, -0.5f, -2});
  add_triangle(scene, emitter(3), {-3, 1, -1}, {-3, -1, 1}, {-3, -1, -1});
  return scene;
}

struct LightSamples {
  std::vector<float4> directions, radiances, ends;
};

LightSamples sample(const SceneBuffers& buffers, const glm::vec3& position, uint count, uint kinds = all_kinds,
                    uint seed = 1) {
  const auto directions = test_buffer<float4>(count), radiances = test_buffer<float4>(count),
             ends = test_buffer<float4>(count);
  run_kernel(program(), "sample_lights", count, 64, [&](PassBuilder& pass) {
    buffers.bind(pass, program(), "sample_lights");
    pass.arg("position", float4(position, 0.f)).arg("kinds", kinds).arg("seed", seed).arg("count", count);
    pass.arg("directions", directions).arg("radiances", radiances).arg("ends", ends);
  });
  return {directions.download(), radiances.download(), ends.download()};
}

/// Radiance (xyz) and density (w) met along the directions from a point.
std::vector<float4> meet(const SceneBuffers& buffers, const glm::vec3& position,
                         const std::vector<float4>& directions) {
  const auto rays = test_buffer(directions), values = test_buffer<float4>(directions.size());
  run_kernel(program(), "meet_lights", directions.size(), 64, [&](PassBuilder& pass) {
    buffers.bind(pass, program(), "meet_lights");
    pass.arg("position", float4(position, 0.f)).arg("directions", rays);
    pass.arg("count", static_cast<uint>(directions.size())).arg("values", values);
  });
  return values.download();
}

std::vector<float4> illuminate(const SceneBuffers& buffers, const std::vector<float4>& positions) {
  const auto points = test_buffer(positions), values = test_buffer<float4>(positions.size());
  run_kernel(program(), "illuminate_points", positions.size(), 64, [&](PassBuilder& pass) {
    buffers.bind(pass, program(), "illuminate_points");
    pass.arg("positions", points).arg("count", static_cast<uint>(positions.size())).arg("values", values);
  });
  return values.download();
}

/// Checks the mean of radiance cos / pdf (green; normal +z) against the exact illuminance: 16 replicates.
void check_illuminance(const LightSamples& samples, double exact) {
  double sums[replicates] = {}, mean = 0, variance = 0;
  const size_t n = samples.directions.size();
  for (size_t i = 0; i < n; ++i) {
    const float4 d = samples.directions[i];
    if (d.w > 0 && d.z > 0)
      sums[i % replicates] += double(samples.radiances[i].y) * d.z / d.w / (double(n) / replicates);
  }
  for (const double sum : sums) mean += sum / replicates;
  for (const double sum : sums) variance += (sum - mean) * (sum - mean) / (replicates - 1);
  const double error = std::sqrt(variance / replicates);
  CAPTURE(mean);
  CAPTURE(exact);
  CHECK(std::abs(mean - exact) <= 5 * error + 2e-4 * exact);
  CHECK(error <= 5e-4 * exact + 1e-9);
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

TEST_CASE("light samples follow the density with which met light is weighted") {
  const int columns = full_run() ? 101 : 32, rows = full_run() ? 202 : 64;
  const uint n = full_run() ? 1u << 20 : 1u << 17;
  const std::pair<Scene, glm::vec3> cases[] = {{environment_scene(), glm::vec3(0)},
                                               {triangle_scene(), glm::vec3(0)},
                                               {triangle_scene(), glm::vec3(0.5f, 0.2f, 0.7f)}};
  for (const auto& [scene, position] : cases) {
    const SceneBuffers buffers(kernel_device(), scene);
    const auto masses = test_buffer<float>(columns * rows);
    run_kernel(program(), "integrate_light_density", columns * rows, 1, [&](PassBuilder& pass) {
      buffers.bind(pass, program(), "integrate_light_density");
      pass.arg("position", float4(position, 0.f)).arg("columns", static_cast<uint>(columns));
      pass.arg("rows", static_cast<uint>(rows)).arg("masses", masses);
    });
    const LightSamples samples = sample(buffers, position, n);
    const std::vector<float4> met = meet(buffers, position, samples.directions);
    std::vector<uint64_t> observed(columns * rows);
    uint64_t different_density = 0, different_light = 0, lost = 0;
    for (uint i = 0; i < n; ++i) {
      const float4 d = samples.directions[i];
      if (!(d.w > 0)) {
        ++lost;
        continue;
      }
      const double turns = std::atan2(double(d.y), double(d.x)) / (2 * pi);
      const int a = std::clamp(static_cast<int>((1 - double(d.z)) * 0.5 * columns), 0, columns - 1);
      const int b = std::clamp(static_cast<int>((turns < 0 ? turns + 1 : turns) * rows), 0, rows - 1);
      ++observed[a * rows + b];
      different_density += !(std::abs(met[i].w - d.w) <= 2e-3f * d.w);
      const float green = samples.radiances[i].y;
      different_light += !(std::abs(met[i].y - green) <= 2e-3f * green + 1e-4f);
    }
    CHECK(lost == 0);
    // Directions on the edge of a texel or triangle may fall on its other side.
    CHECK(different_density <= n / 2000);
    CHECK(different_light <= n / 2000);
    double total = 0;
    std::vector<double> expected;
    for (const float mass : masses.download()) total += mass, expected.push_back(mass);
    CHECK(total == test::relative(1, 2e-3));
    for (double& e : expected) e *= n / total;
    const Chi2Result result = chi2_test(observed, expected);
    CHECK(result.stray == 0);
    CHECK(result.p >= sidak(0.01, 3));
  }
}

TEST_CASE("the environment is looked up as its definition says") {
  // No peak, whose slope would need more digits than a direction has, and one colour at the pole, which has no azimuth.
  Scene scene = environment_scene();
  for (uint32_t i = 0; i < 32; ++i) scene.environment->radiance[15 * 32 + i] = glm::vec3(0.3f);
  scene.environment->radiance[5 * 32 + 27] = glm::vec3(3, 2, 1);
  const SceneBuffers buffers(kernel_device(), scene);
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
  run_kernel(program(), "lookup_environment", directions.size(), 64, [&](PassBuilder& pass) {
    buffers.bind(pass, program(), "lookup_environment");
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
    const SceneBuffers buffers(kernel_device(), scene);
    const auto values = illuminate(buffers, points);
    for (int i = 0; i < 4; ++i)
      CHECK(values[i].y * values[i].w * 0.5 / pi == test::relative(expected[i], 1e-5));
  }
  scene.lights[0].type = LightType::directional;
  {
    const SceneBuffers buffers(kernel_device(), scene);
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
  const SceneBuffers buffers(kernel_device(), scene);
  const auto values = illuminate(buffers, points);
  double flux = 0;
  for (int i = 0; i < n; ++i) flux += double(values[i].y) * 2 * pi * std::sin(pi * (i + 0.5) / n) * pi / n;
  CHECK(flux == test::relative(.533211, 1e-4));
}

TEST_CASE("illuminance of a square light, from one and from two sides, and of environments") {
  const uint n = full_run() ? 1u << 18 : 1u << 15;
  for (const bool double_sided : {false, true}) {
    Scene scene = empty_scene();
    const float h = 0.5f;
    add_triangle(scene, emitter(1, double_sided), {-h, -h, 1}, {-h, h, 1}, {h, h, 1});
    add_triangle(scene, emitter(1, double_sided), {-h, -h, 1}, {h, h, 1}, {h, -h, 1});
    const SceneBuffers buffers(kernel_device(), scene);
    check_illuminance(sample(buffers, {0, 0, 0}, n), .752275);
    check_illuminance(sample(buffers, {.5f, .5f, 0}, n), .435210);
    check_illuminance(sample(buffers, {2, 0, 0}, n), .0437426);
    // From behind: turn the normal over, since check_illuminance faces +z.
    LightSamples behind = sample(buffers, {0, 0, 2}, n);
    for (float4& d : behind.directions) d.z = -d.z;
    check_illuminance(behind, double_sided ? .752275 : 0);
  }
  Scene scene = empty_scene();
  scene.environment = Environment{};
  scene.environment->factor = glm::vec3(2);
  check_illuminance(sample(SceneBuffers(kernel_device(), scene), glm::vec3(0), n), 2 * pi);
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
  check_illuminance(sample(SceneBuffers(kernel_device(), scene), glm::vec3(0), 8 * n), exact);
}

TEST_CASE("shadow rays end in front of the light's surface") {
  const SceneBuffers buffers(kernel_device(), triangle_scene());
  const auto triangles = buffers.scene_triangles.download();
  const auto vertices = buffers.scene_vertices.download();
  const LightSamples samples = sample(buffers, glm::vec3(0), 4096);
  for (size_t i = 0; i < samples.ends.size(); ++i) {
    double nearest = 1e30;
    for (const Triangle& t : triangles) {
      const glm::dvec3 a(vertices[t.v0].position.xyz()), b(vertices[t.v1].position.xyz()),
          c(vertices[t.v2].position.xyz());
      const glm::dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
      // Height of the end over the plane, positive on the origin's side; only of the plane it belongs to.
      const double height =
          glm::dot(glm::dvec3(samples.ends[i].xyz()) - a, normal) * (glm::dot(-a, normal) > 0 ? 1 : -1);
      if (std::abs(height) < std::abs(nearest)) nearest = height;
    }
    REQUIRE(nearest > 0);
    REQUIRE(nearest < 1e-3);
  }
}

// A float's 24 bits leave 64 places inside each of 2^18 columns; these intensities put the alias threshold where rounding to
// them favoured the dim light by 3 %.
TEST_CASE("dim lights among a quarter of a million are chosen no more often than the table says") {
  Scene scene = triangle_scene();
  scene.lights.resize(1 << 18);
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    scene.lights[i].intensity = glm::vec3(i % 2 ? 1.0f : 9.766f);
    scene.lights[i].world_from_light[3] = glm::vec4(0, 0, 1, 1);
  }
  const SceneBuffers buffers(kernel_device(), scene);
  const uint n = 1 << 22;
  const auto lights = test_buffer<uint>(n);
  run_kernel(program(), "choose_lights_at_random", n, 64, [&](PassBuilder& pass) {
    buffers.bind(pass, program(), "choose_lights_at_random");
    pass.arg("count", n).arg("lights", lights);
  });
  const auto table = buffers.scene_light_table.download();
  const auto is_dim = [&](uint light) { return table[light].pmf < 1.0f / static_cast<float>(table.size()); };
  const double threshold = 64.0 * table[scene.lights.size() - 1].probability;
  REQUIRE(threshold - std::floor(threshold) < 0.25);
  double expected = 0, chosen = 0;
  for (uint i = 0; i < table.size(); ++i) expected += is_dim(i) ? table[i].pmf : 0;
  for (const uint light : lights.download()) chosen += is_dim(light) ? 1 : 0;
  REQUIRE(expected > 0.05);
  REQUIRE(expected < 0.5);
  const double standard_error = std::sqrt(expected * (1 - expected) / n);
  CHECK(std::abs(chosen / n - expected) < 4 * standard_error);
}

TEST_CASE("lights are chosen as the table says; kinds can be left out") {
  Scene scene = triangle_scene();
  SceneLight light;
  light.intensity = glm::vec3(30);
  light.world_from_light[3] = glm::vec4(0, 0, 1, 1);
  scene.lights = {light};
  scene.environment = Environment{};
  const SceneBuffers buffers(kernel_device(), scene);
  const uint n = 1 << 16;
  const auto lights = test_buffer<uint>(n);
  const auto pmfs = test_buffer<float>(n);
  run_kernel(program(), "choose_lights", n, 64, [&](PassBuilder& pass) {
    buffers.bind(pass, program(), "choose_lights");
    pass.arg("count", n).arg("lights", lights).arg("pmfs", pmfs);
  });
  const auto table = buffers.scene_light_table.download();
  const auto chosen = lights.download();
  const auto pmf = pmfs.download();
  REQUIRE(buffers.info().light_count == 5);
  std::vector<double> share(5);
  for (uint i = 0; i < n; ++i) {
    share[chosen[i]] += 1.0 / n;
    REQUIRE(pmf[i] == table[chosen[i]].pmf);
  }
  for (int i = 0; i < 5; ++i) CHECK(share[i] == test::relative(table[i].pmf, 1e-3));

  const LightSamples no_triangles = sample(buffers, glm::vec3(0), 4096, all_kinds & ~(1u << LUCARIUM_LIGHT_TRIANGLE));
  const LightSamples punctual_only = sample(buffers, glm::vec3(0), 4096, 1u << LUCARIUM_LIGHT_POINT);
  uint punctual = 0, infinite = 0, finite_area = 0, others = 0;
  for (size_t i = 0; i < 4096; ++i) {
    const int flags = static_cast<int>(no_triangles.radiances[i].w);
    if (no_triangles.directions[i].w > 0) ++(flags == 1 ? punctual : flags == 2 ? infinite : finite_area);
    others += punctual_only.directions[i].w > 0 && static_cast<int>(punctual_only.radiances[i].w) != 1;
  }
  CHECK(punctual > 0);
  CHECK(infinite > 0);
  CHECK(finite_area == 0);
  CHECK(others == 0);
}

TEST_CASE("what surfaces emit: sides, unlit, textures, coverage") {
  Scene scene = empty_scene();
  scene.images.push_back({"two texels", 2, 1, {255, 255, 255, 255, 0, 0, 0, 255}});
  scene.textures.push_back({0, Wrap::clamp, Wrap::clamp, true, true});
  SceneMaterial unlit = emitter(0), textured = emitter(4), blended = emitter(4);
  unlit.unlit = true, unlit.emissive_factor = glm::vec3(0), unlit.base_color = glm::vec4(0.25f, 0.5f, 1, 1);
  textured.emissive_texture.texture = 0;
  blended.alpha_mode = AlphaMode::blend, blended.base_color.a = 0.25f;
  const SceneMaterial materials[] = {emitter(2), emitter(2, true), unlit, textured, blended};
  // Five triangles side by side at z = 1 that face the points below them.
  const auto place = [](int i) { return 3 * static_cast<float>(i); };
  for (int i = 0; i < 5; ++i) {
    add_triangle(scene, materials[i], {place(i), 0, 1}, {place(i), 1, 1}, {place(i) + 1, 0, 1});
  }
  const SceneBuffers buffers(kernel_device(), scene);
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
  const LightSamples samples = sample(SceneBuffers(kernel_device(), alone), {0.2f, 0.2f, 0}, 64);
  CHECK(samples.radiances[0].y == test::relative(1));
}
