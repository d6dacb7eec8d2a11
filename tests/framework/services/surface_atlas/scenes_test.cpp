// SPDX-License-Identifier: Apache-2.0
// The atlas of large scenes: wanted count, density, no bleeding, times. Third-party scenes may be absent.
#include <cstdio>

#include "lucarium/base/stopwatch.h"
#include "support.h"
#include "test_support.h"
#include "tolerance.h"
#include "touch.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Lays a scene out, prints what came of it and checks count and bleeding.
void check_scene(const std::string& name, const AtlasGeometry& g, uint64_t texels) {
  CAPTURE(name);
  CAPTURE(texels);
  AtlasLayoutOptions options;
  options.texel_count = texels;
  const Stopwatch watch;
  const AtlasLayout layout = make_atlas_layout(g, options);
  const double seconds = watch.seconds();
  std::vector<double> areas;
  const double s2 = double(layout.info.texel_edge) * double(layout.info.texel_edge);
  for (const AtlasTexel& texel : layout.texels) areas.push_back(double(texel.area) / s2);
  std::sort(areas.begin(), areas.end());
  const auto percentile = [&](double q) { return areas[size_t(q * double(areas.size() - 1))]; };
  std::printf("%s: %zu triangles, %u texel sides, %zu charts, %u cells, %zu pieces, area %.2f %.2f %.2f s^2, %.2f s\n",
              name.c_str(), g.triangles.size(), layout.info.texel_count, layout.charts.size(), layout.info.cell_count,
              layout.pieces.size(), percentile(0.05), percentile(0.5), percentile(0.95), seconds);
  CHECK(double(layout.info.texel_count) == test::relative(double(texels), 0.13));
  const std::vector<uint32_t> bad = bad_texels(g, layout);
  CHECK_MESSAGE(bad.empty(), bad.size() << " texels join what does not touch, the first is " << bad.front());
}

/// A bumpy sphere of 2 · rows · 2 rows triangles.
AtlasGeometry bumpy_sphere(uint32_t rows) {
  AtlasGeometry g;
  const uint32_t columns = 2 * rows;
  for (uint32_t j = 0; j <= rows; ++j) {
    for (uint32_t i = 0; i < columns; ++i) {
      const double theta = 3.14159265358979 * (0.001 + 0.998 * j / rows), phi = 2 * 3.14159265358979 * i / columns;
      const glm::dvec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      g.positions.emplace_back(n * (1 + 0.05 * std::sin(9 * theta) * std::sin(11 * phi)));
      g.normals.emplace_back(n);
    }
  }
  for (uint32_t j = 0; j < rows; ++j) {
    for (uint32_t i = 0; i < columns; ++i) {
      const uint32_t a = j * columns + i, b = j * columns + (i + 1) % columns;
      g.triangles.emplace_back(a, b, b + columns);
      g.triangles.emplace_back(a, b + columns, a + columns);
    }
  }
  g.instance.assign(g.triangles.size(), 0);
  g.two_sided = {0};
  return g;
}

}  // namespace

TEST_CASE("a mesh of a million small triangles") {
  const AtlasGeometry g = bumpy_sphere(full_run() ? 500 : 160);
  for (const uint64_t texels : {1000, 100000}) check_scene("bumpy sphere", g, texels);
  if (full_run()) check_scene("bumpy sphere", g, 1'000'000);
}

TEST_CASE("third-party scenes get the wanted count without bleeding") {
  if (shared_scenes().empty()) return skip("third-party scenes");
  std::vector<std::string> names = {"scenes/sponza_crytek/sponza.gltf", "scenes/bathroom_salle_de_bain.glb"};
  std::vector<uint64_t> counts = {1'000'000};
  if (full_run()) {
    names.insert(names.end(),
                 {"scenes/classroom_luxcore.glb", "scenes/apartment_dream_house.glb", "scenes/vr_gallery.glb",
                  "scenes/zdm2_level.glb", "models/dragon_stanford_res3.glb", "models/teapot_utah.glb"});
    counts = {200'000, 1'000'000, 4'000'000};
  }
  for (const std::string& name : names) {
    const AtlasGeometry g = geometry_of(load_scene((shared_scenes() / name).string()));
    for (const uint64_t texels : counts) check_scene(name, g, texels);
  }
}
