// SPDX-License-Identifier: Apache-2.0
// The atlas of large scenes: wanted count, density, no bleeding, times. Third-party scenes may be absent.
#include <chrono>
#include <cstdio>

#include "surface_atlas_support.h"
#include "surface_atlas_touch.h"
#include "test_support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

struct Measured {
  double seconds;
  AtlasLayout layout;
};

Measured measure(const char* name, const AtlasGeometry& g, uint64_t texels) {
  AtlasLayoutOptions options;
  options.texel_count = texels;
  const auto start = std::chrono::steady_clock::now();
  Measured result{0, make_atlas_layout(g, options)};
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::vector<double> areas;
  const double s2 = double(result.layout.info.texel_edge) * double(result.layout.info.texel_edge);
  for (const AtlasTexel& texel : result.layout.texels) areas.push_back(double(texel.area) / s2);
  std::sort(areas.begin(), areas.end());
  const auto p = [&](double q) { return areas[size_t(q * double(areas.size() - 1))]; };
  size_t single = 0;
  for (const AtlasChart& chart : result.layout.charts) single += chart.width == 1;
  std::printf("%s: %zu triangles, %u slots, %zu charts (%zu of one texel), %u cells, %zu pieces, %.2f/%.2f/%.2f s^2, %.2f s\n", name,
              g.triangles.size(), result.layout.info.texel_count, result.layout.charts.size(), single,
              result.layout.info.cell_count, result.layout.pieces.size(), p(.05), p(.5), p(.95), result.seconds);
  std::fflush(stdout);
  return result;
}

}  // namespace

TEST_CASE("third-party scenes get the wanted count without bleeding") {
  if (shared_scenes().empty()) return skip("third-party scenes");
  for (const char* name : {"scenes/sponza_crytek/sponza.gltf", "scenes/bathroom_salle_de_bain.glb", "scenes/classroom_luxcore.glb",
  "scenes/apartment_dream_house.glb", "models/dragon_stanford_res3.glb"}) {
    CAPTURE(name);
    const AtlasGeometry g = geometry_of(load_scene((shared_scenes() / name).string()));
    const uint64_t wanted = 1'000'000;
    const Measured m = measure(name, g, wanted);
    CHECK(double(m.layout.info.texel_count) == doctest::Approx(double(wanted)).epsilon(0.13));
    const auto bad = bad_texels(g, m.layout);
    TexelPolygons all = polygons_by_texel(g, m.layout, 1e-4);
    for (uint32_t b : bad) {
      std::printf("bad %u s=%g area %g\n", b, double(m.layout.info.texel_edge), double(m.layout.texels[b].area));
      for (auto& p : all.polygons) if (p.texel == b) {
        const AtlasTriangle& r = m.layout.triangles[p.triangle];
        std::printf("  t %u uv %g %g  %g %g  %g %g base %u pitch %u area %g:", p.triangle, r.u0, r.v0, r.u1, r.v1, r.u2, r.v2, r.base, r.pitch, area_of(g, p.triangle));
        for (uint32_t i = 0; i < p.count; ++i) { auto c = all.corners[p.first+i]; std::printf(" (%.6f %.6f %.6f)", c.x, c.y, c.z); }
        std::printf("\n   tri"); for (int i = 0; i < 3; ++i) { auto c = corner(g, p.triangle, i); std::printf(" %u(%.7f %.7f %.7f)", g.triangles[p.triangle][i], c.x, c.y, c.z); }
        std::printf("\n");
      }
    }
    CHECK_MESSAGE(bad.empty(), bad.size() << " texels join what does not touch");
  }
}
