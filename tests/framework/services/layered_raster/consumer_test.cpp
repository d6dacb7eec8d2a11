// SPDX-License-Identifier: Apache-2.0
// A consumer of fused tiles (layered_example.cl) sees what the stored A-buffer holds.
#include <doctest/doctest.h>

#include "scene.h"
#include "test_support.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

struct Gaps {
  std::vector<uint32_t> gaps, sums;
};

Gaps find_gaps(LayeredScene& scene, const LayeredView& view) {
  Device& device = scene.scheduler().device();
  SourceLibrary library;
  library.add(test_services_kernels());
  const Program program(
      device, library,
      {.name = "test/gaps", .files = {"test_services/layered_raster/example.cl"}, .defines = scene.raster().defines()});
  const TypedBuffer<LayeredView> views(device, "test", "views", std::vector<LayeredView>{view});
  const TypedBuffer<uint32_t> gaps(device, "test", "gaps", view.width * view.height),
      sums(device, "test", "sums", view.width * view.height);
  ScheduleRecorder recorder = scene.scheduler().record("gaps", "test");
  scene.raster().record_tiles(recorder, "tiles", {views, recorder.variable("view", 0u)}, program, "find_gaps",
                              [&](PassBuilder& pass) { pass.arg("gaps", gaps).arg("sums", sums); });
  Schedule schedule = recorder.compile();
  scene.scheduler().run(schedule);
  scene.scheduler().finish();
  return {gaps.download(), sums.download()};
}

double weight_of_second(const Soup& soup, uint32_t triangle, double x, double y) {
  const Triangle& t = soup.triangles[triangle];
  const glm::dvec3 a = soup.corner(t.v0), b = soup.corner(t.v1), c = soup.corner(t.v2);
  const auto area = [](const glm::dvec3& p, const glm::dvec3& q, double rx, double ry) {
    return (q.x - p.x) * (ry - p.y) - (q.y - p.y) * (rx - p.x);
  };
  return area(c, a, x, y) / area(a, b, c.x, c.y);
}

}  // namespace

TEST_CASE("gaps and payloads") {
  // Few and large, then more than fits into the layers of a row, then as many in one place.
  for (const uint32_t count : {40u, 400u, 150u}) {
    CAPTURE(count);
    Soup soup;
    Random random(count);
    for (uint32_t i = 0; i < count; ++i) {
      if (count == 150) {
        soup.add_triangle({3, 2, 1}, {33, 9, 2}, {7, 31, 4});
        continue;
      }
      const auto corner = [&] {
        return glm::vec3(random.uniform(-20, 60), random.uniform(-20, 60), random.uniform(-9, 9));
      };
      soup.add_triangle(corner(), corner(), corner());
    }
    const LayeredView view = pixel_view(40, 37);
    const HostLayers layers = LayeredScene(scene_of(soup), {.max_width = 40, .max_height = 37}).store(view);
    for (const uint32_t row_layers : {64u, 4u}) {
      CAPTURE(row_layers);
      LayeredScene scene(scene_of(soup), {.max_width = 40, .max_height = 37, .row_layers = row_layers});
      const Gaps found = find_gaps(scene, view);
      uint32_t wrong_gaps = 0, wrong_sums = 0;
      for (uint32_t y = 0; y < 37; ++y)
        for (uint32_t x = 0; x < 40; ++x) {
          const auto pixel = layers.at(x, y);
          wrong_gaps += found.gaps[y * 40 + x] + 1 != std::max<size_t>(1, pixel.size());
          double sum = 0, slack = 0;
          for (const LayeredFragment& fragment : pixel) {
            sum += 4096 *
                   std::clamp(weight_of_second(soup, fragment.triangle & ~LAYERED_AWAY, x + 0.5, y + 0.5), 0.0, 1.0);
            slack += 30;  // vertices are snapped, slivers steep
          }
          wrong_sums += std::abs(found.sums[y * 40 + x] - sum) > slack;
        }
      CHECK(wrong_gaps == 0);
      CHECK(wrong_sums == 0);
    }
    CHECK(layers.fragments.size() > 5000);
  }
}

TEST_CASE("payloads in perspective, of whole and of clipped triangles") {
  constexpr uint32_t width = 48, height = 40;
  Soup soup;
  Random random(3);
  for (int i = 0; i < 80; ++i) {
    const glm::vec3 center = random.in_cube(4);
    soup.add_triangle(center + random.in_cube(3), center + random.in_cube(3), center + random.in_cube(3));
  }
  LayeredScene scene(scene_of(soup), {.max_width = width, .max_height = height, .perspective = true});
  const glm::vec3 eye(0.3f, 0.2f, -0.5f);
  const LayeredView view = perspective_view(eye, {0, 0, 1}, {0, -1, 0}, 1, width, height, 0.05f, 20);
  const HostLayers layers = scene.store(view);
  const Gaps found = find_gaps(scene, view);
  uint32_t wrong_gaps = 0, wrong_sums = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const auto pixel = layers.at(x, y);
      wrong_gaps += found.gaps[y * width + x] + 1 != std::max<size_t>(1, pixel.size());
      double sum = 0, slack = 1;
      for (const LayeredFragment& fragment : pixel) {
        const Triangle& t = soup.triangles[fragment.triangle & ~LAYERED_AWAY];
        const glm::dvec3 a = soup.corner(t.v0), e1 = glm::dvec3(soup.corner(t.v1)) - a,
                         e2 = glm::dvec3(soup.corner(t.v2)) - a;
        // x grows along down × direction = −x of the world, in steps of 2 / width at depth 1.
        const glm::dvec3 d(-(x + 0.5 - width / 2) * 2.0 / width, -(y + 0.5 - height / 2) * 2.0 / width, 1);
        const glm::dvec3 p = glm::cross(d, e2);
        const double weight = glm::dot(glm::dvec3(eye) - a, p) / glm::dot(e1, p);
        sum += 4096 * std::clamp(weight, 0.0, 1.0);
        // Vertices are snapped to 1/512 pixel: much for what is seen at a grazing angle.
        slack += 8 + 4096 * 0.004 * glm::length(d) * fragment.depth * glm::length(glm::cross(e1, e2)) /
                         std::abs(glm::dot(e1, p)) * 2 / width / glm::length(e1);
      }
      wrong_sums += std::abs(found.sums[y * width + x] - sum) > slack;
    }
  CHECK(wrong_gaps == 0);
  CHECK(wrong_sums == 0);
  CHECK(layers.fragments.size() > 2000);
}
