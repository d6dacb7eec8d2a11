// SPDX-License-Identifier: Apache-2.0
// The fragment lists: their numbers against closed forms, and that three stores make the same.
#include <doctest/doctest.h>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "test_support.h"
#include "tolerance.h"
#include "voxel_abuffer/structure/state.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::Intersect;
using abuffer::VoxelAbuffer;

TEST_CASE("conservative lists hold a fragment where a triangle touches a pixel of its dominant axis, not more") {
  // Width and height beside the area (Minkowski sum), in one view each.
  AbufferRig rig(scene_of(rough_sphere(60, 80, 5)));
  const VoxelAbuffer structure = rig.make({.abuffer_size = 1280, .intersect = Intersect::exact});
  const auto& s = structure.statistics();
  CHECK(static_cast<double>(s.exact_fragments) == test::relative(s.expected_exact_fragments, 0.02));
  CHECK(s.exact_fragments >= 0.999 * s.expected_exact_fragments);
  CHECK(s.parity_fragments == 0);
  MESSAGE(s.exact_fragments, " of ", s.expected_exact_fragments, ", ", s.bytes, " bytes, ", s.build_seconds, " s");
}
