// SPDX-License-Identifier: Apache-2.0
// How many texel sides an atlas is said to have at the most, and how many it has.
#include "lucarium/services/surface_atlas/estimate.h"

#include "context.h"
#include "lucarium/scene/builtin/builder.h"
#include "lucarium/services/surface_atlas/most_texels.h"
#include "support.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// Triangles that touch nothing, about `width` as high as long, anywhere in a cube.
void add_slivers(std::vector<glm::vec3>& corners, std::mt19937& random, int count, float length, float width) {
  std::uniform_real_distribution<float> unit(-1, 1), scale(0.5f, 2);
  const auto direction = [&] { return glm::normalize(glm::vec3(unit(random), unit(random), unit(random) + 1e-3f)); };
  for (int i = 0; i < count; ++i) {
    const glm::vec3 at(unit(random), unit(random) + 2, unit(random)), along = direction() * length * scale(random);
    const glm::vec3 across = glm::normalize(glm::cross(along, direction())) * length * width * scale(random);
    corners.insert(corners.end(), {at, at + along, at + 0.3f * along + across});
  }
}

}  // namespace

TEST_CASE("no atlas of slivers that touch nothing has more sides than was estimated") {
  std::mt19937 random(3);
  double fullest = 0;
  for (const bool floor : {true, false})
    for (const int count : {20, 300, 4000})
      for (const float length : {0.01f, 0.1f, 1.f})
        for (const float width : {1e-4f, 1e-2f, 0.5f})
          for (const uint64_t texels : {200, 3000}) {
            std::vector<glm::vec3> corners;
            if (floor) add_floor(corners, -2, -2, 2, 2);
            add_slivers(corners, random, count, length, width);
            const AtlasGeometry geometry = soup(corners, count == 300);
            AtlasLayoutOptions options;
            options.texel_count = texels;
            const AtlasLayout layout = make_atlas_layout(geometry, options);
            const double share = layout.info.texel_count / count_sides(geometry, options);
            CAPTURE(floor);
            CAPTURE(count);
            CAPTURE(length);
            CAPTURE(width);
            CAPTURE(texels);
            CHECK(share <= 1);
            AtlasLayoutOptions by_edge;
            by_edge.texel_edge = double(layout.info.texel_edge);
            const double again = layout.info.texel_count / count_sides(geometry, by_edge);
            CHECK(again <= 1);
            fullest = std::max({fullest, share, again});
          }
  MESSAGE("at most ", fullest, " of the estimate");
}

TEST_CASE("slivers that touch nothing take no more memory than was estimated") {
  std::mt19937 random(4);
  for (const float width : {1e-4f, 0.5f}) {
    CAPTURE(width);
    std::vector<glm::vec3> corners;
    add_floor(corners, -2, -2, 2, 2);
    add_slivers(corners, random, 4000, 0.5f, width);
    MeshBuilder builder("slivers");
    for (size_t i = 0; i < corners.size(); i += 3) builder.triangle(corners[i], corners[i + 1], corners[i + 2]);
    Scene scene;
    scene.source = "test:slivers";
    add_instance(scene, add_mesh(scene, builder.take()), add_lambert(scene, "grey", glm::vec3(0.5f)));
    const AtlasContext context(scene, 3000);
    const SurfaceAtlasReport& report = context.atlas->report();
    MESSAGE(report.sides, " sides, at most ", SurfaceAtlas::estimate_sides(scene, context.options), "; ", report.bytes,
            " bytes, at most ", SurfaceAtlas::estimate_bytes(scene, context.options));
    CHECK(report.sides > 3000 * 5 / 4);
    CHECK(report.sides <= SurfaceAtlas::estimate_sides(scene, context.options));
    CHECK(report.bytes <= SurfaceAtlas::estimate_bytes(scene, context.options));
  }
}

TEST_CASE("techniques take eight texels per pixel, or as many as the scene's detail asks for") {
  CHECK(suitable_texels(64 * 36, 12) == 32768);
  CHECK(suitable_texels(160 * 90, 12) == 115200);
  CHECK(suitable_texels(160 * 90, 313820) == 115200);
  CHECK(suitable_texels(64 * 36, 313820) == 78455);
  CHECK(suitable_texels(1280 * 720, 12) == 262144);
  CHECK(suitable_texels(64 * 36, 10'000'000) == 262144);
}
