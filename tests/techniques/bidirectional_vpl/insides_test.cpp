// SPDX-License-Identifier: Apache-2.0
// What inspect() reports of a pixel: light vertices, what they bring, and what each strategy has brought.
#include <algorithm>
#include <cstdio>

#include "bidirectional_rig.h"
#include "made_scene.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

std::string value_of(const InspectedValues& rows, const std::string& name) {
  for (const auto& [row, text] : rows)
    if (row == name) return text;
  return {};
}

struct Inspection {
  Inspection(const Scene& scene, uint64_t seed, const Parameters& parameters, int max_bounces = 3)
      : session(test_device(), scene, registry().find("bidirectional_vpl"), settings_of(scene, seed, max_bounces),
                parameters) {
    session.run({.iterations = 2});
  }
  static RenderSettings settings_of(const Scene& scene, uint64_t seed, int max_bounces) {
    RenderSettings settings;
    settings.width = settings.height = 16;
    settings.max_bounces = max_bounces;
    settings.seed = seed;
    settings.camera = scene.cameras.front();
    return settings;
  }
  RenderSession session;
};

/// The point in the middle of a triangle of the first mesh, whose instance has not moved.
SeenPoint middle_of(const Scene& scene, uint32_t triangle, uint32_t x, uint32_t y) {
  const Mesh& mesh = scene.meshes.front();
  const glm::uvec3 corners = mesh.triangles.at(triangle);
  const glm::vec3 a = mesh.positions.at(corners.x), b = mesh.positions.at(corners.y), c = mesh.positions.at(corners.z);
  SeenPoint point;
  point.x = x;
  point.y = y;
  point.triangle = triangle;
  point.b1 = point.b2 = 1 / 3.f;
  point.position = (a + b + c) / 3.f;
  point.normal = glm::normalize(glm::cross(b - a, c - a));
  return point;
}

}  // namespace

TEST_CASE("inspect(): in a sphere, all light vertices face each point and bring it the sum of albedo^k I / R^2") {
  const float albedo = 0.6f;
  const Scene scene = sphere_room(albedo, {0.9f, 0.2f, -0.4f});
  ClosedForms table;
  for (const uint32_t triangle : {0u, 777u, 2024u}) {
    std::vector<double> light;
    for (uint64_t seed = 1; seed <= 8; ++seed) {
      Inspection inspection(scene, seed, {{"strategy", "vpl"}, {"light_paths", "512"}, {"light_vertices", "3"}});
      const InspectedValues rows = inspection.session.technique().inspect(middle_of(scene, triangle, 3, 4));
      unsigned there = 0, paths = 0, facing = 0;
      CAPTURE(value_of(rows, "light vertices"));
      REQUIRE(std::sscanf(value_of(rows, "light vertices").c_str(), "%u of %u light paths, %u", &there, &paths,
                          &facing) == 3);
      CHECK(paths == 512);
      CHECK(there > 512);
      CHECK(facing + 2 >= there);  // those of its own facet lie in its plane
      light.push_back(std::stod(value_of(rows, "they bring at most")));
      // Each brings what it reflects over 4 pi R^2, in a sphere; the strongest is one beside the point, where facets do
      // not bend as the sphere does. First vertices reflect most. Places are written with four digits.
      unsigned number = 0;
      float x = 0, y = 0, z = 0, distance = 0, reflected = 0, brought = 0;
      CAPTURE(value_of(rows, "the strongest"));
      REQUIRE(std::sscanf(value_of(rows, "the strongest").c_str(),
                          "vertex %u of its path, at %f, %f, %f m, %f m away: reflects %f lm, brings %f lx", &number,
                          &x, &y, &z, &distance, &reflected, &brought) == 7);
      CHECK(number == 1);
      CHECK(glm::length(glm::vec3(x, y, z)) == relative(2, 0.003));
      CHECK(glm::distance(glm::vec3(x, y, z), middle_of(scene, triangle, 3, 4).position) == within(distance, 0.001));
      CHECK(reflected == relative(albedo * 4 * M_PI / 512, 1e-3));
      const double of_sphere = static_cast<double>(reflected) / (16 * M_PI);
      CHECK(static_cast<double>(brought) > 0.98 * of_sphere);
      CHECK(static_cast<double>(brought) < 2.5 * of_sphere);
    }
    double expected = 0;
    for (int k = 1; k <= 3; ++k) expected += std::pow(double{albedo}, k) / 4;
    table.add("triangle " + std::to_string(triangle), estimate_of(light), expected, 4e-3 * expected);
  }
  table.check(0.01);
}

TEST_CASE("inspect(): a light path of its own is all that a pixel has") {
  const Scene scene = sphere_room(0.6f, glm::vec3(0));
  Inspection inspection(scene, 1, {{"strategy", "vpl"}, {"vpl_choice", "own"}, {"light_vertices", "3"}});
  const InspectedValues rows = inspection.session.technique().inspect(middle_of(scene, 99, 3, 4));
  CHECK(value_of(rows, "light vertices").find(" of its light path, ") != std::string::npos);
  CHECK(std::stoul(value_of(rows, "light vertices")) <= 3);
  CHECK(value_of(rows, "samples in the weights") == "each vpl 1; balance heuristic");
}

TEST_CASE("inspect(): the strategies at a pixel are its layers, and their shares are all of its light") {
  const Scene scene = load_scene("builtin:cornell-mirror");
  Inspection inspection(scene, 1, {{"show_strategies", "on"}, {"light_vertices", "3"}});
  const Film film = inspection.session.resolve();
  const std::vector<float>& connected = film.find("vpl1")->pixels;
  const auto brightest =
      static_cast<uint32_t>(std::max_element(connected.begin(), connected.end()) - connected.begin()) / 3;
  const SeenPoint point = middle_of(scene, 0, brightest % 16, brightest / 16);
  const InspectedValues rows = inspection.session.technique().inspect(point);
  double shares = 0;
  for (const char* const strategy : {"hit", "nee", "vpl1", "vpl2", "vpl3", "splat"}) {
    CAPTURE(strategy);
    float r = -1, g = -1, b = -1, share = -1;
    REQUIRE(std::sscanf(value_of(rows, std::string("by ") + strategy).c_str(), "%f  %f  %f cd/m², %f %%", &r, &g, &b,
                        &share) == 4);
    const float* const pixel = &film.find(strategy)->pixels[3 * (size_t{point.y} * 16 + point.x)];
    CHECK(r == relative(pixel[0], 0.001));
    CHECK(g == relative(pixel[1], 0.001));
    CHECK(b == relative(pixel[2], 0.001));
    shares += static_cast<double>(share);
  }
  CHECK(shares == relative(100, 0.01));
  CHECK(value_of(rows, "samples in the weights").starts_with("hit 1, nee 1, each vpl "));
  CHECK(value_of(rows, "samples in the weights").find("splat 32") != std::string::npos);
}

TEST_CASE("inspect(): without bounces there are no light vertices, and no layers of strategies without their option") {
  Inspection inspection(load_scene("builtin:cornell"), 1, {}, 0);
  const InspectedValues rows = inspection.session.technique().inspect({});
  CHECK(value_of(rows, "strategies") == "show_strategies=on shows what each brings here");
  CHECK(value_of(rows, "samples in the weights") == "hit 1, nee 1; balance heuristic");
  CHECK(value_of(rows, "light vertices").empty());
}
