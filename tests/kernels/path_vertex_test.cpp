// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/path_vertex.clh, turn_bsdf() and camera_project(): vertices seen from elsewhere are what they would
// be if they had been met from there.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "bsdf_scene.h"
#include "lucarium/shared/ray.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint kPairs = 512;

const Program& path_vertex_program() {
  static const Program instance = kernel_program("path_vertex");
  return instance;
}

const std::vector<NamedMaterial>& vertex_materials() {
  static const std::vector<NamedMaterial> all = {{"lambert", dielectric(0.7f, 1, 1)},
                                                 {"plastic", dielectric(0.5f, 0.4f)},
                                                 {"lacquer", dielectric(0.5f, 0)},
                                                 {"gold", metal(0.8f, 0.3f)},
                                                 {"frosted glass", glass(0.9f, 0.3f, 1, true)},
                                                 {"clear glass", glass(0.9f, 0, 1, true)},
                                                 {"milk", glass(0.8f, 0.5f, 0.4f, true, 1.33f)},
                                                 {"paper", glass(0.8f, 0.5f, 0.4f, false)},
                                                 {"leaning", dielectric(0.6f, 0.5f), {0.4f, 0.2f, 1}}};
  return all;
}

/// Triples: from, to, light; unit vectors anywhere.
std::vector<float4> random_directions() {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  std::vector<float4> directions;
  for (uint i = 0; i < 3 * kPairs; ++i)
    directions.push_back(float4(glm::normalize(glm::vec3(normal(random), normal(random), normal(random))), 0.f));
  return directions;
}

double worst_difference(const std::vector<float>& a, const std::vector<float>& b, double floor) {
  double worst = 0;
  for (size_t i = 0; i < a.size(); ++i)
    worst = std::max(worst, std::abs(double{a[i]} - double{b[i]}) / (floor + std::abs(double{b[i]})));
  return worst;
}

}  // namespace

TEST_CASE("a BSDF that is turned to another viewer is the one made for that viewer") {
  const SceneBuffers buffers(*test_device(), material_scene(vertex_materials()));
  const auto directions = test_buffer(random_directions());
  for (uint m = 0; m < vertex_materials().size(); ++m) {
    CAPTURE(vertex_materials()[m].name);
    const auto turned = test_buffer<float>(8 * kPairs), made = test_buffer<float>(8 * kPairs);
    run_kernel(path_vertex_program(), "turn_and_make", kPairs, 64, [&](PassBuilder& pass) {
      buffers.bind(pass);
      pass.arg("triangle", m).arg("count", kPairs).arg("directions", directions).arg("turned", turned);
      pass.arg("made", made);
    });
    const std::vector<float> a = turned.download(), b = made.download();
    const std::vector<float4> d = directions.download();
    std::vector<float> kept_a, kept_b;
    for (uint i = 0; i < kPairs; ++i) {
      // Backs of opaque surfaces are asked for by nothing; a first viewer behind the shading normal has no BSDF.
      const bool same_side = d[3 * i].z * d[3 * i + 1].z > 0;
      const glm::vec3 shading = glm::normalize(vertex_materials()[m].shading_normal);
      const float side = d[3 * i].z > 0 ? 1.f : -1.f;
      if (side * glm::dot(shading, d[3 * i].xyz()) <= 0) continue;
      if (!same_side && vertex_materials()[m].material.transmission == 0) continue;
      kept_a.insert(kept_a.end(), a.begin() + 8 * i, a.begin() + 8 * i + 8);
      kept_b.insert(kept_b.end(), b.begin() + 8 * i, b.begin() + 8 * i + 8);
    }
    CHECK(kept_a.size() > kPairs);
    CHECK(worst_difference(kept_a, kept_b, 1e-4) <= 1e-4);
  }
}

TEST_CASE("a stored vertex has the BSDF, flux, number, medium and ray ends of its surface") {
  const SceneBuffers buffers(*test_device(), material_scene(vertex_materials()));
  const auto directions = test_buffer(random_directions());
  const std::vector<float4> d = directions.download();
  for (uint m = 0; m < vertex_materials().size(); ++m) {
    CAPTURE(vertex_materials()[m].name);
    const auto stored = test_buffer<float>(8 * kPairs), made = test_buffer<float>(8 * kPairs);
    const auto flags = test_buffer<uint4>(kPairs);
    const auto ends = test_buffer<float4>(kPairs);
    run_kernel(path_vertex_program(), "store_and_make", kPairs, 64, [&](PassBuilder& pass) {
      buffers.bind(pass);
      pass.arg("triangle", m).arg("count", kPairs).arg("directions", directions).arg("stored", stored);
      pass.arg("made", made).arg("flags", flags).arg("ends", ends);
    });
    CHECK(worst_difference(stored.download(), made.download(), 1e-3) <= 1e-4);
    const std::vector<uint4> all_flags = flags.download();
    const std::vector<float4> all_ends = ends.download();
    uint wrong = 0;
    double worst_end = 0, worst_flux = 0;
    for (uint i = 0; i < kPairs; ++i) {
      const bool front = d[3 * i].z > 0, light_in_front = d[3 * i + 2].z > 0;
      const uint end = m | (light_in_front ? 0 : LUCARIUM_RAY_END_BACK);
      wrong += all_flags[i].x != 5 || all_flags[i].y != 11 || all_flags[i].z != end || all_flags[i].w != 1;
      const double side = front == light_in_front ? 1 : -1;
      worst_end = std::max(worst_end, std::abs(double{all_ends[i].x} - side));
      const double cosine = std::max(std::abs(double{d[3 * i].z}), 1e-4);
      worst_flux = std::max(worst_flux, std::abs(double{all_ends[i].y} * cosine / 3 - 1));
    }
    CHECK(wrong == 0);
    CHECK(worst_end <= 0.05);
    CHECK(worst_flux <= 1e-4);
  }
}

TEST_CASE("points project to the film position that their camera ray left, with the density of one pixel's rays") {
  std::vector<float4> films;
  for (float y = 0.6f; y < 36; y += 4)
    for (float x = 0.3f; x < 64; x += 4) films.push_back(float4(x, y, 0.1f + 0.1f * (x + y), 0));
  for (const bool perspective : {true, false}) {
    CAPTURE(perspective);
    SceneCamera camera;
    camera.perspective = perspective;
    camera.yfov = 1.2f;
    camera.xmag = 2;
    camera.ymag = 1.5f;
    camera.world_from_camera =
        glm::mat4(glm::vec4(0, 0, -1, 0), glm::vec4(0, 1, 0, 0), glm::vec4(1, 0, 0, 0), glm::vec4(1, 2, 3, 1));
    Frame frame{};
    frame.width = 64, frame.height = 36;
    frame.camera = make_camera(camera, 64.f / 36.f);
    const auto device_films = test_buffer(films), result = test_buffer<float4>(films.size());
    run_kernel(path_vertex_program(), "project_back", films.size(), 16, [&](PassBuilder& pass) {
      pass.arg("frame", frame).arg("count", static_cast<uint>(films.size())).arg("films", device_films);
      pass.arg("result", result);
    });
    const std::vector<float4> found = result.download();
    double worst_film = 0, worst_distance = 0, worst_density = 0;
    for (size_t i = 0; i < films.size(); ++i) {
      worst_film = std::max({worst_film, std::abs(double{found[i].x} - double{films[i].x}),
                             std::abs(double{found[i].y} - double{films[i].y})});
      worst_distance = std::max(worst_distance, std::abs(double{found[i].z} / double{films[i].z} - 1));
      worst_density = std::max(worst_density, std::abs(double{found[i].w} - 1));
    }
    CHECK(worst_film <= 1e-3);
    CHECK(worst_distance <= 1e-5);
    CHECK(worst_density <= 1e-3);
  }
}
