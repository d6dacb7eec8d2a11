// SPDX-License-Identifier: Apache-2.0
// layered_walk_pairs() reports the beginnings, gaps and ends of rays that the stored A-buffer holds.
#include <doctest/doctest.h>

#include <cmath>

#include "lucarium/shared/hash.h"
#include "scene.h"
#include "test_support.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kWidth = 40, kHeight = 33;

std::vector<uint32_t> device_sums(LayeredScene& scene, const LayeredView& view, bool backs) {
  Device& device = scene.scheduler().device();
  SourceLibrary library;
  library.add(test_services_kernels());
  const Program program(
      device, library,
      {.name = "test/pairs", .files = {"test_services/layered_raster/pairs.cl"}, .defines = scene.raster().defines()});
  const TypedBuffer<LayeredView> views(device, "test", "views", std::vector<LayeredView>{view});
  const TypedBuffer<uint32_t> sums(device, "test", "sums", std::vector<uint32_t>(kWidth * kHeight));
  ScheduleRecorder recorder = scene.scheduler().record("pairs", "test");
  scene.raster().record_tiles(recorder, "tiles", {views, recorder.variable("view", 0u)}, program, "sum_events",
                              [&](PassBuilder& pass) { pass.arg("backs", backs ? 1u : 0u).arg("sums", sums); });
  Schedule schedule = recorder.compile();
  scene.scheduler().run(schedule);
  scene.scheduler().finish();
  return sums.download();
}

uint32_t id(const LayeredFragment& f) { return f.triangle & ~LAYERED_AWAY; }
bool away(const LayeredFragment& f) { return f.triangle & LAYERED_AWAY; }

/// What a ray meets at fragment i: of those in one place, the lowest triangle.
const LayeredFragment& met(std::span<const LayeredFragment> ray, size_t i) {
  while (i > 0 && ray[i - 1].depth == ray[i].depth && away(ray[i - 1]) == away(ray[i])) --i;
  return ray[i];
}

/// Events of one ray by their definition; `unsure` where rounding decides whether two fragments are one surface.
uint32_t events(std::span<const LayeredFragment> ray, bool backs, double step, bool& unsure) {
  if (ray.empty()) return 0;
  const LayeredFragment& last = met(ray, ray.size() - 1);
  uint32_t sum = hash_uint3(1, id(ray.front()), !away(ray.front())) + hash_uint3(3, id(last), away(last));
  for (size_t i = 1; i < ray.size(); ++i) {
    const LayeredFragment &near = met(ray, i - 1), &far = ray[i];
    const double gap = std::abs(static_cast<double>(far.depth) - static_cast<double>(near.depth));
    const bool near_front = away(near), far_front = !away(far);
    if (near_front != far_front && gap > 0 && gap < 4 * step) unsure = true;
    if (near_front != far_front && gap == 0) continue;  // drawn twice in one place
    if (!backs && !near_front && !far_front) continue;
    sum += hash_uint3(hash_uint2(2, id(near)), id(far), (near_front ? 2u : 0u) + (far_front ? 1u : 0u));
  }
  return sum;
}

}  // namespace

TEST_CASE("rays begin, cross gaps and end where fragments are; surfaces drawn twice are one") {
  // The second: more layers than a row holds at a time. The third: than it does on other devices.
  for (const auto& [count, row_layers] : {std::pair{30u, 64u}, {300u, 64u}, {30u, 4u}}) {
    CAPTURE(count);
    CAPTURE(row_layers);
    Soup soup;
    Random random(count);
    for (uint32_t i = 0; i < count; ++i) {
      const auto corner = [&] {
        return glm::vec3(random.uniform(-20, 60), random.uniform(-20, 60), random.uniform(-9, 9));
      };
      const glm::vec3 a = corner(), b = corner(), c = corner();
      soup.add_triangle(a, b, c);
      for (uint32_t copies = i % 5 == 0 ? 1 + i % 2 : 0; copies > 0; --copies) soup.add_triangle(a, b, c);
    }
    LayeredScene scene(scene_of(soup), {.max_width = kWidth, .max_height = kHeight, .row_layers = row_layers});
    const LayeredView view = pixel_view(kWidth, kHeight);
    const HostLayers layers = scene.store(view);
    const double step = 1 / (static_cast<double>(view.depth_scale) * 4194304.0);
    for (const bool backs : {true, false}) {
      CAPTURE(backs);
      const std::vector<uint32_t> got = device_sums(scene, view, backs);
      uint32_t wrong = 0, unsure_rows = 0, rows = 0;
      // The kernel adds up the rays of a row of lanes; which pixel begins one depends on the number of lanes.
      for (uint32_t y = 0; y < kHeight; ++y) {
        uint32_t expected = 0, found = 0;
        bool unsure = false;
        for (uint32_t x = 0; x < kWidth; ++x) {
          expected += events(layers.at(x, y), backs, step, unsure);
          found += got[y * kWidth + x];
        }
        ++rows;
        unsure_rows += unsure;
        wrong += !unsure && expected != found;
      }
      CHECK(wrong == 0);
      CHECK(unsure_rows < rows / 4);
    }
  }
}
