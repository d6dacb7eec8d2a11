// SPDX-License-Identifier: Apache-2.0
// Views for all directions, cubes and axes. Declared in layered_raster.h.
#include "lucarium/services/layered_raster/layered_raster.h"

namespace lucarium {

namespace {

float4 row(const glm::vec3& axis, const glm::vec3& origin, float offset) {
  return float4(axis, offset - glm::dot(axis, origin));
}

void set_image(LayeredView& view, uint32_t width, uint32_t height, float depth_min, float depth_max) {
  view.width = width;
  view.height = height;
  view.depth_min = depth_min;
  view.depth_scale = 1 / (depth_max - depth_min);
}

}  // namespace

LayeredView orthographic_view(const glm::vec3& center, const glm::vec3& direction, const glm::vec3& right,
                              float pixel_size, uint32_t width, uint32_t height, float depth, const glm::vec2& corner) {
  LayeredView view{};
  const glm::vec3 down = glm::cross(direction, right);
  view.row_x = row(right / pixel_size, center, -corner.x / pixel_size);
  view.row_y = row(down / pixel_size, center, -corner.y / pixel_size);
  view.row_w = row(direction, center, 0);
  set_image(view, width, height, -depth, depth);
  return view;
}

LayeredView perspective_view(const glm::vec3& eye, const glm::vec3& direction, const glm::vec3& down,
                             float tan_half_width, uint32_t width, uint32_t height, float near_depth, float far_depth) {
  LayeredView view{};
  const glm::vec3 right = glm::cross(down, direction);
  const float half_width = 0.5f * static_cast<float>(width), half_height = 0.5f * static_cast<float>(height);
  const float scale = half_width / tan_half_width;
  view.row_x = row(right * scale + direction * half_width, eye, 0);
  view.row_y = row(down * scale + direction * half_height, eye, 0);
  view.row_w = row(direction, eye, 0);
  set_image(view, width, height, near_depth, far_depth);
  return view;
}

std::array<LayeredView, 6> cube_views(const glm::vec3& eye, uint32_t size, float near_depth, float far_depth) {
  std::array<LayeredView, 6> views;
  for (int face = 0; face < 6; ++face) {
    glm::vec3 direction(0), down(0);
    direction[face / 2] = face % 2 ? -1.f : 1.f;
    down[face / 2 == 1 ? 2 : 1] = face == 2 ? 1.f : -1.f;
    views[face] = perspective_view(eye, direction, down, 1, size, size, near_depth, far_depth);
  }
  return views;
}

}  // namespace lucarium
