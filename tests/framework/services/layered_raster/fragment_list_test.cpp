// SPDX-License-Identifier: Apache-2.0
// fragment_list.clh: points of stacked sheets find themselves among stored fragments, and see the next sheet.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>

#include "lucarium/shared/ray.h"
#include "scene.h"
#include "test_support.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kSide = 24, kSheets = 7;

/// Height of sheet k: tilted planes that do not meet within the view.
float plane_height(uint32_t k, float x, float y) {
  return -9.f + 3.f * static_cast<float>(k) + (k % 2 == 0 ? 0.04f : -0.03f) * (x - 12) + 0.02f * (y - 12);
}

/// Sheets of two triangles; odd ones face the other way, sheet 3 is drawn twice. `sheet_of`: per triangle.
Soup sheets(std::vector<uint32_t>& sheet_of) {
  Soup soup;
  for (uint32_t k = 0; k < kSheets; ++k) {
    const auto corner = [&](float x, float y) { return glm::vec3(x, y, plane_height(k, x, y)); };
    const glm::vec3 a = corner(-3, -3), b = corner(27, -3), c = corner(27, 27), d = corner(-3, 27);
    for (int copies = k == 3 ? 2 : 1; copies > 0; --copies) {
      k % 2 == 0 ? soup.add_triangle(a, b, c) : soup.add_triangle(a, c, b);
      k % 2 == 0 ? soup.add_triangle(a, c, d) : soup.add_triangle(a, d, c);
      sheet_of.insert(sheet_of.end(), 2, k);
    }
  }
  return soup;
}

struct Point {
  glm::vec3 position, normal;
  uint32_t triangle;
  bool front;
};

std::vector<uint4> look_up(LayeredScene& scene, const LayeredView& view, const std::vector<Point>& points,
                           bool around) {
  KernelScheduler& scheduler = scene.scheduler();
  Device& device = scheduler.device();
  SourceLibrary library;
  library.add(test_services_kernels());
  const Program program(device, library,
                        {.name = "test/look_up", .files = {"test_services/layered_raster/fragment_list.cl"}});
  std::vector<float4> positions, normals;
  std::vector<uint32_t> triangles;
  for (const Point& p : points) {
    positions.push_back(float4(p.position, 0));
    normals.push_back(float4(p.normal, p.front ? 1.f : 0.f));
    triangles.push_back(p.triangle);
  }
  const TypedBuffer<LayeredView> views(device, "test", "views", std::vector<LayeredView>{view});
  const TypedBuffer<float4> position_buffer(device, "test", "positions", positions),
      normal_buffer(device, "test", "normals", normals);
  const TypedBuffer<uint32_t> triangle_buffer(device, "test", "triangles", triangles);
  const TypedBuffer<uint4> seen(device, "test", "seen", points.size());
  ScheduleRecorder recorder = scheduler.record("look up", "test");
  const LayeredRaster::Stored stored =
      scene.raster().record_stored(recorder, "layers", {views, recorder.variable("view", 0u)});
  PassBuilder pass = recorder.pass("look up", program, "look_up");
  scene.buffers().bind(pass);
  pass.global(points.size())
      .arg("positions", position_buffer)
      .arg("normals", normal_buffer)
      .arg("triangles", triangle_buffer)
      .arg("count", static_cast<uint32_t>(points.size()))
      .arg("around", around ? 1u : 0u)
      .arg("views", views)
      .arg("pixel_start", stored.pixel_start)
      .arg("fragments", stored.fragments)
      .arg("seen", seen);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  return seen.download();
}

}  // namespace

TEST_CASE("a point finds itself and sees the next sheet on its side, from fronts and backs") {
  std::vector<uint32_t> sheet_of;
  const Soup soup = sheets(sheet_of);
  LayeredScene scene(scene_of(soup), {.max_width = kSide, .max_height = kSide});
  const LayeredView view = pixel_view(kSide, kSide);
  Random random(5);
  std::vector<Point> points;
  for (int i = 0; i < 2000; ++i) {
    const auto triangle = static_cast<uint32_t>(i) % static_cast<uint32_t>(sheet_of.size());
    const Triangle& t = soup.triangles[triangle];
    const glm::vec3 a(soup.corner(t.v0)), b(soup.corner(t.v1)), c(soup.corner(t.v2));
    float u, v;
    glm::vec3 p;
    do {
      u = random.uniform(0, 1), v = random.uniform(0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      p = a + u * (b - a) + v * (c - a);
    } while (p.x < 0.1f || p.x > 23.9f || p.y < 0.1f || p.y > 23.9f);
    const bool front = random.uniform(0, 1) < 0.5f;
    const glm::vec3 n = glm::normalize(glm::cross(b - a, c - a));
    points.push_back({p, front ? n : -n, triangle, front});
  }
  for (const bool around : {false, true}) {
    CAPTURE(around);
    const std::vector<uint4> seen = look_up(scene, view, points, around);
    size_t lost = 0, wrong = 0, off = 0, copies = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const uint32_t sheet = sheet_of[points[i].triangle];
      const bool along = points[i].normal.z > 0;
      lost += seen[i].y == 0;
      if (along ? sheet + 1 == kSheets : sheet == 0) {
        wrong += seen[i].x != LUCARIUM_NONE;
        continue;
      }
      if (seen[i].x == LUCARIUM_NONE || sheet_of[seen[i].x] != (along ? sheet + 1 : sheet - 1)) {
        ++wrong;
        continue;
      }
      // Of a sheet drawn twice, the first one is seen from either side.
      copies += seen[i].x >= 2 && sheet_of[seen[i].x - 2] == sheet_of[seen[i].x];
      // The weights are those of the pixel's centre.
      const Triangle& t = soup.triangles[seen[i].x];
      const glm::vec3 a(soup.corner(t.v0)), b(soup.corner(t.v1)), c(soup.corner(t.v2));
      const glm::vec3 q = a + std::bit_cast<float>(seen[i].z) * (b - a) + std::bit_cast<float>(seen[i].w) * (c - a);
      const float cx = std::floor(points[i].position.x) + 0.5f, cy = std::floor(points[i].position.y) + 0.5f;
      off += std::abs(q.x - cx) > 2e-3f || std::abs(q.y - cy) > 2e-3f;
    }
    CHECK(lost == 0);
    CHECK(wrong == 0);
    CHECK(copies == 0);
    CHECK(off == 0);
  }
}

TEST_CASE("points between pixel centres are put in by their depth, those outside of the view see nothing") {
  std::vector<uint32_t> sheet_of;
  Soup soup = sheets(sheet_of);
  // A speck between four pixel centres, between sheets 2 and 3, with no sheet of its facing within reach.
  soup.add_triangle({5.9f, 5.9f, -1.5f}, {6.1f, 5.9f, -1.5f}, {6.f, 6.1f, -1.5f});
  const uint32_t speck = static_cast<uint32_t>(soup.triangles.size()) - 1;
  LayeredScene scene(scene_of(soup), {.max_width = kSide, .max_height = kSide});
  LayeredView view = pixel_view(kSide, kSide);
  view.row_x.x = view.row_y.y = 1;
  const std::vector<Point> points = {{{6, 6, -1.5f}, {0, 0, 1}, speck, true},
                                     {{6, 6, -1.5f}, {0, 0, -1}, speck, false},
                                     {{-40, 6, 0}, {0, 0, 1}, speck, true}};
  // Sheet heights near (6, 6): 2 at about -3.4 and 3 at about 0.1, both farther than the reach of 1.
  for (const bool around : {false, true}) {
    CAPTURE(around);
    const std::vector<uint4> seen = look_up(scene, view, points, around);
    for (const uint4& s : seen) CHECK(s.y == 0);
    REQUIRE(seen[0].x < speck);
    REQUIRE(seen[1].x < speck);
    CHECK(sheet_of[seen[0].x] == 3);
    CHECK(sheet_of[seen[1].x] == 2);
    CHECK(seen[2].x == LUCARIUM_NONE);
  }
}
