// SPDX-License-Identifier: Apache-2.0
// A closed box of emission 1 whose walls have GGX lobes only.
//
// The field that comes to its walls first is 1 from everywhere. What a wall reflects of it towards a direction at the
// cosine μ to its normal is then its directional albedo, a(μ) = F0 (E1(μ) - B(μ)) + F90 B(μ), whatever the directions
// of the grid: cells hold that, and nothing else. Lines through the box leave its walls by cos θ dω dA as they arrive,
// so that the mean irradiance over pi of light scattered once is the cosine-weighted mean
//
//   Ē = ∫ a(μ) 2 μ dμ.
#include <doctest/doctest.h>

#include <cmath>

#include "field_rig.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/scene/device/specular_albedo.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using test::Options;
using test::relative;
using test::within;

namespace {

Scene shining_box(float reflectance, float roughness) {
  SceneMaterial metal = test::mirror(reflectance, roughness);
  metal.emissive_factor = glm::vec3(1);
  return test::unit_box({{0, metal}, {1, metal}, {2, metal}, {3, metal}, {4, metal}, {5, metal}});
}

/// a(μ), interpolated in the table as kernels/lucarium/specular_albedo.clh says; F0 the reflectance, F90 1.
double directional_albedo(double reflectance, double roughness, double mu) {
  constexpr int averages = 129, nodes = 32;
  static const std::vector<float> table = specular_albedo_table();
  const double y = roughness * (nodes - 1), x = std::sqrt(mu) * (nodes - 1);
  const int i = std::min(static_cast<int>(x), nodes - 2), j = std::min(static_cast<int>(y), nodes - 2);
  const auto value = [&](int which) {
    const auto row = [&](int r) {
      const auto at = [&](int column) {
        return static_cast<double>(table[static_cast<size_t>(2 * (averages + r * nodes + column) + which)]);
      };
      return std::lerp(at(i), at(i + 1), x - i);
    };
    return std::lerp(row(j), row(j + 1), y - j);
  };
  return reflectance * (value(0) - value(1)) + value(1);
}

double mean_albedo(double reflectance, double roughness) {
  constexpr int steps = 2000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double mu = (i + 0.5) / steps;
    sum += directional_albedo(reflectance, roughness, mu) * 2 * mu / steps;
  }
  return sum;
}

vlf::Parameters field(int dir_n) {
  vlf::Parameters parameters;
  parameters.dir_n = dir_n;
  parameters.cells = 32;
  parameters.texels = 1536;
  parameters.direct_mode = vlf::DirectMode::exchange;
  return parameters;
}

}  // namespace

TEST_CASE("in a shining box of metal every cell sends its lobe's albedo, and light scattered once has its mean") {
  struct Case {
    float roughness;
    int dir_n, levels;
  };
  for (const auto& [roughness, dir_n, levels] : {Case{0.3f, 6, 0}, Case{0.6f, 6, 0}, Case{0.95f, 12, 1}}) {
    CAPTURE(roughness);
    vlf::Parameters parameters = field(dir_n);
    parameters.dir_levels = levels;
    test::FieldRig rig(shining_box(0.8f, roughness), parameters, {.max_bounces = 1});
    rig.propagate(2);
    const double expected = mean_albedo(0.8, static_cast<double>(roughness)), found = [&] {
      double sum = 0;
      for (int wall = 0; wall < 6; ++wall) sum += rig.mean(rig.indirect(), wall) / 6;
      return sum;
    }();
    MESSAGE("roughness ", roughness, ": mean of one scattering ", found, ", expected ", expected);
    // With a level rays get what lies between the cells of three directions, 0.29 apart, and the albedo is convex.
    CHECK(found == relative(expected, levels > 0 ? 0.01 : 0.005));
    // Cells by direction and wall.
    const vlf::TileMaps& maps = rig.field().maps();
    const std::vector<FieldMap> all = maps.maps().download();
    const std::vector<uint32_t> tiles = maps.tile_cells().download(), direct = rig.field().direct().download();
    const vlf::Patches& patches = rig.surfaces().patches;
    for (const FieldFacet& facet : patches.facets) CHECK(facet.level == static_cast<uint32_t>(levels));
    const std::vector<Triangle> triangles = rig.buffers().scene_triangles.download();
    const std::vector<Vertex> vertices = rig.buffers().scene_vertices.download();
    uint64_t known = 0;
    double worst = 0;
    for (uint32_t facet = 0; facet < patches.facets.size(); ++facet) {
      const Triangle& t = triangles[patches.triangles[patches.facets[facet].first]];
      const glm::vec3 a = vertices[t.v0].position.xyz(), b = vertices[t.v1].position.xyz(),
                      c = vertices[t.v2].position.xyz(), normal = glm::normalize(glm::cross(b - a, c - a));
      for (uint32_t direction = 0; direction < 2 * maps.info().lines; ++direction) {
        const FieldMap& map = all[size_t{direction} * maps.info().facets + facet];
        const glm::vec3 omega = maps.host_lines()[direction / 2].omega.xyz();
        const auto mu = static_cast<double>(glm::dot(normal, direction & 1 ? -omega : omega));
        for (uint32_t entry = 0; entry < FIELD_MAP_WIDTH(map) * FIELD_MAP_HEIGHT(map); ++entry) {
          const uint32_t first = tiles[map.first + entry], m = FIELD_MAP_TILE(map);
          for (uint32_t k = 0; first != LUCARIUM_NONE && k < m * m; ++k) {
            const uint32_t bits = direct[first + k];
            if (bits == FIELD_NO_CELL) continue;
            ++known;
            const double value = static_cast<double>(bits & 511) * std::exp2(static_cast<double>(bits >> 27) - 24) /
                                 static_cast<double>(rig.field().scale());
            worst = std::max(worst, std::abs(value - directional_albedo(0.8, static_cast<double>(roughness), mu)));
          }
        }
      }
    }
    MESSAGE(known, " cells, farthest from the albedo by ", worst);
    CHECK(known > 10000);
    // Rounding: half of 1/256 of values from 1/2 to 1; the table is read in single precision.
    CHECK(worst < 0.5 / 256 + 1e-3);
  }
}

TEST_CASE("a shining box of metal after one and two bounces is path_tracing's") {
  Scene scene = shining_box(0.8f, 0.5f);
  scene.cameras.push_back(look_at_camera("inside", {0.3f, 0.6f, 0.8f}, {0.6f, 0.4f, 0.f}, 70.f));
  const Options options = {{"dir_n", "6"}, {"cells", "24"}, {"texels", "1536"}, {"preset", "walkthrough"}};
  for (const int bounces : {1, 2}) {
    CAPTURE(bounces);
    const auto paths = test::session(scene, bounces, {{"samples_per_iteration", "64"}}, "path_tracing");
    paths->run({.iterations = test::full_run() ? 64u : 8u});
    // eye_specular=vlf, of the preset, does not matter where nothing is ideal.
    const auto run = test::session(scene, bounces, options);
    run->finish_light();
    run->run({.samples = 16});
    const auto layer = [](RenderSession& session, const char* name) {
      return test::mean(session.resolve().find(name)->pixels);
    };
    for (const char* name : {"direct", "indirect"}) {
      CAPTURE(name);
      MESSAGE(bounces, " bounces, ", std::string(name), ": ", layer(*run, name), ", path traced ", layer(*paths, name));
      CHECK(layer(*run, name) == relative(layer(*paths, name), 0.015));
    }
  }
}

TEST_CASE("glass balls and slabs in a furnace change nothing outside of them") {
  // Walls of emission 1 and albedo 1/2: radiance is 2 everywhere, through clear glass too.
  const SceneMaterial wall = test::emitter(1, 0.5f);
  SceneMaterial glass = test::clear_glass();
  for (const bool ball : {true, false}) {
    CAPTURE(ball);
    Scene scene = test::unit_box({{0, wall}, {1, wall}, {2, wall}, {3, wall}, {4, wall}, {5, wall}});
    const int material = test::add_material(scene, glass);
    if (ball)
      test::add_triangles(scene, test::sphere_triangles({0.5f, 0.45f, 0.5f}, 0.3f, 3, false), material);
    else
      add_instance(scene, add_mesh(scene, MeshBuilder("slab").box({0.1f, 0.4f, 0.1f}, {0.9f, 0.6f, 0.9f}).take()),
                   material);
    vlf::Parameters parameters = field(test::full_run() ? 16 : 6);
    parameters.cells = test::full_run() ? 64 : 32;
    parameters.texels = 4096;
    parameters.residual = 0.001f;
    test::FieldRig rig(std::move(scene), parameters);
    rig.propagate();
    // Outside all cells send 2, inside index^2 as much; black ones at silhouettes would drain the ball.
    const std::vector<double> cells = rig.cells();
    const std::vector<uint32_t> total = rig.field().total().download();
    double shown = 0, black = 0;
    for (size_t cell = 0; cell < cells.size(); ++cell) {
      shown += total[cell] != FIELD_NO_CELL;
      black += total[cell] != FIELD_NO_CELL && cells[cell] < 0.1;
    }
    MESSAGE(std::string(ball ? "ball" : "slab"), ", cells: ", shown, ", black: ", black);
    CHECK(black < 1e-3 * shown);
    for (int k = 0; k < 6; ++k) {
      CAPTURE(k);
      const double e = rig.mean(rig.all(), k);
      MESSAGE(std::string(ball ? "ball" : "slab"), ", wall ", k, ": ", e);
      CHECK(e == relative(2, 0.01));
    }
  }
}
