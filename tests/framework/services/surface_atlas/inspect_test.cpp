// SPDX-License-Identifier: Apache-2.0
// What techniques say of a texel side to people.
#include "lucarium/services/surface_atlas/inspect.h"

#include "context.h"
#include "lucarium/scene/builtin/scenes.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("points find the side of the texel that they lie on") {
  Scene scene = make_builtin_scene("cornell");
  scene.materials[0].double_sided = true;
  AtlasContext context(std::move(scene), 2000);
  const SurfaceAtlas& atlas = *context.atlas;
  const std::vector<AtlasTexel> texels = atlas.texels().download();
  const uint32_t k = atlas.info().double_sided_count;
  REQUIRE(k > 0);
  for (uint32_t side = 0; side < texels.size(); side += 37) {
    const AtlasTexel& t = texels[side];
    const bool back = side >= k && side < 2 * k;
    CAPTURE(side);
    CHECK(side_at(atlas, t.triangle, t.b1, t.b2, !back) == side);
    if (side >= 2 * k) CHECK(side_at(atlas, t.triangle, t.b1, t.b2, false) == LUCARIUM_NONE);
  }
}

TEST_CASE("light at a side is shown as irradiance of its open part") {
  AtlasContext context(make_builtin_scene("cornell"), 500);
  const SurfaceAtlas& atlas = *context.atlas;
  const uint32_t sides = atlas.info().texel_count;
  std::vector<float4> shown(sides, float4(0, 0, 0, 1));
  shown[3] = float4(0.5f, 1, 2, 0.5f);  // over π, times the accessibility of one half
  const auto buffer = test_buffer(shown);
  const auto rows = describe_side(atlas, 3, buffer, "light");
  REQUIRE(rows.size() == 4);
  CHECK(rows[0].second == fmt::format("3 of {}", sides));
  CHECK(rows[1].second == fmt::format("{:.4g} cm²", 1e4 * atlas.texels().download(3, 1).front().area));
  CHECK(rows[2].second == "50 %");
  CHECK(rows[3].first == "light");
  CHECK(rows[3].second == "3.142  6.283  12.57 lx");
  CHECK(describe_side(atlas, LUCARIUM_NONE, buffer, "light").size() == 1);

  // A fifth of it, under glass, has light of its own; another side has nothing else.
  shown.resize(2 * size_t{sides});
  shown[sides + 3] = float4(0.2f, 0, 0, 0.2f);
  shown[4] = float4(0, 0, 0, 0);
  shown[sides + 4] = float4(0.2f, 0, 0, 0.2f);
  const auto both = describe_side(atlas, 3, test_buffer(shown), "light");
  REQUIRE(both.size() == 6);
  CHECK(both[2].second == "70 %");
  CHECK(both[3].second == "3.142  6.283  12.57 lx");
  CHECK(both[4].second == "20 %");
  CHECK(both[5].first == "light there");
  CHECK(both[5].second == "3.142  0  0 lx");
  const auto covered = describe_side(atlas, 4, test_buffer(shown), "light");
  REQUIRE(covered.size() == 5);
  CHECK(covered[2].second == "20 %");
  CHECK(covered[4].second == "3.142  0  0 lx");
}
