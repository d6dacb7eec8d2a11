// SPDX-License-Identifier: Apache-2.0
// Texels that lie partly under glass: what light samples miss below a sheet comes through it along the lines of the
// field.
#include <doctest/doctest.h>

#include "field_rig.h"
#include "invisible_sheet.h"
#include "technique_session.h"
#include "tolerance.h"

using namespace lucarium;
using test::half_floor;
using test::half_sheet;
using test::invisible_sheet;
using test::Options;
using test::relative;
using test::with;

namespace {

const Options few_lines = {{"dir_n", "8"}, {"cells", "64"}, {"texels", "1200"}, {"preview", "off"}};

}  // namespace

TEST_CASE("a sheet that nobody sees takes no light from texels that lie partly under it, and gives them none") {
  for (const Options& eye : {Options{{"camera_samples", "256"}}, Options{{"preset", "walkthrough"}}}) {
    test::SheetRings mean;
    constexpr uint64_t seeds = 4;
    for (uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto run = test::session("virtual_light_field", invisible_sheet(), {.seed = seed, .max_bounces = -1},
                                     with(eye, few_lines));
      run->run({.iterations = 2000});
      const test::SheetRings one = test::sheet_rings(run->resolve().image());
      mean.inside += one.inside / seeds;
      mean.outside += one.outside / seeds;
    }
    const std::string eyes = eye.front().first + "=" + eye.front().second;
    CAPTURE(eyes);
    MESSAGE(eyes << ": inside " << mean.inside << ", outside " << mean.outside);
    CHECK(mean.inside == relative(1, 0.05));
    CHECK(mean.outside == relative(1, 0.05));
  }
}

TEST_CASE("halves without a light sample get the light of one sky, not of two or none") {
  vlf::Parameters parameters;
  parameters.dir_n = 8;
  parameters.cells = 64;
  parameters.texels = 1200;
  test::FieldRig rig(invisible_sheet(0.6f), parameters);
  rig.propagate();
  const std::vector<AtlasTexel> texels = rig.surfaces().atlas.texels().download();
  const std::vector<float> shares = rig.surfaces().accessibility.shares().download();
  const std::vector<float4> samples = rig.surfaces().light.light_samples().download();
  const std::vector<uint32_t> instances = rig.instances();
  const std::vector<double> direct = rig.direct(), all = rig.all();
  for (const size_t first : {size_t{0}, texels.size()}) {
    double area = 0, of_direct = 0, sum = 0;
    for (size_t side = 0; side < texels.size(); ++side) {
      const size_t half = first + side;
      if (instances[side] != 0 || samples[half].w > 0) continue;
      const auto own = static_cast<double>(texels[side].area * shares[half]);
      area += own;
      of_direct += own * direct[half];
      sum += own * all[half];
    }
    const std::string which = first == 0 ? "open" : "covered";
    CAPTURE(which);
    REQUIRE(area > 0);
    MESSAGE(which << ": " << area << " m2, direct " << of_direct / area << ", all " << sum / area);
    CHECK(sum / area == relative(1, 0.05));
  }
}

TEST_CASE("covered halves of texel sides have the area of the glass above them") {
  vlf::Parameters parameters;
  parameters.dir_n = 4;
  parameters.cells = 32;
  parameters.texels = 1200;
  /// Of the floor [m2], and of its covered halves.
  struct Areas {
    double all = 0, covered = 0;
  };
  const auto areas_of = [&](float height) {
    const test::FieldRig rig(invisible_sheet(0, height), parameters);
    const vlf::FieldSurfaces& surfaces = rig.surfaces();
    REQUIRE(surfaces.accessibility.halves() == 2);
    const std::vector<AtlasTexel> texels = surfaces.atlas.texels().download();
    const std::vector<float> shares = surfaces.accessibility.shares().download();
    const std::vector<uint32_t> instances = rig.instances();
    Areas areas;
    for (size_t side = 0; side < texels.size(); ++side) {
      if (instances[side] != 0) continue;
      const auto area = static_cast<double>(texels[side].area);
      areas.covered += area * static_cast<double>(shares[texels.size() + side]);
      areas.all += area * static_cast<double>(shares[side] + shares[texels.size() + side]);
    }
    MESSAGE("covered " << areas.covered << " m2 of " << areas.all);
    return areas;
  };
  const Areas close = areas_of(test::sheet_height);
  CHECK(close.covered == relative(4 * half_sheet * half_sheet, 0.05));
  CHECK(close.all == relative(4 * half_floor * half_floor, 1e-3));

  // 2.5 edges of texels above the floor, of the 4.5 within which detail counts as near.
  CHECK(areas_of(0.25f).covered == 0);

  // Nothing is kept twice without glass, and with the weights of the paper.
  parameters.access_gap = 0;
  CHECK(test::FieldRig(invisible_sheet(), parameters).surfaces().accessibility.halves() == 1);
}
