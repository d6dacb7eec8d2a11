// SPDX-License-Identifier: Apache-2.0
// The image of a bundle holds the scene from every direction, and its pixels have the area that it says.
#include "lucarium/services/bundles/bundle_view.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tolerance.h"

using namespace lucarium;

namespace {

double place(const float4& row, const glm::dvec3& p) { return glm::dot(glm::dvec3(row.xyz()), p) + row.w; }

}  // namespace

TEST_CASE("bounds lie within the bundle's image and depth range, whatever the direction, rotation and jitter") {
  Bounds bounds;
  bounds.add({-3, 1, 2});
  bounds.add({5, 1.5f, 9});
  const DirectionSequence sequence({}, 5);
  for (const double pixel : {0.3, 0.05, 1e-5}) {  // the last: coarser, so that 4096 pixels suffice
    CAPTURE(pixel);
    const uint32_t side = bundle_side(bounds, pixel);
    CHECK(side <= LAYERED_MAX_EDGE);
    for (uint64_t i = 0; i < 200; ++i) {
      const BundleDirection direction = sequence.at(i);
      const BundleView bundle = make_bundle_view(bounds, direction, pixel, 77);
      const LayeredView& view = bundle.view;
      CHECK(view.seed == 77);
      CHECK(view.width <= side);
      CHECK(view.height <= side);
      bool inside = true;
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                           corner & 4 ? bounds.max.z : bounds.min.z);
        const double x = place(view.row_x, p), y = place(view.row_y, p), depth = place(view.row_w, p);
        inside = inside && x > -1e-2 && x < view.width + 1e-2 && y > -1e-2 && y < view.height + 1e-2;
        const double share = (depth - view.depth_min) * view.depth_scale;
        inside = inside && share > 0 && share < 1;
      }
      CHECK(inside);
      // Right, down and away from the viewer, square pixels of the stated area.
      const glm::dvec3 x(view.row_x.xyz()), y(view.row_y.xyz()), w(view.row_w.xyz());
      CHECK(glm::dot(w, glm::dvec3(direction.direction)) == test::relative(1, 1e-6));
      CHECK(glm::dot(glm::cross(x, y), w) == test::relative(1 / bundle.pixel_area, 1e-5));
      CHECK(glm::length(x) == test::relative(glm::length(y), 1e-5));
      CHECK(std::sqrt(bundle.pixel_area) >= pixel);
    }
  }
}

TEST_CASE("the jitter shifts the pixel grid by its share of a pixel") {
  Bounds bounds;
  bounds.add({0, 0, 0});
  bounds.add({1, 2, 3});
  BundleDirection direction;
  direction.direction = glm::normalize(glm::vec3(1, 2, 3));
  direction.rotation = 0.3f;
  const LayeredView still = make_bundle_view(bounds, direction, 0.1, 1).view;
  direction.jitter = {0.25f, 0.75f};
  const LayeredView moved = make_bundle_view(bounds, direction, 0.1, 1).view;
  CHECK(still.row_x.w - moved.row_x.w == test::within(0.25, 1e-4));
  CHECK(still.row_y.w - moved.row_y.w == test::within(0.75, 1e-4));
  CHECK(still.width == moved.width);
}
