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

/// What counts in gaps: fronts, both sides, or both sides of sheets (most triangles), either of which may be met where
/// two lie in one place.
enum class Count { fronts, backs, sheets };

std::vector<uint32_t> device_sums(LayeredScene& scene, const LayeredView& view, Count count) {
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
                              [&](PassBuilder& pass) {
                                pass.arg("backs", count != Count::fronts ? 1u : 0u)
                                    .arg("sheets", count == Count::sheets ? 1u : 0u)
                                    .arg("sums", sums);
                              });
  Schedule schedule = recorder.compile();
  scene.scheduler().run(schedule);
  scene.scheduler().finish();
  return sums.download();
}

uint32_t id(const LayeredFragment& f) { return f.triangle & ~LAYERED_AWAY; }
bool away(const LayeredFragment& f) { return f.triangle & LAYERED_AWAY; }

bool sheet(const LayeredFragment& f) { return id(f) % 7 != 0; }

/// A ray's fragments, and what it meets where some lie in one place.
struct Ray {
  std::span<const LayeredFragment> at;
  Count count;
  bool even;  ///< the pixel is one where sheets of opposite facing are met at the other one

  bool same(size_t i, size_t j) const { return at[i].depth == at[j].depth && away(at[i]) == away(at[j]); }
  /// Of those of one facing, the lowest triangle.
  size_t first(size_t i) const {
    while (i > 0 && same(i - 1, i)) --i;
    return i;
  }
  bool other(size_t near, size_t far) const {
    return count == Count::sheets && even && away(at[near]) && !away(at[far]) && at[near].depth == at[far].depth &&
           sheet(at[near]) && sheet(at[far]);
  }
  const LayeredFragment& from_before(size_t i) const {
    size_t next = i + 1;
    while (next < at.size() && same(i, next)) ++next;
    return at[next < at.size() && other(i, next) ? next : i];
  }
  const LayeredFragment& from_behind(size_t i) const {
    i = first(i);
    return at[i > 0 && other(first(i - 1), i) ? first(i - 1) : i];
  }
};

/// Events of one ray by their definition; `unsure` where rounding decides whether two fragments are one surface.
uint32_t events(const Ray& ray, double step, bool& unsure) {
  if (ray.at.empty()) return 0;
  const LayeredFragment &begin = ray.from_before(0), &end = ray.from_behind(ray.at.size() - 1);
  uint32_t sum = hash_uint3(1, id(begin), !away(begin)) + hash_uint3(3, id(end), away(end));
  for (size_t i = 1; i < ray.at.size(); ++i) {
    const LayeredFragment &near = ray.from_behind(i - 1), &far = ray.from_before(i);
    const double gap = std::abs(static_cast<double>(ray.at[i].depth) - static_cast<double>(ray.at[i - 1].depth));
    const bool same_facing = away(ray.at[i - 1]) == away(ray.at[i]);
    if ((same_facing || ray.count == Count::sheets) && gap > 0 && gap < 4 * step) unsure = true;
    if (same_facing && gap == 0) continue;  // drawn twice in one place
    if (ray.count == Count::sheets && gap == 0 && sheet(near) && sheet(far)) continue;
    const bool near_front = away(near), far_front = !away(far);
    if (ray.count == Count::fronts && !near_front && !far_front) continue;
    sum += hash_uint3(hash_uint2(2, id(near)), id(far), (near_front ? 2u : 0u) + (far_front ? 1u : 0u));
  }
  return sum;
}

}  // namespace

TEST_CASE("rays begin, cross gaps and end where fragments are; surfaces in one place are one") {
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
      for (uint32_t copies = i % 3 == 0 ? 1 + i % 2 : 0; copies > 0; --copies) soup.add_triangle(a, c, b);
    }
    LayeredScene scene(scene_of(soup), {.max_width = kWidth, .max_height = kHeight, .row_layers = row_layers});
    const LayeredView view = pixel_view(kWidth, kHeight);
    const HostLayers layers = scene.store(view);
    const double step = 1 / (static_cast<double>(view.depth_scale) * 4194304.0);
    for (const Count what : {Count::fronts, Count::backs, Count::sheets}) {
      // Of sheets in one place on either side of the border of two parts, one is met from both sides.
      if (what == Count::sheets && (count > 30 || row_layers < 64)) continue;
      CAPTURE(int(what));
      const std::vector<uint32_t> got = device_sums(scene, view, what);
      uint32_t wrong = 0, unsure_rows = 0, rows = 0;
      // The kernel adds up the rays of a row of lanes; which pixel begins one depends on the number of lanes.
      for (uint32_t y = 0; y < kHeight; ++y) {
        uint32_t expected = 0, found = 0;
        bool unsure = false;
        for (uint32_t x = 0; x < kWidth; ++x) {
          expected += events({layers.at(x, y), what, (x + y) % 2 == 0}, step, unsure);
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
