// SPDX-License-Identifier: Apache-2.0
// The surface that is seen through a pixel.
#include "lucarium/view/inspect/pixel_surface.h"

#include <doctest/doctest.h>

#include "device_fixture.h"
#include "lucarium/scene/device/scene_layout.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/scene/look_at.h"
#include "lucarium/session/scene_on_device.h"
#include "tolerance.h"

using namespace lucarium;

// The room is 2 × 2 × 2 m, its floor at y = 0 (builtin:room): its walls are where the camera's rays meet its planes.
TEST_CASE("pixels of the room show the wall that their rays meet") {
  const std::shared_ptr<Device> device = test::test_device();
  const std::shared_ptr<SceneOnDevice> scene = share_scene(load_scene("builtin:room"));
  const Bounds bounds = scene->scene.bounds();
  const glm::vec3 eye = bounds.center() + glm::vec3(0, 0.25f, 0);
  RenderSettings settings;
  settings.width = 8;
  settings.height = 4;
  settings.camera = look_at_camera("", eye, eye + glm::vec3(0, 0, -1), 90);
  int seen = 0;
  for (uint32_t y = 0; y < settings.height; ++y) {
    for (uint32_t x = 0; x < settings.width; ++x) {
      const PixelSurface surface = find_pixel_surface(device, *scene, settings, x, y);
      REQUIRE(surface.hit);
      // The direction of the pixel's middle: 90 degrees high, twice as wide.
      const glm::vec3 d =
          glm::normalize(glm::vec3(0.5f * static_cast<float>(x) - 1.75f, 0.75f - 0.5f * static_cast<float>(y), -1));
      CHECK(glm::length(eye + surface.distance * d - surface.position) < 1e-4f);
      CHECK(glm::dot(surface.normal, d) < 0);
      CHECK(glm::length(surface.normal) == test::relative(1.0f, 1e-5));
      CHECK_FALSE(surface.material_name.empty());
      CHECK(surface.instance < scene->scene.instances.size());
      const SceneInstance& instance = scene->scene.instances[surface.instance];
      CHECK(static_cast<uint32_t>(instance.material) == surface.material);
      CHECK(surface.triangle < instance.shape(scene->scene).triangles.size());
      // The same for techniques: the triangle of the whole scene holds the point.
      CHECK(surface.seen.x == x);
      CHECK(surface.seen.y == y);
      CHECK(surface.seen.front);
      const SceneLayout layout(scene->scene);
      CHECK(surface.seen.triangle == layout.instances[surface.instance].world_triangle + surface.triangle);
      const Mesh& mesh = instance.shape(scene->scene);
      const glm::uvec3 corners = mesh.triangles[surface.triangle];
      const glm::vec3 at = (1 - surface.seen.b1 - surface.seen.b2) * mesh.positions[corners.x] +
                           surface.seen.b1 * mesh.positions[corners.y] + surface.seen.b2 * mesh.positions[corners.z];
      CHECK(glm::length(glm::vec3(instance.world_from_object * glm::vec4(at, 1)) - surface.position) < 1e-4f);
      ++seen;
    }
  }
  CHECK(seen == 32);
}

TEST_CASE("beside the scene there is nothing") {
  RenderSettings settings;
  settings.camera = look_at_camera("", {0, 0, 100}, {0, 0, 200}, 40);
  CHECK_FALSE(find_pixel_surface(test::test_device(), *share_scene(load_scene("builtin:room")), settings, 0, 0).hit);
}
