// SPDX-License-Identifier: Apache-2.0
// Where rays begin that leave a surface: on the right side of their triangle and near it, at every size.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <span>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/bvh/bvh.h"
#include "surface_fixture.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Triangles that share no corners; one for every three positions.
Scene loose_triangles(const std::vector<glm::vec3>& corners) {
  Scene scene;
  scene.source = "test";
  scene.materials.emplace_back();
  Mesh mesh;
  mesh.positions = corners;
  mesh.normals.assign(corners.size(), glm::vec3(0, 0, 1));
  for (uint32_t i = 0; i < corners.size(); i += 3) mesh.triangles.emplace_back(i, i + 1, i + 2);
  scene.meshes.push_back(mesh);
  SceneInstance instance;
  instance.mesh = 0, instance.material = 0;
  scene.instances.push_back(instance);
  return scene;
}

}  // namespace

TEST_CASE("ray origins never lie on the wrong side of their triangle, nor far from it") {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(-1, 1), positive(0, 1);
  const int triangles = full_run() ? 200000 : 20000;
  std::vector<glm::vec3> corners;
  const auto vec3 = [&] { return glm::vec3(uniform(random), uniform(random), uniform(random)); };
  std::vector<float> sizes;
  for (int i = 0; i < triangles; ++i) {
    // Sizes from a millimetre to ten kilometres, some far from the world's origin, some in axis-aligned planes.
    const float size = std::pow(10.f, 3.5f * uniform(random) + 0.5f), away = i % 3 ? 0.f : 100 * size;
    const glm::vec3 centre = away * vec3();
    for (int k = 0; k < 3; ++k) {
      glm::vec3 p = centre + size * vec3();
      if (i % 5 == 0) p[i / 5 % 3] = i % 2 ? 0.f : centre[i / 5 % 3];
      corners.push_back(p);
    }
    sizes.push_back(size + away);
  }
  const SceneBuffers buffers(*test_device(), loose_triangles(corners));
  std::vector<Hit> hits;
  for (int i = 0; i < triangles; ++i) {
    const float u = positive(random), v = (1 - u) * positive(random);
    hits.push_back(hit_at(static_cast<uint>(i), u, v));
  }
  const glm::vec3 direction = glm::normalize(glm::vec3(0.3f, -0.5f, 0.7f));
  const auto surfaces = make_surfaces(buffers, hits, direction);
  int wrong = 0, far = 0;
  for (int i = 0; i < triangles; ++i) {
    const glm::dvec3 a(corners[3 * i]), b(corners[3 * i + 1]), c(corners[3 * i + 2]);
    const glm::dvec3 e1 = b - a, e2 = c - a, normal = glm::normalize(glm::cross(e1, e2));
    // Needles have no normal in single precision.
    if (glm::length(glm::cross(e1, e2)) < 1e-3 * glm::length(e1) * glm::length(e2)) continue;
    // Which side a ray along the plane leaves on is a matter of rounding.
    const double cosine = glm::dot(normal, glm::dvec3(direction));
    if (std::abs(cosine) < 1e-6) continue;
    const double side = cosine > 0 ? 1 : -1;
    const double on = side * glm::dot(glm::dvec3(surfaces[i].origin_on.xyz()) - a, normal);
    const double back = -side * glm::dot(glm::dvec3(surfaces[i].origin_back.xyz()) - a, normal);
    wrong += !(on > 0 && back > 0);
    far += on > 1e-4 * sizes[i] || back > 1e-4 * sizes[i];
  }
  CHECK(wrong == 0);
  CHECK(far == 0);
}

TEST_CASE("rays do not find the triangle that they leave, at whatever angle") {
  // Triangles 20 m across that pass near the world's origin, in planes along the axes and others; points near the
  // origin, where coordinates alone would allow the least distance. Rays may meet the others.
  std::mt19937 random(13);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<glm::vec3> corners;
  std::vector<Hit> hits;
  const int triangles = 12, points = 200;
  for (int i = 0; i < triangles; ++i) {
    const int axis = i % 3;
    const auto corner = [&](float x, float y) {
      glm::vec3 p(0);
      p[(axis + 1) % 3] = 20 * x, p[(axis + 2) % 3] = 20 * y;
      p[axis] = static_cast<float>(i / 3 % 2) * (0.3f * p.x + 0.2f * p.y - 0.1f * p.z);
      return p;
    };
    corners.insert(corners.end(), {corner(-0.5f, -0.5f), corner(1, -0.5f), corner(-0.5f, 1)});
  }
  const Scene scene = loose_triangles(corners);
  const SceneBuffers buffers(*test_device(), scene);
  const Bvh bvh(*test_device(), scene, buffers);
  KernelScheduler scheduler(test_device());
  const glm::vec3 direction = glm::normalize(glm::vec3(0.3f, -0.5f, 0.7f));
  for (int i = 0; i < triangles; ++i)
    for (int k = 0; k < points; ++k) {
      const float near = k % 2 ? 0.3f : 1e-3f;
      hits.push_back(hit_at(static_cast<uint>(i), (1 + near * uniform(random)) / 3, (1 + near * uniform(random)) / 3));
    }
  const auto surfaces = make_surfaces(buffers, hits, direction);
  std::vector<Ray> rays;
  for (size_t i = 0; i < hits.size(); ++i) {
    const glm::vec3 n = -surfaces[i].n_g_flags.xyz();  // on the side that `direction` goes on to
    const glm::vec3 along = glm::normalize(glm::cross(n, glm::vec3(uniform(random), uniform(random), uniform(random))));
    const float cosine = std::pow(10.f, -3 + 3 * std::abs(uniform(random)));
    Ray ray;
    ray.origin = surfaces[i].origin_on;
    ray.direction = float4(glm::normalize(cosine * n + along), INFINITY);
    rays.push_back(ray);
  }
  const auto ray_buffer = test_buffer(rays);
  const auto found = test_buffer<Hit>(rays.size());
  const auto counter = test_buffer(std::vector<uint>{static_cast<uint>(rays.size())});
  ScheduleRecorder recorder = scheduler.record("trace", "test");
  bvh.record_closest(recorder, "closest", {ray_buffer, counter, 0, static_cast<uint32_t>(rays.size())}, found);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  const std::vector<Hit> results = found.download();
  size_t own = 0;
  for (size_t i = 0; i < hits.size(); ++i) own += results[i].triangle == hits[i].triangle;
  CHECK(own == 0);
}

TEST_CASE("ray origins keep off the edges of their triangle as far as off the triangle") {
  // Far from the origin, where that is far; corners of 30 degrees and more.
  const std::vector<glm::vec3> corners = {{1000, 300, -200}, {1001, 300, -200.2f}, {1000.3f, 301, -199.9f},
                                          {-80, 4000, 7},    {-78, 4000.5f, 7},    {-78.1f, 4003, 7.3f}};
  const SceneBuffers buffers(*test_device(), loose_triangles(corners));
  std::vector<Hit> hits;
  const float weights[][2] = {{0, 0},     {1, 0},       {0, 1},     {0, .4f},  {.7f, 0},
                              {.5f, .5f}, {.2f, 1e-4f}, {.3f, .3f}, {.5f, .2f}};
  for (const uint triangle : {0u, 1u})
    for (const auto& w : weights) hits.push_back(hit_at(triangle, w[0], w[1]));
  const auto surfaces = make_surfaces(buffers, hits, glm::normalize(glm::vec3(0.3f, -0.5f, 0.7f)));
  for (size_t i = 0; i < hits.size(); ++i) {
    CAPTURE(i);
    const std::span p = std::span(corners).subspan(3 * hits[i].triangle, 3);
    const glm::dvec3 origin(surfaces[i].origin_on.xyz()), hit = glm::dvec3(p[0]) +
                                                                double(hits[i].u) * glm::dvec3(p[1] - p[0]) +
                                                                double(hits[i].v) * glm::dvec3(p[2] - p[0]);
    const glm::dvec3 normal = glm::normalize(glm::cross(glm::dvec3(p[1] - p[0]), glm::dvec3(p[2] - p[0])));
    const double height = std::abs(glm::dot(origin - hit, normal));
    const double moved = glm::length(origin - hit - glm::dot(origin - hit, normal) * normal);
    double nearest = 1e9;
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 along = glm::normalize(glm::dvec3(p[(k + 1) % 3] - p[k]));
      nearest = std::min(nearest, glm::dot(glm::cross(normal, along), origin - glm::dvec3(p[k])));
    }
    REQUIRE(height > 1e-3);
    // Two edges push at once in a corner, by less than the height each where it is sharp.
    CHECK(nearest > (i % 9 < 3 ? 0.1 : 0.9) * height);
    CHECK(moved < 2.1 * height);
    if (i % 9 >= 7) CHECK(moved < 1e-3);
  }
}

TEST_CASE("the geometric normal does not depend on the size of a triangle") {
  for (const float size : {1e-12f, 1e-9f, 1e-6f, 1.f, 1e6f, 1e10f}) {
    CAPTURE(size);
    Scene scene = attribute_scene();
    for (glm::vec3& p : scene.meshes[0].positions) p *= size;
    const SceneBuffers buffers(*test_device(), scene);
    const SurfaceResult result = make_surfaces(buffers, {hit_at(0, 0.3f, 0.3f)}, {0, 0, -1}).front();
    CHECK(near(glm::vec3(result.n_g_flags.xyz()), {0, 0, 1}, 1e-6f));
  }
}
