// SPDX-License-Identifier: Apache-2.0
// kernels/lucarium/camera.clh and mis.clh: camera rays against geometry, weights against their definition.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>

#include "kernel_fixture.h"
#include "lucarium/shared/ray.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

const Program& program() {
  static const Program instance = kernel_program("surface");
  return instance;
}

bool near_point(const glm::vec3& a, const glm::vec3& b) { return glm::distance(a, b) <= 1e-5f; }

}  // namespace

TEST_CASE("primary rays pass through their film points; pixel sampling modes") {
  SceneCamera camera;
  camera.yfov = 1.0f;
  camera.world_from_camera =
      glm::mat4(glm::vec4(0, 0, -1, 0), glm::vec4(0, 1, 0, 0), glm::vec4(1, 0, 0, 0), glm::vec4(1, 2, 3, 1));
  const uint width = 8, height = 4;
  const auto rays = [&](uint sampling, const std::vector<uint4>& samples, const std::vector<float2>& jitters) {
    Frame frame{};
    frame.camera = make_camera(camera, float(width) / float(height));
    frame.width = width, frame.height = height, frame.pixel_sampling = sampling;
    const auto device_samples = test_buffer(samples);
    const auto device_jitters = test_buffer(jitters);
    const auto result = test_buffer<Ray>(samples.size());
    run_kernel(program(), "make_camera_rays", samples.size(), 1, [&](PassBuilder& pass) {
      pass.arg("frame", frame).arg("samples", device_samples).arg("jitters", device_jitters);
      pass.arg("count", static_cast<uint>(samples.size())).arg("rays", result);
    });
    return result.download();
  };
  // The camera looks along -x, its right is -z, its up is +y.
  const auto expected = [&](float film_x, float film_y) {
    const float half = std::tan(0.5f);
    const float sx = 2 * film_x / width - 1, sy = 1 - 2 * film_y / height;
    return glm::normalize(glm::vec3(-1, half * sy, -2 * half * sx));
  };
  const auto jittered = rays(LUCARIUM_PIXEL_JITTER, {{0, 0, 0, 0}, {7, 3, 5, 0}}, {{0.25f, 0.75f}, {0.5f, 0.1f}});
  CHECK(near_point(jittered[0].direction.xyz(), expected(0.25f, 0.75f)));
  CHECK(near_point(jittered[1].direction.xyz(), expected(7.5f, 3.1f)));
  CHECK(near_point(jittered[0].origin.xyz(), {1, 2, 3}));
  CHECK(std::isinf(jittered[0].direction.w));
  uint seed = 0;
  std::memcpy(&seed, &jittered[0].origin.w, sizeof seed);
  CHECK(seed == 5);
  const auto centre = rays(LUCARIUM_PIXEL_CENTRE, {{2, 1, 9, 0}}, {{0.9f, 0.9f}});
  CHECK(near_point(centre[0].direction.xyz(), expected(2.5f, 1.5f)));
  const auto grid = rays(2, {{2, 1, 0, 0}, {2, 1, 1, 0}, {2, 1, 6, 0}}, {{0.9f, 0.9f}, {0.9f, 0.9f}, {0.9f, 0.9f}});
  CHECK(near_point(grid[0].direction.xyz(), expected(2.25f, 1.25f)));
  CHECK(near_point(grid[1].direction.xyz(), expected(2.75f, 1.25f)));
  CHECK(near_point(grid[2].direction.xyz(), expected(2.25f, 1.75f)));

  camera.perspective = false;
  camera.ymag = 3;
  const auto parallel = rays(LUCARIUM_PIXEL_JITTER, {{0, 0, 0, 0}, {4, 2, 0, 0}}, {{0, 0}, {0, 0}});
  CHECK(near_point(parallel[0].direction.xyz(), {-1, 0, 0}));
  CHECK(near_point(parallel[0].origin.xyz(), {1, 2 + 3, 3 + 6}));
  CHECK(near_point(parallel[1].origin.xyz(), {1, 2, 3}));
}

TEST_CASE("heuristics of multiple importance sampling add up to 1") {
  const std::vector<float2> densities = {{1, 1}, {3, 1}, {1, 3}, {1e30f, 1}, {1, 1e30f}, {2, 0}, {1e-20f, 1e-20f}};
  const auto input = test_buffer(densities);
  const auto weights = test_buffer<float2>(densities.size());
  run_kernel(program(), "weigh", densities.size(), 1, [&](PassBuilder& pass) {
    pass.arg("densities", input).arg("count", static_cast<uint>(densities.size())).arg("weights", weights);
  });
  const auto got = weights.download();
  CHECK(got[0].x == test::relative(0.5));
  CHECK(got[1].x == test::relative(0.9));
  CHECK(got[1].x + got[2].x == test::relative(1));
  CHECK(got[1].y == test::relative(0.75));
  CHECK(got[3].x == 1);
  CHECK(got[4].x == test::within(0, 1e-6));
  CHECK(got[5].x == 1);
  CHECK(got[6].x == test::relative(0.5));
}
